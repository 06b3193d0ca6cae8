"""Expressions as graphs: the order of computation, what they depend on, the same with other leaves."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import overload

from mafsil.errors import OperandError
from mafsil.expression.elementary import BINARY, UNARY
from mafsil.expression.matrix import Expression, matrix
from mafsil.expression.node import CONSTANT, FOLDS, LEAF, SYMBOL, Node, Symbol, constant


def topological_order(roots: Iterable[Node]) -> list[Node]:
    """All nodes under the roots, operands before what needs them, each once; depth first, first operands first."""
    order: list[Node] = []
    seen = {id(LEAF)}
    for root in roots:
        stack = [root]
        while stack:
            node = stack[-1]
            if id(node) in seen:
                stack.pop()
            elif id(node.a) not in seen:
                stack.append(node.a)
            elif id(node.b) not in seen:
                stack.append(node.b)
            else:
                seen.add(id(node))
                order.append(node)
                stack.pop()
    return order


def symvar(x: Expression) -> list[Expression]:
    """The symbols that x depends on, each as a scalar, in the order of computation."""
    return [matrix(1, 1, [node]) for node in topological_order(x.entries) if node.op == SYMBOL]


def symbols_of(xs: Sequence[Expression]) -> list[Symbol]:
    """The nodes of columns or matrices of symbols.

    Raises:
        OperandError: an element is no symbol.
    """
    found: list[Symbol] = []
    for x in xs:
        for node in x.entries:
            if not isinstance(node, Symbol):
                raise OperandError("expression.no_symbol", operation=node.op)
            found.append(node)
    return found


def rebuilt(order: Iterable[Node], known: dict[int, Node], shared: bool = False) -> dict[int, Node]:
    """Every node of the order built anew over new operands, by the identity of the old node.

    Args:
        order: operands first.
        known: replacements of some nodes; extended and returned.
        shared: equal values become one node.
    """
    table = _Table()
    for node in order:
        if id(node) in known:
            continue
        op = node.op
        if op in (SYMBOL, CONSTANT):
            new = node
        elif node.b is LEAF:
            new = UNARY[op](known[id(node.a)])
        else:
            new = BINARY[op](known[id(node.a)], known[id(node.b)])
        known[id(node)] = table.one(new) if shared else new
    return known


class _Table:
    """One node for every value: an operation on nodes that are one themselves."""

    def __init__(self) -> None:
        self._nodes: dict[tuple[object, ...], Node] = {}
        self._ones: set[int] = {id(LEAF)}

    def one(self, node: Node) -> Node:
        """The node of this value; what a rule built below it is shared too."""
        if id(node) in self._ones:
            return node
        if node.op == SYMBOL:
            key: tuple[object, ...] = (SYMBOL, id(node))
        elif node.op == CONSTANT:
            key = (CONSTANT, node.value.hex())
        else:
            a, b = self.one(node.a), self.one(node.b)
            if a is not node.a or b is not node.b:
                node = Node(node.op, a, b)
            key = (node.op, id(a), id(b))
        found = self._nodes.setdefault(key, node)
        self._ones.add(id(found))
        return found


@overload
def cse(x: Expression) -> Expression: ...
@overload
def cse(x: Sequence[Expression]) -> list[Expression]: ...
def cse(x: Expression | Sequence[Expression]) -> Expression | list[Expression]:
    """The same with common subexpressions built once."""
    several = _several(x)
    roots = [node for each in several for node in each.entries]
    order = topological_order(roots)
    known = rebuilt(order, {}, shared=True)
    done = [matrix(each.rows, each.columns, [known[id(node)] for node in each.entries]) for each in several]
    return done[0] if isinstance(x, Expression) else done


@overload
def substitute(x: Expression, old: Expression, new: Expression) -> Expression: ...
@overload
def substitute(x: Sequence[Expression], old: Sequence[Expression], new: Sequence[Expression]) -> list[Expression]: ...
def substitute(
    x: Expression | Sequence[Expression],
    old: Expression | Sequence[Expression],
    new: Expression | Sequence[Expression],
) -> Expression | list[Expression]:
    """The same with symbols replaced.

    Args:
        x: one expression or several.
        old: the symbols, a matrix or several.
        new: what takes their places, of the same shapes.

    Raises:
        OperandError: `old` holds something that is no symbol, or shapes differ.
    """
    several, olds, news = _several(x), _several(old), _several(new)
    known: dict[int, Node] = {}
    for before, after in zip(olds, news, strict=True):
        if before.shape != after.shape:
            raise OperandError("expression.shapes", sign="substitute", left=before.shape, right=after.shape)
        known.update((id(symbol), node) for symbol, node in zip(symbols_of([before]), after.entries, strict=True))
    rebuilt(topological_order(node for each in several for node in each.entries), known)
    done = [matrix(each.rows, each.columns, [known[id(node)] for node in each.entries]) for each in several]
    return done[0] if isinstance(x, Expression) else done


def _several(x: Expression | Sequence[Expression]) -> list[Expression]:
    return [x] if isinstance(x, Expression) else list(x)


def values(order: Sequence[Node], known: dict[int, float]) -> dict[int, float]:
    """The number of every node, by its identity.

    Args:
        order: operands first.
        known: numbers of the symbols; extended and returned.
    """
    for node in order:
        if node.op == CONSTANT:
            known[id(node)] = node.value
        elif node.b is not LEAF:
            known[id(node)] = FOLDS[node.op](known[id(node.a)], known[id(node.b)])
        elif node.op != SYMBOL:
            known[id(node)] = FOLDS[node.op](known[id(node.a)])
        elif id(node) not in known:
            raise OperandError("expression.free", name=node.name if isinstance(node, Symbol) else node.op)
    return known


def evalf(x: Expression) -> Expression:
    """The numbers of an expression without symbols, as a constant.

    Raises:
        OperandError: a symbol is in it.
    """
    found = values(topological_order(x.entries), {})
    return matrix(x.rows, x.columns, [constant(found[id(node)]) for node in x.entries])
