"""A tape as LLVM IR: one module with the batch entry (W rows at once) and the single entry (one row, shortest way)."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from mafsil.errors import KernelError
from mafsil.kernels import transcendental
from mafsil.kernels.argument import huge_function
from mafsil.kernels.emitter import Comparison, Lanes, Text
from mafsil.kernels.layout import SINGLE, Signature
from mafsil.kernels.reduce import COMPARISONS
from mafsil.kernels.remainder import far_function
from mafsil.kernels.schedule import EXPENSIVE, GROUP, TRIGONOMETRIC, kind
from mafsil.kernels.staging import BODY, staging
from mafsil.kernels.tape import Node, Tape
from mafsil.kernels.target import Target


def lower(tape: Tape, signature: Signature, target: Target) -> str:
    """Text of one module with `mafsil_batch` and `mafsil_single`, without calls to anything outside.

    Args:
        tape: the program, reduced or not.
        signature: its ports; sizes must be those of the tape.
        target: lanes, and whether products and sums may be fused.

    Raises:
        KernelError: the ports do not fit the tape.
    """
    _check(tape, signature)
    width = target.lanes
    batch, single = _Batch(tape, target), _Single(tape, target, signature)
    huge, declared = huge_function(target.fma, "#0")
    bits = 64 * width
    attributes = f'"min-legal-vector-width"="{bits}" "prefer-vector-width"="{bits}" "no-builtins" nounwind'
    return "\n".join(
        [
            f'target triple = "{target.triple}"',
            *sorted(batch.text.declared | single.text.declared | declared),
            "declare i64 @llvm.ctlz.i64(i64, i1)",
            huge,
            far_function("#0"),
            batch.function(),
            single.function(),
            staging(signature, width, "#0"),
            f"attributes #0 = {{ {attributes} }}",
            '!0 = !{!"branch_weights", i32 1, i32 1000000}',
            "",
        ]
    )


def _check(tape: Tape, signature: Signature) -> None:
    sizes = tuple(port.size for port in signature.inputs), tuple(port.size for port in signature.outputs)
    if sizes != (tape.input_sizes, tape.output_sizes):
        raise KernelError(
            "kernels.ports", kernel=signature.name, expected=sizes, got=(tape.input_sizes, tape.output_sizes)
        )


class _Program:
    """Walks a tape in order and emits every node once; subclasses say where inputs lie and how groups are packed."""

    def __init__(self, tape: Tape, target: Target, width: int) -> None:
        self.tape = tape
        self.text = Text(target.fma, target.rounding)
        self.lanes = Lanes(self.text, width)
        self.names: dict[int, str] = {}
        self.masks: dict[int, str] = {}
        self.places: dict[int, list[tuple[int, int]]] = {}
        for k, port in enumerate(tape.outputs):
            for element, i in enumerate(port):
                self.places.setdefault(i, []).append((k, element))
        self.text.do("br label %body")
        self.text.label("body")

    def emit(self) -> None:
        """Emit all nodes, each output as soon as it is known."""
        for group in _groups(self.tape):
            if self.tape.nodes[group[0]].op in EXPENSIVE:
                self.expensive(group)
            elif group[0] not in self.names:
                self.simple(group[0])
            for i in group:
                for port, element in self.places.get(i, ()):
                    self.output(port, element, self.value(i))

    def input(self, port: int, element: int) -> str:
        """Load one element of an input."""
        raise NotImplementedError

    def output(self, port: int, element: int, value: str) -> None:
        """Store one element of an output."""
        raise NotImplementedError

    def expensive(self, group: list[int]) -> None:
        """Emit independent nodes of one kind."""
        raise NotImplementedError

    def value(self, i: int) -> str:
        """Name of node i as numbers; a comparison becomes 1 or 0 only here."""
        if i not in self.names:
            self.names[i] = self.lanes.select(self.masks[i], self.lanes.const(1.0), self.lanes.const(0.0))
        return self.names[i]

    def mask(self, i: int) -> str:
        """Name of node i as a mask: not equal to zero, NaN included."""
        if i not in self.masks:
            self.masks[i] = self.lanes.compare("une", self.value(i), self.lanes.const(0.0))
        return self.masks[i]

    def simple(self, i: int) -> None:
        node = self.tape.nodes[i]
        if node.op == "input":
            self.names[i] = self.input(*node.args)
        elif node.op == "const":
            self.names[i] = self.lanes.const(node.value)
        elif node.op in COMPARISONS:
            self.masks[i] = self.comparison(node)
        elif node.op in ("select", "if_else_zero"):
            other = self.value(node.args[2]) if node.op == "select" else self.lanes.const(0.0)
            self.names[i] = self.lanes.select(self.mask(node.args[0]), self.value(node.args[1]), other)
        else:
            self.names[i] = _EMIT[node.op](self.lanes, *(self.value(a) for a in node.args))

    def comparison(self, node: Node) -> str:
        if node.op == "not":
            return self.lanes.invert(self.mask(node.args[0]))
        if node.op in ("and", "or"):
            return self.lanes.mask_op(node.op, self.mask(node.args[0]), self.mask(node.args[1]))
        return self.lanes.compare(_ORDER[node.op], self.value(node.args[0]), self.value(node.args[1]))


_ORDER: dict[str, Comparison] = {"lt": "olt", "le": "ole", "eq": "oeq", "ne": "une"}
_PLAIN = "add sub mul div neg fma fms fnma fnms sqrt fabs copysign floor ceil sign fmin fmax"
_EMIT: dict[str, Callable[..., str]] = {
    **{op: getattr(Lanes, op) for op in _PLAIN.split()},
    **{op: transcendental.FUNCTIONS[op] for op in ("hypot", "fmod", "remainder")},
}


def _groups(tape: Tape) -> Iterator[list[int]]:
    """Runs of expensive nodes that do not need each other and are of one kind; everything else alone."""
    run: list[int] = []
    for i, node in enumerate(tape.nodes):
        joins = run and kind(node) == kind(tape.nodes[run[0]]) and not set(node.args) & set(run)
        joins = joins and len({node.args, *(tape.nodes[k].args for k in run)}) <= GROUP
        if run and not joins:
            yield run
            run = []
        if node.op in EXPENSIVE:
            run.append(i)
        else:
            yield [i]
    if run:
        yield run


def _evaluate(lanes: Lanes, nodes: list[Node], args: list[tuple[str, ...]]) -> list[str]:
    """Results of expensive nodes of one kind with the given arguments."""
    if nodes[0].op not in TRIGONOMETRIC:
        return [transcendental.FUNCTIONS[nodes[0].op](lanes, *arg) for arg in args]
    wanted: dict[str, set[str]] = {}
    for node, (angle,) in zip(nodes, args, strict=True):
        wanted.setdefault(angle, set()).add(node.op)
    angles = list(wanted)
    found = dict(zip(angles, transcendental.sincos(lanes, angles, [wanted[a] for a in angles]), strict=True))
    return [found[angle][node.op == "cos"] for node, (angle,) in zip(nodes, args, strict=True)]


class _Batch(_Program):
    """The body of a tile: every name is a vector, inputs and outputs lie in the tiles, which do not overlap."""

    def __init__(self, tape: Tape, target: Target) -> None:
        super().__init__(tape, target, target.lanes)
        self.first_in, self.first_out = _firsts(tape.input_sizes), _firsts(tape.output_sizes)
        self.emit()

    def input(self, port: int, element: int) -> str:
        return self.lanes.load("%in", self.first_in[port] + element)

    def output(self, port: int, element: int, value: str) -> None:
        self.lanes.store(value, "%out", self.first_out[port] + element)

    def expensive(self, group: list[int]) -> None:
        nodes = [self.tape.nodes[i] for i in group]
        args = [tuple(self.value(a) for a in node.args) for node in nodes]
        self.names.update(zip(group, _evaluate(self.lanes, nodes, args), strict=True))

    def function(self) -> str:
        head = f"define internal void @{BODY}(ptr noalias %in, ptr noalias %out) noinline #0 {{"
        return "\n".join([head, "entry:", *self.text.entry, *self.text.lines, "  ret void", "}", ""])


class _Single(_Program):
    """One row: plain numbers, but independent expensive functions share a vector.

    Outputs may overwrite inputs, so all inputs are read first.
    """

    def __init__(self, tape: Tape, target: Target, signature: Signature) -> None:
        super().__init__(tape, target, 1)
        self.signature = signature
        for i, node in enumerate(tape.nodes):
            if node.op == "input":
                self.simple(i)
        self.emit()

    def input(self, port: int, element: int) -> str:
        place = self.text.let(f"getelementptr double, ptr %x{port}, i64 {element}")
        return self.text.let(f"load double, ptr {place}, align 8")

    def output(self, port: int, element: int, value: str) -> None:
        place = self.text.let(f"getelementptr double, ptr %y{port}, i64 {element}")
        self.text.do(f"store double {value}, ptr {place}, align 8")

    def expensive(self, group: list[int]) -> None:
        rows = list(dict.fromkeys(self.tape.nodes[i].args for i in group))
        width = next(w for w in (1, 2, 4, GROUP) if w >= len(rows))
        lanes = Lanes(self.text, width)
        columns = [self._packed([self.value(row[k]) for row in rows], lanes) for k in range(len(rows[0]))]
        ops = sorted({self.tape.nodes[i].op for i in group})
        results = dict(zip(ops, _evaluate(lanes, [Node(op) for op in ops], [tuple(columns)] * len(ops)), strict=True))
        for i in group:
            node = self.tape.nodes[i]
            self.names[i] = self._unpacked(results[node.op], rows.index(node.args), lanes)

    def _packed(self, values: list[str], lanes: Lanes) -> str:
        if lanes.width == 1:
            return values[0]
        vector = "poison"
        for k in range(lanes.width):
            value = values[min(k, len(values) - 1)]
            vector = self.text.let(f"insertelement {lanes.real} {vector}, double {value}, i64 {k}")
        return vector

    def _unpacked(self, vector: str, k: int, lanes: Lanes) -> str:
        return vector if lanes.width == 1 else self.text.let(f"extractelement {lanes.real} {vector}, i64 {k}")

    def function(self) -> str:
        ports = [f"ptr %x{k}" for k in range(len(self.signature.inputs))]
        ports += [f"ptr %y{k}" for k in range(len(self.signature.outputs))]
        head = f"define dso_local void @{SINGLE}({', '.join(ports)}) #0 {{"
        return "\n".join([head, "entry:", *self.text.entry, *self.text.lines, "  ret void", "}", ""])


def _firsts(sizes: tuple[int, ...]) -> list[int]:
    """Index of every port's first element when all lie one after another."""
    return [sum(sizes[:k]) for k in range(len(sizes))]
