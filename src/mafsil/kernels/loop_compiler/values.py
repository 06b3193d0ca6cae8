"""Values of compiled loops and the LLVM instructions that make them: types, conversions, arithmetic, comparisons."""

from __future__ import annotations

import ast
import struct
from collections.abc import Container, Mapping
from dataclasses import dataclass

from mafsil.errors import KernelError


@dataclass(frozen=True, slots=True)
class Kind:
    """A type.

    Attributes:
        llvm: its name in LLVM.
        element: the type of the elements of an array; empty for a number.
        record: the name of the record that an address leads to; empty for others.
        rows: whether it leads to rows of such records.
    """

    llvm: str
    element: str = ""
    record: str = ""
    rows: bool = False

    @property
    def address(self) -> bool:
        """Whether it is an array, a record or rows of records."""
        return self.llvm == "ptr"


INTEGER, REAL, SINGLE, TRUTH = Kind("i64"), Kind("double"), Kind("float"), Kind("i1")
ANNOTATIONS = {
    "int": INTEGER,
    "float": REAL,
    "bool": TRUTH,
    "Floats": Kind("ptr", "double"),
    "JointVector": Kind("ptr", "double"),
    "Whole": Kind("ptr", "i64"),
    "Singles": Kind("ptr", "float"),
}
"""How functions say the types of their arguments and results."""
FIELD = 8
"""Bytes of a field of a record."""
Layout = Mapping[str, Kind]
"""Name -> type of every field of a record, in their order."""


def kind_of(annotation: str, records: Container[str]) -> Kind:
    """The type that an annotation says: a number, an array, a record, or `Rows[...]` of one.

    Args:
        annotation: as it is written.
        records: names of the program's records.

    Raises:
        KernelError: none of these.
    """
    if annotation in ANNOTATIONS:
        return ANNOTATIONS[annotation]
    name = annotation.removeprefix("Rows[").removesuffix("]")
    if name not in records:
        raise refused(f"the annotation {annotation!r}")
    return Kind("ptr", record=name, rows=name != annotation)


SIZES = {"double": 8, "i64": 8, "float": 4}
OPERATIONS: dict[type[ast.operator], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%",
    ast.LShift: "<<", ast.RShift: ">>", ast.BitAnd: "&", ast.BitOr: "|",
}  # fmt: skip
ORDERS: dict[type[ast.cmpop], str] = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
_RANK = {TRUTH: 0, INTEGER: 1, SINGLE: 2, REAL: 3}
_REAL_OPERATIONS = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv"}
_INTEGER_OPERATIONS = {"+": "add nsw", "-": "sub nsw", "*": "mul nsw", "<<": "shl", ">>": "ashr", "&": "and", "|": "or"}
_ORDERS = {"<": ("slt", "olt"), "<=": ("sle", "ole"), ">": ("sgt", "ogt"), ">=": ("sge", "oge"), "==": ("eq", "oeq")}
_ORDERS["!="] = ("ne", "une")


@dataclass(frozen=True, slots=True)
class Value:
    """A number or array that an instruction made, or a constant.

    Attributes:
        kind: its type.
        name: in LLVM IR.
    """

    kind: Kind
    name: str


def constant(x: bool | int | float) -> Value:
    """A number written in the source."""
    if isinstance(x, bool):
        return Value(TRUTH, "true" if x else "false")
    if isinstance(x, int):
        return Value(INTEGER, str(x))
    return Value(REAL, f"0x{struct.unpack('<Q', struct.pack('<d', x))[0]:016X}")


class Block:
    """The instructions of one function, in the order in which they are emitted; variables live in its first block.

    1. Every variable is a cell of memory (`alloca` in the first block), read and written like one of C. LLVM turns
       cells into registers; so nobody here has to know which value a variable has where two paths meet.
    2. Instructions are appended in order; `label` begins a basic block, `jump` and `branch` end one.
    3. After an end nothing is appended until the next label: what stands behind `return` or `break` is never reached,
       and IR allows no instruction there.
    """

    def __init__(self) -> None:
        self.heads: list[str] = []
        self.lines: list[str] = []
        self.ended = False
        self._count = 0

    def name(self, stem: str = "t") -> str:
        """A name that no other value or label has."""
        self._count += 1
        return f"{stem}{self._count}"

    def do(self, text: str) -> None:
        """An instruction without a value."""
        if not self.ended:
            self.lines.append("  " + text)

    def let(self, kind: Kind, text: str) -> Value:
        """The value of an instruction."""
        made = Value(kind, "%" + self.name())
        self.do(f"{made.name} = {text}")
        return made

    def cell(self, kind: Kind, count: int = 1) -> Value:
        """Memory of the function for a variable, or for an array of fixed size."""
        made = Value(Kind("ptr", kind.llvm), "%" + self.name("m"))
        what = kind.llvm if count == 1 else f"[{count} x {kind.llvm}]"
        self.heads.append(f"  {made.name} = alloca {what}, align {64 if count > 1 else 8}")
        return made

    def label(self, name: str) -> None:
        """Begin a block; whoever falls through from the one before jumps there."""
        self.jump(name)
        self.lines.append(f"{name}:")
        self.ended = False

    def end(self, text: str) -> None:
        """The last instruction of a block; what follows before the next label is never reached and dropped."""
        self.do(text)
        self.ended = True

    def jump(self, name: str) -> None:
        """End the block by going on elsewhere."""
        self.end(f"br label %{name}")

    def branch(self, condition: Value, yes: str, no: str) -> None:
        """End the block by going on at one of two places."""
        self.end(f"br i1 {condition.name}, label %{yes}, label %{no}")

    def load(self, place: Value) -> Value:
        """The number at an address."""
        element = place.kind.element
        return self.let(
            Kind(element), f"load {element}, ptr {place.name}, align {SIZES.get(element, 1)}, {_tag(element)}"
        )

    def store(self, value: Value, place: Value) -> None:
        """Write a number to an address, converted to the type there."""
        element = place.kind.element
        value = self.converted(value, Kind(element))
        self.do(f"store {element} {value.name}, ptr {place.name}, align {SIZES.get(element, 1)}, {_tag(element)}")

    def keep(self, value: Value, place: Value, kind: Kind) -> None:
        """Give a variable of a type its value, a number or an array.

        Raises:
            KernelError: an array of another type.
        """
        if not kind.address:
            self.store(value, place)
        elif value.kind == kind:
            self.store(Value(Kind("ptr"), value.name), place)
        else:
            raise refused("an array of another type")

    def kept(self, place: Value, kind: Kind) -> Value:
        """The value of a variable."""
        return Value(kind, self.load(place).name)

    def moved(self, array: Value, index: Value) -> Value:
        """The array from an element on."""
        by = self.converted(index, INTEGER).name
        return self.let(array.kind, f"getelementptr inbounds {array.kind.element}, ptr {array.name}, i64 {by}")

    def field(self, record: Value, index: int, kind: Kind) -> Value:
        """The number or address in a field of a record."""
        place = self._field(record, index)
        # Addresses are given from outside: as long as a loop runs they stay what they are.
        fixed = ", !invariant.load !9" if kind.address else ""
        return self.let(kind, f"load {kind.llvm}, ptr {place}, align {FIELD}, {_tag('')}{fixed}")

    def set_field(self, record: Value, index: int, kind: Kind, value: Value) -> None:
        """Write a number to a field of a record.

        Raises:
            KernelError: an address, which is given from outside only.
        """
        if kind.address:
            raise refused("another array for a field")
        place, name = self._field(record, index), self.converted(value, kind).name
        self.do(f"store {kind.llvm} {name}, ptr {place}, align {FIELD}, {_tag('')}")

    def _field(self, record: Value, index: int) -> str:
        return self.let(record.kind, f"getelementptr inbounds i64, ptr {record.name}, i64 {index}").name

    def member(self, rows: Value, index: Value, size: int) -> Value:
        """One of some records of so many fields."""
        place = self.arithmetic("*", self.converted(index, INTEGER), constant(size))
        kind = Kind("ptr", record=rows.kind.record)
        return self.let(kind, f"getelementptr inbounds i64, ptr {rows.name}, i64 {place.name}")

    def converted(self, value: Value, kind: Kind) -> Value:
        """The value as another type; only numbers are, and none loses its fraction unasked.

        Raises:
            KernelError: no such conversion.
        """
        if value.kind == kind:
            return value
        if value.kind in _RANK and kind in _RANK:
            return self._number(value, kind)
        raise refused(f"{value.kind} where {kind} is needed")

    def _number(self, value: Value, kind: Kind) -> Value:
        if value.kind == INTEGER and kind in (REAL, SINGLE):
            if value.name.lstrip("-").isdigit() and kind == REAL:
                return constant(float(value.name))
            return self.let(kind, f"sitofp i64 {value.name} to {kind.llvm}")
        if value.kind == SINGLE and kind == REAL:
            return self.let(kind, f"fpext float {value.name} to double")
        if value.kind == TRUTH and kind == INTEGER:
            return self.let(kind, f"zext i1 {value.name} to i64")
        if value.kind == TRUTH and kind == REAL:
            return self.let(kind, f"uitofp i1 {value.name} to double")
        raise refused(f"{value.kind.llvm} where {kind.llvm} is needed")

    def rounded(self, value: Value, kind: Kind) -> Value:
        """The value as a type that may not hold all of it, as `int` and `np.float32` do."""
        if value.kind in (REAL, SINGLE) and kind == INTEGER:
            return self.let(kind, f"fptosi {value.kind.llvm} {value.name} to i64")
        if value.kind == REAL and kind == SINGLE:
            return self.let(kind, f"fptrunc double {value.name} to float")
        return self.converted(value, kind)

    def alike(self, a: Value, b: Value) -> tuple[Value, Value]:
        """Both numbers in the wider of their types."""
        if a.kind not in _RANK or b.kind not in _RANK:
            raise refused("arithmetic of arrays")
        kind = max(a.kind, b.kind, key=_RANK.__getitem__)
        return self.converted(a, kind), self.converted(b, kind)

    def arithmetic(self, operation: str, a: Value, b: Value) -> Value:
        """One of + - * / // % << >> & | as Python means it; whole numbers are taken to fit 64 bits."""
        if operation == "/":
            a, b = (self.converted(x, REAL) if x.kind == INTEGER else x for x in (a, b))
        a, b = self.alike(a, b)
        if a.kind in (REAL, SINGLE):
            if operation not in _REAL_OPERATIONS:
                raise refused(f"{operation} of real numbers")
            return self.let(a.kind, f"{_REAL_OPERATIONS[operation]} {a.kind.llvm} {a.name}, {b.name}")
        a, b = self.converted(a, INTEGER), self.converted(b, INTEGER)
        if operation in ("//", "%"):
            return self._floored(operation, a, b)
        return self.let(INTEGER, f"{_INTEGER_OPERATIONS[operation]} i64 {a.name}, {b.name}")

    def _floored(self, operation: str, a: Value, b: Value) -> Value:
        """Quotient or remainder as Python rounds: towards minus infinity."""
        rest = self.let(INTEGER, f"srem i64 {a.name}, {b.name}")
        signs = self.let(INTEGER, f"xor i64 {rest.name}, {b.name}")
        off = self.let(TRUTH, f"icmp slt i64 {signs.name}, 0")
        some = self.let(TRUTH, f"icmp ne i64 {rest.name}, 0")
        wrong = self.let(TRUTH, f"and i1 {off.name}, {some.name}")
        if operation == "%":
            moved = self.let(INTEGER, f"add i64 {rest.name}, {b.name}")
            return self.selected(wrong, moved, rest)
        quotient = self.let(INTEGER, f"sdiv i64 {a.name}, {b.name}")
        less = self.let(INTEGER, f"sub i64 {quotient.name}, 1")
        return self.selected(wrong, less, quotient)

    def compared(self, order: str, a: Value, b: Value) -> Value:
        """One of < <= > >= == != of two numbers."""
        a, b = self.alike(a, b)
        real = a.kind in (REAL, SINGLE)
        return self.let(TRUTH, f"{'fcmp' if real else 'icmp'} {_ORDERS[order][real]} {a.kind.llvm} {a.name}, {b.name}")

    def selected(self, condition: Value, yes: Value, no: Value) -> Value:
        """One of two values."""
        if yes.kind != no.kind:
            yes, no = self.alike(yes, no)
        llvm = yes.kind.llvm
        return self.let(yes.kind, f"select i1 {condition.name}, {llvm} {yes.name}, {llvm} {no.name}")

    def truth(self, value: Value) -> Value:
        """Whether a number is not zero."""
        return value if value.kind == TRUTH else self.compared("!=", value, constant(0))

    def negated(self, value: Value) -> Value:
        """The other sign."""
        if value.kind == INTEGER:
            return self.arithmetic("-", constant(0), value)
        return self.let(value.kind, f"fneg {value.kind.llvm} {value.name}")


def refused(reason: str) -> KernelError:
    """What is raised where a function is not of the language."""
    return KernelError("kernels.refused", reason=reason)


def _tag(element: str) -> str:
    """Which memory an access may touch: arrays of one type never lie over arrays of another."""
    return f"!tbaa !{ {'double': 1, 'i64': 2, 'float': 3}.get(element, 4) }"


TAGS = """
!0 = !{!"loops"}
!9 = !{}
!5 = !{!"double", !0}
!6 = !{!"i64", !0}
!7 = !{!"float", !0}
!8 = !{!"other", !0}
!1 = !{!5, !5, i64 0}
!2 = !{!6, !6, i64 0}
!3 = !{!7, !7, i64 0}
!4 = !{!8, !8, i64 0}
"""
"""What the tags of loads and stores mean, at the end of a module."""
