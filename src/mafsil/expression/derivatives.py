"""Derivatives of expressions by the chain rule, forward and in reverse."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from mafsil.errors import OperandError
from mafsil.expression import arithmetic, elementary
from mafsil.expression.graph import symbols_of, topological_order
from mafsil.expression.matrix import Expression, matrix
from mafsil.expression.node import LEAF, MINUS_ONE, ONE, TWO, ZERO, Node, binary, unary

Slopes = tuple[Node, Node]


def jacobian(f: Expression, x: Expression) -> Expression:
    """Derivatives of the elements of f by the symbols x: (elements of f, elements of x).

    Forward by one symbol after the other, or in reverse from one element after the other, whichever passes over fewer
    nodes; nodes that do not lie between are not visited.

    Raises:
        OperandError: x holds something that is no symbol.
    """
    graph = _Graph(f.entries, x)
    forward, reverse = graph.effort()
    m, n = len(f.entries), len(x.entries)
    if forward <= reverse:
        columns = [graph.forward({s: ONE}, 1 << j) for j, s in enumerate(graph.symbols)]
        return matrix(m, n, [entry for column in columns for entry in column])
    rows = [graph.reverse([(node, ONE)]) for node in f.entries]
    return matrix(m, n, [row[j] for j in range(n) for row in rows])


def gradient(f: Expression, x: Expression) -> Expression:
    """Derivatives of a scalar f by the symbols x, in the shape of x, in reverse.

    Raises:
        OperandError: f is no scalar, or x holds something that is no symbol.
    """
    if len(f.entries) != 1:
        raise OperandError("expression.shapes", sign="gradient", left=f.shape, right=(1, 1))
    graph = _Graph(f.entries, x)
    return matrix(x.rows, x.columns, graph.reverse([(f.entries[0], ONE)]))


def hessian(f: Expression, x: Expression) -> tuple[Expression, Expression]:
    """Second derivatives (n, n) of a scalar by n symbols, and its gradient; exactly symmetric."""
    slope = gradient(f, x)
    graph, n = _Graph(slope.entries, x), len(x.entries)
    columns = [graph.forward({s: ONE}, 1 << j) for j, s in enumerate(graph.symbols)]
    return matrix(n, n, [columns[min(i, j)][max(i, j)] for j in range(n) for i in range(n)]), slope


def jtimes(f: Expression, x: Expression, v: Expression) -> Expression:
    """Derivative of f along the direction v of the symbols x, forward.

    Raises:
        OperandError: shapes of x and v differ, or x holds something that is no symbol.
    """
    if x.shape != v.shape:
        raise OperandError("expression.shapes", sign="jtimes", left=x.shape, right=v.shape)
    graph = _Graph(f.entries, x)
    seeds: dict[Node, Node] = dict(zip(graph.symbols, v.entries, strict=True))
    return matrix(f.rows, f.columns, graph.forward(seeds, (1 << len(graph.symbols)) - 1))


class _Graph:
    """The nodes of a result that depend on symbols, and their slopes."""

    def __init__(self, results: Sequence[Node], x: Expression) -> None:
        self.results, self.symbols = results, symbols_of([x])
        self.depends: dict[Node, int] = {s: 1 << j for j, s in enumerate(self.symbols)}
        """Bit j: the node depends on symbol j."""
        self.active: list[Node] = []
        self.slopes: dict[Node, Slopes] = {}
        depends = self.depends
        for node in topological_order(results):
            mask = depends.get(node.a, 0) | depends.get(node.b, 0)
            if mask and node.a is not LEAF:
                depends[node] = mask
                self.active.append(node)
                self.slopes[node] = slopes(node)

    def effort(self) -> tuple[int, int]:
        """Nodes that all forward passes, and all reverse passes, go over."""
        forward = sum(self.depends[node].bit_count() for node in self.active)
        needed: dict[Node, int] = {}
        for i, node in enumerate(self.results):
            needed[node] = needed.get(node, 0) | 1 << i
        reverse = 0
        for node in reversed(self.active):
            mask = needed.get(node, 0)
            reverse += mask.bit_count()
            for operand in (node.a, node.b):
                needed[operand] = needed.get(operand, 0) | mask
        return forward, reverse

    def forward(self, seeds: dict[Node, Node], mask: int) -> list[Node]:
        """Derivatives of all results along the seeds of symbols, over the nodes that depend on those of the mask."""
        change = dict(seeds)
        for node in self.active:
            if self.depends[node] & mask:
                by_a, by_b = self.slopes[node]
                da, db = change.get(node.a, ZERO), change.get(node.b, ZERO)
                change[node] = arithmetic.add(_carried(node, by_a, da), _carried(node, by_b, db))
        return [change.get(node, ZERO) for node in self.results]

    def reverse(self, seeds: Sequence[tuple[Node, Node]]) -> list[Node]:
        """Derivatives by all symbols of the sum of results times seeds."""
        weight: dict[Node, Node] = {}
        for node, seed in seeds:
            weight[node] = arithmetic.add(weight.get(node, ZERO), seed)
        for node in reversed(self.active):
            outer = weight.get(node)
            if outer is None or outer is ZERO:
                continue
            for operand, slope in zip((node.a, node.b), self.slopes[node], strict=True):
                if slope is not ZERO and operand in self.depends:
                    share = _carried(node, slope, outer)
                    weight[operand] = arithmetic.add(weight.get(operand, ZERO), share)
        return [weight.get(s, ZERO) for s in self.symbols]


def _carried(node: Node, slope: Node, change: Node) -> Node:
    """A change times a slope; through a choice it passes only where the choice is taken, so that NaN stays behind."""
    if node.op == "if_else_zero" and slope is not ZERO:
        return arithmetic.if_else_zero(slope, change)
    return arithmetic.mul(slope, change)


def slopes(node: Node) -> Slopes:
    """Derivatives of the node's operation by its operands."""
    rule = _SLOPES.get(node.op)
    if rule is None:
        return ZERO, ZERO
    return rule(node.a, node.b, node)


def _plus_one(x: Node) -> Node:
    return arithmetic.add(ONE, x)


def _inverse(x: Node) -> Node:
    return arithmetic.div(ONE, x)


def _less_square(x: Node) -> Node:
    """1 - x^2."""
    return arithmetic.sub(ONE, arithmetic.sq(x))


def _chosen(a: Node, b: Node) -> Slopes:
    """Shares of an extreme: half and half where both are equal."""
    x, y = elementary.le(a, b), elementary.le(b, a)
    total = arithmetic.add(x, y)
    return arithmetic.div(x, total), arithmetic.div(y, total)


def _atan2(y: Node, x: Node) -> Slopes:
    square = arithmetic.add(arithmetic.sq(y), arithmetic.sq(x))
    return arithmetic.div(x, square), arithmetic.neg(arithmetic.div(y, square))


def _power(a: Node, b: Node, f: Node) -> Slopes:
    return arithmetic.mul(b, elementary.power(a, arithmetic.sub(b, ONE))), arithmetic.mul(elementary.log(a), f)


_SLOPES: dict[str, Callable[[Node, Node, Node], Slopes]] = {
    "add": lambda a, b, f: (ONE, ONE),
    "sub": lambda a, b, f: (ONE, MINUS_ONE),
    "mul": lambda a, b, f: (b, a),
    "div": lambda a, b, f: (_inverse(b), arithmetic.neg(arithmetic.div(f, b))),
    "neg": lambda a, b, f: (MINUS_ONE, ZERO),
    "sq": lambda a, b, f: (arithmetic.twice(a), ZERO),
    "twice": lambda a, b, f: (TWO, ZERO),
    "inv": lambda a, b, f: (arithmetic.neg(arithmetic.sq(f)), ZERO),
    "sqrt": lambda a, b, f: (_inverse(arithmetic.twice(f)), ZERO),
    "exp": lambda a, b, f: (f, ZERO),
    "log": lambda a, b, f: (_inverse(a), ZERO),
    "pow": _power,
    "sin": lambda a, b, f: (elementary.cos(a), ZERO),
    "cos": lambda a, b, f: (arithmetic.neg(unary("sin", a)), ZERO),
    "tan": lambda a, b, f: (_inverse(arithmetic.sq(elementary.cos(a))), ZERO),
    "asin": lambda a, b, f: (_inverse(elementary.sqrt(_less_square(a))), ZERO),
    "acos": lambda a, b, f: (arithmetic.neg(_inverse(elementary.sqrt(_less_square(a)))), ZERO),
    "atan": lambda a, b, f: (_inverse(_plus_one(arithmetic.sq(a))), ZERO),
    "tanh": lambda a, b, f: (_less_square(f), ZERO),
    "fabs": lambda a, b, f: (unary("sign", a), ZERO),
    "fmin": lambda a, b, f: _chosen(a, b),
    "fmax": lambda a, b, f: _chosen(b, a),
    "if_else_zero": lambda a, b, f: (ZERO, a),
    "atan2": lambda a, b, f: _atan2(a, b),
    "copysign": lambda a, b, f: (arithmetic.mul(binary("copysign", ONE, b), unary("sign", a)), ZERO),
}
"""Slopes by operation; what is not here is a step, with slope zero."""
