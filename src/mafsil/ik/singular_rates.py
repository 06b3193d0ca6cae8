"""Joint rates near and at singular configurations: bounded, with the directions in which the arm cannot move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, as_batch, calculable, positive
from mafsil.errors import InputError
from mafsil.ik.rates import RANK, RatesAnswer, TwistForm, rate_codes, twist_jacobian, twists_for
from mafsil.model.loading import RobotLike
from mafsil.robot import as_robot
from mafsil.solvers import decompositions


@dataclass(frozen=True, eq=False, repr=False)
class BoundedRates(RatesAnswer):
    """Joint rates that stay bounded where the inverse of the Jacobian does not.

    Attributes:
        qd: (*batch, n) rates [rad/s | m/s].
        scale: (*batch,) factor by which the motion was slowed down to keep the limits of the rates; one if not.
        residual: (*batch,) norm of what J qd lacks of scale V.
        rank: (*batch,) rank of the task's Jacobian.
        singular_values: (*batch, min(m, n)) of the task's Jacobian, largest first.
        directions: (*batch, m, min(m, n)) unit twists that belong to them; those from column `rank` on cannot be made.
        damped: (*batch,) how many directions were damped.
        codes: (*batch,) index into `rates.STATUSES`.
    """

    qd: JointVector
    scale: Floats
    residual: Floats
    rank: NDArray[np.int64]
    singular_values: Floats
    directions: Floats
    damped: NDArray[np.int64]
    codes: NDArray[np.int8]

    @property
    def factor(self) -> Floats:
        """(*batch,) part of the twist that is sought: as `scale`."""
        return self.scale

    def lost(self, *index: int) -> Floats:
        """(m, k) unit twists that the arm cannot make at one configuration of the batch; k = 0 if it is regular."""
        return self.directions[index][:, int(self.rank[index]) :]


def bounded_rates(
    robot: RobotLike,
    q: ArrayLike,
    V: ArrayLike,
    *,
    form: TwistForm = "body",
    rows: Sequence[int] | None = None,
    region: float = 0.05,
    damping: float = 0.05,
    limits: ArrayLike | None = None,
) -> BoundedRates:
    """Rates of a twist that are exact away from singular configurations and never large.

    qd = sum of s_i / (s_i^2 + lambda_i^2) v_i (u_i' V),  lambda_i^2 = (1 - (s_i / e)^2) lambda^2 for s_i < e, else 0

    Only the directions in which the arm is nearly singular are damped; |qd| <= |V| max(1 / e, 1 / lambda).

    Args:
        robot: any arm.
        q: (*batch, n) coordinates.
        V: (*batch, m) desired twist, or its components `rows` [rad/s, m/s].
        form: frame of the twist, see `twist_jacobian`.
        rows: components that count; all six if None.
        region: singular value e below which a direction is damped.
        damping: lambda at a singular configuration.
        limits: (n,) largest rates; the whole motion is slowed down where one would be exceeded.

    Raises:
        InputError: wrong shapes, numbers that are not finite, a region, damping or limit that is not positive.

    Reference: Maciejewski and Klein, Numerical filtering for the operation of robotic manipulators through
        kinematically singular configurations, 1988.
    """
    robot = as_robot(robot)
    e, largest = positive("region", region), positive("damping", damping)
    J = twist_jacobian(robot, as_batch("q", q, (robot.n,), finite=True), form, rows)
    twist = twists_for(J, V)
    U, s, W = decompositions.svd(J)
    squares = np.where(s < e, (1.0 - (s / e) ** 2) * largest**2, 0.0)
    parts = (np.swapaxes(U, -1, -2) @ twist[..., None])[..., 0]
    inverse = s / np.where(s < e, s * s + squares, s * s)
    qd = (np.swapaxes(W, -1, -2) @ (inverse * parts)[..., None])[..., 0]
    scale = _slow(qd, limits, robot.n)
    qd = qd * scale[..., None]
    residual = np.linalg.norm((J @ qd[..., None])[..., 0] - scale[..., None] * twist, axis=-1)
    rank = (s > RANK * s.max(axis=-1, keepdims=True, initial=0.0)).sum(axis=-1)
    codes = rate_codes(residual, scale[..., None] * twist, scale)
    return BoundedRates(qd, scale, residual, rank, s, U, (s < e).sum(axis=-1), codes)


def _slow(qd: JointVector, limits: ArrayLike | None, n: int) -> Floats:
    """(*batch,) the factor that brings all rates within their limits."""
    if limits is None:
        return np.ones(qd.shape[:-1])
    most = as_batch("limits", limits, (n,))
    if not (most > 0.0).all():
        raise InputError("input.positive", name="limits", value=float(most.min()))
    excess = (np.abs(qd) / calculable("limits", most)).max(axis=-1, initial=0.0)
    return 1.0 / np.maximum(excess, 1.0)
