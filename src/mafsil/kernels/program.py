"""The arithmetic of a piece of a tape as IR: every node once, in order.

1. Blocks of outputs (`rows`) are listed with the values they wait for; those that wait for nothing are written.
2. Group by group in the order of the schedule: cheap operations alone, expensive ones of a kind side by side, since
   their long chains of dependent instructions overlap in the processor.
3. On one row, expensive operations share a vector: up to eight sines for the price of one (`pack_lanes`).
4. A value that completes a block sends it to memory at once; a value for a later piece goes to its cell.
5. Comparisons stay masks (one bit a lane) as long as only choices use them; 0 and 1 are made where numbers are needed.

Elementary functions (FUNCTIONS) are IR arithmetic alone and branch-free, but for huge angles; they pass NaN on, and ULP
says how far each may be from the truth. A row's result does not depend on the lanes beside it. On targets without fused
multiply-add the same bounds hold. All but sin and tan keep the sign of a zero.

Reference: Muller et al., Handbook of Floating-Point Arithmetic, 2018.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import accumulate

from mafsil.kernels.emitter import Comparison, Lanes, Text
from mafsil.kernels.exponential import exp, log, pow, tanh
from mafsil.kernels.reduce import COMPARISONS
from mafsil.kernels.rows import Block, row_pointers, write
from mafsil.kernels.schedule import EXPENSIVE, GROUP, TRIGONOMETRIC, Segment
from mafsil.kernels.tape import Node, Tape
from mafsil.kernels.trigonometric import acos, asin, atan, atan2, sincos, tan

ULP = {
    "sin": 1.0, "cos": 1.0, "tan": 1.0, "asin": 1.0, "acos": 1.0, "atan": 1.5, "atan2": 2.0,
    "exp": 1.0, "log": 1.0, "pow": 1.0, "tanh": 2.0,
}  # fmt: skip
"""Largest distance from the exact value, in units of its last place; proven by samples against mpmath in the tests."""
FUNCTIONS: dict[str, Callable[..., str]] = {
    function.__name__: function for function in (acos, asin, atan, atan2, exp, log, pow, tan, tanh)
}
"""Functions by the operation's name: (lanes, names of the arguments) -> name of the result."""
_ORDER: dict[str, Comparison] = {"lt": "olt", "le": "ole", "eq": "oeq", "ne": "une"}
_PLAIN = "add sub mul div neg fma fms fnma fnms sqrt fabs copysign floor ceil sign fmin fmax"
_EMIT: dict[str, Callable[..., str]] = {
    **{op: getattr(Lanes, op) for op in _PLAIN.split()},
}


class Program:
    """Emits a segment into `text`.

    Inputs lie one after another at %in unless preloaded, values of other segments at %far. With several lanes the
    outputs are written by blocks to rows at %rows0, %rows1, ..., or stay lanes (`in_rows` is False); with one lane or
    as lanes every output port has its own pointer %y0, %y1, .... On one lane independent expensive functions share a
    vector.
    """

    def __init__(self, tape: Tape, segment: Segment, text: Text, width: int, in_rows: bool = True) -> None:
        self.tape = tape
        self.segment = segment
        self.text = text
        self.lanes = Lanes(text, width)
        self.by_blocks = in_rows and width > 1
        self.first_in = _firsts(tape.input_sizes)
        self.names: dict[int, str] = {}
        self.masks: dict[int, str] = {}
        self.rows: dict[int, list[str]] = {}
        self.waiting: dict[Block, int] = {}
        self.completes: dict[int, list[Block]] = {}

    def preload(self) -> None:
        """Read all inputs from the ports %x0, %x1, ...: afterwards outputs may overwrite them."""
        for i, node in enumerate(self.tape.nodes):
            if node.op == "input":
                port, element = node.args
                self.names[i] = self.lanes.load(f"%x{port}", element)

    def emit(self, places: dict[int, list[tuple[int, int]]]) -> None:
        """Emit all nodes; outputs and values for later segments are stored as soon as they are known.

        Args:
            places: for every node, the (port, element) of the outputs that it is; where outputs are written in blocks,
                the segment's blocks count instead.
        """
        # 1.
        self.open_blocks()
        # 2. and 3., then 4. for every value of the group.
        for group in self.segment.groups:
            if self.tape.nodes[group[0]].op in EXPENSIVE:
                self.expensive(group)
            else:
                self.simple(group[0])
            for i in group:
                self.store(i, places.get(i, []))

    def open_blocks(self) -> None:
        """Find what every block waits for; one that waits for nothing is written at once."""
        computed = {i for group in self.segment.groups for i in group}
        for port in sorted({block.port for block in self.segment.blocks}):
            self.rows[port] = row_pointers(self.text, port, self.lanes.width)
        for block in self.segment.blocks:
            missing = computed.intersection(block.nodes)
            self.waiting[block] = len(missing)
            for i in missing:
                self.completes.setdefault(i, []).append(block)
            if not missing:
                self.write(block)

    def store(self, i: int, places: list[tuple[int, int]]) -> None:
        """Write node i to its places in the outputs, and to its memory cell."""
        if not self.by_blocks:
            for port, element in places:
                self.lanes.store(self.value(i), f"%y{port}", element)
        for block in self.completes.get(i, ()):
            self.waiting[block] -= 1
            if not self.waiting[block]:
                self.write(block)
        if i in self.segment.kept:
            self.lanes.store(self.value(i), "%far", self.segment.kept[i])

    def write(self, block: Block) -> None:
        """Write a block whose values are all known, before anything else is written.

        Left alone, LLVM gathers the stores at the end, and their values overflow the registers.
        """
        write(self.text, self.rows[block.port], block.first, [self.value(i) for i in block.nodes])
        # An empty instruction with side effects, over which no store is moved.
        self.text.do('call void asm sideeffect "", ""()')

    def value(self, i: int) -> str:
        """Name of node i as numbers; loaded at first use; a comparison becomes 1 or 0 only here."""
        if i not in self.names:
            node = self.tape.nodes[i]
            if node.op == "const":
                self.names[i] = self.lanes.const(node.value)
            elif node.op == "input":
                port, element = node.args
                self.names[i] = self.lanes.load("%in", self.first_in[port] + element)
            elif i in self.segment.known:
                self.names[i] = self.lanes.load("%far", self.segment.known[i])
            else:
                self.names[i] = self.lanes.select(self.masks[i], self.lanes.const(1.0), self.lanes.const(0.0))
        return self.names[i]

    def mask(self, i: int) -> str:
        """Name of node i as a mask: not equal to zero, NaN included."""
        if i not in self.masks:
            self.masks[i] = self.lanes.compare("une", self.value(i), self.lanes.const(0.0))
        return self.masks[i]

    def simple(self, i: int) -> None:
        """Emit one node that takes an instruction or a few."""
        node = self.tape.nodes[i]
        if node.op in COMPARISONS:
            self.masks[i] = self.comparison(node)
        elif node.op in ("select", "if_else_zero"):
            other = self.value(node.args[2]) if node.op == "select" else self.lanes.const(0.0)
            self.names[i] = self.lanes.select(self.mask(node.args[0]), self.value(node.args[1]), other)
        else:
            self.names[i] = _EMIT[node.op](self.lanes, *[self.value(a) for a in node.args])

    def comparison(self, node: Node) -> str:
        """Mask of a comparison or of a logical operation."""
        if node.op == "not":
            return self.lanes.invert(self.mask(node.args[0]))
        if node.op in ("and", "or"):
            return self.lanes.mask_op(node.op, self.mask(node.args[0]), self.mask(node.args[1]))
        return self.lanes.compare(_ORDER[node.op], self.value(node.args[0]), self.value(node.args[1]))

    def expensive(self, group: tuple[int, ...]) -> None:
        """Emit independent nodes of one kind."""
        nodes = [self.tape.nodes[i] for i in group]
        if self.lanes.width == 1 and not self.text.scalar:
            self.names.update(zip(group, self.pack_lanes(nodes), strict=True))  # 3.
        else:
            args = [tuple(self.value(a) for a in node.args) for node in nodes]
            self.names.update(zip(group, _evaluate(self.lanes, nodes, args), strict=True))

    def pack_lanes(self, nodes: list[Node]) -> list[str]:
        """Results of the nodes, their arguments in the lanes of one vector."""
        # Equal arguments (sine and cosine of one angle) take one lane; the narrowest vector that holds all is used.
        rows = list(dict.fromkeys(node.args for node in nodes))
        lanes = Lanes(self.text, next(w for w in (1, 2, 4, GROUP) if w >= len(rows)))
        columns = tuple(self.pack([self.value(row[k]) for row in rows], lanes) for k in range(len(rows[0])))
        ops = sorted({node.op for node in nodes})
        results = dict(zip(ops, _evaluate(lanes, [Node(op) for op in ops], [columns] * len(ops)), strict=True))
        return [self.unpack(results[node.op], rows.index(node.args), lanes) for node in nodes]

    def pack(self, values: list[str], lanes: Lanes) -> str:
        """A vector of the values, the last one repeated."""
        if lanes.width == 1:
            return values[0]
        vector = "poison"
        for k in range(lanes.width):
            value = values[min(k, len(values) - 1)]
            vector = self.text.let(f"insertelement {lanes.real} {vector}, double {value}, i64 {k}")
        return vector

    def unpack(self, vector: str, k: int, lanes: Lanes) -> str:
        """Lane k of a vector."""
        return vector if lanes.width == 1 else self.text.let(f"extractelement {lanes.real} {vector}, i64 {k}")


def _evaluate(lanes: Lanes, nodes: list[Node], args: list[tuple[str, ...]]) -> list[str]:
    """Results of expensive nodes of one kind with the given arguments."""
    if nodes[0].op not in TRIGONOMETRIC:
        return [FUNCTIONS[nodes[0].op](lanes, *arg) for arg in args]
    # Sine and cosine of one angle share its reduction and most of the polynomials.
    needed: dict[str, set[str]] = {}
    for node, (angle,) in zip(nodes, args, strict=True):
        needed.setdefault(angle, set()).add(node.op)
    angles = list(needed)
    found = dict(zip(angles, sincos(lanes, angles, [needed[a] for a in angles]), strict=True))
    return [found[angle][node.op == "cos"] for node, (angle,) in zip(nodes, args, strict=True)]


def _firsts(sizes: tuple[int, ...]) -> list[int]:
    """Index of every port's first element when all lie one after another."""
    return [0, *accumulate(sizes)]
