"""Reduction of angles by quarter turns: x = n pi/2 + r - rest, |r| <= pi/4, for any finite x.

1. n is the whole number nearest to x 2/pi, found by adding a large number that leaves n in the low bits (`MAGIC`).
2. |n| < 2^20 (angles up to 1.6e6 rad, every angle of a robot): n pi/2 is subtracted in three parts, of which the
   first two products are exact (`_moderate`: Cody and Waite).
3. Beyond, the parts would not reach: x = m 2^k is multiplied by those bits of 2/pi that decide the quarter turn and
   its fraction, in integers of 128 bits (`_payne_hanek`). A branch that is never taken in practice leads there, since
   a sine of 1e10 must be as right as one of 1: the alternative would be a wrong number without a word.

The rest counts downwards so that it is +0, never -0, where r is exact: then r - rest keeps the sign of a zero.

References: Cody and Waite 1980, Software Manual for the Elementary Functions; Payne and Hanek 1983, Radian reduction
for trigonometric functions.
"""

from __future__ import annotations

from mafsil.kernels.emitter import Lanes, Text
from mafsil.kernels.exact import two_product

MAGIC = 6755399442104320.0
"""1.5 * 2^52 + 2^20: added to |n| < 2^20 it leaves the integer n + 2^20 in the low bits, all higher bits known."""
MAGIC_BITS = 0x4338000000000000
QUARTERS_PER_RADIAN = 0.6366197723675814
HALF_PI = (1.5707963267948966, 6.12323399538461e-17, 3.5215598651832e-27)
"""pi/2 as a sum whose second term has 33 bits: |n| < 2^20 times it is exact; the first needs a fused product."""
HALF_PI_LOW = 6.123233995736766e-17
HALF_PI_SHORT = (1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21)
"""pi/2 as a sum whose first two terms have 33 bits, so that products with |n| < 2^20 are exact."""
TWO_OVER_PI = (
    "a2f9836e4e441529fc2757d1f534ddc0db6295993c439041fe5163abdebbc561"
    "b7246e3a424dd2e006492eea09d1921cfe1deb1cb129a73ee88235f52ebb4484"
    "e99c7026b45f7e413991d639835339f49c845f8bbdf9283b1ff897ffde05980f"
    "ef2f118b5a0a6d1f6d367ecf27cb09b74f463f669e5fea2d7527bac7ebe5f17b"
    "3d0739f78a5292ea6bfb5fb11f8d5d0856033046fc7b6bab"
)
"""The first 1216 bits of 2/pi after the binary point."""
HUGE = "mafsil_huge"
HUGE_VALUE = "mafsil_huge_value"
_PARTS = "{ double, double, i64 }"


def reduce_angles(lanes: Lanes, angles: list[str]) -> list[tuple[str, str, str]]:
    """(r, rest, bits whose last two are n mod 4) of every angle; NaN and infinities give NaN.

    The hot path is for |n| < 2^20; if any lane is beyond, a function reduces those lanes with 2/pi to 1200 bits.
    """
    # 1. and 2. All angles, as if none were large.
    fast = [_moderate(lanes, x) for x in angles]
    # 3. The bits of x 2/pi + MAGIC are MAGIC's but for the low 21, unless n is too large (or x is no number): any other
    #    bit that differs makes the exclusive or larger than 2^21 - 1. One test serves all angles and lanes.
    beyond = ""
    for _, _, turns in fast:
        known = lanes.integer_op("xor", turns, lanes.whole(MAGIC_BITS))
        beyond = lanes.integer_op("or", beyond, known) if beyond else known
    large = lanes.compare_integers("ugt", beyond, lanes.whole((1 << 21) - 1))
    return _join(lanes, angles, fast, lanes.any(large))


def _moderate(lanes: Lanes, x: str) -> tuple[str, str, str]:
    """Cody and Waite: subtract n times pi/2 in parts, each step exact but the last."""
    # 1. 1.5 2^52 is so large that its last place is 1: the addition rounds to the nearest whole number, and the
    #    subtraction gives that number back as a double.
    turned = lanes.fma(x, lanes.const(QUARTERS_PER_RADIAN), lanes.const(MAGIC))
    n = lanes.sub(turned, lanes.const(MAGIC))
    if lanes.text.fma:
        # 2. `above` is exact: a fused product is rounded only after the subtraction, whose result is below 1 and a
        #    multiple of 2^-53, the last place of x and of the first part.
        first, second, third = (lanes.const(part) for part in HALF_PI)
        above = lanes.fnma(n, first, x)
        r = lanes.fnma(n, second, above)
        # r rounds; what it lost is (r - above) + n second, and the third part comes on top.
        rest = lanes.fma(n, third, lanes.fma(n, second, lanes.sub(r, above)))
        return r, rest, lanes.bits(turned)
    # 2. Without fused products: the first two parts are short enough that n times them is exact.
    first, second, third = (lanes.const(part) for part in HALF_PI_SHORT)
    above = lanes.sub(x, lanes.mul(n, first))
    step = lanes.mul(n, second)
    middle = lanes.sub(above, step)
    # What `middle` lost, and the third part: taken off, and what that subtraction lost is handed on as the rest.
    beyond = lanes.add(lanes.add(lanes.sub(middle, above), step), lanes.mul(n, third))
    r = lanes.sub(middle, beyond)
    return r, lanes.add(lanes.sub(r, middle), beyond), lanes.bits(turned)


def _join(lanes: Lanes, angles: list[str], fast: list[tuple[str, str, str]], large: str) -> list[tuple[str, str, str]]:
    """`fast`, unless `large`: then the lanes beyond the hot path are reduced again, through memory."""
    # The branch is marked as one in a million (!prof !0), so the slow block lies outside the hot code.
    text = lanes.text
    before, slow, after = text.block, f"huge{text.count}", f"reduced{text.count}"
    text.do(f"br i1 {large}, label %{slow}, label %{after}, !prof !0")
    text.label(slow)
    again = _by_value(lanes, angles, fast) if text.scalar else _by_memory(lanes, angles, fast)
    text.do(f"br label %{after}")
    text.label(after)
    kinds = (lanes.real, lanes.real, lanes.integer)
    # Behind the branch every value is either the quick one or the one reduced again.
    joined: list[tuple[str, str, str]] = []
    for quick, late in zip(fast, again, strict=True):
        r, rest, turns = (
            text.let(f"phi {kind} [ {q}, %{before} ], [ {s}, %{slow} ]")
            for kind, q, s in zip(kinds, quick, late, strict=True)
        )
        joined.append((r, rest, turns))
    return joined


def _by_memory(lanes: Lanes, angles: list[str], fast: list[tuple[str, str, str]]) -> list[tuple[str, str, str]]:
    """All lanes of all angles in one call."""
    text, count = lanes.text, len(angles)
    space = f"%space{text.count}"
    # Four rows of `count` vectors: the angles, then r, rest and turned bits, which the function renews in place. One
    # function without vectors for all kernels keeps the rare case out of the registers of the frequent one.
    text.entry.append(f"  {space} = alloca [{4 * count} x {lanes.real}], align 64")
    for k, (x, (r, rest, turns)) in enumerate(zip(angles, fast, strict=True)):
        for part, value in enumerate((x, r, rest, lanes.from_bits(turns))):
            lanes.store(value, space, part * count + k)
    text.do(f"call void @{HUGE}(ptr {space}, i64 {count * lanes.width})")
    again = [tuple(lanes.load(space, part * count + k) for part in (1, 2, 3)) for k in range(count)]
    return [(r, rest, lanes.bits(turns)) for r, rest, turns in again]


def _by_value(lanes: Lanes, angles: list[str], fast: list[tuple[str, str, str]]) -> list[tuple[str, str, str]]:
    """One call for each angle, arguments and results in registers."""
    text = lanes.text
    again: list[tuple[str, str, str]] = []
    for x, (r, rest, turns) in zip(angles, fast, strict=True):
        parts = text.let(f"call {_PARTS} @{HUGE_VALUE}(double {x}, double {r}, double {rest}, i64 {turns})")
        first, second, third = (text.let(f"extractvalue {_PARTS} {parts}, {k}") for k in range(3))
        again.append((first, second, third))
    return again


def huge_value_function(fma: bool, attributes: str) -> tuple[str, set[str]]:
    """IR of the function that reduces one huge angle, and the declarations it needs: (x, r, rest, turns) renewed."""
    text = Text(fma, rounding=False)
    lanes = Lanes(text, 1)
    # The test of `reduce_angles` again, for this angle alone; NaN and infinities keep the NaN that they have.
    beyond = lanes.integer_op("xor", "%turns", lanes.whole(MAGIC_BITS))
    beyond = lanes.compare_integers("ugt", beyond, lanes.whole((1 << 21) - 1))
    finite = lanes.compare("olt", lanes.fabs("%x"), lanes.const(float("inf")))
    text.do(f"br i1 {lanes.mask_op('and', beyond, finite)}, label %reduce, label %done")
    text.label("reduce")
    renewed = _payne_hanek(lanes, "%x")
    text.do("br label %done")
    text.label("done")
    total = "poison"
    kinds = (("double", "%r"), ("double", "%rest"), ("i64", "%turns"))
    chosen = [
        text.let(f"phi {kind} [ {old}, %entry ], [ {new}, %reduce ]")
        for (kind, old), new in zip(kinds, renewed, strict=True)
    ]
    for k, ((kind, _), value) in enumerate(zip(kinds, chosen, strict=True)):
        total = text.let(f"insertvalue {_PARTS} {total}, {kind} {value}, {k}")
    text.do(f"ret {_PARTS} {total}")
    arguments = "double %x, double %r, double %rest, i64 %turns"
    header = f"define internal {_PARTS} @{HUGE_VALUE}({arguments}) cold noinline {attributes} {{\nentry:\n"
    return _table() + header + "\n".join(text.lines) + "\n}\n", text.declared


def _table() -> str:
    """The bits of 2/pi as a constant, a word of zeros before them."""
    words = [0, *(int(TWO_OVER_PI[k : k + 16], 16) for k in range(0, len(TWO_OVER_PI), 16))]
    numbers = ", ".join(f"i64 {word - (1 << 64) if word >= 1 << 63 else word}" for word in words)
    return f"@{HUGE}.bits = private unnamed_addr constant [{len(words)} x i64] [{numbers}]\n"


def huge_function(fma: bool, attributes: str) -> tuple[str, set[str]]:
    """IR of the function that reduces huge angles, and the declarations it needs.

    It gets n angles, then n values of r, of the rest and of the turned bits, and renews those beyond the hot path.
    """
    text = Text(fma, rounding=False)
    lanes = Lanes(text, 1)
    text.do("br label %next")
    text.label("next")
    text.do("%i = phi i64 [ 0, %entry ], [ %following, %continue ]")
    # for i in 0 ... n-1: the places of x[i], r[i], rest[i], turns[i]
    for part, name in enumerate(("x", "r", "rest", "turns")):
        text.do(f"%{name}.skip = mul i64 %n, {part}")
        text.do(f"%{name}.index = add i64 %i, %{name}.skip")
        text.do(f"%{name}.place = getelementptr double, ptr %base, i64 %{name}.index")
    text.do("%x = load double, ptr %x.place, align 8")
    text.do("%turns = load i64, ptr %turns.place, align 8")
    beyond = lanes.integer_op("xor", "%turns", lanes.whole(MAGIC_BITS))
    beyond = lanes.compare_integers("ugt", beyond, lanes.whole((1 << 21) - 1))
    finite = lanes.compare("olt", lanes.fabs("%x"), lanes.const(float("inf")))
    text.do(f"br i1 {lanes.mask_op('and', beyond, finite)}, label %reduce, label %continue")
    text.label("reduce")
    r, rest, turns = _payne_hanek(lanes, "%x")
    text.do(f"store double {r}, ptr %r.place, align 8")
    text.do(f"store double {rest}, ptr %rest.place, align 8")
    text.do(f"store i64 {turns}, ptr %turns.place, align 8")
    text.do("br label %continue")
    text.label("continue")
    text.do("%following = add i64 %i, 1")
    text.do("%more = icmp ult i64 %following, %n")
    text.do("br i1 %more, label %next, label %done")
    text.label("done")
    text.do("ret void")
    header = f"define internal void @{HUGE}(ptr %base, i64 %n) cold noinline {attributes} {{\nentry:\n"
    return _table() + header + "\n".join(text.lines) + "\n}\n", text.declared


def _payne_hanek(lanes: Lanes, x: str) -> tuple[str, str, str]:
    """(r, rest, n) of one huge finite angle x.

    With x = m 2^k, m a whole number of 53 bits, x 2/pi mod 4 is wanted: two bits of quarter turns, then a fraction.
    Bits of 2/pi so high that m 2^k times them is a multiple of 4 do not matter, so only a window of 192 bits is used:

    1. Take x apart into m and the place of its last bit.
    2. Cut the window out of the table of 2/pi.
    3. Multiply by m, modulo 4: 128 bits, of which the first two count quarter turns.
    4. Round the quarter turns to the nearest; the fraction then has a sign.
    5. The fraction as two doubles: its first 53 significant bits and the next 53.
    6. Times pi/2, in twice the digits of a double.
    7. The sign of x.

    Why 192 bits are enough: no double is nearer to a multiple of pi/2 than 2^-62 of a quarter turn, so of the 126
    bits behind the point at least 64 are significant, of which r needs 53.

    Reference: Payne and Hanek 1983; Muller et al., Handbook of Floating-Point Arithmetic, 2018, sec. 10.2.
    """
    text, op = lanes.text, lanes.integer_op

    def wide(value: str) -> str:
        return text.let(f"zext i64 {value} to i128")

    def long(operation: str, a: str, b: str) -> str:
        return text.let(f"{operation} i128 {a}, {b}")

    # 1. A double is (2^52 + low 52 bits) 2^(exponent - 1075); the leading 1 is not stored.
    bits = lanes.bits(x)
    exponent = op("and", op("lshr", bits, "52"), "2047")
    mantissa = op("or", op("and", bits, str((1 << 52) - 1)), str(1 << 52))
    # 2. Bit j of 2/pi (j = 1 is the first behind the point) has the weight 2^-j; times 2^(exponent - 1075) it is
    #    2^(exponent - 1075 - j). Weights of 4 and more drop out: the window starts at j = exponent - 1075 - 1, whose
    #    weight is 2. The table begins with 64 zero bits, so that bit j stands at index 63 + j: the first bit of the
    #    window is at exponent - 1075 + 62. (Huge angles have exponents far above 1013, so it is not negative.)
    first = op("sub", exponent, str(1075 - 62))
    word, shift = op("lshr", first, "6"), op("and", first, "63")
    loaded: list[str] = []
    for k in range(4):
        place = text.let(f"getelementptr i64, ptr @{HUGE}.bits, i64 {op('add', word, str(k))}")
        loaded.append(text.let(f"load i64, ptr {place}, align 8"))
    #    Four words shifted left by the bits before the window leave three full ones (fshl: funnel shift of a pair).
    high, middle, low = (text.call("fshl", "i64", loaded[k], loaded[k + 1], shift) for k in range(3))
    # 3. m (high 2^128 + middle 2^64 + low) / 2^64 modulo 2^128, with the point behind the second bit. What overflows
    #    are whole turns; of m low only the upper half reaches the 128 bits, so the error is below 2^-126 quarter turns.
    m = wide(mantissa)
    top = long("shl", wide(op("mul", mantissa, high)), "64")
    turns = long("add", long("add", top, long("mul", m, wide(middle))), long("lshr", long("mul", m, wide(low)), "64"))
    # 4. The two leading bits are the quarter turns (128 - 2 = 126); moved out, the fraction fills all 128 bits. Its
    #    first bit says that it is one half or more: then the next quarter turn is nearer, and the fraction, read as a
    #    signed number, is negative.
    quarter = text.let(f"trunc i128 {long('lshr', turns, '126')} to i64")
    fraction = long("shl", turns, "2")
    upper = text.let(f"trunc i128 {long('lshr', fraction, '127')} to i64")
    quarter = op("add", quarter, upper)
    below = text.let(f"icmp slt i128 {fraction}, 0")
    size = text.let(f"select i1 {below}, i128 {long('sub', '0', fraction)}, i128 {fraction}")
    # 5. Without its leading zeros the magnitude is size 2^-(128 + zeros).
    text.declared.add("declare i128 @llvm.ctlz.i128(i128, i1)")
    zeros = text.let(f"call i128 @llvm.ctlz.i128(i128 {size}, i1 false)")
    size = long("shl", size, zeros)
    zeros = text.let(f"trunc i128 {zeros} to i64")

    def piece(skip: int, scale: int) -> str:
        """53 bits of the fraction, those from bit `skip` upwards, as a double: times 2^-(scale + zeros)."""
        digits = op("and", text.let(f"trunc i128 {long('lshr', size, str(skip))} to i64"), str((1 << 53) - 1))
        # A power of two is its biased exponent in bits 52 ... 62 and zeros below.
        power = lanes.from_bits(op("shl", op("sub", str(1023 - scale), zeros), "52"))
        return lanes.mul(text.let(f"sitofp i64 {digits} to double"), power)

    #    128 - 53 = 75 and 75 - 53 = 22: the first and the next 53 bits; both conversions are exact.
    hi, lo = piece(75, 53), piece(22, 106)
    # 6. (hi + lo) (HALF_PI + HALF_PI_LOW): the large parts with the error of their product, then the mixed.
    product, error = two_product(lanes, hi, lanes.const(HALF_PI[0]))
    error = lanes.add(error, lanes.add(lanes.mul(hi, lanes.const(HALF_PI_LOW)), lanes.mul(lo, lanes.const(HALF_PI[0]))))
    r = lanes.add(product, error)
    lo = lanes.add(lanes.sub(product, r), error)
    # 7. So far |x| was reduced: for a negative x the quarter turns count backwards and r turns its sign, once more if
    #    the fraction was negative. The rest counts downwards, so it is the negative of what r lacks.
    minus = text.let(f"icmp slt i64 {bits}, 0")
    flip = text.let(f"xor i1 {minus}, {below}")
    quarter = text.let(f"select i1 {minus}, i64 {op('sub', '0', quarter)}, i64 {quarter}")
    return lanes.select(flip, lanes.neg(r), r), lanes.select(flip, lo, lanes.neg(lo)), quarter
