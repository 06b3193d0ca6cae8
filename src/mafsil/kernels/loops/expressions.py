"""Expressions of compiled loops as LLVM IR: names, elements, arithmetic, logic and calls."""

from __future__ import annotations

import ast
import builtins
from collections.abc import Callable, Sequence
from types import ModuleType
from typing import Any, cast

import numpy as np

from mafsil.kernels.loops import arrays, library, numbers
from mafsil.kernels.loops.arrays import Index, Span
from mafsil.kernels.loops.block import Block, Value, constant, tuple_value
from mafsil.kernels.loops.definition import Callee
from mafsil.kernels.loops.functions import FUNCTIONS
from mafsil.kernels.loops.kinds import (
    BOOL,
    BUFFER,
    COMPLEX,
    INTEGER,
    LANES,
    MASK,
    NONE,
    NUMBERS,
    REAL,
    Array,
    Kind,
    Number,
    Tuple,
    array_kind,
    by_address,
    join_kinds,
    refusal,
    return_types,
    tuple_of,
)
from mafsil.kernels.loops.numbers import OPERATIONS, ORDERS

_MISSING = object()


class Expressions:
    """Values of the expressions of one function.

    Args:
        function: of Python, in whose module names are looked up.
        names: of its variables.
        fast: flags of its arithmetic.
        specialised: what gives another function for the kinds of its arguments.
    """

    def __init__(
        self,
        function: Any,
        names: frozenset[str],
        fast: str,
        specialised: Callable[[Any, tuple[Kind, ...]], Callee],
    ) -> None:
        self.function, self.names, self.specialised = function, names, specialised
        self.block = Block(fast)
        self.bound: dict[str, Value] = {}
        self.cells: dict[str, tuple[Kind, tuple[str, ...]]] = {}
        self.callees: list[Callee] = []
        self.uses_region = False
        self.fails = False
        self.depth = 0
        self.stack = 0
        self.may_use_stack = True
        closure = function.__closure__ or ()
        self.free = {
            name: cell.cell_contents for name, cell in zip(function.__code__.co_freevars, closure, strict=True)
        }
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
            ast.Call: self.call,
            ast.Tuple: self.tuple,
        }

    def value(self, node: ast.expr) -> Value:
        """The value of an expression."""
        form = self.forms.get(type(node))
        if form is None:
            raise refusal(f"{ast.unparse(node)}")
        return form(node)

    # Names ------------------------------------------------------------------------------------------------------------

    def literal(self, node: ast.Constant) -> Value:
        """A number written in the source."""
        return self.static_value(node.value, node)

    def static(self, node: ast.expr) -> Any:
        """The object of Python that a name of the module means; `_MISSING` where it is a variable or no name."""
        if isinstance(node, ast.Name):
            if node.id in self.names:
                return _MISSING
            if node.id in self.free:
                return self.free[node.id]
            found = self.function.__globals__.get(node.id, _MISSING)
            return getattr(builtins, node.id, _MISSING) if found is _MISSING else found
        if isinstance(node, ast.Attribute):
            base = self.static(node.value)
            if isinstance(base, ModuleType | type):
                return getattr(base, node.attr, _MISSING)
        return _MISSING

    def static_value(self, found: Any, node: ast.expr) -> Value:
        """A constant of the module."""
        if found is None:
            return Value(NONE, ())
        if isinstance(found, _TRUTHS):
            return constant(bool(found))
        if isinstance(found, int | float):
            return constant(found)
        if isinstance(found, np.integer | np.floating):
            return constant(cast("Any", found).item())
        if isinstance(found, tuple):
            items = [self.static_value(item, node) for item in cast("tuple[Any, ...]", found)]
            return self.tuple_of(items)
        if isinstance(found, np.ndarray):
            return self.block.table(array_kind(cast("Any", found)), cast("Any", found))
        raise refusal(f"the name {ast.unparse(node)}")

    def name(self, node: ast.Name) -> Value:
        """A variable, or a constant of the module."""
        if node.id in self.bound:
            return self.bound[node.id]
        if node.id in self.cells:
            kind, cells = self.cells[node.id]
            return self.block.read_variable(kind, cells)
        found = self.static(node)
        if found is _MISSING:
            raise refusal(f"the name {node.id}, which has no value yet")
        return self.static_value(found, node)

    def attribute(self, node: ast.Attribute) -> Value:
        """A constant of a module, an item of a named tuple, or what an array or a number says of itself."""
        found = self.static(node)
        if found is not _MISSING:
            return self.static_value(found, node)
        base = self.value(node.value)
        kind = base.kind
        if isinstance(kind, Tuple) and node.attr in kind.fields:
            return self.block.item(base, kind.fields.index(node.attr))
        if isinstance(kind, Array):
            return self.of_array(base, node)
        if kind is REAL and node.attr in ("real", "imag"):
            return base if node.attr == "real" else constant(0.0)
        if kind is COMPLEX and node.attr in ("real", "imag"):
            return Value(REAL, (base.parts[node.attr == "imag"],))
        raise refusal(ast.unparse(node))

    def of_array(self, array: Value, node: ast.Attribute) -> Value:
        """What an array says of itself."""
        kind = array.kind
        assert isinstance(kind, Array)
        if node.attr == "shape":
            return arrays.shape_of(array)
        if node.attr == "T":
            return arrays.transpose(self.block, array)
        if node.attr == "ndim":
            return constant(kind.ndim)
        if node.attr == "size":
            total = constant(1)
            for size in arrays.sizes(array):
                total = self.arithmetic("*", total, size)
            return total
        raise refusal(ast.unparse(node))

    def tuple(self, node: ast.Tuple) -> Value:
        """Several values as one."""
        return self.tuple_of([self.value(item) for item in node.elts])

    def tuple_of(self, items: Sequence[Value], named: type[Any] | None = None) -> Value:
        """A tuple of these values, of a class of named ones if there is one."""
        return tuple_value(self.block, tuple_of(tuple(item.kind for item in items), named), list(items))

    # Numbers ----------------------------------------------------------------------------------------------------------

    def arithmetic(self, operation: str, a: Value, b: Value) -> Value:
        """The result of an operation."""
        if isinstance(a.kind, Array) or isinstance(b.kind, Array):
            return self.elementwise(operation, a, b)
        found = numbers.arithmetic(self.block, operation, a, b)
        if found is not None:
            return found
        if operation == "**":
            return self.call_loop(
                library.power, [numbers.convert(self.block, a, REAL) if a.kind is not INTEGER else a, b]
            )
        a, b = numbers.alike(self.block, a, b)
        return self.call_loop(library.OPERATIONS[a.kind.name, operation], [a, b])

    def elementwise(self, operation: str, a: Value, b: Value) -> Value:
        """An operation of whole arrays, or of one and a number, in memory of its own."""
        like = max((x for x in (a, b) if isinstance(x.kind, Array)), key=lambda x: len(x.kind.parts))
        kinds = [x.kind.of if isinstance(x.kind, Array) else x.kind for x in (a, b)]
        of = join_kinds(*kinds)
        if operation == "/" and of is INTEGER:
            of = REAL
        if not isinstance(of, Number):
            raise refusal(f"{operation} of {a.kind} and {b.kind}")
        made = self.allocate(of, arrays.sizes(like))
        self.write_elementwise(made, operation, a, b)
        return made

    def write_elementwise(self, made: Value, operation: str, a: Value, b: Value) -> None:
        """The results of an operation of whole arrays into an array."""
        if operation not in library.ELEMENTWISE:
            raise refusal(f"{operation} of whole arrays; write the loop")
        self.call_loop(library.ELEMENTWISE[operation], [made, a, b])

    def along(self, given: list[Value]) -> Value:
        """`library.along`: what one row of a result takes of an operand."""
        value, index, made = given
        if not isinstance(value.kind, Array) or not isinstance(made.kind, Array) or value.kind.ndim < made.kind.ndim:
            return value
        if value.kind.ndim > 1:
            return arrays.view(self.block, value, [index])
        return self.block.load_element(value.kind.of, arrays.place(self.block, value, [index]))

    def binary(self, node: ast.BinOp) -> Value:
        """Arithmetic of two numbers."""
        left, right = self.value(node.left), self.value(node.right)
        return self.arithmetic(OPERATIONS[type(node.op)], left, right)

    def unary(self, node: ast.UnaryOp) -> Value:
        """`-x`, `+x`, `~x` or `not x`."""
        if isinstance(node.op, ast.Not):
            truth = self.truth(node.operand)
            if truth.constant is not None:
                return constant(not truth.constant)
            return self.block.number(BOOL, f"xor i1 {truth.name}, true")
        value = self.value(node.operand)
        if isinstance(node.op, ast.USub):
            whole = isinstance(value.kind, Array)
            return self.elementwise("*", constant(-1), value) if whole else numbers.negate(self.block, value)
        if isinstance(node.op, ast.UAdd):
            return value
        if value.kind is MASK:
            ones = f"<{', '.join(['i1 true'] * 8)}>"
            return self.block.number(MASK, f"xor {MASK.parts[0]} {value.name}, {ones}")
        if value.kind is BOOL:
            raise refusal(f"{ast.unparse(node)} of a truth value; write `not`")
        return self.block.number(INTEGER, f"xor i64 {numbers.convert(self.block, value, INTEGER).name}, -1")

    def truth(self, node: ast.expr) -> Value:
        """The value as a condition."""
        return numbers.truth(self.block, self.value(node))

    def condition(self, node: ast.expr, yes: str, no: str) -> bool | None:
        """Go on at one of two places; the answer, where it is known now."""
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            known = self.condition(node.operand, no, yes)
            return None if known is None else not known
        if isinstance(node, ast.BoolOp):
            return self.conditions(node, yes, no)
        value = self.truth(node)
        if value.constant is not None:
            self.block.jump(yes if value.constant else no)
            return bool(value.constant)
        self.block.branch(value.name, yes, no)
        return None

    def conditions(self, node: ast.BoolOp, yes: str, no: str) -> bool | None:
        """`and` and `or`: what comes after the deciding one is not looked at."""
        both = isinstance(node.op, ast.And)
        certain = True
        for part in node.values[:-1]:
            ahead = self.block.fresh("ahead")
            known = self.condition(part, ahead, no) if both else self.condition(part, yes, ahead)
            if known is not None and known is not both:
                return known if certain else None
            certain = certain and known is not None
            self.block.label(ahead)
        last = self.condition(node.values[-1], yes, no)
        return last if certain else None

    def logic(self, node: ast.BoolOp) -> Value:
        """`and` and `or` as a truth value."""
        yes, no, after = (self.block.fresh(stem) for stem in ("yes", "no", "after"))
        known = self.conditions(node, yes, no)
        self.block.label(yes)
        self.block.jump(after)
        self.block.label(no)
        self.block.jump(after)
        self.block.label(after)
        if known is not None:
            return constant(known)
        return self.block.number(BOOL, f"phi i1 [ true, %{yes} ], [ false, %{no} ]")

    def comparison(self, node: ast.Compare) -> Value:
        """One comparison or a chain of them."""
        if isinstance(node.ops[0], ast.In | ast.NotIn):
            return self.membership(node)
        values = [self.value(each) for each in (node.left, *node.comparators)]
        found: Value | None = None
        for k, op in enumerate(node.ops):
            each = self.compare(op, values[k], values[k + 1], node)
            found = each if found is None else self.arithmetic("&", found, each)
        assert found is not None
        return found

    def compare(self, op: ast.cmpop, a: Value, b: Value, node: ast.expr) -> Value:
        """One comparison; of constants it is known now."""
        if isinstance(op, ast.Is | ast.IsNot):
            if NONE not in (a.kind, b.kind):
                raise refusal(ast.unparse(node))
            return constant((a.kind is b.kind) is isinstance(op, ast.Is))
        order = ORDERS.get(type(op))
        if order is None:
            raise refusal(ast.unparse(node))
        if a.constant is not None and b.constant is not None:
            return constant(bool(_COMPARED[order](a.constant, b.constant)))
        return numbers.compare(self.block, order, a, b)

    def membership(self, node: ast.Compare) -> Value:
        """`x in (a, b)`."""
        left, pool = self.value(node.left), self.value(node.comparators[0])
        if not isinstance(pool.kind, Tuple):
            raise refusal(ast.unparse(node))
        found = constant(False)
        for i in range(len(pool.kind.items)):
            same = self.compare(ast.Eq(), left, self.block.item(pool, i), node)
            found = same if found.constant is False else self.arithmetic("|", found, same)
        if isinstance(node.ops[0], ast.In):
            return found
        if found.constant is not None:
            return constant(not found.constant)
        return self.block.number(BOOL, f"xor i1 {found.name}, true")

    def conditional(self, node: ast.IfExp) -> Value:
        """`a if c else b`: only one of the two is found."""
        yes, no, after = (self.block.fresh(stem) for stem in ("yes", "no", "after"))
        known = self.condition(node.test, yes, no)
        if known is not None:
            self.block.label(yes if known else no)
            return self.value(node.body if known else node.orelse)
        self.block.label(yes)
        first = self.block.explode(self.value(node.body))
        begun, first_end = len(self.block.lines), self.block.here
        self.block.ended = True
        self.block.label(no)
        second = self.block.explode(self.value(node.orelse))
        kind = join_kinds(first.kind, second.kind)
        if kind is None:
            raise refusal(f"{first.kind} or {second.kind} in {ast.unparse(node)}")
        second = self.coerce(second, kind)
        second_end = self.block.here
        self.block.jump(after)
        # The first value is brought to the common kind in its own block, whose end was left open.
        rest = self.block.lines[begun:]
        del self.block.lines[begun:]
        self.block.ended, self.block.here = False, first_end
        first = self.coerce(first, kind)
        self.block.jump(after)
        self.block.lines += rest
        self.block.label(after)
        return self.block.either(kind, [(first, first_end), (second, second_end)])

    def coerce(self, value: Value, kind: Kind) -> Value:
        """The value as a wider kind."""
        if value.kind is kind:
            return self.block.explode(value)
        if isinstance(kind, Tuple) and isinstance(value.kind, Tuple):
            items = [self.coerce(self.block.item(value, i), item) for i, item in enumerate(kind.items)]
            return tuple_value(self.block, kind, items)
        if isinstance(kind, Array) and isinstance(value.kind, Array):
            return arrays.general(self.block, value)
        return numbers.convert(self.block, value, kind)

    # Elements ---------------------------------------------------------------------------------------------------------

    def indices(self, node: ast.expr) -> list[Index]:
        """The indices and slices in brackets."""
        parts = node.elts if isinstance(node, ast.Tuple) else [node]
        found: list[Index] = []
        for part in parts:
            if isinstance(part, ast.Slice):
                found.append(self.span(part))
                continue
            value = self.value(part)
            if isinstance(value.kind, Tuple):
                found += [self.block.item(value, i) for i in range(len(value.kind.items))]
            else:
                found.append(value)
        return found

    def span(self, node: ast.Slice) -> Span:
        """A slice."""
        backwards = node.step is not None
        if backwards and (ast.unparse(cast(ast.expr, node.step)) != "-1" or node.lower or node.upper):
            raise refusal(f"the step in [{ast.unparse(node)}]")
        first, last = (None if each is None else self.value(each) for each in (node.lower, node.upper))
        return Span(first, last, backwards)

    def subscript(self, node: ast.Subscript) -> Value:
        """An element, a view, an item of a tuple, or a place of a buffer."""
        base = self.value(node.value)
        if isinstance(base.kind, Tuple):
            if isinstance(node.slice, ast.Slice):
                first, last = (ast.literal_eval(x) if x else None for x in (node.slice.lower, node.slice.upper))
                places = range(len(base.kind.items))[first:last]
                return self.tuple_of([self.block.item(base, i) for i in places])
            return self.item_of(base, self.value(node.slice), node)
        if base.kind is BUFFER:
            return self.block.load_lanes(self.lane_place(base, self.value(node.slice)))
        if not isinstance(base.kind, Array):
            raise refusal(ast.unparse(node))
        indices = self.indices(node.slice)
        if len(indices) == base.kind.ndim and all(isinstance(index, Value) for index in indices):
            return self.block.load_element(base.kind.of, arrays.place(self.block, base, cast("list[Value]", indices)))
        return arrays.view(self.block, base, indices)

    def item_of(self, base: Value, index: Value, node: ast.expr) -> Value:
        """An item of a tuple; of numbers alike an index may be a variable."""
        kind = base.kind
        assert isinstance(kind, Tuple)
        if isinstance(index.constant, int):
            return self.block.item(base, range(len(kind.items))[index.constant])
        if len(set(kind.items)) != 1:
            raise refusal(f"{ast.unparse(node)}: which item must be known")
        index = arrays.wrap_index(self.block, index, constant(len(kind.items)))
        base = self.block.explode(base)
        item = kind.items[0]
        place = self.block.address_of(Value(kind, base.parts))
        at = self.block.let(f"mul i64 {index.name}, {item.size}")
        return self.block.refer(item, self.block.let(f"getelementptr inbounds i8, ptr {place}, i64 {at}"), 0, False)

    def lane_place(self, base: Value, index: Value) -> str:
        """Address of a place of a buffer."""
        at = numbers.convert(self.block, index, INTEGER)
        return self.block.let(f"getelementptr inbounds {LANES.parts[0]}, ptr {base.name}, i64 {at.name}")

    # Calls ------------------------------------------------------------------------------------------------------------

    def call(self, node: ast.Call) -> Value:
        """A call: of a method, of another loop, of a class of named tuples, or of a function of the language."""
        function = self.static(node.func)
        if function is _MISSING:
            if isinstance(node.func, ast.Attribute):
                return self.method(node, node.func)
            raise refusal(f"the function {ast.unparse(node.func)}")
        if function in _MAKERS:
            return self.new_array(node, function)
        values = [self.value(each) for each in node.args]
        if isinstance(function, type) and hasattr(function, "_fields"):
            return self.new_tuple(function, values, node)
        if node.keywords:
            raise refusal(f"named arguments in {ast.unparse(node)}")
        return self.apply(function, values, node)

    def apply(self, function: Any, values: list[Value], node: ast.expr) -> Value:
        """A function of the language or of the program."""
        if hasattr(function, "definition"):
            return self.call_loop(function, values)
        emit = FUNCTIONS.get(function)
        if emit is None:
            raise refusal(f"the function {ast.unparse(node.func) if isinstance(node, ast.Call) else node}")
        return emit(self, values)

    def new_tuple(self, named: type[Any], values: list[Value], node: ast.Call) -> Value:
        """A named tuple."""
        fields: tuple[str, ...] = named._fields
        given = dict(zip(fields, values, strict=False)) | {
            str(word.arg): self.value(word.value) for word in node.keywords
        }
        if set(given) != set(fields):
            raise refusal(f"{ast.unparse(node)}: every field of {named.__name__} is needed")
        return self.tuple_of([given[field] for field in fields], named)

    def method(self, node: ast.Call, function: ast.Attribute) -> Value:
        """A method of an array or of a number."""
        base = self.value(function.value)
        kind = base.kind
        if kind is COMPLEX and function.attr == "conjugate":
            minus = self.block.let(f"fneg double {base.parts[1]}")
            return Value(COMPLEX, (base.parts[0], minus))
        if not isinstance(kind, Array):
            raise refusal(ast.unparse(node))
        if function.attr == "copy":
            return self.copy_array(base)
        if function.attr == "view":
            return arrays.view_as(self.block, base, self.element_kind(node.args[0]))
        if function.attr == "reshape":
            given = [self.value(each) for each in node.args]
            shape = arrays.shape_from(self.block, given[0]) if len(given) == 1 else given
            return arrays.reshape_array(base, shape)
        loop = library.METHODS.get(function.attr)
        if loop is None or node.args:
            raise refusal(ast.unparse(node))
        if kind.ndim > 1:
            base = arrays.reshape_array(base, [self.of_array(base, ast.Attribute(function.value, "size"))])
        return self.call_loop(loop, [base])

    def element_kind(self, node: ast.expr) -> Number:
        """The kind of elements that a type of NumPy names."""
        found = self.static(node)
        try:
            return NUMBERS[np.dtype(found).name]
        except (TypeError, KeyError):
            raise refusal(f"elements of {ast.unparse(node)}") from None

    def new_array(self, node: ast.Call, maker: Any) -> Value:
        """`np.empty`, `np.zeros`, `np.ones` and `np.full`."""
        words = {str(word.arg): word.value for word in node.keywords}
        positional = list(node.args)
        shape = arrays.shape_from(self.block, self.value(positional.pop(0)))
        fill = None
        if maker is np.full:
            fill = self.value(positional.pop(0))
        elif maker is np.ones:
            fill = constant(1)
        typed = positional[0] if positional else words.get("dtype")
        of = self.element_kind(typed) if typed is not None else (
            cast(Number, fill.kind) if maker is np.full and fill is not None else REAL
        )  # fmt: skip
        made = self.allocate(of, shape, clear=maker is np.zeros)
        if fill is not None:
            self.fill(made, fill)
        return made

    def allocate(self, of: Number, shape: list[Value], *, clear: bool = False) -> Value:
        """A new array: on the stack where it is small, outside of loops and cannot leave the function."""
        size = arrays.fixed_size(of, shape)
        if size is not None and self.may_use_stack and not self.depth and self.stack + size <= arrays.ON_STACK:
            self.stack += size
            made = arrays.allocate(self.block, of, shape, None)
        else:
            self.fails = self.uses_region = True
            made = arrays.allocate(self.block, of, shape, "%region")
            self.check(f"icmp eq ptr {made.name}, null")
        if clear:
            arrays.clear(self.block, made)
        return made

    def check(self, failure: str) -> None:
        """Leave the function where memory is lacking."""
        ahead = self.block.fresh("ahead")
        self.block.branch(self.block.let(failure), "failed", ahead)
        self.block.label(ahead)

    def copy_array(self, array: Value) -> Value:
        """The same elements in memory of their own."""
        kind = array.kind
        assert isinstance(kind, Array)
        made = self.allocate(kind.of, arrays.sizes(array))
        self.write(made, array)
        return made

    def fill(self, array: Value, value: Value) -> None:
        """Every element, or every row, set to a value."""
        self.call_loop(library.fill, [array, value])

    def write(self, array: Value, value: Value) -> None:
        """An array written over by another one, by a row for each of its rows, or by a number."""
        kind = array.kind
        assert isinstance(kind, Array)
        if not isinstance(value.kind, Array):
            self.fill(array, numbers.convert(self.block, value, kind.of))
        elif value.kind.ndim < kind.ndim:
            self.fill(array, value)
        else:
            self.call_loop(library.assign, [array, value])

    def call_loop(self, loop: Any, values: list[Value]) -> Value:
        """A call of another loop.

        A tuple of many parts is handed over by its address, memory is the caller's where an array comes back.
        """
        values = [self.annotate(value, word) for value, word in zip(values, loop.definition.words, strict=True)]
        callee = self.specialised(loop, tuple(value.kind for value in values))
        self.callees.append(callee)
        given = [part for value in values for part in self.as_arguments(value)]
        if callee.shares_region:
            self.uses_region = True
            given.append("ptr %region")
        return self.results(callee.result, callee.fails, f"@{callee.symbol}", given)

    def as_arguments(self, value: Value) -> list[str]:
        """A value as arguments, with their types."""
        if by_address(value.kind):
            return [f"ptr {self.block.address_of(value)}"]
        value = self.block.explode(value)
        return [f"{kind} {part}" for kind, part in zip(value.kind.parts, value.parts, strict=True)]

    def results(self, result: Kind, fails: bool, place: str, given: list[str]) -> Value:
        """What a function gives back; where it has failed, this one has too."""
        kinds = return_types(result, fails)
        llvm = kinds[0] if len(kinds) == 1 else f"{{ {', '.join(kinds)} }}" if kinds else "void"
        text = f"call {llvm} {place}({', '.join(given)})"
        if not kinds:
            self.block.do(text)
            return Value(result, ())
        made = self.block.let(text)
        parts = (
            [made]
            if len(kinds) == 1
            else [self.block.let(f"extractvalue {llvm} {made}, {i}") for i in range(len(kinds))]
        )
        if fails:
            self.fails = True
            self.check(f"icmp ne i1 {parts.pop()}, false")
        return Value(result, tuple(parts))

    def annotate(self, value: Value, word: str) -> Value:
        """A number as the kind that the function's annotation says."""
        kind = WORDS.get(word)
        if kind is None or value.kind is kind or not isinstance(value.kind, Number) or value.kind.rank > kind.rank:
            return value
        return numbers.convert(self.block, value, kind)


WORDS: dict[str, Number] = {"float": REAL, "int": INTEGER, "bool": BOOL, "complex": COMPLEX}
"""Annotations that say the kind of a number."""
_TRUTHS: Any = (bool, np.bool_)
_MAKERS = (np.empty, np.zeros, np.ones, np.full)
_COMPARED: dict[str, Callable[[Any, Any], bool]] = {
    "<": lambda a, b: a < b, "<=": lambda a, b: a <= b, ">": lambda a, b: a > b, ">=": lambda a, b: a >= b,
    "==": lambda a, b: a == b, "!=": lambda a, b: a != b,
}  # fmt: skip
