"""How evenly an arm moves: rates, speeds and forces along one direction, and a search for isotropic configurations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, as_batch, whole
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.model.loading import RobotLike
from mafsil.performance.dexterity.manipulability import Part, rate_jacobian
from mafsil.performance.tolerances import ISOTROPIC, LEAST_DAMPING, NO_TRACE, SAME, WITHIN
from mafsil.performance.velocity.jacobians import jacobian_hessian, tool_jacobian
from mafsil.performance.velocity.scaling import TOLERANCE, Task, random_configurations, ranges, scaled_jacobian
from mafsil.robot import Robot, as_robot, of_robot
from mafsil.solvers import decompositions
from mafsil.solvers.least_squares import damped_step


class IsotropyStatus(Status):
    """Whether an isotropic configuration was found."""

    FOUND = ("performance.isotropy_found", True)
    NOT_FOUND = ("performance.isotropy_none", False)


@dataclass(frozen=True, eq=False, repr=False)
class IsotropySearch(Answer, data="q condition_number starts", entries="q"):
    """What a search found; true if there is an isotropic configuration among it.

    Attributes:
        q: (k, n) the best configuration first; all that are isotropic and different, or one [rad | m].
        condition_number: (k,) largest over smallest singular value.
        starts: how many were tried.
    """

    q: JointVector
    condition_number: Floats
    starts: int

    @property
    def found(self) -> bool:
        """Whether there is an isotropic configuration among them."""
        return bool(self.condition_number[0] - 1.0 < ISOTROPIC)

    @property
    def status(self) -> IsotropyStatus:
        """Found or not; a search proves no absence."""
        return IsotropyStatus.FOUND if self.found else IsotropyStatus.NOT_FOUND

    def __bool__(self) -> bool:
        return self.found

    def explain(self, language: str | None = None) -> str:
        """The answer in a sentence."""
        details = {"count": len(self.q), "starts": self.starts, "condition_number": float(self.condition_number[0])}
        return self.status.sentence(language, **details)


@of_robot
def isotropic_configurations(
    robot: Robot,
    task: Task = "position",
    *,
    length: float | None = None,
    starts: int = 128,
    iterations: int = 80,
    seed: int = 3,
) -> IsotropySearch:
    """Configurations within the limits whose Jacobian has equal singular values, by damped least squares.

    1. Many random starts within the limits, each a row of a batch.
    2. Damped least-squares steps for J J' / mean(sigma^2) = I, kept within the limits; a step that is no gain is
       undone and damped more.
    3. The configurations are ordered by their condition number, and equal ones are left out.

    Args:
        robot: the arm.
        task: rows that count.
        length: [m] that divides translations; the characteristic length if None.
        starts: random starts.
        iterations: steps from each.
        seed: of the starts.
    """
    lower, upper = ranges(robot)
    whole("starts", starts, 1, 1_000_000)
    whole("iterations", iterations, 0, 10_000)
    q = random_configurations(robot, starts, seed)  # 1
    damping = np.full(starts, 1e-2)
    residual, slope = _residual(robot, q, task, length)
    for _ in range(iterations):  # 2
        trial = np.clip(q - damped_step(slope, residual, damping), lower, upper)
        after, slope_after = _residual(robot, trial, task, length)
        better = (after**2).sum(axis=-1) < (residual**2).sum(axis=-1)
        q, residual = np.where(better[:, None], trial, q), np.where(better[:, None], after, residual)
        slope = np.where(better[:, None, None], slope_after, slope)
        damping = np.clip(np.where(better, damping / 5, damping * 4), LEAST_DAMPING, 1e6)
    s = decompositions.singular_values(scaled_jacobian(robot, q, task=task, length=length).J)
    condition_number = s[:, 0] / np.maximum(s[:, -1], LEAST_DIVISOR)
    order = np.argsort(condition_number)  # 3
    good = [k for k in order if condition_number[k] - 1.0 < ISOTROPIC] or [order[0]]
    kept = _different(q, good)
    return IsotropySearch(q[kept], condition_number[kept], starts)


def _residual(robot: Robot, q: Floats, task: Task, length: float | None) -> tuple[Floats, Floats]:
    """Entries of J J' / mean - I above and on the diagonal, and their derivatives by q."""
    scaled = scaled_jacobian(robot, q, task=task, length=length)
    J = scaled.J
    m = J.shape[-2]
    dJ = jacobian_hessian(robot, q)[..., list(scaled.rows), :] * (scaled.row_factors[:, None] * scaled.columns)
    G = J @ np.swapaxes(J, -1, -2)
    half = dJ @ np.swapaxes(J, -1, -2)[..., None, :, :]
    dG = half + np.swapaxes(half, -1, -2)
    mean = np.maximum(np.trace(G, axis1=-2, axis2=-1) / m, NO_TRACE)[..., None, None]
    dmean = (np.trace(dG, axis1=-2, axis2=-1) / m)[..., None, None]
    rows, columns = np.triu_indices(m)
    residual = (G / mean - np.eye(m))[..., rows, columns]
    slope = (dG / mean[..., None] - G[..., None, :, :] * dmean / mean[..., None] ** 2)[..., rows, columns]
    return residual, np.swapaxes(slope, -1, -2)


def _different(q: Floats, order: list[int]) -> list[int]:
    """Those that are no neighbours of an earlier one, at most sixteen."""
    kept: list[int] = []
    for k in order:
        if all(np.abs(q[k] - q[other]).max() > SAME for other in kept):
            kept.append(k)
        if len(kept) == 16:
            break
    return kept


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
