"""Path points: where a motion starts, ends, and what it passes; given as poses or joints, planned in joints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch
from mafsil.errors import InputError

Solver = Callable[[Floats, Floats], Any]
"""(pose (4, 4), (n,) configuration to stay near) -> an answer that is false where it found none, with q (n,)."""


class PointKind(Enum):
    """What a path point is."""

    INITIAL = "initial"
    VIA = "via"
    FINAL = "final"


@dataclass(frozen=True, eq=False)
class PathPoint:
    """One point of a path: where, not when.

    Attributes:
        kind: initial, via or final.
        q: (n,) [rad | m].
        index: in the path.
    """

    kind: PointKind
    q: Floats
    index: int


@dataclass(frozen=True, eq=False)
class PathPoints:
    """A path as points in joints, without time: durations make a trajectory of it.

    Attributes:
        points: from the initial to the final one.
        unsolved: indices of poses for which no configuration was found; then the path is false.
    """

    points: tuple[PathPoint, ...]
    unsolved: tuple[int, ...] = ()

    def __bool__(self) -> bool:
        return not self.unsolved

    def __len__(self) -> int:
        return len(self.points)

    @property
    def q(self) -> Floats:
        """(m, n) configurations; NaN where none was found [rad | m]."""
        return np.stack([point.q for point in self.points])


def joint_path(points: ArrayLike) -> PathPoints:
    """Path points from configurations.

    Args:
        points: (m, n) with m >= 2, the first initial, the last final, those between via [rad | m].

    Raises:
        InputError: a wrong shape, a number that is not finite.
    """
    q = as_batch("points", points, np.shape(points)[-1:], finite=True)
    if q.ndim != 2 or len(q) < 2:
        raise InputError("input.shape", name="points", expected="(m, n), m >= 2", got=q.shape, hint="")
    return PathPoints(tuple(PathPoint(_kind(k, len(q)), row, k) for k, row in enumerate(q)))


def tip_path(poses: ArrayLike, q_start: ArrayLike, solve: Solver) -> PathPoints:
    """Path points from poses {T_a}, {T_b} .. {T_c} of the tip in {s}: inverse kinematics at each, near the one before.

    Args:
        poses: (m, 4, 4) with m >= 2.
        q_start: (n,) configuration near which the first is solved [rad | m].
        solve: inverse kinematics, such as `lambda T, q: mf.solve_ik(robot, T, q)`.

    Returns:
        The path; false, with the indices of the poses that were not solved, if there are some.

    Raises:
        InputError: a wrong shape, a number that is not finite.
    """
    T = as_batch("poses", poses, (4, 4), finite=True)
    if T.ndim != 3 or len(T) < 2:
        raise InputError("input.shape", name="poses", expected="(m, 4, 4), m >= 2", got=T.shape, hint="")
    near = np.asarray(as_batch("q_start", q_start, np.shape(q_start)[-1:], finite=True))
    found: list[PathPoint] = []
    unsolved: list[int] = []
    for k, each in enumerate(T):
        answer = solve(each, near)
        if answer:
            near = np.asarray(answer.q, dtype=np.float64)
        else:
            unsolved.append(k)
        found.append(PathPoint(_kind(k, len(T)), near if answer else np.full_like(near, np.nan), k))
    return PathPoints(tuple(found), tuple(unsolved))


def _kind(index: int, count: int) -> PointKind:
    """Initial, via or final."""
    return {0: PointKind.INITIAL, count - 1: PointKind.FINAL}.get(index, PointKind.VIA)
