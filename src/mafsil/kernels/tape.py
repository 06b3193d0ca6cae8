"""A casadi.Function as a straight-line program of plain Python data, one value per node."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache, cached_property
from hashlib import blake2b
from typing import Any, NamedTuple

from mafsil.errors import KernelError

UNARY = frozenset(
    [
        "neg",
        "exp",
        "log",
        "sqrt",
        "sin",
        "cos",
        "tan",
        "asin",
        "acos",
        "atan",
        "sinh",
        "cosh",
        "tanh",
        "asinh",
        "acosh",
        "atanh",
        "floor",
        "ceil",
        "fabs",
        "sign",
        "not",
        "log1p",
        "expm1",
    ]
)
BINARY = frozenset(
    [
        "add",
        "sub",
        "mul",
        "div",
        "pow",
        "lt",
        "le",
        "eq",
        "ne",
        "and",
        "or",
        "fmod",
        "remainder",
        "copysign",
        "if_else_zero",
        "fmin",
        "fmax",
        "atan2",
        "hypot",
    ]
)
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
        return blake2b(self.text().encode(), digest_size=16).hexdigest()

    def counts(self) -> dict[str, int]:
        """How often every operation occurs, most frequent first."""
        names = [node.op for node in self.nodes if node.op not in ("input", "const")]
        return dict(sorted(((name, names.count(name)) for name in set(names)), key=lambda pair: (-pair[1], pair[0])))

    def text(self) -> str:
        """The program as one line of JSON; `from_text` reads it back, every bit kept."""
        rows = [[n.op, *n.args] if n.op != "const" else [n.op, n.value] for n in self.nodes]
        return json.dumps([rows, self.input_sizes, self.outputs], separators=(",", ":"))


def from_text(text: str) -> Tape:
    """The program that `Tape.text` wrote."""
    rows, sizes, outputs = json.loads(text)
    nodes = tuple(Node("const", (), float(r[1])) if r[0] == "const" else Node(r[0], tuple(r[1:])) for r in rows)
    return Tape(nodes, tuple(sizes), tuple(tuple(port) for port in outputs))


def arguments(node: Node) -> tuple[int, ...]:
    """Indices of the nodes that `node` needs."""
    return () if node.op in ("input", "const") else node.args


def alive(tape: Tape) -> Tape:
    """Only the nodes that outputs depend on."""
    needed = bytearray(len(tape.nodes))
    for port in tape.outputs:
        for i in port:
            needed[i] = 1
    for i in range(len(needed) - 1, -1, -1):
        if needed[i]:
            for a in arguments(tape.nodes[i]):
                needed[a] = 1
    return reordered(tape, [i for i, wanted in enumerate(needed) if wanted])


def reordered(tape: Tape, order: list[int]) -> Tape:
    """The tape with the nodes of `order`, in that order."""
    place = [0] * len(tape.nodes)
    nodes: list[Node] = []
    for new, old in enumerate(order):
        place[old] = new
        node = tape.nodes[old]
        nodes.append(Node(node.op, tuple([place[a] for a in node.args])) if arguments(node) else node)
    return Tape(tuple(nodes), tape.input_sizes, tuple(tuple(place[i] for i in port) for port in tape.outputs))


def read(function: Any) -> Tape:
    """The tape of a casadi.Function whose ports are columns, dense or sparse; structural zeros of outputs are 0.

    Raises:
        KernelError: an instruction has no compiled form, the function is not an expression, or a port is not a column.
    """
    function = _expanded(function)
    return _Reader(function).tape()


class _Reader:
    """One pass over the instructions; `slots` maps CasADi's reused work vector to the nodes now in it."""

    def __init__(self, function: Any) -> None:
        self.function = function
        self.rows_in = [_rows(function.sparsity_in(i), function.name_in(i)) for i in range(function.n_in())]
        self.rows_out = [_rows(function.sparsity_out(i), function.name_out(i)) for i in range(function.n_out())]
        self.nodes: list[Node] = []
        self.slots: dict[int, int] = {}

    def tape(self) -> Tape:
        f = self.function
        zero = self.add(Node("const", (), 0.0))
        outputs = [[zero] * f.size1_out(i) for i in range(f.n_out())]
        names = _names()
        for k in range(f.n_instructions()):
            name, source = names[f.instruction_id(k)], f.instruction_input(k)
            if name == "OUTPUT":
                port, nonzero = f.instruction_output(k)
                outputs[port][self.rows_out[port][nonzero]] = self.slots[source[0]]
            else:
                self.slots[f.instruction_output(k)[0]] = self.value(name, source, k)
        sizes = tuple(f.size1_in(i) for i in range(f.n_in()))
        return Tape(tuple(self.nodes), sizes, tuple(tuple(port) for port in outputs))

    def value(self, name: str, source: list[int], k: int) -> int:
        """Index of the node that instruction k computes."""
        if name == "CONST":
            return self.add(Node("const", (), float(self.function.instruction_constant(k))))
        if name == "INPUT":
            port, nonzero = source
            return self.add(Node("input", (port, self.rows_in[port][nonzero])))
        args = tuple(self.slots[slot] for slot in source)
        if name in ("ASSIGN", "LIFT"):
            return args[0]
        if name == "SQ":
            return self.add(Node("mul", (args[0], args[0])))
        if name == "TWICE":
            return self.add(Node("add", (args[0], args[0])))
        if name == "INV":
            return self.add(Node("div", (self.add(Node("const", (), 1.0)), args[0])))
        op = "pow" if name == "CONSTPOW" else name.lower()
        if op not in UNARY and op not in BINARY:
            raise KernelError("kernels.operation", function=self.function.name(), operation=f"OP_{name}", index=k)
        return self.add(Node(op, args))

    def add(self, node: Node) -> int:
        self.nodes.append(node)
        return len(self.nodes) - 1


def _expanded(function: Any) -> Any:
    """The function as scalar expressions."""
    if function.is_a("SXFunction"):
        return function
    try:
        return function.expand()
    except RuntimeError as error:
        reason = str(error).strip().splitlines()[-1]
        raise KernelError("kernels.expression", function=function.name(), reason=reason) from None


def _rows(sparsity: Any, port: str) -> list[int]:
    """Element of every nonzero of a column."""
    if sparsity.size2() != 1 and sparsity.numel():
        raise KernelError("kernels.column", port=port, rows=sparsity.size1(), columns=sparsity.size2())
    return list(sparsity.row())


@cache
def _names() -> dict[int, str]:
    """CasADi's operation numbers by name, `OP_` removed."""
    import casadi

    return {int(getattr(casadi, name)): name[3:] for name in dir(casadi) if name.startswith("OP_")}
