"""Expressions of compiled loops as LLVM IR: names, elements, arithmetic, logic and calls."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Mapping

from mafsil.kernels.loop_compiler.headers import Header
from mafsil.kernels.loop_compiler.values import (
    INTEGER,
    OPERATIONS,
    ORDERS,
    REAL,
    SINGLE,
    TRUTH,
    Block,
    Kind,
    Layout,
    Value,
    constant,
    refused,
)

_EXACT = 2.0**52
"""From here on every float64 is an integer: adding and taking it away rounds smaller ones, ties to even."""


class Expressions:
    """Values of the expressions of one function.

    Args:
        headers: of all functions of the program.
        constants: of its module.
        records: of the program.
    """

    def __init__(
        self, headers: Mapping[str, Header], constants: Mapping[str, int | float], records: Mapping[str, Layout]
    ) -> None:
        self.headers, self.constants, self.records = headers, constants, records
        self.block = Block()
        self.variables: dict[str, tuple[Kind, Value]] = {}
        self.forms: dict[type[ast.expr], Callable[..., Value]] = {
            ast.Constant: self.literal,
            ast.Name: self.name,
            ast.Attribute: self.attribute,
            ast.BinOp: self.binary,
            ast.UnaryOp: self.unary,
            ast.BoolOp: self.logic,
            ast.Compare: self.comparison,
            ast.IfExp: self.conditional,
            ast.Subscript: self.subscript,
            ast.Call: self.called,
        }
        of_two: dict[str, Callable[[Value, Value], Value]] = {
            "min": lambda a, b: self.block.selected(self.block.compared("<", b, a), b, a),
            "max": lambda a, b: self.block.selected(self.block.compared(">", b, a), b, a),
        }
        of_one: dict[str, Callable[[Value], Value]] = {
            "abs": self.absolute,
            "int": lambda x: self.block.rounded(x, INTEGER),
            "float": lambda x: self.block.converted(x, REAL),
            "address": lambda x: self.block.let(INTEGER, f"ptrtoint ptr {x.name} to i64"),
            "np.float32": lambda x: self.block.rounded(x, SINGLE),
            "np.sqrt": lambda x: self.block.let(
                REAL, f"call double @llvm.sqrt.f64(double {self.block.converted(x, REAL).name})"
            ),
            "np.rint": self.nearest_integer,
        }
        self.builtins: dict[str, Callable[..., Value]] = {**of_one, **of_two}

    def value(self, node: ast.expr) -> Value:
        """The value of an expression."""
        form = self.forms.get(type(node))
        if form is None:
            raise refused(ast.unparse(node))
        return form(node)

    def truth(self, node: ast.expr) -> Value:
        """The value as a condition."""
        return self.block.truth(self.value(node))

    def assign(self, name: str, value: Value) -> None:
        """Give a variable a value; its first one decides its type."""
        if name not in self.variables:
            self.variables[name] = value.kind, self.block.cell(value.kind)
        kind, place = self.variables[name]
        self.block.keep(value, place, kind)

    def literal(self, node: ast.Constant) -> Value:
        """A number written in the source."""
        if not isinstance(node.value, int | float):
            raise refused(ast.unparse(node))
        return constant(node.value)

    def name(self, node: ast.Name) -> Value:
        """A variable, or a constant of the module."""
        if node.id in self.variables:
            kind, place = self.variables[node.id]
            return self.block.kept(place, kind)
        if node.id in self.constants:
            return constant(self.constants[node.id])
        raise refused(f"the name {node.id}")

    def attribute(self, node: ast.Attribute) -> Value:
        """`np.pi`, `np.inf` or the field of a record."""
        known = {"np.pi": math.pi, "np.inf": math.inf}
        if ast.unparse(node) in known:
            return constant(known[ast.unparse(node)])
        return self.block.field(*self.field(node))

    def field(self, node: ast.Attribute) -> tuple[Value, int, Kind]:
        """The record whose field it is, the field's place there, and its type."""
        record = self.value(node.value)
        layout = self.records.get(record.kind.record, {})
        if node.attr not in layout or record.kind.rows:
            raise refused(ast.unparse(node))
        return record, list(layout).index(node.attr), layout[node.attr]

    def binary(self, node: ast.BinOp) -> Value:
        """Arithmetic of two numbers; the only power is the square."""
        if isinstance(node.op, ast.Pow):
            base = self.value(node.left)
            if not isinstance(node.right, ast.Constant) or node.right.value != 2:
                raise refused(ast.unparse(node))
            return self.block.arithmetic("*", base, base)
        return self.block.arithmetic(OPERATIONS[type(node.op)], self.value(node.left), self.value(node.right))

    def unary(self, node: ast.UnaryOp) -> Value:
        """`-x` or `not x`."""
        if isinstance(node.op, ast.Not):
            return self.block.let(TRUTH, f"xor i1 {self.truth(node.operand).name}, true")
        if not isinstance(node.op, ast.USub):
            raise refused(ast.unparse(node))
        return self.block.negated(self.value(node.operand))

    def logic(self, node: ast.BoolOp) -> Value:
        """`and` and `or` of conditions: what comes after the deciding one is not looked at."""
        # found = part; if `and` and it is false, or `or` and it is true, goto decided; else on to the next part.
        found, after = self.block.cell(TRUTH), self.block.name("decided")
        for part in node.values:
            value = self.truth(part)
            self.block.store(value, found)
            if part is not node.values[-1]:
                ahead = self.block.name("ahead")
                both = (ahead, after) if isinstance(node.op, ast.And) else (after, ahead)
                self.block.branch(value, *both)
                self.block.label(ahead)
        self.block.label(after)
        return self.block.load(found)

    def comparison(self, node: ast.Compare) -> Value:
        """One comparison or a chain of them."""
        values = [self.value(each) for each in (node.left, *node.comparators)]
        orders = [ORDERS[type(each)] for each in node.ops]
        found = [self.block.compared(order, values[k], values[k + 1]) for k, order in enumerate(orders)]
        all_of = found[0]
        for each in found[1:]:
            all_of = self.block.let(TRUTH, f"and i1 {all_of.name}, {each.name}")
        return all_of

    def conditional(self, node: ast.IfExp) -> Value:
        """`a if c else b`: only one of the two is found; both are of the type of the first."""
        yes, no, after = (self.block.name(stem) for stem in ("yes", "no", "after"))
        self.block.branch(self.truth(node.test), yes, no)
        self.block.label(yes)
        value = self.value(node.body)
        found = self.block.cell(value.kind)
        self.block.keep(value, found, value.kind)
        self.block.jump(after)
        self.block.label(no)
        self.block.keep(self.value(node.orelse), found, value.kind)
        self.block.label(after)
        return self.block.kept(found, value.kind)

    def place(self, node: ast.Subscript) -> Value:
        """The array that begins at the element."""
        return self.moved(node, self.value(node.value), node.slice)

    def subscript(self, node: ast.Subscript) -> Value:
        """An element, a member of some records, or the view from an element on."""
        array, index = self.value(node.value), node.slice
        if isinstance(index, ast.Slice):
            if index.upper or index.step or index.lower is None:
                raise refused(ast.unparse(node))
            return self.moved(node, array, index.lower)
        if array.kind.rows:
            return self.block.member(array, self.value(index), len(self.records[array.kind.record]))
        return self.block.load(self.moved(node, array, index))

    def moved(self, node: ast.Subscript, array: Value, index: ast.expr) -> Value:
        """The array from an element on."""
        if not array.kind.element:
            raise refused(ast.unparse(node))
        return self.block.moved(array, self.value(index))

    def called(self, node: ast.expr) -> Value:
        """A call with a result."""
        assert isinstance(node, ast.Call)
        found = self.call(node)
        if found is None:
            raise refused(f"the result of {ast.unparse(node)}")
        return found

    def call(self, node: ast.Call) -> Value | None:
        """A call of a function of the program or of the language."""
        name = ast.unparse(node.func)
        if name == "np.empty":
            return self.array(node)
        values = [self.value(each) for each in node.args]
        if name in self.builtins:
            return self.builtins[name](*values)
        if name == "run_kernel":
            entry = self.block.let(Kind("ptr"), f"inttoptr i64 {values[0].name} to ptr")
            given = ", ".join(f"ptr {value.name}" for value in values[1:])
            self.block.do(f"call void {entry.name}({given}, ptr null)")
            return None
        if name not in self.headers:
            raise refused(f"the function {name}")
        return self.own(self.headers[name], values)

    def own(self, header: Header, values: list[Value]) -> Value | None:
        """A call of a function of the program."""
        pairs = zip(header.arguments.values(), values, strict=True)
        given = ", ".join(f"{kind.llvm} {self.block.converted(value, kind).name}" for kind, value in pairs)
        if header.result is None:
            self.block.do(f"call void @{header.name}({given})")
            return None
        return self.block.let(header.result, f"call {header.result.llvm} @{header.name}({given})")

    def array(self, node: ast.Call) -> Value:
        """`np.empty(12)` or `np.empty(12, np.int64)`: memory of the function; a number or a constant is its size."""
        kinds = {"np.float64": REAL, "np.int64": INTEGER, "np.float32": SINGLE}
        kind = kinds[ast.unparse(node.args[1])] if len(node.args) > 1 else REAL
        size = self.value(node.args[0])
        if not size.name.isdigit():
            raise refused(f"the size in {ast.unparse(node)}")
        return self.block.cell(kind, int(size.name))

    def absolute(self, x: Value) -> Value:
        """`abs`."""
        if x.kind == INTEGER:
            return self.block.selected(self.block.compared("<", x, constant(0)), self.block.negated(x), x)
        name = "llvm.fabs.f64" if x.kind == REAL else "llvm.fabs.f32"
        return self.block.let(x.kind, f"call {x.kind.llvm} @{name}({x.kind.llvm} {x.name})")

    def nearest_integer(self, x: Value) -> Value:
        """`np.rint` without a call of the system's library, which not all processors can do without."""
        x = self.block.converted(x, REAL)
        size = self.absolute(x)
        moved = self.block.arithmetic("-", self.block.arithmetic("+", size, constant(_EXACT)), constant(_EXACT))
        signed = self.block.let(REAL, f"call double @llvm.copysign.f64(double {moved.name}, double {x.name})")
        return self.block.selected(self.block.compared("<", size, constant(_EXACT)), signed, x)

    def range_of(self, node: ast.expr) -> list[ast.expr]:
        """What is given to the `range` that a `for` counts through."""
        if not isinstance(node, ast.Call) or ast.unparse(node.func) != "range":
            raise refused(f"for in {ast.unparse(node)}")
        return node.args
