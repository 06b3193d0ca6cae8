"""Velocities of joints at via points from velocities of the tip: the inverse Jacobian, damped where it is singular."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer
from mafsil.arrays import Floats, JointVector, Scalar, as_batch, positive, real_array, spread
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.robot import Robot, of_robot
from mafsil.trajectory.status import ViaRateStatus
from mafsil.trajectory.tolerances import GIVEN, ROUNDING


@dataclass(frozen=True, eq=False, repr=False)
class ViaRates(Answer, data="qd condition damping residual exact most_condition"):
    """Joint rates for velocities of the tip; true where all are made.

    Attributes:
        qd: (*batch, n) [rad/s | m/s].
        condition: (*batch,) largest over smallest singular value of the Jacobian of what was asked.
        damping: (*batch,) lambda of the damped inverse; 0 where it is exact.
        residual: (*batch,) norm of what J qd lacks of the velocity.
        exact: (*batch,) whether the velocity is made.
        most_condition: from which condition number on the inverse is damped.
    """

    qd: JointVector
    condition: Scalar
    damping: Scalar
    residual: Scalar
    exact: NDArray[np.bool_]
    most_condition: float

    def __bool__(self) -> bool:
        return bool(self.exact.all())

    def __len__(self) -> int:
        return len(self.exact) if self.exact.ndim else 1

    def __iter__(self) -> Iterator[JointVector]:
        return iter(self.qd if self.exact.ndim else (self.qd,))

    @property
    def status(self) -> Any:
        """The status, a member of `ViaRateStatus`; of a batch an array (*batch,) of them."""
        found = np.full(self.exact.shape, ViaRateStatus.EXACT, dtype=np.object_)
        found[~self.exact & (self.damping > 0.0)] = ViaRateStatus.DAMPED
        found[~self.exact & (self.damping == 0.0)] = ViaRateStatus.NOT_POSSIBLE
        return found if found.ndim else found[()]

    def explain(self, language: str | None = None) -> str:
        """How many velocities are made, and the worst of the others."""
        count, made = self.exact.size, int(self.exact.sum())
        lines = [say("trajectory.via_rates", language=language, made=made, count=count)]
        if made < count:
            worst = np.unravel_index(int(np.where(self.exact, -1.0, self.residual).argmax()), self.exact.shape)
            details = {name: float(getattr(self, name)[worst]) for name in ("condition", "damping", "residual")}
            status: ViaRateStatus = self.status[worst] if self.exact.ndim else self.status
            lines.append(status.sentence(language, most=self.most_condition, **details))
        return "\n".join(lines)


@of_robot
def via_rates(
    robot: Robot,
    q: ArrayLike,
    *,
    linear: ArrayLike | None = None,
    angular: ArrayLike | None = None,
    weights: ArrayLike | None = None,
    most_condition: float = 1e3,
    frame: str | None = None,
) -> ViaRates:
    """qd = J# (omega; v) at via points, for `cubic_through(..., velocities=via_rates(...).qd)`.

    J# = W^-1 J' (J W^-1 J' + lambda^2 I)^-1,  lambda = 0 below `most_condition`; beyond it grows with
    lambda^2 = (1 - (s_min most_condition/s_max)^2) (s_max/most_condition)^2, so that no rate jumps.

    Args:
        robot: whose tip or `frame` moves.
        q: (*batch, n) at the points [rad | m].
        linear: (*batch, 3) velocity of the tip's origin in {s}; None if it is free [m/s].
        angular: (*batch, 3) angular velocity in {s}; None if it is free [rad/s].
        weights: (n,) cost of each joint's rate, positive; all 1 if None.
        most_condition: the condition number beyond which the inverse is damped.
        frame: name of a link; the tip if None.

    Raises:
        InputError: a wrong shape, a number that is not finite, neither velocity, a weight that is not positive.

    Reference: Nakamura and Hanafusa, Inverse kinematic solutions with singularity robustness, 1986.
    """
    Q = as_batch("q", q, (robot.n,), finite=True)
    bound = positive("most_condition", most_condition)
    wanted = [
        None if value is None else as_batch(name, value, (3,), finite=True)
        for name, value in (("angular", angular), ("linear", linear))
    ]
    if linear is None and angular is None:
        raise InputError("trajectory.no_tip_velocity")
    W = np.ones(robot.n) if weights is None else real_array("weights", weights)
    if W.shape != (robot.n,) or not ((W > 0.0) & np.isfinite(W)).all():
        raise InputError("trajectory.weights", n=robot.n)
    if frame is None:
        J_b, T = robot.jacobian_body(Q), robot.forward_kinematics(Q)
    else:
        J_b, T = robot.jacobian_body(Q, frame=frame), robot.forward_kinematics(Q, frame=frame)
    R = T[..., :3, :3]
    blocks = [R @ J_b[..., k : k + 3, :] for k, each in zip((0, 3), wanted, strict=True) if each is not None]
    J = np.concatenate(blocks, axis=-2)
    V = np.concatenate(
        [
            spread(name, each, (*Q.shape[:-1], 3))
            for name, each in zip(("angular", "linear"), wanted, strict=True)
            if each is not None
        ],
        axis=-1,
    )
    return _rates(J, V, 1.0 / np.sqrt(W), bound)


def _rates(J: Floats, V: Floats, scale: Floats, bound: float) -> ViaRates:
    """1. Singular values of the weighted Jacobian, which the task's rows or the joints have.  2. Damping.  3. Rates."""
    # 1
    s_all = np.linalg.svd(J, compute_uv=False)
    U, s, Vt = np.linalg.svd(J * scale, full_matrices=False)
    # Rows that no joint can move, as those out of the plane of a planar arm, are no singularity.
    rank = min(int((s_all.max(axis=tuple(range(s_all.ndim - 1))) > ROUNDING * s_all.max()).sum()), s.shape[-1])
    s_all, s, U, Vt = s_all[..., :rank], s[..., :rank], U[..., :rank], Vt[..., :rank, :]
    with np.errstate(divide="ignore"):
        condition = s_all[..., 0] / s_all[..., -1]
    # 2
    least = s[..., 0] / bound
    squared = np.where(s[..., -1] < least, (1.0 - (s[..., -1] / least) ** 2) * least**2, 0.0)
    # 3
    inverse = s / (s**2 + squared[..., None])
    along = (np.swapaxes(U, -1, -2) @ V[..., None])[..., 0]
    qd = scale * (np.swapaxes(Vt, -1, -2) @ (inverse * along)[..., None])[..., 0]
    residual = np.linalg.norm((J @ qd[..., None])[..., 0] - V, axis=-1)
    exact = np.asarray(residual <= GIVEN * np.linalg.norm(V, axis=-1), dtype=np.bool_)
    return ViaRates(qd, np.asarray(condition), np.sqrt(squared), np.asarray(residual), exact, bound)
