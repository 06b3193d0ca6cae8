"""A smaller tape with the same values: constants folded, equal values shared, signs absorbed, products fused with sums.

1. Every operation goes through the rules of its kind, once, operands first (`_Builder.emit`): constants are folded,
   x + 0 and 1 x vanish, negations move outwards until something absorbs them, (c ? u : 0) + (not c ? v : 0) becomes one
   choice. Equal operations on equal operands are one value.
2. Sums of products are put in rows (`sums`), so that every product can be fused.
3. Products are fused with their sums (`fusion`).
4. The order is chosen for few registers (`schedule`).

Every rewrite keeps the IEEE result of every operation, NaN and infinities included, but for three: the sign of a zero
may change, a product fused with its sum is rounded once instead of twice, and sums of products may be taken in another
order (`sums`), which keeps the bound of their rounding error.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from mafsil.kernels.fusion import fuse, in_rows
from mafsil.kernels.schedule import schedule
from mafsil.kernels.tape import Node, Tape, places

COMPARISONS = frozenset(["lt", "le", "eq", "ne", "and", "or", "not"])
"""Operations whose value is 1 or 0."""


def reduce(tape: Tape) -> Tape:
    """The tape rewritten, dead values removed, in an order that keeps few values alive."""
    return schedule(fuse(in_rows(_simplify(tape))))


def _simplify(tape: Tape) -> Tape:
    """Local rewrites, each value offered once to every rule, equal values shared; some are dead afterwards."""
    builder = _Builder()
    place: list[int] = []
    for node in tape.nodes:
        if node.op in ("input", "const"):
            place.append(builder.leaf(node))
        else:
            place.append(builder.emit(node.op, *places(node.args, place)))
    outputs = tuple(tuple(place[i] for i in port) for port in tape.outputs)
    return Tape(tuple(builder.nodes), tape.input_sizes, outputs)


class _Builder:
    """Grows a list of nodes; equal values get equal indices.

    Attributes:
        nodes: made so far.
        index: where each operation on its arguments is.
        numbers: values of the constants among them.
        negands: x, of the nodes that are -x.
    """

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self.index: dict[tuple[str, object], int] = {}
        self.numbers: dict[int, float] = {}
        self.negands: dict[int, int] = {}

    def leaf(self, node: Node) -> int:
        """An input or a constant, of which every bit counts."""
        key = (node.op, node.value.hex() if node.op == "const" else node.args)
        if key not in self.index:
            self.index[key] = len(self.nodes)
            if node.op == "const":
                self.numbers[len(self.nodes)] = node.value
            self.nodes.append(node)
        return self.index[key]

    def const(self, value: float) -> int:
        return self.leaf(Node("const", (), value))

    def emit(self, op: str, *args: int) -> int:
        """Index of the value `op(*args)` after all rules."""
        if args[0] in self.numbers and args[-1] in self.numbers:
            folded = self._fold(op, args)
            if folded is not None:
                return self.const(folded)
        rule = _RULES.get(op)
        found = rule(self, *args) if rule else None
        return self.plain(op, *args) if found is None else found

    def plain(self, op: str, *args: int) -> int:
        """The operation itself, arguments of commutative ones in a fixed order."""
        if op in _COMMUTATIVE and args[0] > args[1]:
            args = (args[1], args[0])
        found = self.index.get((op, args))
        if found is None:
            found = self.index[op, args] = len(self.nodes)
            self.nodes.append(Node(op, args))
            if op == "neg":
                self.negands[found] = args[0]
        return found

    def _fold(self, op: str, args: tuple[int, ...]) -> float | None:
        fold = _FOLDS.get(op)
        if fold is None:
            return None
        try:
            return float(fold(*[self.numbers[a] for a in args]))
        except (ValueError, OverflowError, ZeroDivisionError):
            return None


_COMMUTATIVE = frozenset(("add", "mul", "eq", "ne", "and", "or"))


def _neg(b: _Builder, x: int) -> int | None:
    return b.negands.get(x)


def _add(b: _Builder, x: int, y: int) -> int | None:
    if b.numbers.get(x) == 0.0:
        return y
    if b.numbers.get(y) == 0.0:
        return x
    if x == y:
        return b.emit("mul", b.const(2.0), x)
    if (minus := b.negands.get(y)) is not None:
        return b.emit("sub", x, minus)
    if (minus := b.negands.get(x)) is not None:
        return b.emit("sub", y, minus)
    return _choice(b, x, y)


def _choice(b: _Builder, x: int, y: int) -> int | None:
    """`if c then u else v` is written as (c ? u : 0) + (not c ? v : 0)."""
    first, second = b.nodes[x], b.nodes[y]
    if first.op != "if_else_zero" or second.op != "if_else_zero":
        return None
    if b.nodes[second.args[0]] == Node("not", (first.args[0],)):
        return b.plain("select", first.args[0], first.args[1], second.args[1])
    if b.nodes[first.args[0]] == Node("not", (second.args[0],)):
        return b.plain("select", second.args[0], second.args[1], first.args[1])
    return None


def _sub(b: _Builder, x: int, y: int) -> int | None:
    if b.numbers.get(y) == 0.0:
        return x
    if b.numbers.get(x) == 0.0:
        return b.emit("neg", y)
    if (minus := b.negands.get(y)) is not None:
        return b.emit("add", x, minus)
    if (minus := b.negands.get(x)) is not None:
        return b.emit("neg", b.emit("add", minus, y))
    if (opposite := b.index.get(("sub", (y, x)))) is not None:
        return b.emit("neg", opposite)
    return None


def _mul(b: _Builder, x: int, y: int) -> int | None:
    if b.numbers.get(y) is not None:
        x, y = y, x
    minus_x, minus_y = b.negands.get(x), b.negands.get(y)
    constant = b.numbers.get(x)
    if constant is not None:
        if constant == 1.0:
            return y
        if constant == -1.0:
            return b.emit("neg", y)
        if minus_y is not None:
            return b.emit("mul", b.const(-constant), minus_y)
        if constant < 0.0 and ("mul", tuple(sorted((b.const(-constant), y)))) in b.index:
            return b.emit("neg", b.emit("mul", b.const(-constant), y))
    elif minus_x is not None or minus_y is not None:
        product = b.emit("mul", x if minus_x is None else minus_x, y if minus_y is None else minus_y)
        return product if minus_x is not None and minus_y is not None else b.emit("neg", product)
    return None


def _div(b: _Builder, x: int, y: int) -> int | None:
    constant = b.numbers.get(y)
    if constant is not None and constant != 0.0 and math.isfinite(constant):
        mantissa, exponent = math.frexp(constant)
        if abs(mantissa) == 0.5 and -1021 < exponent < 1021:
            return b.emit("mul", x, b.const(1.0 / constant))
    if (minus := b.negands.get(y)) is not None:
        return b.emit("neg", b.emit("div", x, minus))
    if (minus := b.negands.get(x)) is not None:
        return b.emit("neg", b.emit("div", minus, y))
    return None


def _odd(op: str) -> Callable[[_Builder, int], int | None]:
    """f(-x) = -f(x)."""

    def rule(b: _Builder, x: int) -> int | None:
        minus = b.negands.get(x)
        return None if minus is None else b.emit("neg", b.emit(op, minus))

    return rule


def _even(op: str) -> Callable[[_Builder, int], int | None]:
    """f(-x) = f(x)."""

    def rule(b: _Builder, x: int) -> int | None:
        minus = b.negands.get(x)
        return None if minus is None else b.emit(op, minus)

    return rule


def _not(b: _Builder, x: int) -> int | None:
    inner = b.nodes[x]
    return inner.args[0] if inner.op == "not" and b.nodes[inner.args[0]].op in COMPARISONS else None


def _if_else_zero(b: _Builder, condition: int, x: int) -> int | None:
    known = b.numbers.get(condition)
    if known is not None:
        return x if known != 0.0 else b.const(0.0)
    return x if b.numbers.get(x) == 0.0 else None


_RULES: dict[str, Callable[..., int | None]] = {
    "neg": _neg,
    "add": _add,
    "sub": _sub,
    "mul": _mul,
    "div": _div,
    "not": _not,
    "if_else_zero": _if_else_zero,
    **{op: _odd(op) for op in ["sin", "tan", "asin", "atan", "tanh"]},
    **{op: _even(op) for op in ("cos", "fabs")},
}

_FOLDS_OF_ONE: dict[str, Callable[[float], float]] = {
    "neg": lambda x: -x,
    "not": lambda x: x == 0.0,
    "sqrt": math.sqrt,
    "fabs": math.fabs,
    "exp": math.exp,
    "log": math.log,
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
    "asin": math.asin,
    "acos": math.acos,
    "atan": math.atan,
    "tanh": math.tanh,
    "floor": math.floor,
    "ceil": math.ceil,
}
_FOLDS_OF_TWO: dict[str, Callable[[float, float], float]] = {
    "add": lambda x, y: x + y,
    "sub": lambda x, y: x - y,
    "mul": lambda x, y: x * y,
    "div": lambda x, y: x / y,
    "atan2": math.atan2,
    "lt": lambda x, y: x < y,
    "le": lambda x, y: x <= y,
    "eq": lambda x, y: x == y,
    "ne": lambda x, y: x != y,
    "and": lambda x, y: x != 0.0 and y != 0.0,
    "or": lambda x, y: x != 0.0 or y != 0.0,
}
_FOLDS: dict[str, Callable[..., float]] = {**_FOLDS_OF_ONE, **_FOLDS_OF_TWO}
"""Operations on numbers alone; whoever raises is left to the machine, which answers with NaN or an infinity."""
