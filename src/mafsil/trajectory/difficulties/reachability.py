"""Open intervals of a path that cannot be reached, and the intervals on which each branch is within the limits."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, positive, whole
from mafsil.errors import InputError
from mafsil.ik import SolutionBatch, inverse_kinematics
from mafsil.ik.result import STATUSES, IKStatus
from mafsil.ik.tolerances import INSIDE
from mafsil.robot import Robot, of_robot
from mafsil.trajectory.paths import TipPath
from mafsil.trajectory.paths.path_task import PathTask

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
