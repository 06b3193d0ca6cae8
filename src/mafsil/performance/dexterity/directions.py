"""How an arm moves and pushes along one direction: least joint rates, greatest speed, efforts for a unit of force."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, as_batch
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.model.loading import RobotLike
from mafsil.performance.dexterity.manipulability import Part, rate_jacobian
from mafsil.performance.tolerances import WITHIN
from mafsil.performance.velocity.jacobians import tool_jacobian
from mafsil.performance.velocity.scaling import TOLERANCE
from mafsil.robot import as_robot


def least_joint_rate(
    robot: RobotLike,
    q: ArrayLike,
    direction: ArrayLike,
    part: Part = "linear",
    *,
    point: ArrayLike | None = None,
    weighted: bool = False,
    length: float | None = None,
) -> Floats:
    """Least size of the joint rates that move the tip at unit speed along a direction: sqrt(u' (J J')^-1 u).

    Args:
        robot: the arm, its mechanism, name or path.
        q: (*batch, n) joint coordinates [rad | m].
        direction: (*batch, 3) in {s}, (*batch, 2) for the part `planar`; any length but zero.
        part: `linear` (motion of the tip's point, however the tip turns), `planar` or `angular`.
        point: (3,) point of the tip frame [m]; its origin if None.
        weighted: whether each joint rate counts in shares of its limit.
        length: [m] by which rates of prismatic joints are divided before they join those of revolute joints; 1 m if
            None.

    Returns:
        (*batch); infinite where the direction is lost.
    """
    J = rate_jacobian(as_robot(robot), q, part, point=point, weighted=weighted, length=length)
    u = unit_direction(direction, J.shape[-2])
    U, s, _ = np.linalg.svd(J, full_matrices=False)
    along = np.einsum("...ij,...i->...j", U, u)
    kept = s > np.maximum(TOLERANCE * s[..., :1], LEAST_DIVISOR)
    reached = np.einsum("...ij,...j->...i", U, np.where(kept, along, 0.0))
    effort = np.sqrt((np.where(kept, along / np.where(kept, s, 1.0), 0.0) ** 2).sum(axis=-1))
    return np.where(np.linalg.norm(u - reached, axis=-1) > WITHIN, np.inf, effort)


def largest_speed(
    robot: RobotLike,
    q: ArrayLike,
    direction: ArrayLike,
    part: Part = "linear",
    *,
    point: ArrayLike | None = None,
    weighted: bool = False,
    length: float | None = None,
) -> Floats:
    """(*batch) greatest speed along a direction, and in no other, at joint rates of unit size: 1 / `least_joint_rate`.

    Zero where the direction is lost; arguments as `least_joint_rate`.
    """
    effort = least_joint_rate(robot, q, direction, part, point=point, weighted=weighted, length=length)
    with np.errstate(divide="ignore"):
        return 1.0 / effort


def torque_along(
    robot: RobotLike,
    q: ArrayLike,
    direction: ArrayLike,
    kind: Literal["force", "moment"] = "force",
    *,
    frame: str | None = None,
    point: ArrayLike | None = None,
) -> JointVector:
    """(*batch, n) joint efforts for a unit force, or a unit moment, that the tip exerts along a direction.

    Args:
        robot: the arm, its mechanism, name or path.
        q: (*batch, n) joint coordinates [rad | m].
        direction: (*batch, 3) in {s}, any length but zero.
        kind: `force` (per N) or `moment` (per N m).
        frame: name of a link; the tip frame if None.
        point: (3,) point of that frame at which the force acts [m]; its origin if None.
    """
    if kind not in ("force", "moment"):
        raise InputError("input.choice", name="kind", value=kind, known="force, moment")
    J = tool_jacobian(as_robot(robot), q, frame=frame, point=point)
    rows = J[..., 3:, :] if kind == "force" else J[..., :3, :]
    return np.einsum("...ij,...i->...j", rows, unit_direction(direction, 3))


def unit_direction(direction: ArrayLike, count: int = 3) -> Floats:
    """(*batch, count) the argument `direction` at unit length.

    Raises:
        InputError: a row is zero.
    """
    u = as_batch("direction", direction, (count,), finite=True)
    size = np.linalg.norm(u, axis=-1, keepdims=True)
    if not size.all():
        raise InputError("performance.zero_vector", name="direction")
    return u / size
