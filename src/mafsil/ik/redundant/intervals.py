"""Where the configurations of a pose exist within the limits, branch by branch: intervals of the locked joint.

A closed form along its locked joint as programs for interval arithmetic, one for every branch.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, PoseMatrix
from mafsil.ik.chain import Chain
from mafsil.ik.tolerances import CELL
from mafsil.kernels.tape import Node, Tape, arguments
from mafsil.lazy_module import lazily
from mafsil.mechanics.arm_pattern import ArmPattern
from mafsil.model.mechanism import JointLimits

if TYPE_CHECKING:
    import mafsil.ik.redundant.cell_loops as cell_loops
    import mafsil.ik.redundant.interval_loops as interval_loops
    import mafsil.mechanics.closed_form.table as locked_joint
else:
    cell_loops = lazily("mafsil.ik.redundant.cell_loops")
    interval_loops = lazily("mafsil.ik.redundant.interval_loops")
    locked_joint = lazily("mafsil.mechanics.closed_form.table")


Codes = NDArray[np.int32]
CELLS = 32
"""Into which the range is divided at first."""
FAR = 1e5
"""Stands for a limit of a prismatic joint that is none [m]."""
MOST, WORK = 32768, 100_000
"""Cells that may be found in a branch, and that may be looked at."""


@dataclass(frozen=True, eq=False)
class BranchIntervals:
    """Intervals of one pose.

    Attributes:
        low, high: (k,) their ends [rad | m].
        branch: (k,) whose they are.
        doubtful: (m, 3) branch and ends of cells in which nothing could be decided with the work allowed.
    """

    low: Floats
    high: Floats
    branch: NDArray[np.int64]
    doubtful: Floats


def range_of(
    chain: Chain, locked: int, low: float, high: float, limits: JointLimits, T: PoseMatrix
) -> tuple[float, float]:
    """Values of a locked joint that have to be looked at: its range; where that has no end a turn, or what may reach.

    Args:
        chain: of the arm.
        locked: coordinate of the joint.
        low, high: its range.
        limits: of the robot.
        T: (4, 4) desired pose of the tip in {s}.
    """
    place, far = chain.joints.index(locked), float(np.pi)
    if chain.prismatic[place]:
        far = chain.length_without(place, limits) + float(np.linalg.norm(T[:3, 3]))
    return float(low if np.isfinite(low) else -far), float(high if np.isfinite(high) else far)


def certify_intervals(
    programs: Programs,
    T: PoseMatrix,
    locked: int,
    domain: tuple[float, float],
    lower: Floats,
    upper: Floats,
    prismatic: NDArray[np.bool_],
) -> BranchIntervals:
    """Intervals in which branches surely exist within the limits; outside of them, but for `CELL`, they surely do not.

    Args:
        programs: of the closed form.
        T: (4, 4) desired pose of the tip in {s}.
        locked: coordinate of the locked joint.
        domain: of its values.
        lower, upper: (n,) limits.
        prismatic: (n,) which coordinates are lengths.
    """
    fixed = programs.fixed
    values = fixed.given.copy()
    some = fixed.inputs >= 0
    values[fixed.inputs[some]] = T.reshape(16)[some]
    cell_loops.fixed_values(fixed.code, fixed.first, fixed.second, values)
    ends = np.linspace(*domain, CELLS + 1)
    start = np.stack([ends[:-1], ends[1:]], axis=1)
    # An angle with one limit missing can always be wound within; a prismatic joint's missing one is far away.
    missing = np.where(prismatic, FAR, 1e200)
    bounded = prismatic | (np.isfinite(lower) & np.isfinite(upper))
    low = np.where(bounded & np.isfinite(lower), lower, -missing)
    high = np.where(bounded & np.isfinite(upper), upper, missing)
    middle, half = (low + high) / 2, (high - low) / 2
    half[locked] = 1e200
    parts: list[tuple[Floats, int]] = []
    doubtful: list[Floats] = []
    out = np.empty((MOST, 2))
    within = cell_loops.Limits(prismatic, middle, half)
    for k, one in enumerate(programs.branches):
        registers = np.zeros((one.registers, 5, interval_loops.LANES))
        program = interval_loops.Program(one.code, one.first, one.second, one.target, one.ports, values)
        count, _ = cell_loops.inside_cells(program, within, start, CELL, WORK, registers, out)
        cells = out[:count]
        unsure = cells[:, 0] > cells[:, 1]
        if unsure.any():
            doubtful.append(np.column_stack([np.full(unsure.sum(), float(k)), cells[unsure][:, ::-1]]))
        parts.append((_join(cells[~unsure]), k))
    branch = np.concatenate([np.full(len(cells), k) for cells, k in parts])
    both = np.concatenate([cells for cells, _ in parts])
    rest = np.concatenate(doubtful) if doubtful else np.zeros((0, 3))
    return BranchIntervals(both[:, 0], both[:, 1], branch, rest)


def _join(cells: Floats) -> Floats:
    """(k, 2) cells in order, those that share an end as one."""
    if not len(cells):
        return np.zeros((0, 2))
    cells = cells[np.argsort(cells[:, 0])]
    begins = np.append(True, cells[1:, 0] > cells[:-1, 1])
    ends = np.append(begins[1:], True)
    return np.stack([cells[begins, 0], cells[ends, 1]], axis=1)


@dataclass(frozen=True, eq=False)
class FixedProgram:
    """What depends on the pose alone.

    Attributes:
        code, first, second: (k,) operations and places of their arguments; -1 where a value is given.
        given: (k,) constants, zero elsewhere.
        inputs: (16,) places of the pose's elements; -1 of those that are not used.
    """

    code: Codes
    first: Codes
    second: Codes
    given: Floats
    inputs: Codes


@dataclass(frozen=True, eq=False)
class BranchProgram:
    """What depends on the parameter, of one branch.

    Attributes:
        code, first, second, target: (k,) operations, places of arguments, negative for -1 - place among the fixed
            values, and of the result.
        ports: (2 n + 1) places of the outputs.
        registers: number of places.
    """

    code: Codes
    first: Codes
    second: Codes
    target: Codes
    ports: Codes
    registers: int


@dataclass(frozen=True, eq=False)
class Programs:
    """Of a closed form whose locked joint is the parameter."""

    fixed: FixedProgram
    branches: tuple[BranchProgram, ...]


@lru_cache(maxsize=64)
def programs(pattern: ArmPattern, locked: int, near: tuple[float, ...]) -> Programs | None:
    """The programs of a closed form; None where one uses an operation that intervals are not made for.

    Args:
        pattern: of the arm, one joint locked.
        locked: its coordinate.
        near: (n,) what free joints take.
    """
    names = ("add", "sub", "mul", "div", "neg", "sqrt", "sin", "cos", "fabs", "fmin", "fmax", "lt", "le", "not")
    numbers = {name: getattr(interval_loops, name.upper()) for name in names}
    numbers |= {"if_else_zero": interval_loops.IF, "sign": interval_loops.SIGN, "atan2": interval_loops.ATAN2}
    # Of zeros and ones the smaller and the larger.
    numbers |= {"and": interval_loops.FMIN, "or": interval_loops.FMAX}
    tape = locked_joint.locked_joint_tape(pattern, locked, near)
    if any(node.op not in numbers and node.op not in ("input", "const") for node in tape.nodes):
        return None
    moving = _moving(tape)
    place = {i: k for k, i in enumerate(i for i in range(len(tape.nodes)) if not moving[i])}
    codes = [_code(numbers, node, interval_loops.SQ) for node in tape.nodes]
    branches = tuple(_branch(tape, port, moving, place, codes) for port in tape.outputs)
    return Programs(_fix(tape, place, codes), branches)


def _code(numbers: dict[str, int], node: Node, square: int) -> int:
    if node.op in ("input", "const"):
        return -1
    return square if node.op == "mul" and node.args[0] == node.args[1] else numbers[node.op]


def _moving(tape: Tape) -> list[bool]:
    """Which nodes depend on the parameter."""
    moving: list[bool] = []
    for node in tape.nodes:
        moving.append(node.args[0] == 1 if node.op == "input" else any(moving[a] for a in arguments(node)))
    return moving


def _fix(tape: Tape, place: dict[int, int], codes: list[int]) -> FixedProgram:
    order = list(place)
    args = [arguments(tape.nodes[i]) for i in order]
    inputs = np.full(16, -1, dtype=np.int32)
    for i in order:
        if tape.nodes[i].op == "input":
            inputs[tape.nodes[i].args[1]] = place[i]
    return FixedProgram(
        np.array([codes[i] for i in order], dtype=np.int32),
        np.array([place[a[0]] if a else 0 for a in args], dtype=np.int32),
        np.array([place[a[-1]] if a else 0 for a in args], dtype=np.int32),
        np.array([tape.nodes[i].value if tape.nodes[i].op == "const" else 0.0 for i in order]),
        inputs,
    )


def _branch(
    tape: Tape, port: tuple[int, ...], moving: list[bool], place: dict[int, int], codes: list[int]
) -> BranchProgram:
    """One branch's operations with places that are used again once their value is not needed any more."""
    needed: set[int] = set()
    stack = [i for i in port if moving[i]]
    while stack:
        i = stack.pop()
        if i not in needed:
            needed.add(i)
            stack.extend(a for a in arguments(tape.nodes[i]) if moving[a])
    order = sorted(i for i in needed if tape.nodes[i].op != "input")
    last = {a: i for i in order for a in arguments(tape.nodes[i]) if moving[a]} | dict.fromkeys(port, len(tape.nodes))
    register = {i: 0 for i in needed if tape.nodes[i].op == "input"}
    free: list[int] = []
    used = 1
    rows: list[tuple[int, int, int, int]] = []
    for i in order:
        args = arguments(tape.nodes[i])
        if free:
            register[i] = free.pop()
        else:
            register[i], used = used, used + 1
        where = [register[a] if moving[a] else -1 - place[a] for a in args]
        rows.append((codes[i], where[0], where[-1], register[i]))
        free.extend(register[a] for a in set(args) if moving[a] and last[a] == i and register[a])
    table = np.array(rows, dtype=np.int32).reshape(-1, 4).T.copy()
    ports = np.array([register[i] if moving[i] else -1 - place[i] for i in port], dtype=np.int32)
    return BranchProgram(table[0], table[1], table[2], table[3], ports, used)
