"""Task-space dynamics of a robot: its kernels evaluated, the rest by `mechanics.task_space`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch
from mafsil.errors import InputError
from mafsil.mechanics.mass_matrix_singularity import mass_matrix_singularity
from mafsil.mechanics.task_space import TaskSpace, task_space
from mafsil.mechanics.tolerances import SINGULAR, SMALLEST
from mafsil.robot.compiled_robot import CompiledRobot


def task_space_of(
    robot: CompiledRobot,
    q: ArrayLike,
    qd: ArrayLike,
    expressed_in: Literal["body", "space"],
    frame: str | None,
    rows: Sequence[int],
) -> TaskSpace:
    """Task-space dynamics; arguments as in `Robot.task_space`, and the robot.

    Raises:
        InputError: as `Robot.task_space`.
        ModelError: the mass matrix of a state is singular; names the joints that move no inertia.
    """
    if expressed_in not in ("body", "space"):
        raise InputError("dynamics.expressed_in", value=expressed_in)
    chosen = list(rows)
    if not chosen or len(set(chosen)) != len(chosen) or not set(chosen) <= set(range(6)):
        raise InputError("dynamics.task_rows", rows=tuple(chosen))
    q, qd = as_batch("q", q, (robot.n,), finite=True), as_batch("qd", qd, (robot.n,), finite=True)
    jacobian, rate = (
        (robot.jacobian_body, robot.jacobian_body_rate)
        if expressed_in == "body"
        else (robot.jacobian_space, robot.jacobian_space_rate)
    )
    M = robot.mass_matrix(q)
    _require_regular(M, robot)
    return task_space(
        M,
        robot.velocity_torque(q, qd),
        robot.gravity_torque(q),
        jacobian(q, frame=frame)[..., chosen, :],
        rate(q, qd, frame=frame)[..., chosen, :],
        qd,
    )


def _require_regular(M: Floats, robot: CompiledRobot) -> None:
    """Refuses the first state (of a batch) whose mass matrix has no inverse, with the motion that moves no inertia."""
    flat = M.reshape(-1, robot.n, robot.n)
    size = np.sqrt(np.maximum(np.einsum("bii->bi", flat), SMALLEST))
    margins = np.linalg.eigvalsh(flat / (size[:, :, None] * size[:, None, :]))[:, 0] if len(flat) else np.ones(0)
    for k in np.flatnonzero(~(margins >= SINGULAR)):
        mass_matrix_singularity(flat[k], robot.joint_names).require_regular()
