"""What an arm is asked to do: the rows of its Jacobian that count."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.geometry import rotation
from mafsil.model.loading import RobotLike
from mafsil.performance.tolerances import CLEAR
from mafsil.performance.velocity.jacobians import tool_jacobian
from mafsil.robot import Robot, as_robot, of_robot

TASKS: Mapping[str, tuple[int, ...]] = MappingProxyType(
    {
        "pose": (0, 1, 2, 3, 4, 5),
        "orientation": (0, 1, 2),
        "position": (3, 4, 5),
        "planar": (2, 3, 4),
        "planar_position": (3, 4),
        "schoenflies": (2, 3, 4, 5),
    }
)
"""Rows of (omega_x, omega_y, omega_z, v_x, v_y, v_z), in the axes of {s}, by name."""

Task: TypeAlias = str | Sequence[int]
"""A name of TASKS, or row numbers 0 .. 5."""


def task_rows(task: Task) -> tuple[int, ...]:
    """Row numbers of a task.

    Args:
        task: a name of TASKS, or row numbers.

    Raises:
        InputError: no such task, or rows that are not different numbers 0 .. 5.
    """
    if isinstance(task, str):
        if task not in TASKS:
            raise InputError("input.choice", name="task", value=task, known=", ".join(TASKS))
        return TASKS[task]
    rows = tuple(int(row) for row in task)
    if not rows or len(set(rows)) < len(rows) or not all(0 <= row <= 5 for row in rows):
        raise InputError("performance.task_rows", rows=rows)
    return rows


def task_coordinates(robot: RobotLike, q: ArrayLike, task: Task = "pose", *, frame: str | None = None) -> Floats:
    """Forward kinematics of the rows that a task asks for, such as (x, y) or (phi, x, y) of a planar arm.

    Args:
        robot: the arm.
        q: (*batch, n) joint coordinates [rad | m].
        task: a name of TASKS, or row numbers: positions 3, 4, 5; of turns all three (a rotation vector) or only the one
            about z (an angle, of arms that turn about nothing else).
        frame: name of a link; the tip frame if None.

    Returns:
        (*batch, m) in the order of the rows [rad, m].

    Raises:
        InputError: other rows of turns, which have no coordinates of their own, or an arm that turns about x or y.
    """
    rows = task_rows(task)
    T = as_robot(robot).forward_kinematics(q, frame=frame)
    turns = [row for row in rows if row < 3]
    if turns == [2]:
        if np.abs(T[..., :2, 2]).max(initial=0.0) > CLEAR:
            raise InputError("performance.turn_rows", rows=rows)
        r = np.zeros((*T.shape[:-2], 3))
        r[..., 2] = np.arctan2(T[..., 1, 0], T[..., 0, 0])
    elif not turns or sorted(turns) == [0, 1, 2]:
        r = rotation.log(T[..., :3, :3])
    else:
        raise InputError("performance.turn_rows", rows=rows)
    return np.concatenate([r, T[..., :3, 3]], axis=-1)[..., list(rows)]


@of_robot
def task_jacobian(
    robot: Robot, q: ArrayLike, task: Task = "pose", *, frame: str | None = None, point: ArrayLike | None = None
) -> Floats:
    """The rows of the tool-point Jacobian that a task asks for.

    Args:
        robot: the arm.
        q: (*batch, n) joint coordinates [rad | m].
        task: a name of TASKS, or row numbers 0 .. 5 of (omega, v) in the axes of {s}.
        frame: name of a link; the tip frame if None.
        point: (3,) point of that frame [m]; its origin if None.

    Returns:
        (*batch, m, n).
    """
    return tool_jacobian(robot, q, frame=frame, point=point)[..., list(task_rows(task)), :]
