"""Writes LLVM IR: one function's text, and arithmetic on vectors of lanes.

IR is an assembly language with types, in which every value gets its name once and is never changed: where C has
`x = a*b; x = x + c;`, IR has `%v1 = fmul double %a, %b` and `%v2 = fadd double %v1, %c`. A vector `<4 x double>` is
four numbers in one register, and the same instructions act on all four. Functions here append instructions to a `Text`
and hand on the names of the results, so Python code that calls them reads like the arithmetic that is printed:

    z = lanes.mul(x, x)                             # x and z are names such as "%v7"
    y = lanes.fma(lanes.const(2.0), z, x)           # 2 x^2 + x in every lane

A choice between two values is `select`, never a branch: the lanes of a vector go one way together, so both sides are
computed and the mask (one bit a lane) picks. That is also why NaN in the side not taken does no harm.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass, field
from functools import cache
from typing import Literal

Comparison = Literal["olt", "ole", "oeq", "une", "ogt", "oge", "uno", "ord"]
Predicate = Literal["eq", "ne", "slt", "sgt", "ult", "ugt"]


@dataclass
class Text:
    """The body of one function while it is written.

    Attributes:
        fma: products and sums may be rounded once (`llvm.fma`), else twice.
        rounding: the target rounds to integers in one instruction.
        entry: lines of the entry block, where stack space is reserved.
        lines: all other lines.
        scalar: a machine without vectors, or where stack space is dear: nothing is packed, huge angles go by value.
        block: label of the current basic block.
        declared: declarations of the intrinsics in use.
    """

    fma: bool
    rounding: bool
    scalar: bool = False
    entry: list[str] = field(default_factory=list[str])
    lines: list[str] = field(default_factory=list[str])
    block: str = "entry"
    declared: set[str] = field(default_factory=set[str])
    count: int = 0

    def name(self) -> str:
        """A fresh value name."""
        self.count += 1
        return f"%v{self.count}"

    def let(self, instruction: str) -> str:
        """Append an instruction with a result; returns the result's name."""
        self.count += 1
        self.lines.append(f"  %v{self.count} = {instruction}")
        return f"%v{self.count}"

    def do(self, instruction: str) -> None:
        """Append an instruction without a result."""
        self.lines.append("  " + instruction)

    def label(self, name: str) -> None:
        """Begin a basic block."""
        self.lines.append(name + ":")
        self.block = name

    def call(self, intrinsic: str, kind: str, *args: str) -> str:
        """Call an overloaded intrinsic of the same type in all places."""
        name, between, declaration = _intrinsic(intrinsic, kind, len(args))
        self.declared.add(declaration)
        return self.let(f"{name}{between.join(args)})")


@cache
def _intrinsic(name: str, kind: str, count: int) -> tuple[str, str, str]:
    """Of a call: what stands before its arguments and between them, and the declaration."""
    head = f"{kind} @llvm.{name}.{intrinsic_suffix(kind)}("
    return f"call {head}{kind} ", f", {kind} ", f"declare {head}{', '.join([kind] * count)})"


_INTERNAL = re.compile(r"(?m)^define internal (.*\)) .*\{$")


def prototypes(text: str) -> list[str]:
    """Declarations of the internal functions of a text, for a module that calls them where they are shared."""
    return [f"declare {re.sub(' %[a-z._]+', '', head)}" for head in re.findall(_INTERNAL, text)]


def intrinsic_suffix(kind: str) -> str:
    """`v8f64` of `<8 x double>`."""
    names = {"double": "f64", "i64": "i64", "i1": "i1", "i128": "i128"}
    if kind in names:
        return names[kind]
    count, _, scalar = kind.strip("<>").split(" ", 2)
    return f"v{count}{names[scalar]}"


def number(value: float) -> str:
    """A double as LLVM writes it, all bits."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"


class Lanes:
    """Arithmetic on `width` doubles at once; every method appends instructions and returns the name of the result."""

    def __init__(self, text: Text, width: int) -> None:
        self.text = text
        self.width = width
        self.real = "double" if width == 1 else f"<{width} x double>"
        self.integer = "i64" if width == 1 else f"<{width} x i64>"
        self.mask = "i1" if width == 1 else f"<{width} x i1>"

    def const(self, value: float) -> str:
        """The same double in every lane."""
        return number(value) if self.width == 1 else f"splat (double {number(value)})"

    def whole(self, value: int) -> str:
        """The same 64-bit integer in every lane."""
        value = value - (1 << 64) if value >= 1 << 63 else value
        return str(value) if self.width == 1 else f"splat (i64 {value})"

    def add(self, x: str, y: str) -> str:
        """Sum x + y."""
        return self.text.let(f"fadd {self.real} {x}, {y}")

    def sub(self, x: str, y: str) -> str:
        """Difference x - y."""
        return self.text.let(f"fsub {self.real} {x}, {y}")

    def mul(self, x: str, y: str) -> str:
        """Product x*y."""
        return self.text.let(f"fmul {self.real} {x}, {y}")

    def div(self, x: str, y: str) -> str:
        """Quotient x/y."""
        return self.text.let(f"fdiv {self.real} {x}, {y}")

    def neg(self, x: str) -> str:
        """-x."""
        return self.text.let(f"fneg {self.real} {x}")

    def fma(self, x: str, y: str, z: str) -> str:
        """x*y + z, rounded once if the target can."""
        return self.text.call("fma", self.real, x, y, z) if self.text.fma else self.add(self.mul(x, y), z)

    def fms(self, x: str, y: str, z: str) -> str:
        """x*y - z."""
        return self.fma(x, y, self.neg(z)) if self.text.fma else self.sub(self.mul(x, y), z)

    def fnma(self, x: str, y: str, z: str) -> str:
        """z - x*y."""
        return self.fma(self.neg(x), y, z) if self.text.fma else self.sub(z, self.mul(x, y))

    def fnms(self, x: str, y: str, z: str) -> str:
        """-(x*y) - z."""
        return self.fms(self.neg(x), y, z)

    def sqrt(self, x: str) -> str:
        """Square root, correctly rounded."""
        return self.text.call("sqrt", self.real, x)

    def fabs(self, x: str) -> str:
        """|x|."""
        return self.text.call("fabs", self.real, x)

    def copysign(self, magnitude: str, sign: str) -> str:
        """The magnitude of one, the sign of the other."""
        return self.text.call("copysign", self.real, magnitude, sign)

    def bits(self, x: str) -> str:
        """The doubles' bits as integers."""
        return self.text.let(f"bitcast {self.real} {x} to {self.integer}")

    def from_bits(self, x: str) -> str:
        """The doubles with these bits."""
        return self.text.let(f"bitcast {self.integer} {x} to {self.real}")

    def integer_op(self, op: str, x: str, y: str) -> str:
        """`and or xor add sub mul shl lshr ashr` on 64-bit integers."""
        return self.text.let(f"{op} {self.integer} {x}, {y}")

    def to_real(self, x: str) -> str:
        """Integers below 2^52 in magnitude as doubles, exactly."""
        # The bits of 1.5 2^52 plus n are the double 1.5 2^52 + n.
        magic = self.integer_op("add", x, self.whole(0x4338000000000000))
        return self.sub(self.from_bits(magic), self.const(6755399441055744.0))

    def compare(self, how: Comparison, x: str, y: str) -> str:
        """Mask of an ordered comparison (`une` and `uno` also hold for NaN)."""
        return self.text.let(f"fcmp {how} {self.real} {x}, {y}")

    def compare_integers(self, how: Predicate, x: str, y: str) -> str:
        """Mask of a comparison of 64-bit integers."""
        return self.text.let(f"icmp {how} {self.integer} {x}, {y}")

    def mask_op(self, op: str, x: str, y: str) -> str:
        """`and or xor` of masks."""
        return self.text.let(f"{op} {self.mask} {x}, {y}")

    def invert(self, x: str) -> str:
        """The other lanes."""
        return self.mask_op("xor", x, "true" if self.width == 1 else "splat (i1 true)")

    def select(self, mask: str, x: str, y: str) -> str:
        """x in the lanes of the mask, y in the others."""
        return self.text.let(f"select {self.mask} {mask}, {self.real} {x}, {self.real} {y}")

    def select_integers(self, mask: str, x: str, y: str) -> str:
        """`select` for 64-bit integers."""
        return self.text.let(f"select {self.mask} {mask}, {self.integer} {x}, {self.integer} {y}")

    def any(self, mask: str) -> str:
        """One i1: some lane of the mask is set."""
        if self.width == 1:
            return mask
        flat = self.text.let(f"bitcast {self.mask} {mask} to i{self.width}")
        return self.text.let(f"icmp ne i{self.width} {flat}, 0")

    def floor(self, x: str) -> str:
        """Largest whole number not above x."""
        if self.text.rounding:
            return self.text.call("floor", self.real, x)
        # Without an instruction for it: to the nearest, and one less where that is above. From 2^52 on all are whole.
        near = self._nearest_below_2_52(x)
        above = self.compare("ogt", near, x)
        return self._kept_if_large(x, self.select(above, self.sub(near, self.const(1.0)), near))

    def ceil(self, x: str) -> str:
        """Smallest whole number not below x."""
        return self.text.call("ceil", self.real, x) if self.text.rounding else self.neg(self.floor(self.neg(x)))

    def trunc(self, x: str) -> str:
        """Whole part, rounded towards 0."""
        if self.text.rounding:
            return self.text.call("trunc", self.real, x)
        return self.copysign(self.floor(self.fabs(x)), x)

    def sign(self, x: str) -> str:
        """-1, 0 or 1; NaN stays."""
        zero, one = self.const(0.0), self.const(1.0)
        above = self.select(self.compare("ogt", x, zero), one, x)
        return self.select(self.compare("olt", x, zero), self.const(-1.0), above)

    def fmin(self, x: str, y: str) -> str:
        """The smaller; of a number and NaN the number, as in C."""
        return self.select(self.compare("uno", y, y), x, self.select(self.compare("olt", x, y), x, y))

    def fmax(self, x: str, y: str) -> str:
        """The larger; of a number and NaN the number, as in C."""
        return self.select(self.compare("uno", y, y), x, self.select(self.compare("ogt", x, y), x, y))

    def load(self, pointer: str, offset: int) -> str:
        """The lanes at an aligned offset, counted in vectors of this width."""
        place = self.text.let(f"getelementptr i8, ptr {pointer}, i64 {offset * self.width * 8}") if offset else pointer
        return self.text.let(f"load {self.real}, ptr {place}, align {8 * self.width}")

    def store(self, value: str, pointer: str, offset: int) -> None:
        """Write the lanes at an aligned offset, counted in vectors of this width."""
        place = self.text.let(f"getelementptr i8, ptr {pointer}, i64 {offset * self.width * 8}") if offset else pointer
        self.text.do(f"store {self.real} {value}, ptr {place}, align {8 * self.width}")

    def _nearest_below_2_52(self, x: str) -> str:
        """x + 2^52 has no place for a fraction: the addition rounds, the subtraction brings x back, whole."""
        big = self.copysign(self.const(4503599627370496.0), x)
        return self.sub(self.add(x, big), big)

    def _kept_if_large(self, x: str, rounded: str) -> str:
        small = self.compare("olt", self.fabs(x), self.const(4503599627370496.0))
        return self.select(small, self.copysign(rounded, x), x)
