"""Robots with one wrong operation: in one routine, called in one way, one sign or one function exchanged."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from mafsil.kernels.reference import _VALUES, evaluate
from mafsil.kernels.tape import Node, Tape, read
from mafsil.mechanics.arm_size import ArmSize
from mafsil.mechanics.catalogue import CATALOGUE, quantity
from mafsil.mechanics.quantity import States, random_states
from mafsil.model import Mechanism
from mafsil.robot import Robot
from mafsil.robot.trace import signature, trace
from mafsil.verification.verify import ways

EXCHANGED = {"add": "sub", "sub": "add", "sin": "cos", "cos": "sin"}
"""Operations and what a slip of the pen makes of them."""
STATES = 8
"""What `verify` draws unless told otherwise."""


@dataclass(frozen=True)
class Way:
    """A routine called in one way."""

    routine: str
    optional: tuple[str, ...] = ()
    frame: str | None = None

    def tape(self, mechanism: Mechanism) -> Tape:
        return read(trace(mechanism, quantity(self.routine), self.frame, self.optional))


class Mutant(Robot):
    """A robot whose routine, called in one way, runs a tape of its own; everything else is compiled as always."""

    def __init__(self, mechanism: Mechanism, way: Way, tape: Tape) -> None:
        super().__init__(mechanism)
        self.way, self.tape = way, tape

    def routine(self, name: str) -> Any:
        true = super().routine(name)
        if name != self.way.routine:
            return true

        def call(*arrays: Any, frame: str | None = None, **named: Any) -> Any:
            row = quantity(name)
            given = dict(zip((*row.inputs, *row.optional), arrays, strict=False)) | named
            optional = tuple(key for key in row.optional if key in given)
            if Way(name, optional, frame) != self.way:
                return true(*arrays, **named, **({} if frame is None else {"frame": frame}))
            return evaluated(self.mechanism, self.way, self.tape, [given[key] for key in (*row.inputs, *optional)])

        return call


def evaluated(mechanism: Mechanism, way: Way, tape: Tape, inputs: list[Any]) -> Any:
    columns = [np.asarray(x, dtype=float).reshape(-1, np.shape(x)[-1]) for x in inputs]
    rows = max(len(column) for column in columns)
    columns = [np.broadcast_to(column, (rows, column.shape[1])) for column in columns]
    (values, _) = evaluate(tape, columns)[0]
    shape = signature(mechanism, quantity(way.routine), way.optional).outputs[0].shape
    return values.reshape(*np.shape(inputs[0])[:-1], *shape)


def mutated(tape: Tape, number: int) -> Tape:
    """The tape with operation `number` exchanged; a product gets the wrong sign."""
    node = tape.nodes[number]
    if node.op in EXCHANGED:
        changed = [*tape.nodes[:number], node._replace(op=EXCHANGED[node.op]), *tape.nodes[number + 1 :]]
        return Tape(tuple(changed), tape.input_sizes, tape.outputs)
    moved = [_shifted(later, number) for later in tape.nodes[number + 1 :]]
    changed = [*tape.nodes[: number + 1], Node("neg", (number,)), *moved]
    outputs = tuple(tuple(i + 1 if i >= number else i for i in port) for port in tape.outputs)
    return Tape(tuple(changed), tape.input_sizes, outputs)


def _shifted(node: Node, number: int) -> Node:
    """A later node: what came from `number` or after it now stands one place further."""
    if node.op in ("input", "const"):
        return node
    return node._replace(args=tuple(a + 1 if a >= number else a for a in node.args))


def places(tape: Tape) -> list[int]:
    """Operations that can be got wrong."""
    return [k for k, node in enumerate(tape.nodes) if node.op in (*EXCHANGED, "mul", "neg", "div")]


def outputs_of(tape: Tape, columns: list[Any], numbers: list[int]) -> Any:
    """(mutants * b, outputs): the same inputs for every mutant, each with its own operation exchanged."""
    rows, count = len(columns[0]), max(1, len(numbers))
    inputs = [np.tile(column, (count, 1)) for column in columns]
    values: list[Any] = []
    with np.errstate(all="ignore"):
        for k, node in enumerate(tape.nodes):
            if node.op == "input":
                value = inputs[node.args[0]][:, node.args[1]]
            elif node.op == "const":
                value = np.full(rows * count, node.value)
            else:
                xs = [values[a] for a in node.args]
                value = np.array(_VALUES[node.op](*xs), dtype=float)
            if k in numbers:
                mine = slice(numbers.index(k) * rows, (numbers.index(k) + 1) * rows)
                other = EXCHANGED.get(node.op)
                value[mine] = -value[mine] if other is None else _VALUES[other](*(x[mine] for x in xs))
            values.append(value)
    return np.stack([values[i] for i in tape.outputs[0]], axis=1)


def calls(robot: Robot) -> Iterator[tuple[Way, States]]:
    """Every routine in every way in which `verify` calls it."""
    drawn = random_states(robot.mechanism, ArmSize.of(robot.mechanism), STATES, 0)
    for row in CATALOGUE.values():
        for s in ways(row, drawn, robot):
            yield Way(row.name, tuple(name for name in row.optional if getattr(s, name) is not None), s.frame), s
