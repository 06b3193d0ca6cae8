"""Ranks of an arm's Jacobian: the task that it is judged by, how many motions it has, and where it loses one."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.algebra.tolerance import DESCRIBED
from mafsil.arrays import Floats, not_negative
from mafsil.errors import InputError
from mafsil.performance.singularities.determinant import natural_task
from mafsil.performance.tolerances import COARSEST
from mafsil.performance.velocity.jacobians import tool_jacobian
from mafsil.performance.velocity.scaling import (
    TOLERANCE,
    Scaled,
    Task,
    at_point,
    central_point,
    random_configurations,
    rank_in_doubt,
    rank_of,
    scaled_jacobian,
    task_rows,
)
from mafsil.robot import Robot, of_robot
from mafsil.solvers import decompositions


@of_robot
def default_task(robot: Robot) -> str:
    """The default task of an arm: its natural task, if the arm reaches full rank in it.

    `pose` for six joints and more, `planar_position` for a planar 2R arm, and so on; planar arms with more joints than
    their plane needs are redundant in it. Arms without such a task are asked for the whole pose.

    Args:
        robot: the arm.
    """
    return _default_task(robot)


@lru_cache(maxsize=64)
def _default_task(robot: Robot) -> str:
    if robot.n >= 6:
        return "pose"
    try:
        natural = [natural_task(robot)]
    except InputError:
        natural = []
    flat = ["schoenflies", "planar"] if _moves_flat(robot) else []
    spherical = ["orientation"] if _is_spherical(robot) else []
    if spherical:
        # A tip at the centre moves by rounding alone, and rounding has any rank.
        natural = [task for task in natural if task != "position"]
    for task in (*natural, *flat, *spherical):
        if generic_rank(robot, task=task) == min(len(task_rows(task)), robot.n):
            return task
    return "pose"


def _moves_flat(robot: Robot) -> bool:
    """Whether the tip never turns about x or y of {s}."""
    J = tool_jacobian(robot, random_configurations(robot, 3, limited=False))
    return bool(np.abs(J[:, :2]).max(initial=0.0) < DESCRIBED)


def _is_spherical(robot: Robot) -> bool:
    """Whether all joints turn about one point."""
    J_s = robot.jacobian_space(random_configurations(robot, 3, limited=False))
    return bool(np.abs(at_point(J_s, central_point(J_s))[:, 3:]).max() < DESCRIBED * max(1.0, float(np.abs(J_s).max())))


@dataclass(frozen=True)
class ResolvedTask:
    """What a configuration is judged by.

    Attributes:
        task: name, or row numbers.
        rows: of the Jacobian that is looked at.
        full_rank: the rank that an arm with so many joints can have for so many rows.
    """

    task: Task
    rows: tuple[int, ...]
    full_rank: int


def resolved_task(robot: Robot, task: Task | None = None) -> ResolvedTask:
    """The task, the default one if None; of the whole Jacobian where the other rows of an arm are zero anyway.

    Args:
        robot: the arm.
        task: rows that count.
    """
    if task is not None:
        rows = task_rows(task)
        return ResolvedTask(task, rows, min(len(rows), robot.n))
    name = default_task(robot)
    return ResolvedTask(name, _looked_at(robot, name), min(len(task_rows(name)), robot.n))


@lru_cache(maxsize=64)
def _looked_at(robot: Robot, task: str) -> tuple[int, ...]:
    rows = task_rows(task)
    others = [row for row in range(6) if row not in rows]
    J = tool_jacobian(robot, random_configurations(robot, 3, limited=False))
    idle = np.abs(J[:, others]).max(initial=0.0) <= DESCRIBED * np.abs(J).max(initial=0.0)
    return tuple(range(6)) if idle else rows


@of_robot
def singular_values(robot: Robot, q: ArrayLike, *, task: Task | None = None, length: float | None = None) -> Floats:
    """Singular values of the Jacobian without units, largest first.

    For the full pose the linear part is taken at the point nearest to all axes, and the length likewise: the values
    depend on neither the base frame nor the tool. For other tasks it is taken at the tip.

    Args:
        robot: the arm.
        q: (*batch, n) joint coordinates [rad | m].
        task: rows that count; the arm's `default_task` if None.
        length: [m] that divides translations; the arm's characteristic length if None.

    Returns:
        (*batch, min(m, n)).
    """
    return decompositions.singular_values(scaled_for_rank(robot, q, resolved_task(robot, task).rows, length).J)


@of_robot
def rank(
    robot: Robot,
    q: ArrayLike,
    *,
    task: Task | None = None,
    length: float | None = None,
    tolerance: float = TOLERANCE,
) -> NDArray[np.int64]:
    """(*batch) rank of the Jacobian; arguments as `singular_values`, tolerance relative to the largest value.

    Rows of q that hold NaN have rank -1.
    """
    tolerance = not_negative("tolerance", tolerance, most=COARSEST)
    return rank_of(singular_values(robot, q, task=task, length=length), tolerance)


@of_robot
def generic_rank(robot: Robot, *, task: Task | None = None) -> int:
    """The rank that almost all configurations have.

    Args:
        robot: the arm.
        task: rows that count; the arm's `default_task` if None.
    """
    return generic_rank_of(robot, resolved_task(robot, task).rows)


@lru_cache(maxsize=64)
def generic_rank_of(robot: Robot, rows: tuple[int, ...]) -> int:
    """The largest rank among random configurations, of some rows of the Jacobian."""
    return int(rank(robot, random_configurations(robot, 32, limited=False), task=rows).max(initial=0))


@of_robot
def is_singular(
    robot: Robot,
    q: ArrayLike,
    *,
    task: Task | None = None,
    length: float | None = None,
    tolerance: float = TOLERANCE,
) -> NDArray[np.bool_]:
    """(*batch) whether the rank is below min(rows of the task, joints); False for NaN; arguments as `rank`.

    True everywhere for an arm that never reaches that rank; `generic_rank` tells such arms.
    """
    tolerance = not_negative("tolerance", tolerance, most=COARSEST)
    here = rank(robot, q, task=task, length=length, tolerance=tolerance)
    return (here >= 0) & (here < resolved_task(robot, task).full_rank)


@of_robot
def verdict_in_doubt(
    robot: Robot,
    q: ArrayLike,
    *,
    task: Task | None = None,
    length: float | None = None,
    tolerance: float = TOLERANCE,
) -> NDArray[np.bool_]:
    """(*batch) whether a description of six digits leaves `rank` and `is_singular` open; arguments as there."""
    tolerance = not_negative("tolerance", tolerance, most=COARSEST)
    return rank_in_doubt(singular_values(robot, q, task=task, length=length), tolerance)


def scaled_for_rank(robot: Robot, q: ArrayLike, rows: tuple[int, ...], length: float | None) -> Scaled:
    """The Jacobian without units, taken about the tip, or about the axes where all six rows count."""
    at: Literal["tip", "axes"] = "axes" if len(rows) == 6 else "tip"
    return scaled_jacobian(robot, q, task=rows, length=length, at=at)
