"""One function of the source as LLVM IR: statements become blocks, variables memory that LLVM turns into values."""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping

from mafsil.kernels.loop_compiler.expressions import Expressions
from mafsil.kernels.loop_compiler.headers import Header
from mafsil.kernels.loop_compiler.values import (
    INTEGER,
    OPERATIONS,
    Layout,
    Value,
    constant,
    refused,
)


class Function(Expressions):
    """The translation of one function.

    1. Every argument and every name that is assigned gets memory of the type of its first value.
    2. Statements become blocks: a condition ends one, a loop is the block of its test, its body and what follows.
    3. What comes after `return`, `break` or `continue` in a block is dropped.

    Args:
        node: its source.
        headers: of all functions of the program.
        constants: of its module.
        records: of the program.
    """

    def __init__(
        self,
        node: ast.FunctionDef,
        headers: Mapping[str, Header],
        constants: Mapping[str, int | float],
        records: Mapping[str, Layout],
    ) -> None:
        super().__init__(headers, constants, records)
        self.header = headers[node.name]
        self.loops: list[tuple[str, str]] = []
        self.statements: dict[type[ast.stmt], Callable[..., None]] = {
            ast.Expr: self.alone,
            ast.Pass: self.nothing,
            ast.Assign: self.assignment,
            ast.AugAssign: self.change,
            ast.If: self.condition,
            ast.While: self.repetition,
            ast.For: self.count,
            ast.Return: self.result,
            ast.Break: self.leave,
            ast.Continue: self.again,
        }
        for name, kind in self.header.arguments.items():
            self.assign(name, Value(kind, f"%a.{name}"))
        self.run(node.body)
        self.block.do("unreachable" if self.header.result else "ret void")

    def text(self, *, exported: bool) -> str:
        """The definition.

        Args:
            exported: whether it is called from outside.
        """
        given = ", ".join(f"{kind.llvm} %a.{name}" for name, kind in self.header.arguments.items())
        result = self.header.result.llvm if self.header.result else "void"
        if exported and result == "i1":
            result = "zeroext i1"
        body = "\n".join([*self.block.heads, *self.block.lines])
        linkage = "" if exported else "internal "
        return f"define {linkage}{result} @{self.header.name}({given}) #0 {{\nentry:\n{body}\n}}\n"

    def run(self, statements: list[ast.stmt]) -> None:
        """Statements one after another."""
        for statement in statements:
            translate = self.statements.get(type(statement))
            if translate is None:
                raise refused(f"{self.header.name}: {ast.unparse(statement)}")
            translate(statement)

    def nothing(self, _node: ast.Pass) -> None:
        """`pass`."""

    def leave(self, _node: ast.Break) -> None:
        """`break`: on to what follows the innermost loop."""
        self.block.jump(self.loops[-1][1])

    def again(self, _node: ast.Continue) -> None:
        """`continue`: on to the next round of the innermost loop."""
        self.block.jump(self.loops[-1][0])

    def alone(self, node: ast.Expr) -> None:
        """A call whose result nobody wants, or a text."""
        if isinstance(node.value, ast.Call):
            self.call(node.value)

    def assignment(self, node: ast.Assign) -> None:
        """Values for names, elements and fields; of several at once all are found before the first is given."""
        target = node.targets[0]
        if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
            values = [self.value(each) for each in node.value.elts]
            for each, value in zip(target.elts, values, strict=True):
                self.give(each, value)
            return
        value = self.value(node.value)
        for each in node.targets:
            self.give(each, value)

    def change(self, node: ast.AugAssign) -> None:
        """A name, element or field changed by an operation."""
        old, by = self.value(node.target), self.value(node.value)
        self.give(node.target, self.block.arithmetic(OPERATIONS[type(node.op)], old, by))

    def give(self, target: ast.expr, value: Value) -> None:
        """Give a name, an element or a field its value."""
        if isinstance(target, ast.Name):
            self.assign(target.id, value)
        elif isinstance(target, ast.Subscript):
            self.block.store(value, self.place(target))
        elif isinstance(target, ast.Attribute):
            self.block.set_field(*self.field(target), value)
        else:
            raise refused(ast.unparse(target))

    def condition(self, node: ast.If) -> None:
        """`if` with or without `else`."""
        # if (!test) goto else; then: body; goto after; else: orelse; after:
        yes, no, after = (self.block.name(stem) for stem in ("then", "else", "after"))
        self.block.branch(self.truth(node.test), yes, no)
        self.block.label(yes)
        self.run(node.body)
        self.block.jump(after)
        self.block.label(no)
        self.run(node.orelse)
        self.block.label(after)

    def repetition(self, node: ast.While) -> None:
        """`while`."""
        # while: if (!test) goto after; body: ...; goto while; after:
        test, body, after = (self.block.name(stem) for stem in ("while", "body", "after"))
        self.block.label(test)
        self.block.branch(self.truth(node.test), body, after)
        self.block.label(body)
        self.looped(node.body, test, after)
        self.block.jump(test)
        self.block.label(after)

    def count(self, node: ast.For) -> None:
        """`for` over a `range` with a positive step; its bounds are found once."""
        # counter = first; for: if (counter >= last) goto after; body: name = counter; ...; next: counter += step; goto
        # for; after: (The counter is a cell of its own: the body may give the name another value, as in Python.)
        given = [self.block.converted(self.value(each), INTEGER) for each in self.range_of(node.iter)]
        first, last = (given[0], given[1]) if len(given) > 1 else (constant(0), given[0])
        step = given[2] if len(given) == 3 else constant(1)
        counter = self.block.cell(INTEGER)
        self.block.store(first, counter)
        test, body, ahead, after = (self.block.name(stem) for stem in ("for", "body", "next", "after"))
        self.block.label(test)
        now = self.block.load(counter)
        self.block.branch(self.block.compared("<", now, last), body, after)
        self.block.label(body)
        self.give(node.target, now)
        self.looped(node.body, ahead, after)
        self.block.label(ahead)
        self.block.store(self.block.arithmetic("+", self.block.load(counter), step), counter)
        self.block.jump(test)
        self.block.label(after)

    def looped(self, body: list[ast.stmt], again: str, after: str) -> None:
        """The body of a loop, which goes on at `again` and is left for `after`."""
        self.loops.append((again, after))
        self.run(body)
        self.loops.pop()

    def result(self, node: ast.Return) -> None:
        """`return`."""
        kind = self.header.result
        if kind is None or node.value is None:
            self.block.end("ret void")
        else:
            self.block.end(f"ret {kind.llvm} {self.block.converted(self.value(node.value), kind).name}")
