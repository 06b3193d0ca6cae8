"""fmod and remainder: exact, in one step for quotients below 2^52, by long division beyond."""

from __future__ import annotations

import math

from mafsil.kernels.emitter import Lanes
from mafsil.kernels.exact import two_product

FAR = "mafsil_fmod"


def fmod(lanes: Lanes, x: str, y: str) -> str:
    """X - y trunc(x/y), exactly, with the sign of x."""
    a, b = lanes.fabs(x), lanes.fabs(y)
    quotient = lanes.trunc(lanes.div(a, b))
    product, error = two_product(lanes, quotient, b)
    rest = lanes.sub(lanes.sub(a, product), error)
    rest = lanes.select(lanes.compare("olt", rest, lanes.const(0.0)), lanes.add(rest, b), rest)
    less = lanes.compare("olt", a, b)
    near = lanes.mask_op("and", lanes.compare("olt", quotient, lanes.const(2.0**52)), _in_range(lanes, a, b))
    near = lanes.mask_op("or", near, less)
    real = lanes.mask_op(
        "and", lanes.compare("olt", a, lanes.const(math.inf)), lanes.compare("ogt", b, lanes.const(0.0))
    )
    far = lanes.mask_op("and", real, lanes.invert(near))
    rest = _with_far(lanes, a, b, lanes.select(less, a, rest), far)
    rest = lanes.select(real, rest, lanes.const(math.nan))
    return lanes.copysign(lanes.select(lanes.compare("uno", x, y), lanes.const(math.nan), rest), x)


def remainder(lanes: Lanes, x: str, y: str) -> str:
    """X - y n, n the whole number nearest to x/y, even if in doubt; exact."""
    b = lanes.fabs(y)
    doubled = lanes.add(b, b)
    twice = lanes.select(lanes.compare("olt", doubled, lanes.const(math.inf)), doubled, b)
    rest = lanes.fabs(fmod(lanes, x, twice))
    # Halves of b would round when b is the smallest number, doubles of rest do not overflow below 2^1022.
    small = lanes.compare("olt", b, lanes.const(2.0**1000))
    scale = lanes.select(small, lanes.const(2.0), lanes.const(1.0))
    bound = lanes.select(small, b, lanes.mul(b, lanes.const(0.5)))
    over = lanes.compare("ogt", lanes.mul(rest, scale), bound)
    rest = lanes.select(over, lanes.sub(rest, b), rest)
    again = lanes.mask_op("and", over, lanes.compare("oge", lanes.mul(rest, scale), bound))
    rest = lanes.select(again, lanes.sub(rest, b), rest)
    sign = lanes.integer_op("and", lanes.bits(x), lanes.whole(1 << 63))
    rest = lanes.from_bits(lanes.integer_op("xor", lanes.bits(rest), sign))
    whole = lanes.mask_op(
        "and",
        lanes.compare("oeq", b, lanes.const(math.inf)),
        lanes.compare("olt", lanes.fabs(x), lanes.const(math.inf)),
    )
    return lanes.select(whole, x, rest)


def _in_range(lanes: Lanes, a: str, b: str) -> str:
    """No part of the split product overflows or vanishes."""
    return lanes.mask_op(
        "and", lanes.compare("olt", a, lanes.const(2.0**990)), lanes.compare("ogt", b, lanes.const(2.0**-900))
    )


def _with_far(lanes: Lanes, a: str, b: str, near: str, far: str) -> str:
    """`near`, but long division in the lanes of `far`; a branch, taken only if there is one."""
    text = lanes.text
    before, slow, after = text.block, f"far{text.count}", f"divided{text.count}"
    text.do(f"br i1 {lanes.any(far)}, label %{slow}, label %{after}, !prof !0")
    text.label(slow)
    space = f"%far.space{text.count}"
    text.entry.append(f"  {space} = alloca [3 x {lanes.real}], align 64")
    marked = lanes.select(far, b, lanes.const(0.0))
    for part, value in enumerate((a, marked, near)):
        lanes.store(value, space, part)
    text.do(f"call void @{FAR}(ptr {space}, i64 {lanes.width})")
    late = lanes.load(space, 2)
    text.do(f"br label %{after}")
    text.label(after)
    return text.let(f"phi {lanes.real} [ {near}, %{before} ], [ {late}, %{slow} ]")


def far_function(attributes: str) -> str:
    """IR of the long division: n dividends, n divisors (0: leave this lane alone), n results; finite, not negative.

    Numbers are taken as mantissa times a power of two; the dividend's mantissa is shifted left bit by bit, the
    divisor's subtracted whenever it fits.
    """
    return f"""define internal void @{FAR}(ptr %base, i64 %n) cold noinline {attributes} {{
entry:
  br label %next
next:
  %i = phi i64 [ 0, %entry ], [ %j, %continue ]
  %i1 = add i64 %i, %n
  %i2 = add i64 %i1, %n
  %a.place = getelementptr i64, ptr %base, i64 %i
  %b.place = getelementptr i64, ptr %base, i64 %i1
  %r.place = getelementptr i64, ptr %base, i64 %i2
  %a = load i64, ptr %a.place, align 8
  %b = load i64, ptr %b.place, align 8
  %skip = icmp eq i64 %b, 0
  br i1 %skip, label %continue, label %divide
divide:
  %a.exp = lshr i64 %a, 52
  %b.exp = lshr i64 %b, 52
  %a.low = and i64 %a, 4503599627370495
  %b.low = and i64 %b, 4503599627370495
  %a.sub = icmp eq i64 %a.exp, 0
  %b.sub = icmp eq i64 %b.exp, 0
  %a.one = select i1 %a.sub, i64 0, i64 4503599627370496
  %b.one = select i1 %b.sub, i64 0, i64 4503599627370496
  %a.man = or i64 %a.low, %a.one
  %b.man = or i64 %b.low, %b.one
  %a.e = select i1 %a.sub, i64 1, i64 %a.exp
  %b.e = select i1 %b.sub, i64 1, i64 %b.exp
  %count = sub i64 %a.e, %b.e
  %first = urem i64 %a.man, %b.man
  br label %shift
shift:
  %left = phi i64 [ %count, %divide ], [ %left.next, %step ]
  %rest = phi i64 [ %first, %divide ], [ %rest.next, %step ]
  %more = icmp sgt i64 %left, 0
  br i1 %more, label %step, label %scale
step:
  %twice = shl i64 %rest, 1
  %less = sub i64 %twice, %b.man
  %fits = icmp uge i64 %twice, %b.man
  %rest.next = select i1 %fits, i64 %less, i64 %twice
  %left.next = sub i64 %left, 1
  br label %shift
scale:
  %none = icmp eq i64 %rest, 0
  %zeros = call i64 @llvm.ctlz.i64(i64 %rest, i1 false)
  %room = sub i64 %zeros, 11
  %most = sub i64 %b.e, 1
  %short = icmp slt i64 %room, %most
  %by = select i1 %short, i64 %room, i64 %most
  %by.safe = select i1 %none, i64 0, i64 %by
  %man = shl i64 %rest, %by.safe
  %e = sub i64 %b.e, %by.safe
  %normal = icmp uge i64 %man, 4503599627370496
  %e.bits = shl i64 %e, 52
  %cut = and i64 %man, 4503599627370495
  %as.normal = or i64 %cut, %e.bits
  %result = select i1 %normal, i64 %as.normal, i64 %man
  store i64 %result, ptr %r.place, align 8
  br label %continue
continue:
  %j = add i64 %i, 1
  %again = icmp ult i64 %j, %n
  br i1 %again, label %next, label %done
done:
  ret void
}}
"""
