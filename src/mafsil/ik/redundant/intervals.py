"""Where the postures of a pose exist within the limits, branch by branch, as intervals of the held joint's value."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, PoseMatrix
from mafsil.ik.chain import Chain
from mafsil.ik.redundant.program import Programs
from mafsil.model.mechanism import JointLimits

WIDTH = 1e-9
"""Cells narrower than that are left undecided: ends are known, and gaps and intervals seen, to it [rad | m]."""

CELLS = 32
"""Into which the range is divided at first."""

FAR = 1e5
"""Stands for a slide's limit that is none [m]."""

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
    chain: Chain, held: int, low: float, high: float, limits: JointLimits, T: PoseMatrix
) -> tuple[float, float]:
    """Values of a held joint that have to be looked at: its range; where that has no end a turn, or what may reach.

    Args:
        chain: of the arm.
        held: coordinate of the joint.
        low, high: its range.
        limits: of the robot.
        T: (4, 4) wanted pose of the tip in {s}.
    """
    place, far = chain.joints.index(held), float(np.pi)
    if chain.prismatic[place]:
        far = chain.length_without(place, limits) + float(np.linalg.norm(T[:3, 3]))
    return float(low if np.isfinite(low) else -far), float(high if np.isfinite(high) else far)


def certified(
    programs: Programs,
    T: PoseMatrix,
    held: int,
    domain: tuple[float, float],
    lower: Floats,
    upper: Floats,
    slides: NDArray[np.bool_],
) -> BranchIntervals:
    """Intervals in which branches surely exist within the limits; outside of them, but for `WIDTH`, they surely do not.

    Args:
        programs: of the closed form.
        T: (4, 4) wanted pose of the tip in {s}.
        held: coordinate of the held joint.
        domain: of its values.
        lower, upper: (n,) limits.
        slides: (n,) which coordinates are lengths.
    """
    from mafsil.ik.redundant.cell_loops import fixed_values, inside_cells
    from mafsil.ik.redundant.interval_loops import LANES

    fixed = programs.fixed
    values = fixed.given.copy()
    some = fixed.inputs >= 0
    values[fixed.inputs[some]] = T.reshape(16)[some]
    fixed_values(fixed.code, fixed.first, fixed.second, values)
    ends = np.linspace(*domain, CELLS + 1)
    start = np.stack([ends[:-1], ends[1:]], axis=1)
    # An angle with one limit missing can always be wound within; a slide's missing one is far away.
    missing = np.where(slides, FAR, 1e200)
    bounded = slides | (np.isfinite(lower) & np.isfinite(upper))
    low = np.where(bounded & np.isfinite(lower), lower, -missing)
    high = np.where(bounded & np.isfinite(upper), upper, missing)
    middle, half = (low + high) / 2, (high - low) / 2
    half[held] = 1e200
    parts: list[tuple[Floats, int]] = []
    doubtful: list[Floats] = []
    out, details = np.empty((MOST, 2)), np.zeros(2, dtype=np.int64)
    for k, one in enumerate(programs.branches):
        room = np.zeros((one.registers, 5, LANES))
        program = one.code, one.first, one.second, one.target, values, one.ports
        inside_cells(*program, slides, middle, half, start, WIDTH, WORK, room, out, details)
        cells = out[: details[0]]
        unsure = cells[:, 0] > cells[:, 1]
        if unsure.any():
            doubtful.append(np.column_stack([np.full(unsure.sum(), float(k)), cells[unsure][:, ::-1]]))
        parts.append((_joined(cells[~unsure]), k))
    branch = np.concatenate([np.full(len(cells), k) for cells, k in parts])
    both = np.concatenate([cells for cells, _ in parts])
    rest = np.concatenate(doubtful) if doubtful else np.zeros((0, 3))
    return BranchIntervals(both[:, 0], both[:, 1], branch, rest)


def _joined(cells: Floats) -> Floats:
    """(k, 2) cells in order, those that share an end as one."""
    if not len(cells):
        return np.zeros((0, 2))
    cells = cells[np.argsort(cells[:, 0])]
    begins = np.append(True, cells[1:, 0] > cells[:-1, 1])
    ends = np.append(begins[1:], True)
    return np.stack([cells[begins, 0], cells[ends, 1]], axis=1)
