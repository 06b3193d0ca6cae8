"""A ladder over a path: all solutions at every sample, which continue each other, and the intervals out of reach."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, positive, whole
from mafsil.errors import InputError
from mafsil.ik import SolutionBatch, inverse_kinematics
from mafsil.ik.result import STATUSES, IKStatus
from mafsil.model import JointKind
from mafsil.robot import Robot, of_robot
from mafsil.trajectory.paths import TipPath
from mafsil.trajectory.paths.pose_path import PathTask, path_equations

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


EXACT = 1e-12
"""Largest residual of a solution: an interval ends where the pose can be met, not where it nearly can."""
SEARCHED = 1e-9
"""The same for arms without a closed form, whose solutions are refined by Newton's method."""
SPACING = 2.0**-53
"""Of floating-point numbers just below 1."""
PROVEN = (IKStatus.OUT_OF_REACH, IKStatus.NOT_OF_THIS_ARM)
Interval = tuple[float, float]


class PathReachStatus(Status):
    """Whether all of the sampled places of a path can be reached within the joint limits."""

    REACHED = ("trajectory.path_reached", True)
    UNREACHABLE = ("trajectory.path_unreachable", False)
    NOT_FOUND = ("trajectory.path_not_found", False)
    BEYOND_LIMITS = ("trajectory.path_beyond_limits", False)


@dataclass(frozen=True, eq=False, repr=False)
class PathReach(Answer, data="unreachable beyond_limits samples"):
    """Where a path can be followed, without and with joint limits.

    Attributes:
        status: UNREACHABLE if it is proven at every place looked at in the gaps, NOT_FOUND if a search found nothing.
        unreachable: open intervals of s without a solution, joint limits ignored.
        beyond_limits: open intervals of s whose solutions all lie beyond the joint limits.
        branches: for every row of inverse kinematics the closed intervals of s where it is within the limits; empty
            for arms without a closed form, whose solutions have no lasting rows.
        samples: places at which the path was looked at first; a gap between two of them is not seen.
    """

    status: PathReachStatus
    unreachable: tuple[Interval, ...]
    beyond_limits: tuple[Interval, ...]
    branches: tuple[tuple[Interval, ...], ...]
    samples: int

    @property
    def covering(self) -> tuple[int, ...]:
        """Rows that are within the limits on the whole path."""
        return tuple(k for k, parts in enumerate(self.branches) if parts == ((0.0, 1.0),))

    def explain(self, language: str | None = None) -> str:
        """Whether the path can be reached, and the intervals where not."""
        gaps = ", ".join(f"({a:.10g}, {b:.10g})" for a, b in self.unreachable or self.beyond_limits)
        return self.status.sentence(language, intervals=gaps, samples=self.samples)

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return Answer.to_dict(self) | {"branches": [[list(part) for part in parts] for parts in self.branches]}


@of_robot
def reachability(
    robot: Robot, path: TipPath, *, task: PathTask = "pose", samples: int = 401, resolution: float = SPACING
) -> PathReach:
    """Intervals of s in 0 .. 1 that cannot be reached, and those on which each branch is within the limits.

    Places side by side that differ are bisected.

    Args:
        robot: whose tip is to move.
        path: of the tip.
        task: what of the path counts, `pose` or `position`.
        samples: places at which it is looked at first; a gap between two of them is not seen.
        resolution: of s, to which ends of intervals are found.

    Raises:
        InputError: fewer than two samples, an unknown task, a resolution that is not positive.
    """
    if whole("samples", samples, 0, 1_000_000) < 2:
        raise InputError("trajectory.few_samples", samples=samples)
    s = np.linspace(0.0, 1.0, samples)
    halvings = math.ceil(math.log2(max(1.0 / ((samples - 1) * positive("resolution", resolution)), 1.0)))
    exact = _solutions(robot, path, s, task, EXACT)
    closed_form = exact.setting.arm.form is not None
    tolerance = EXACT if closed_form else SEARCHED
    if not closed_form:
        exact = _solutions(robot, path, s, task, SEARCHED)

    def solutions(places: Floats) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Which rows are solutions, and which of them within the limits: as written, for ends as exact as asked."""
        found = _solutions(robot, path, places, task, tolerance)
        low, high = robot.limits.lower - INSIDE, robot.limits.upper + INSIDE
        return found.valid, found.valid & ((found.q >= low) & (found.q <= high)).all(axis=-1)

    def unreached(places: Floats) -> NDArray[np.bool_]:
        return np.logical_not(solutions(places)[0].any(axis=-1))

    def beyond(places: Floats) -> NDArray[np.bool_]:
        valid, within = solutions(places)
        return np.logical_and(valid.any(axis=-1), ~within.any(axis=-1))

    def of_row(row: int, places: Floats) -> NDArray[np.bool_]:
        return solutions(places)[1][:, row]

    gaps = tuple(_intervals(s, unreached, halvings))
    outside = tuple(_intervals(s, beyond, halvings))
    count = exact.q.shape[-2] if closed_form else 0
    branches = tuple(tuple(_intervals(s, partial(of_row, k), halvings)) for k in range(count))
    status = PathReachStatus.BEYOND_LIMITS if outside else PathReachStatus.REACHED
    if gaps:
        proven = all(STATUSES[code] in PROVEN for code in exact.status_codes[unreached(s)])
        status = PathReachStatus.UNREACHABLE if proven else PathReachStatus.NOT_FOUND
    return PathReach(status, gaps, outside, branches, samples)


def _solutions(robot: Robot, path: TipPath, s: Floats, task: PathTask, tolerance: float) -> SolutionBatch:
    found = inverse_kinematics(robot, path.poses(s), task=task, tolerance=tolerance)
    assert isinstance(found, SolutionBatch)
    return found


def _intervals(s: Floats, at: Callable[[Floats], NDArray[np.bool_]], halvings: int) -> Iterator[Interval]:
    """Intervals where a property holds, their ends bisected all at once."""
    inside = at(s)
    change = np.flatnonzero(inside[1:] != inside[:-1])
    low, high, before = s[change], s[change + 1], inside[change]
    for _ in range(halvings if len(change) else 0):
        middle = (low + high) / 2
        same = at(middle) == before
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    ends = [0.0] * bool(inside[0]) + ((low + high) / 2).tolist() + [1.0] * bool(inside[-1])
    yield from zip(ends[::2], ends[1::2], strict=True)
