"""A function of expressions as a straight-line program of plain Python data, one value per node."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass
from functools import cached_property, lru_cache
from hashlib import blake2b
from typing import NamedTuple

from mafsil.errors import KernelError
from mafsil.expression import Function
from mafsil.expression.node import Node as Value

UNARY = frozenset((
    "neg", "exp", "log", "sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "tanh", "floor", "ceil", "fabs", "sign",
    "not",
))  # fmt: skip
BINARY = frozenset((
    "add", "sub", "mul", "div", "pow", "lt", "le", "eq", "ne", "and", "or", "copysign", "if_else_zero", "fmin",
    "fmax", "atan2",
))  # fmt: skip
FUSED = frozenset(("fma", "fms", "fnma", "fnms"))
"""a*b + c, a*b - c, c - a*b, -(a*b) - c, each rounded once where the target can."""
OPERATIONS = UNARY | BINARY | FUSED | {"select"}
"""All operations of a tape besides `input` and `const`; `select(c, a, b)` is a where c is not zero, else b."""


class Node(NamedTuple):
    """One value of the program.

    Attributes:
        op: `input`, `const` or a member of OPERATIONS.
        args: indices of earlier nodes; of an input, its (port, element).
        value: the number of a `const`.
    """

    op: str
    args: tuple[int, ...] = ()
    value: float = 0.0


@dataclass(frozen=True)
class Tape:
    """A straight-line program without branches.

    Attributes:
        nodes: values in an order in which they can be computed.
        input_sizes: number of elements of every input port.
        outputs: for every output port, the node of each element.
    """

    nodes: tuple[Node, ...]
    input_sizes: tuple[int, ...]
    outputs: tuple[tuple[int, ...], ...]

    @cached_property
    def operands(self) -> tuple[tuple[int, ...], ...]:
        """For every node, the nodes that it needs: its arguments, but for the place of an input."""
        return tuple([() if op == "input" else args for op, args, _ in self.nodes])

    @property
    def output_sizes(self) -> tuple[int, ...]:
        """Number of elements of every output port."""
        return tuple(len(port) for port in self.outputs)

    @cached_property
    def operations(self) -> int:
        """Number of nodes that compute something."""
        return sum(node.op not in ("input", "const") for node in self.nodes)

    @cached_property
    def hash(self) -> str:
        """Identity of the program: 32 hexadecimal digits, equal for equal text in every process."""
        return blake2b(self.text.encode(), digest_size=16).hexdigest()

    def counts(self) -> dict[str, int]:
        """How often every operation occurs, most frequent first."""
        found = Counter(node.op for node in self.nodes if node.op not in ("input", "const"))
        return dict(sorted(found.items(), key=lambda pair: (-pair[1], pair[0])))

    @cached_property
    def text(self) -> str:
        """The program as one line of JSON; `from_text` reads it back, every bit kept."""
        rows = [[n.op, *n.args] if n.op != "const" else [n.op, n.value] for n in self.nodes]
        return json.dumps([rows, self.input_sizes, self.outputs], separators=(",", ":"))


@lru_cache(maxsize=1)
def from_text(text: str) -> Tape:
    """The program that `Tape.text` wrote; the last one is kept, since a kernel is compiled part by part."""
    rows, sizes, outputs = json.loads(text)
    nodes = tuple(Node("const", (), float(r[1])) if r[0] == "const" else Node(r[0], tuple(r[1:])) for r in rows)
    return Tape(nodes, tuple(sizes), tuple(tuple(port) for port in outputs))


def arguments(node: Node) -> tuple[int, ...]:
    """Indices of the nodes that `node` needs."""
    return () if node.op in ("input", "const") else node.args


def places(args: tuple[int, ...], place: list[int]) -> tuple[int, ...]:
    """Where the arguments are now; nearly all operations have two, which need no loop."""
    return (place[args[0]], place[args[1]]) if len(args) == 2 else tuple([place[a] for a in args])


def reorder_nodes(tape: Tape, order: list[int]) -> Tape:
    """The tape with the nodes of `order`, in that order; what they need is among them."""
    place = [0] * len(tape.nodes)
    nodes: list[Node] = []
    for new, old in enumerate(order):
        place[old] = new
        node, args = tape.nodes[old], tape.operands[old]
        nodes.append(Node(node.op, places(args, place)) if args else node)
    return Tape(tuple(nodes), tape.input_sizes, tuple(tuple(place[i] for i in port) for port in tape.outputs))


def read(function: Function) -> Tape:
    """The tape of a function whose ports are columns.

    Raises:
        KernelError: an operation has no compiled form, or a port is not a column.
    """
    for port, x in zip(function.input_names + function.output_names, function.inputs + function.outputs, strict=True):
        if x.columns != 1 and x.entries:
            raise KernelError("kernels.column", port=port, rows=x.rows, columns=x.columns)
    return _Reader(function).tape()


class _Reader:
    """One pass over the nodes; `place` says where the value of a node stands."""

    def __init__(self, function: Function) -> None:
        self.function = function
        self.nodes: list[Node] = [Node("const", (), 0.0)]
        self.place: dict[Value, int] = {}
        self.ports = {
            symbol: (port, element)
            for port, x in enumerate(function.inputs)
            for element, symbol in enumerate(x.entries)
        }

    def tape(self) -> Tape:
        """All nodes, operands first."""
        place = self.place
        for index, node in enumerate(self.function.order):
            place[node] = self._value(node, index)
        outputs = tuple(tuple(place[node] for node in x.entries) for x in self.function.outputs)
        return Tape(tuple(self.nodes), tuple(len(x.entries) for x in self.function.inputs), outputs)

    def _value(self, node: Value, index: int) -> int:
        op = node.op
        if op in BINARY:
            return self._add(Node(op, (self.place[node.a], self.place[node.b])))
        if op == "const":
            return self._add(Node("const", (), node.value))
        if op == "symbol":
            return self._add(Node("input", self.ports[node]))
        a = self.place[node.a]
        if op == "sq":
            return self._add(Node("mul", (a, a)))
        if op == "twice":
            return self._add(Node("add", (a, a)))
        if op == "inv":
            return self._add(Node("div", (self._add(Node("const", (), 1.0)), a)))
        if op in UNARY:
            return self._add(Node(op, (a,)))
        raise KernelError("kernels.operation", function=self.function.name, operation=op, index=index)

    def _add(self, node: Node) -> int:
        self.nodes.append(node)
        return len(self.nodes) - 1
