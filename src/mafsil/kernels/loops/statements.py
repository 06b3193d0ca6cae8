"""One function of the source as LLVM IR: statements become blocks, variables values or cells of memory.

1. Names that are one value are bound to it; of others each gets cells of the kind that holds all its values. Where a
   later one turns out to be wider, the function is translated again with that kind (`Restart`).
2. Statements become blocks: a condition ends one, a loop is the block of its test, its body and what follows.
3. What comes after `return`, `break` or `continue` in a block is dropped.
4. There is one way out: results are kept in cells until then, and memory of the function is given back there.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from mafsil.kernels.loops import arrays, numbers
from mafsil.kernels.loops.block import Value, constant
from mafsil.kernels.loops.definition import Callee, Definition, Scopes
from mafsil.kernels.loops.expressions import Expressions
from mafsil.kernels.loops.kinds import (
    BUFFER,
    INTEGER,
    LANES,
    NONE,
    Array,
    Held,
    Kind,
    Narrow,
    RefusedError,
    Tuple,
    by_address,
    has_arrays,
    join_kinds,
    refusal,
    return_types,
)
from mafsil.kernels.loops.numbers import OPERATIONS

UNROLLED = 4
"""Items of a tuple up to which a loop over them is written out."""
Specialised = Callable[[Any, tuple[Kind, ...]], Callee]


class Restart(Exception):
    """A variable is of a wider kind than was thought."""


@dataclass
class Known:
    """What one translation of a function has found out for the next.

    Attributes:
        kinds: of variables that change.
        result: of the function; None before the first `return`.
        may_use_stack: whether small arrays may lie on the stack.
    """

    kinds: dict[str, Kind]
    result: Kind | None = None
    may_use_stack: bool = True


@dataclass(frozen=True)
class Translation:
    """A function in LLVM IR.

    Attributes:
        text: its definition, from its result type on.
        result: kind of its result.
        fails: whether it says at its end that memory was lacking.
        shares_region: whether its memory joins that of its caller.
        callees: specialisations that it calls.
        declared: what it calls of LLVM and of the system.
    """

    text: str
    result: Kind
    fails: bool
    shares_region: bool
    callees: tuple[Callee, ...]
    declared: frozenset[str]


def translate_function(
    definition: Definition, node: ast.FunctionDef, kinds: tuple[Kind, ...], symbol: str, specialised: Specialised
) -> Translation:
    """A function for some kinds of arguments.

    Args:
        definition: of the function.
        node: its source.
        kinds: of its arguments.
        symbol: its name in LLVM IR.
        specialised: what gives other functions for the kinds of their arguments.

    Raises:
        KernelError: it is not of the language.
    """
    known, scopes = Known({}), Scopes(node)
    while True:
        try:
            return Function(definition, node, kinds, scopes, known, specialised).translation(symbol)
        except Restart:
            continue


class Function(Expressions):
    """The translation of one function, in one go.

    Args:
        definition: of the function.
        node: its source.
        kinds: of its arguments.
        scopes: of its names.
        known: from translations before; it is added to.
        specialised: what gives other functions.
    """

    def __init__(
        self,
        definition: Definition,
        node: ast.FunctionDef,
        kinds: tuple[Kind, ...],
        scopes: Scopes,
        known: Known,
        specialised: Specialised,
    ) -> None:
        super().__init__(definition.function, scopes.names, definition.fast, specialised)
        self.definition, self.node, self.kinds, self.scopes, self.known = definition, node, kinds, scopes, known
        self.may_use_stack = known.may_use_stack
        self.loops: list[tuple[str, str]] = []
        self.result_cells: tuple[str, ...] = ()
        self.returns = False
        self.statements: dict[type[ast.stmt], Callable[..., None]] = {
            ast.Expr: self.alone,
            ast.Pass: self.nothing,
            ast.Assign: self.assignment,
            ast.AnnAssign: self.annotated_assignment,
            ast.AugAssign: self.change,
            ast.If: self.condition_of,
            ast.While: self.repetition,
            ast.For: self.count,
            ast.Return: self.result,
            ast.Break: self.leave,
            ast.Continue: self.again,
        }

    def translation(self, symbol: str) -> Translation:
        """The function.

        Raises:
            Restart: a variable is of a wider kind than was thought.
        """
        given: list[str] = []
        for name, kind in zip(self.definition.arguments, self.kinds, strict=True):
            given += self.argument(name, kind)
        self.run(self.node.body)
        result = self.known.result or NONE
        if has_arrays(result) and self.stack:
            self.known.may_use_stack = False
            raise Restart
        shares = self.uses_region and has_arrays(result)
        if shares:
            given.append("ptr %region")
        kinds = return_types(result, self.fails)
        llvm = kinds[0] if len(kinds) == 1 else f"{{ {', '.join(kinds)} }}" if kinds else "void"
        self.finish(result, kinds, llvm, own=self.uses_region and not shares)
        body = "\n".join([*self.block.heads, *self.block.lines])
        flags = " alwaysinline" if self.definition.inline else ""
        text = f"{llvm} @{symbol}({', '.join(given)}) nounwind{flags} {{\nentry:\n{body}\n}}\n"
        declared = frozenset(self.block.declared)
        return Translation(text, result, self.fails, shares, tuple(dict.fromkeys(self.callees)), declared)

    def argument(self, name: str, kind: Kind) -> list[str]:
        """Bind an argument; its parts with their types."""
        if by_address(kind):
            assert isinstance(kind, Tuple)
            # What lies there is read and nothing else is written over it while the function runs.
            given = [f"ptr noalias readonly dereferenceable({kind.size}) %a.{name}"]
            value = self.block.refer(kind, f"%a.{name}", 0, False)
        else:
            parts = tuple(f"%a.{name}.{i}" for i in range(len(kind.parts)))
            value = Value(kind, parts)
            given = [f"{part} {each}" for part, each in zip(kind.parts, parts, strict=True)]
            if isinstance(kind, Held):
                given = [f"ptr dereferenceable({max(kind.value.size, 1)}) {parts[0]}"]
        self.assign(name, value)
        return given

    def finish(self, result: Kind, kinds: list[str], llvm: str, *, own: bool) -> None:
        """The way out, and the one where memory is lacking."""
        block = self.block
        if result is not NONE and not block.ended:
            block.end("unreachable")
        block.label("exit")
        parts = [
            *(block.read_variable(result, self.result_cells).parts if self.returns else ()),
            *(["false"] if self.fails else []),
        ]
        self._leave(kinds, llvm, parts, own=own)
        if self.fails:
            block.label("failed")
            self._leave(kinds, llvm, [*(["poison"] * (len(kinds) - 1)), "true"], own=own)
        if own:
            block.heads += ["  %region = alloca ptr", "  store ptr null, ptr %region"]

    def _leave(self, kinds: list[str], llvm: str, parts: list[str], *, own: bool) -> None:
        if own:
            self.block.call(arrays.RELEASE, "void", "ptr %region")
        if not kinds:
            self.block.end("ret void")
            return
        if len(kinds) == 1:
            self.block.end(f"ret {llvm} {parts[0]}")
            return
        whole = "poison"
        for i, (kind, part) in enumerate(zip(kinds, parts, strict=True)):
            whole = self.block.let(f"insertvalue {llvm} {whole}, {kind} {part}, {i}")
        self.block.end(f"ret {llvm} {whole}")

    def run(self, statements: list[ast.stmt]) -> None:
        """Statements one after another."""
        for statement in statements:
            if self.block.ended:
                return
            translate = self.statements.get(type(statement))
            if translate is None:
                raise refusal(ast.unparse(statement).split("\n")[0])
            try:
                translate(statement)
            except RefusedError as error:
                error.line = error.line or statement.lineno
                raise

    def nothing(self, _node: ast.Pass) -> None:
        """`pass`."""

    def leave(self, _node: ast.Break) -> None:
        """`break`: on to what follows the innermost loop."""
        self.block.jump(self.loops[-1][1])

    def again(self, _node: ast.Continue) -> None:
        """`continue`: on to the next round of the innermost loop."""
        self.block.again(self.loops[-1][0])

    def alone(self, node: ast.Expr) -> None:
        """A call whose result nobody wants, or a text."""
        if not isinstance(node.value, ast.Constant):
            self.value(node.value)

    # Assignments ------------------------------------------------------------------------------------------------------

    def assignment(self, node: ast.Assign) -> None:
        """Values for names and elements; of several at once all are found before the first is given."""
        value = self.assigned_value(node.value)
        for target in node.targets:
            self.give(target, value)

    def annotated_assignment(self, node: ast.AnnAssign) -> None:
        """A value with its annotation, which is for people."""
        if node.value is not None:
            self.give(node.target, self.assigned_value(node.value))

    def assigned_value(self, node: ast.expr) -> Value | list[Value]:
        """The value on the right, or the values of a tuple that is taken apart at once."""
        return [self.value(item) for item in node.elts] if isinstance(node, ast.Tuple) else self.value(node)

    def give(self, target: ast.expr, value: Value | list[Value]) -> None:
        """Give a name, an element, a view or a place of a buffer its value."""
        if isinstance(target, ast.Tuple):
            if isinstance(value, Value):
                if not isinstance(value.kind, Tuple):
                    raise refusal(f"{ast.unparse(target)} from {value.kind}")
                value = [self.block.item(value, i) for i in range(len(value.kind.items))]
            for each, item in zip(target.elts, value, strict=True):
                self.give(each, item)
            return
        if isinstance(value, list):
            value = self.tuple_of(value)
        if isinstance(target, ast.Name):
            self.assign(target.id, value)
        elif isinstance(target, ast.Subscript):
            self.set_element(target, value)
        else:
            raise refusal(f"a value for {ast.unparse(target)}")

    def assign(self, name: str, value: Value) -> None:
        """Give a variable a value."""
        if name in self.scopes.single:
            self.bound[name] = value
            return
        if name not in self.cells:
            kind = self.known.kinds.get(name, INTEGER if isinstance(value.kind, Narrow) else value.kind)
            self.cells[name] = kind, self.block.cells(kind)
        kind, cells = self.cells[name]
        self.block.keep(self.widen(name, value, kind), cells)

    def widen(self, name: str, value: Value, kind: Kind) -> Value:
        """The value as the kind of its variable.

        Raises:
            Restart: that is too narrow.
        """
        whole = join_kinds(kind, value.kind)
        if whole is None:
            raise refusal(f"{name} as {kind} and as {value.kind}")
        if whole is not kind and not isinstance(whole, Narrow):
            self.known.kinds[name] = whole
            raise Restart
        return self.coerce(value, kind)

    def set_element(self, target: ast.Subscript, value: Value) -> None:
        """Write an element, the elements of a view, or a place of a buffer."""
        base = self.value(target.value)
        if base.kind is BUFFER:
            place = self.lane_place(base, self.value(target.slice))
            self.block.store_lanes(numbers.convert(self.block, value, LANES), place)
            return
        if not isinstance(base.kind, Array):
            raise refusal(f"a value for {ast.unparse(target)}")
        indices = self.indices(target.slice)
        if len(indices) < base.kind.ndim or any(not isinstance(index, Value) for index in indices):
            self.write(arrays.view(self.block, base, indices), value)
            return
        place = arrays.place(self.block, base, [index for index in indices if isinstance(index, Value)])
        self.block.store_element(base.kind.of, self.as_element(value, base.kind), place)

    def as_element(self, value: Value, kind: Array) -> Value:
        """A number as an element of an array: whole numbers lose bits, reals precision, as in NumPy."""
        of = kind.of
        if of.parts == ("i64",) and value.kind is not of:
            return numbers.whole(self.block, value)
        if of.parts == ("float",) and value.kind is not of:
            real = numbers.convert(self.block, value, numbers.REAL)
            return self.block.number(of, f"fptrunc double {real.name} to float")
        if of.parts == ("i1",):
            return numbers.truth(self.block, value)
        return numbers.convert(self.block, value, of)

    def change(self, node: ast.AugAssign) -> None:
        """A name, an element or a place of a buffer changed by an operation; where it stands is found once."""
        operation = OPERATIONS[type(node.op)]
        if isinstance(node.target, ast.Name):
            old, by = self.name(node.target), self.value(node.value)
            if isinstance(old.kind, Array):
                self.write_elementwise(old, operation, old, by)
            else:
                self.assign(node.target.id, self.arithmetic(operation, old, by))
            return
        if not isinstance(node.target, ast.Subscript):
            raise refusal(ast.unparse(node))
        base, index = self.value(node.target.value), node.target.slice
        if base.kind is BUFFER:
            place = self.lane_place(base, self.value(index))
            found = self.arithmetic(operation, self.block.load_lanes(place), self.value(node.value))
            self.block.store_lanes(found, place)
            return
        indices = self.indices(index)
        whole = [each for each in indices if isinstance(each, Value)]
        if not isinstance(base.kind, Array):
            raise refusal(ast.unparse(node))
        if len(whole) != base.kind.ndim or len(indices) != len(whole):
            rows = arrays.view(self.block, base, indices)
            self.write_elementwise(rows, operation, rows, self.value(node.value))
            return
        place = arrays.place(self.block, base, whole)
        found = self.arithmetic(operation, self.block.load_element(base.kind.of, place), self.value(node.value))
        self.block.store_element(base.kind.of, self.as_element(found, base.kind), place)

    # Ways -------------------------------------------------------------------------------------------------------------

    def condition_of(self, node: ast.If) -> None:
        """`if` with or without `else`; of a condition that is known now only one suite is translated."""
        yes, no, after = (self.block.fresh(stem) for stem in ("then", "else", "after"))
        known = self.condition(node.test, yes, no)
        if known is not False:
            self.block.label(yes)
            self.run(node.body)
            self.block.jump(after)
        if known is not True:
            self.block.label(no)
            self.run(node.orelse)
            self.block.jump(after)
        self.meet(after)

    def meet(self, after: str) -> None:
        """Begin the block where ways meet; nothing is translated there if none leads to it."""
        if after in self.block.targets:
            self.block.label(after)

    def repetition(self, node: ast.While) -> None:
        """`while`."""
        # while: if (!test) goto after; body: ...; goto while; after:
        test, body, after = (self.block.fresh(stem) for stem in ("while", "body", "after"))
        self.block.label(test)
        self.condition(node.test, body, after)
        self.block.label(body)
        self.translate_loop(node.body, test, after)
        self.block.again(test)
        self.meet(after)

    def count(self, node: ast.For) -> None:
        """`for` over a `range` or over the items of a tuple."""
        if self.static(node.iter.func if isinstance(node.iter, ast.Call) else node.iter) is range:
            assert isinstance(node.iter, ast.Call)
            self.through_range(node, [self.value(each) for each in node.iter.args])
            return
        items = self.value(node.iter)
        if isinstance(items.kind, Array):
            self.through_range(node, [arrays.sizes(items)[0]], items)
            return
        if not isinstance(items.kind, Tuple):
            raise refusal(f"for in {ast.unparse(node.iter)}")
        if len(items.kind.items) > UNROLLED and set(items.kind.items) == {items.kind.items[0]}:
            self.through_range(node, [constant(len(items.kind.items))], items)
            return
        after = self.block.fresh("after")
        for i in range(len(items.kind.items)):
            ahead = self.block.fresh("next")
            self.give(node.target, self.block.item(items, i))
            self.translate_loop(node.body, ahead, after)
            self.block.jump(ahead)
            self.meet(ahead)
        self.block.jump(after)
        self.meet(after)

    def through_range(self, node: ast.For, given: list[Value], items: Value | None = None) -> None:
        """`for` over a `range`, whose bounds are found once and whose step is a constant, or over items of an array."""
        # counter = first; for: if (counter >= last) goto after; body: name = counter; ...; next: counter += step; goto
        # for; after: (The counter is a cell of its own: the body may give the name another value, as in Python.)
        given = [numbers.convert(self.block, each, INTEGER) for each in given]
        first, last = (given[0], given[1]) if len(given) > 1 else (constant(0), given[0])
        step = given[2] if len(given) == 3 else constant(1)
        if not isinstance(step.constant, int) or step.constant == 0:
            raise refusal(f"the step of {ast.unparse(node.iter)}")
        upwards = step.constant > 0
        cells = self.block.cells(INTEGER)
        self.block.keep(first, cells)
        test, body, ahead, after = (self.block.fresh(stem) for stem in ("for", "body", "next", "after"))
        self.block.label(test)
        now = Value(INTEGER, self.block.read_variable(INTEGER, cells).parts, None, first.natural and upwards)
        self.block.branch(numbers.compare(self.block, "<" if upwards else ">", now, last).name, body, after)
        self.block.label(body)
        self.give(node.target, now if items is None else self.item_at(items, now, node))
        self.translate_loop(node.body, ahead, after)
        self.block.label(ahead)
        self.block.keep(
            numbers.arithmetic(self.block, "+", self.block.read_variable(INTEGER, cells), step) or now, cells
        )
        self.block.again(test, counted=first.constant is not None and last.constant is not None)
        self.meet(after)

    def item_at(self, items: Value, index: Value, node: ast.For) -> Value:
        """An item of an array, or of a tuple of items alike."""
        if isinstance(items.kind, Tuple):
            return self.item_of(items, index, node.iter)
        return self.along([items, index, items])

    def translate_loop(self, body: list[ast.stmt], again: str, after: str) -> None:
        """The body of a loop, which goes on at `again` and is left for `after`."""
        self.loops.append((again, after))
        self.depth += 1
        self.run(body)
        self.depth -= 1
        self.loops.pop()

    def result(self, node: ast.Return) -> None:
        """`return`."""
        value = Value(NONE, ()) if node.value is None else self.value(node.value)
        if isinstance(value.kind, Narrow):
            value = Value(INTEGER, value.parts)
        known = self.known.result
        whole = value.kind if known is None else join_kinds(known, value.kind)
        if whole is None:
            raise refusal(f"{known} and {value.kind} as results")
        if known is not None and whole is not known:
            self.known.result = whole
            raise Restart
        self.known.result = whole
        if not self.returns:
            self.result_cells, self.returns = self.block.cells(whole), True
        self.block.keep(self.coerce(value, whole), self.result_cells)
        self.block.jump("exit")
