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
    seen = {LEAF}
    for root in roots:
        # What lies on the stack waits for what lies above it, so nothing is on it twice.
        stack = [] if root in seen else [root]
        while stack:
            node = stack[-1]
            if (operand := node.a) not in seen or (operand := node.b) not in seen:
                stack.append(operand)
            else:
                seen.add(node)
                order.append(stack.pop())
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


def rebuilt(order: Iterable[Node], known: dict[Node, Node], shared: bool = False) -> dict[Node, Node]:
    """Every node of the order built anew over new operands, by the old node.

    Args:
        order: operands first.
        known: replacements of some nodes; extended and returned.
        shared: equal values become one node.
    """
    table = _Table()
    for node in order:
        if node in known:
            continue
        if node.a is LEAF:
            new = node
        elif node.b is LEAF:
            new = UNARY[node.op](known[node.a])
        else:
            new = BINARY[node.op](known[node.a], known[node.b])
        known[node] = table.one(new) if shared else new
    return known


class _Table:
    """One node for every value: an operation on nodes that are one themselves."""

    def __init__(self) -> None:
        self._nodes: dict[tuple[object, ...], Node] = {}
        self._ones = {LEAF}

    def one(self, node: Node) -> Node:
        """The node of this value; what a rule built below it is shared too."""
        if node in self._ones:
            return node
        if node.op == SYMBOL:
            key: tuple[object, ...] = (node,)
        elif node.op == CONSTANT:
            key = (CONSTANT, node.value.hex())
        else:
            a, b = node.a, node.b
            if a not in self._ones or b not in self._ones:
                a, b = self.one(a), self.one(b)
                node = Node(node.op, a, b)
            key = (node.op, a, b)
        found = self._nodes.setdefault(key, node)
        self._ones.add(found)
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
    done = [matrix(each.rows, each.columns, [known[node] for node in each.entries]) for each in several]
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
    known: dict[Node, Node] = {}
    for before, after in zip(olds, news, strict=True):
        if before.shape != after.shape:
            raise OperandError("expression.shapes", sign="substitute", left=before.shape, right=after.shape)
        known.update((symbol, node) for symbol, node in zip(symbols_of([before]), after.entries, strict=True))
    rebuilt(topological_order(node for each in several for node in each.entries), known)
    done = [matrix(each.rows, each.columns, [known[node] for node in each.entries]) for each in several]
    return done[0] if isinstance(x, Expression) else done


def _several(x: Expression | Sequence[Expression]) -> list[Expression]:
    return [x] if isinstance(x, Expression) else list(x)


def values(order: Sequence[Node], known: dict[Node, float]) -> dict[Node, float]:
    """The number of every node.

    Args:
        order: operands first.
        known: numbers of the symbols; extended and returned.
    """
    for node in order:
        if node.op == CONSTANT:
            known[node] = node.value
        elif node.b is not LEAF:
            known[node] = FOLDS[node.op](known[node.a], known[node.b])
        elif node.op != SYMBOL:
            known[node] = FOLDS[node.op](known[node.a])
        elif node not in known:
            raise OperandError("expression.free", name=node.name if isinstance(node, Symbol) else node.op)
    return known


def evalf(x: Expression) -> Expression:
    """The numbers of an expression without symbols, as a constant.

    Raises:
        OperandError: a symbol is in it.
    """
    found = values(topological_order(x.entries), {})
    return matrix(x.rows, x.columns, [constant(found[node]) for node in x.entries])
