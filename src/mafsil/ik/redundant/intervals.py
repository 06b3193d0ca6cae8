"""Where the configurations of a pose exist within the limits, branch by branch: intervals of the locked joint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, PoseMatrix
from mafsil.ik.chain import Chain
from mafsil.ik.redundant.program import Programs
from mafsil.ik.tolerances import CELL
from mafsil.lazy_module import lazily
from mafsil.model.mechanism import JointLimits

if TYPE_CHECKING:
    import mafsil.ik.redundant.cell_loops as cell_loops
    import mafsil.ik.redundant.interval_loops as interval_loops
else:
    cell_loops = lazily("mafsil.ik.redundant.cell_loops")
    interval_loops = lazily("mafsil.ik.redundant.interval_loops")

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
