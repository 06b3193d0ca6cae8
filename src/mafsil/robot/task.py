"""Task-space dynamics of a robot: its kernels evaluated, the rest by `mechanics.task_space`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

from numpy.typing import ArrayLike

from mafsil.arrays import gate
from mafsil.errors import InputError
from mafsil.mechanics.task_space import TaskSpace, task_space

if TYPE_CHECKING:
    from mafsil.robot.robot import Robot


def task_space_of(
    robot: Robot,
    q: ArrayLike,
    qd: ArrayLike,
    expressed_in: Literal["body", "space"],
    frame: str | None,
    rows: Sequence[int],
) -> TaskSpace:
    """Task-space dynamics; arguments as in `Robot.task_space`, and the robot."""
    if expressed_in not in ("body", "space"):
        raise InputError("dynamics.expressed_in", value=expressed_in)
    chosen = list(rows)
    if not chosen or len(set(chosen)) != len(chosen) or not set(chosen) <= set(range(6)):
        raise InputError("dynamics.task_rows", rows=tuple(chosen))
    q, qd = gate("q", q, (robot.n,), finite=True), gate("qd", qd, (robot.n,), finite=True)
    jacobian, rate = (
        (robot.jacobian_body, robot.jacobian_body_rate)
        if expressed_in == "body"
        else (robot.jacobian_space, robot.jacobian_space_rate)
    )
    return task_space(
        robot.mass_matrix(q),
        robot.velocity_torque(q, qd),
        robot.gravity_torque(q),
        jacobian(q, frame=frame)[..., chosen, :],
        rate(q, qd, frame=frame)[..., chosen, :],
        qd,
    )
