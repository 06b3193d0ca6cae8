"""The instructions of one function: values, cells for variables, basic blocks, memory and what it may overlap with.

1. A variable that is given a value once is that value. One that changes is a cell of memory (`alloca` in the first
   block) for each of its parts; LLVM turns cells into registers, so nobody here has to know which value a variable has
   where two paths meet.
2. Instructions are appended in order; `label` begins a basic block, `jump` and `branch` end one.
3. After an end nothing is appended until the next label: what stands behind `return` or `break` is never reached, and
   IR allows no instruction there.
"""

from __future__ import annotations

import hashlib
import struct
from typing import Any, Protocol

from numpy.typing import NDArray

from mafsil.kernels.loops.kinds import (
    BITS,
    BOOL,
    INTEGER,
    LANES,
    REAL,
    VECTOR,
    Array,
    Held,
    Kind,
    Number,
    Tuple,
    refusal,
    slot_size,
)

Constant = bool | int | float
TAGS = {"float64": 1, "int64": 2, "float32": 3, "slot": 4, "bool": 5, "int32": 6, "int16": 7, "int8": 8}
"""What an access may touch: elements of one type never lie over those of another, nor over slots of tuples."""


class Value:
    """A value that instructions made, or a constant.

    Attributes:
        kind: its type.
        parts: in LLVM IR, one for each part of the kind.
        constant: the number, where it is known.
        natural: whether it is known not to be negative.
    """

    __slots__ = ("constant", "kind", "natural", "parts")

    def __init__(
        self, kind: Kind, parts: tuple[str, ...], constant: Constant | None = None, natural: bool = False
    ) -> None:
        self.kind, self.parts, self.constant, self.natural = kind, parts, constant, natural

    @property
    def name(self) -> str:
        """The only part."""
        return self.parts[0]


class Referred(Value):
    """A tuple in memory: its items are read where they are asked for.

    Attributes:
        base: address in LLVM IR.
        offset: bytes from there.
        fixed: whether the memory stays as it is as long as the outermost loop runs.
    """

    __slots__ = ("base", "fixed", "offset")

    def __init__(self, kind: Tuple, base: str, offset: int, fixed: bool) -> None:
        super().__init__(kind, ())
        self.base, self.offset, self.fixed = base, offset, fixed


def constant(x: Constant) -> Value:
    """A number written in the source."""
    if isinstance(x, bool):
        return Value(BOOL, ("true" if x else "false",), x)
    if isinstance(x, int):
        return Value(INTEGER, (str(x),), x, x >= 0)
    return Value(REAL, (real_text(x),), x)


def real_text(x: float) -> str:
    """A float64 in LLVM IR, bit for bit."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', x))[0]:016X}"


_COUNTED_LOOP, _SHORT_LOOP = 60, 63
"""Numbers of the metadata of loops that are not copied for several turns at once: those whose number of turns is known
may fill vectors, the others stay as they are."""


class Block:
    """Instructions of one function.

    Args:
        fast: flags of its arithmetic.
    """

    def __init__(self, fast: str) -> None:
        self.fast = fast
        self.heads: list[str] = []
        self.lines: list[str] = []
        self.declared: set[str] = set()
        self.targets: set[str] = set()
        self.ended = False
        self.here = "entry"
        self._count = 0

    def fresh(self, stem: str = "v") -> str:
        """A name that no other value or label has."""
        self._count += 1
        return f"{stem}{self._count}"

    def do(self, text: str) -> None:
        """An instruction without a value."""
        if not self.ended:
            self.lines.append("  " + text)

    def let(self, text: str) -> str:
        """The part that an instruction makes."""
        self._count += 1
        if not self.ended:
            self.lines.append(f"  %v{self._count} = {text}")
        return f"%v{self._count}"

    def number(self, kind: Kind, text: str) -> Value:
        """A value of one part."""
        return Value(kind, (self.let(text),))

    def label(self, name: str) -> None:
        """Begin a block; whoever falls through from the one before jumps there."""
        self.jump(name)
        self.lines.append(f"{name}:")
        self.ended, self.here = False, name

    def end(self, text: str) -> None:
        """The last instruction of a block."""
        self.do(text)
        self.ended = True

    def jump(self, name: str) -> None:
        """End the block by going on elsewhere."""
        if not self.ended:
            self.targets.add(name)
        self.end(f"br label %{name}")

    def again(self, name: str, *, counted: bool = False) -> None:
        """Go back to where a loop begins.

        Most loops count joints or axes: copies of their bodies for eight turns at once cost half of LLVM's time and are
        never reached. Loops whose sums may be reordered are along rows, and get them.

        Args:
            name: label of the beginning.
            counted: whether the number of turns is a constant.
        """
        if self.ended or self.fast:
            return self.jump(name)
        self.targets.add(name)
        return self.end(f"br label %{name}, !llvm.loop !{_COUNTED_LOOP if counted else _SHORT_LOOP}")

    def branch(self, condition: str, yes: str, no: str) -> None:
        """End the block by going on at one of two places."""
        if not self.ended:
            self.targets |= {yes, no}
        self.end(f"br i1 {condition}, label %{yes}, label %{no}")

    def call(self, name: str, result: str, *given: str) -> str:
        """The result of a function of LLVM or of the system: arguments with their types."""
        types = ", ".join(part.rsplit(" ", 1)[0] for part in given)
        self.declared.add(f"declare {result} @{name}({types})")
        text = f"call {self.fast if result == 'double' else ''}{result} @{name}({', '.join(given)})"
        if result == "void":
            self.do(text)
            return ""
        return self.let(text)

    def table(self, kind: Array, numbers: NDArray[Any]) -> Value:
        """An array of the module as constants of the code."""
        if kind.of not in (REAL, INTEGER) or not kind.contiguous:
            raise refusal(f"{kind} as constants")
        name = f"@table.{hashlib.blake2b(numbers.tobytes(), digest_size=8).hexdigest()}"
        texts = [constant(number).name for number in numbers.reshape(-1).tolist()]
        of = f"[{len(texts)} x {kind.of.element}]"
        items = ", ".join(f"{kind.of.element} {text}" for text in texts)
        self.declared.add(f"{name} = private unnamed_addr constant {of} [{items}], align 64")
        return Value(kind, (name, *map(str, numbers.shape)))

    # Memory -----------------------------------------------------------------------------------------------------------

    def cells(self, kind: Kind) -> tuple[str, ...]:
        """Memory of the function for the parts of a variable."""
        made = tuple(f"%{self.fresh('m')}" for _ in kind.parts)
        self.heads += [f"  {name} = alloca {part}" for name, part in zip(made, kind.parts, strict=True)]
        return made

    def room(self, size: int, align: int = 8) -> str:
        """Memory of the function, so many bytes."""
        name = f"%{self.fresh('m')}"
        self.heads.append(f"  {name} = alloca [{size} x i8], align {align}")
        return name

    def keep(self, value: Value, cells: tuple[str, ...]) -> None:
        """Give a variable its value."""
        for part, kind, cell in zip(self.explode(value).parts, value.kind.parts, cells, strict=True):
            self.do(f"store {kind} {part}, ptr {cell}")

    def read_variable(self, kind: Kind, cells: tuple[str, ...]) -> Value:
        """The value of a variable."""
        return Value(
            kind, tuple(self.let(f"load {part}, ptr {cell}") for part, cell in zip(kind.parts, cells, strict=True))
        )

    def item(self, value: Value, index: int) -> Value:
        """An item of a tuple."""
        kind = value.kind
        assert isinstance(kind, Tuple)
        item = kind.items[index]
        if isinstance(value, Referred):
            return self.refer(item, value.base, value.offset + kind.offsets[index], value.fixed)
        begin = sum(len(each.parts) for each in kind.items[:index])
        return Value(item, value.parts[begin : begin + len(item.parts)])

    def refer(self, kind: Kind, base: str, offset: int, fixed: bool) -> Value:
        """What lies in slots of memory; a tuple is not read yet."""
        if isinstance(kind, Tuple) and kind.items:
            return Referred(kind, base, offset, fixed)
        parts: list[str] = []
        for part in kind.parts:
            parts.append(self._load_slot(part, base, offset, fixed))
            offset += slot_size(part)
        return Value(kind, tuple(parts))

    def explode(self, value: Value) -> Value:
        """The value with all its parts at hand."""
        if not isinstance(value, Referred):
            return value
        kind = value.kind
        assert isinstance(kind, Tuple)
        items = [self.explode(self.item(value, i)) for i in range(len(kind.items))]
        return Value(kind, sum((item.parts for item in items), ()))

    def address_of(self, value: Value) -> str:
        """Where a tuple lies in memory; it is written there first if it does not."""
        if isinstance(value, Referred):
            return self.offset(value.base, value.offset)
        place, offset = self.room(max(value.kind.size, 8)), 0
        for part, kind in zip(value.parts, value.kind.parts, strict=True):
            self._store_slot(part, kind, place, offset)
            offset += slot_size(kind)
        return place

    def open_tuple(self, held: Value) -> Value:
        """The tuple that is held."""
        kind = held.kind
        assert isinstance(kind, Held)
        return self.refer(kind.value, held.name, 0, True)

    def offset(self, base: str, offset: int) -> str:
        """An address so many bytes on."""
        return self.let(f"getelementptr inbounds i8, ptr {base}, i64 {offset}") if offset else base

    def _load_slot(self, part: str, base: str, offset: int, fixed: bool) -> str:
        place = self.offset(base, offset)
        kind = {"i1": "i8", BITS: "i8"}.get(part, part)
        made = self.let(
            f"load {kind}, ptr {place}, align 8, !tbaa !{TAGS['slot']}" + (", !invariant.load !9" if fixed else "")
        )
        if part == "i1":
            return self.let(f"trunc i8 {made} to i1")
        return self.let(f"bitcast i8 {made} to {BITS}") if part == BITS else made

    def _store_slot(self, part: str, kind: str, base: str, offset: int) -> None:
        place = self.offset(base, offset)
        if kind == "i1":
            part, kind = self.let(f"zext i1 {part} to i8"), "i8"
        elif kind == BITS:
            part, kind = self.let(f"bitcast {BITS} {part} to i8"), "i8"
        self.do(f"store {kind} {part}, ptr {place}, align 8, !tbaa !{TAGS['slot']}")

    def load_element(self, of: Number, place: str) -> Value:
        """The element of an array at an address."""
        tag = f"!tbaa !{TAGS[of.tag]}"
        if len(of.parts) == 2:
            second = self.offset(place, 8)
            return Value(of, tuple(self.let(f"load double, ptr {each}, align 8, {tag}") for each in (place, second)))
        made = self.let(f"load {of.element}, ptr {place}, {tag}")
        if of is BOOL:
            return Value(of, (self.let(f"trunc i8 {made} to i1"),))
        if of.element != of.parts[0]:
            return Value(INTEGER, (self.let(f"{'zext' if of.name[0] == 'u' else 'sext'} {of.element} {made} to i64"),))
        return Value(of, (made,))

    def store_element(self, of: Number, value: Value, place: str) -> None:
        """Write an element, whose value is of this kind."""
        tag = f"!tbaa !{TAGS[of.tag]}"
        if len(of.parts) == 2:
            for part, each in zip(value.parts, (place, self.offset(place, 8)), strict=True):
                self.do(f"store double {part}, ptr {each}, align 8, {tag}")
            return
        part = value.name
        if of is BOOL:
            part = self.let(f"zext i1 {part} to i8")
        elif of.element != of.parts[0]:
            part = self.let(f"trunc i64 {part} to {of.element}")
        self.do(f"store {of.element} {part}, ptr {place}, {tag}")

    def load_lanes(self, place: str) -> Value:
        """Eight numbers side by side."""
        return Value(LANES, (self.let(f"load {VECTOR}, ptr {place}, align 8, !tbaa !{TAGS['float64']}"),))

    def store_lanes(self, value: Value, place: str) -> None:
        """Write eight numbers side by side."""
        self.do(f"store {VECTOR} {value.name}, ptr {place}, align 8, !tbaa !{TAGS['float64']}")

    # Where two paths meet ---------------------------------------------------------------------------------------------

    def either(self, kind: Kind, ends: list[tuple[Value, str]]) -> Value:
        """The value of the path that was taken.

        Args:
            kind: of all the values.
            ends: values, and the blocks that they come from.
        """
        parts: list[str] = []
        for i, part in enumerate(kind.parts):
            pairs = ", ".join(f"[ {value.parts[i]}, %{block} ]" for value, block in ends)
            parts.append(self.let(f"phi {part} {pairs}"))
        return Value(kind, tuple(parts), natural=all(value.natural for value, _ in ends))


METADATA = (
    '\n!0 = !{!"loops"}\n!9 = !{}\n!61 = !{!"llvm.loop.unroll.runtime.disable"}\n'
    f"!{_COUNTED_LOOP} = distinct !{{!{_COUNTED_LOOP}, !61, !62}}\n"
    '!62 = !{!"llvm.loop.interleave.count", i32 1}\n'
    f"!{_SHORT_LOOP} = distinct !{{!{_SHORT_LOOP}, !61, !64}}\n"
    '!64 = !{!"llvm.loop.vectorize.enable", i1 false}\n'
) + "".join(
    f'!{number} = !{{!{number + 20}, !{number + 20}, i64 0}}\n!{number + 20} = !{{!"{name}", !0}}\n'
    for name, number in TAGS.items()
)
"""What the tags of loads and stores mean, at the end of a module."""


def tuple_value(block: Block, kind: Tuple, items: list[Value]) -> Value:
    """A tuple of these values."""
    exploded = [block.explode(item) for item in items]
    return Value(kind, sum((item.parts for item in exploded), ()))


class Translator(Protocol):
    """A function that is being translated, as the functions of the language see it."""

    block: Block

    def arithmetic(self, operation: str, a: Value, b: Value) -> Value:
        """The result of an operation."""
        ...

    def allocate(self, of: Number, shape: list[Value], *, clear: bool = False) -> Value:
        """A new array."""
        ...

    def call_loop(self, loop: Any, values: list[Value]) -> Value:
        """A call of another loop."""
        ...

    def lane_place(self, base: Value, index: Value) -> str:
        """Address of a place of a buffer."""
        ...

    def along(self, given: list[Value]) -> Value:
        """What one row of a result takes of an operand."""
        ...
