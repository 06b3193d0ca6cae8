"""A ladder over a path: all solutions of inverse kinematics at every sample, and which of them continue each other."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector
from mafsil.ik import SolutionBatch, inverse_kinematics
from mafsil.model import JointKind
from mafsil.robot import Robot
from mafsil.trajectory.paths import TipPath
from mafsil.trajectory.paths.path_task import PathTask, path_equations

TURN = 2 * np.pi

AGREEMENT = 0.5
"""Two solutions continue each other if the mean of their rates explains their difference up to this share of it."""

ROUNDING = 1e-6
"""Difference [rad | m] that needs no rate: solutions are known to nine digits, and rates to six of a description."""

INSIDE = 1e-9
"""By how much a coordinate at its limit may seem beyond it."""

JUMP = 1e4
"""What a jump costs in the sum of coordinate changes: one more is never worth a shorter way."""

RATIO = 1e-12
"""Singular values of a Jacobian below this share of the largest give no rate."""


@dataclass(frozen=True, eq=False)
class Ladder:
    """All solutions at samples of a path.

    Attributes:
        robot, path, task: what was asked.
        s: (k,) samples.
        q: (k, m, n) solutions, NaN where a row has none; in a row they need not continue each other.
        within: (k, m) which of them are within the joint limits, up to whole turns.
        before, after: (k, m, n) rates dq/ds of least norm, of the path before and after the sample.
        solutions: what inverse kinematics says of the samples.
    """

    robot: Robot
    path: TipPath
    task: PathTask
    s: Floats
    q: JointVector
    within: NDArray[np.bool_]
    before: Floats
    after: Floats
    solutions: SolutionBatch

    @property
    def revolute(self) -> NDArray[np.bool_]:
        """(n,) which coordinates are angles."""
        return revolute_coordinates(self.robot)

    def change(self, i: int) -> Floats:
        """(m, m, n) shortest change of the coordinates from every solution of sample i to every one of sample i + 1."""
        return shortest(self.q[i + 1][None] - self.q[i][:, None], self.revolute)

    def continuous(self, i: int) -> NDArray[np.bool_]:
        """(m, m) which solutions of sample i + 1 continue those of sample i: their rates explain the change."""
        change, h = self.change(i), float(self.s[i + 1] - self.s[i])
        first, last = h * self.after[i][:, None], h * self.before[i + 1][None]
        off = np.abs(change - (first + last) / 2).max(axis=-1)
        size = np.maximum(np.abs(first).max(axis=-1), np.abs(last).max(axis=-1))
        with np.errstate(invalid="ignore"):
            close = off <= AGREEMENT * size + ROUNDING
        return close & (off <= off.min(axis=1, initial=np.inf, where=np.isfinite(off))[:, None])


def revolute_coordinates(robot: Robot) -> NDArray[np.bool_]:
    """(n,) which coordinates are angles, equal up to whole turns.

    Args:
        robot: any arm.
    """
    return np.array([joint.kind is JointKind.REVOLUTE for joint in robot.mechanism.coordinates])


def shortest(change: Floats, angles: NDArray[np.bool_]) -> Floats:
    """Changes of coordinates with whole turns of angles left out.

    Args:
        change: (*batch, n) [rad | m].
        angles: (n,) which coordinates are angles.
    """
    return change - np.where(angles, TURN * np.round(change / TURN), 0.0)


def solution_ladder(robot: Robot, path: TipPath, task: PathTask, s: Floats, q0: JointVector | None = None) -> Ladder:
    """All solutions at samples, with their rates along the path.

    Args:
        robot: whose tip is to move.
        path: of the tip.
        task: what of the path counts.
        s: (k,) increasing samples.
        q0: (n,) where locked joints of redundant arms stay.
    """
    found = inverse_kinematics(robot, path.poses(s), task=task, q0=q0)
    assert isinstance(found, SolutionBatch)
    q = np.where(found.valid[..., None], found.q, np.nan)
    before, after = (_rates(robot, path, task, q, np.clip(np.nextafter(s, end), 0.0, 1.0)) for end in (-1.0, 2.0))
    return Ladder(robot, path, task, s, q, found.valid & found.within, before, after, found)


def _rates(robot: Robot, path: TipPath, task: PathTask, q: JointVector, s: Floats) -> Floats:
    """(k, m, n) rates dq/ds of least norm; NaN where there is no solution."""
    rates = np.full_like(q, np.nan)
    sample, row = np.nonzero(np.isfinite(q).all(axis=-1))
    if len(sample):
        A, b = path_equations(
            robot.forward_kinematics(q[sample, row]), robot.jacobian_body(q[sample, row]), path, s[sample], task
        )
        rates[sample, row] = (np.linalg.pinv(A, rcond=RATIO) @ b[..., None])[..., 0]
    return rates


@dataclass(frozen=True, eq=False)
class Chain:
    """One solution for every sample of a stretch of a ladder, with as few jumps as possible.

    Attributes:
        begin: its first sample.
        rows: (c,) of the ladder.
        q: (c, n) coordinates, whole turns chosen so that they go on without a jump where the solutions do [rad | m].
        jumps: samples of the ladder after which it jumps, to another branch or by whole turns.
    """

    begin: int
    rows: NDArray[np.intp]
    q: JointVector
    jumps: tuple[int, ...]


def best_chain(ladder: Ladder, begin: int, end: int, start: JointVector | None = None) -> Chain:
    """The chain of fewest jumps, then of least change of the coordinates, by dynamic programming over the samples.

    1. Forward: the least cost of reaching every solution within the limits, and from which solution before.
    2. Backward from the cheapest last solution.
    3. Whole turns: each angle goes on from sample to sample, from where it stays longest within its limits.

    Args:
        ladder: solutions; every sample from begin to end has one within the limits.
        begin, end: first sample, and the one after the last.
        start: (n,) where the chain begins, up to rounding; any solution of the first sample if None.
    """
    # 1
    cost = np.where(ladder.within[begin], 0.0, np.inf)
    if start is not None:
        away = np.abs(shortest(ladder.q[begin] - start, ladder.revolute)).max(axis=-1)
        cost = np.where(ladder.within[begin] & (away <= np.nanmin(away) + ROUNDING), 0.0, np.inf)
    came: list[NDArray[np.intp]] = []
    smooth: list[NDArray[np.bool_]] = []
    for i in range(begin, end - 1):
        smooth.append(ladder.continuous(i))
        change = np.abs(ladder.change(i)).sum(axis=-1)
        step = cost[:, None] + change + JUMP * ~smooth[-1]
        step = np.where(np.isfinite(step) & ladder.within[i + 1], step, np.inf)
        came.append(step.argmin(axis=0))
        cost = step.min(axis=0)
    # 2
    rows = [int(cost.argmin())]
    for back in reversed(came):
        rows.append(int(back[rows[-1]]))
    rows.reverse()
    jumps = [i + 1 for i, edges in enumerate(smooth) if not edges[rows[i], rows[i + 1]]]
    # 3
    q, cuts = _unwind(ladder, ladder.q[np.arange(begin, end), rows], jumps, start)
    return Chain(begin, np.array(rows), q, tuple(begin + i - 1 for i in cuts))


def _unwind(
    ladder: Ladder, q: JointVector, jumps: list[int], start: JointVector | None
) -> tuple[JointVector, list[int]]:
    """Coordinates with their whole turns, piece by piece, and where pieces begin; where limits end one, it is cut."""
    out: list[JointVector] = []
    ends, cuts, at = [*jumps, len(q)], list[int](), 0
    while at < len(q):
        end = next(place for place in ends if place > at)
        steps = shortest(np.diff(q[at:end], axis=0), ladder.revolute)
        whole = q[at] + np.concatenate([np.zeros((1, q.shape[1])), np.cumsum(steps, axis=0)])
        moved, lasts = _wind(ladder, whole, start if not out else out[-1][-1], fixed=not out and start is not None)
        out.append(moved[:lasts])
        at += lasts
        cuts.append(at)
    return np.concatenate(out), cuts[:-1]


def _wind(ladder: Ladder, q: JointVector, near: JointVector | None, *, fixed: bool) -> tuple[JointVector, int]:
    """A piece with every angle moved by the whole turns that keep it longest within its limits, and how long that is.

    Args:
        ladder: gives the limits.
        q: (c, n) a piece without jumps, within the limits up to whole turns at each sample.
        near: (n,) to which turns that last equally long should lead.
        fixed: whether it has to begin at `near`.
    """
    limits, moved, lasts = ladder.robot.limits, q.copy(), len(q)
    for j in np.flatnonzero(ladder.revolute):
        aim = q[0, j] if near is None else near[j]
        nearest = round((aim - q[0, j]) / TURN)
        low, high = (
            (end - q[0, j]) / TURN if np.isfinite(end) else nearest for end in (limits.lower[j], limits.upper[j])
        )
        turns = [nearest] if fixed else range(math.ceil(low - INSIDE), math.floor(high + INSIDE) + 1)
        best = (0, 0.0, 0)
        for k in turns:
            x = q[:, j] + TURN * k
            beyond = (x < limits.lower[j] - INSIDE) | (x > limits.upper[j] + INSIDE)
            lasting = int(beyond.argmax()) if beyond.any() else len(x)
            best = max(best, (lasting, -abs(k - nearest), k))
        moved[:, j] += TURN * best[2]
        lasts = min(lasts, max(best[0], 1))
    return moved, lasts
