"""Dynamics in the coordinates of the tip: F = Lambda dV + eta, and back.

Reference: Lynch & Park, Modern Robotics, sec. 8.6; Khatib, A unified approach for motion and force control of robot
manipulators, IEEE J. Robotics and Automation 3, 1987 (redundant arms).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, as_batch
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.mechanics.tolerances import SINGULAR_TASK


@dataclass(frozen=True, eq=False, slots=True)
class TaskSpace:
    """Task-space dynamics at a batch of states; k rows of the twist. NaN where the arm is singular.

    Attributes:
        J: (*batch, k, n) Jacobian.
        inverse: (*batch, k, k) Lambda^-1 = J M^-1 J', finite everywhere: what a wrench at rest accelerates.
        Lambda: (*batch, k, k) task-space inertia.
        J_bar: (*batch, n, k) = M^-1 J' Lambda, the dynamically consistent inverse of J; J^-1 for six joints.
        mu: (*batch, k) velocity part of eta.
        p: (*batch, k) gravity part of eta.
        margin: (*batch,) smallest eigenvalue of Lambda^-1 scaled to a unit diagonal.
        singular: (*batch,) J has lost rank, so that no force produces some accelerations.
    """

    J: Floats
    inverse: Floats
    Lambda: Floats
    J_bar: Floats
    mu: Floats
    p: Floats
    margin: Floats
    singular: NDArray[np.bool_]

    @property
    def eta(self) -> Floats:
        """(*batch, k) = mu + p."""
        return self.mu + self.p

    def force(self, dV: ArrayLike, tip_wrench: ArrayLike | None = None) -> Floats:
        """F (*batch, k) = Lambda dV + eta + F_tip: with the joint efforts J' F the task accelerates by dV (*batch, k).

        Args:
            dV: (*batch, k) derivative of the task's twist.
            tip_wrench: (*batch, k) what the tip exerts on the world, in the same frame; none by default. What the world
                exerts on the tip enters with the other sign.
        """
        return _times(self.Lambda, self._gate("dV", dV)) + self.eta + self._exert(tip_wrench)

    def acceleration(self, F: ArrayLike, tip_wrench: ArrayLike | None = None) -> Floats:
        """dV (*batch, k) = Lambda^-1 (F - eta - F_tip): the answer to the joint efforts J' F, and to a tip wrench.

        Args:
            F: (*batch, k) task force, `task_force` of joint efforts.
            tip_wrench: as in `force`.
        """
        return _times(self.inverse, self._gate("F", F) - self.eta - self._exert(tip_wrench))

    def task_force(self, tau: ArrayLike) -> Floats:
        """F (*batch, k) = J_bar' tau, which is J^-T tau for six joints: the task's share of the efforts (*batch, n)."""
        return _times(_transpose(self.J_bar), as_batch("tau", tau, (self.J.shape[-1],)))

    def joint_torque(self, F: ArrayLike, internal: ArrayLike | None = None) -> JointVector:
        """tau (*batch, n) = J' F + (E - J' J_bar') tau_0: the second part moves a redundant arm but not its tip.

        Args:
            F: (*batch, k) task force.
            internal: tau_0 (*batch, n) any efforts; None for none.
        """
        task = _times(_transpose(self.J), as_batch("F", F, (self.J.shape[-2],)))
        if internal is None:
            return task
        tau_0 = as_batch("internal", internal, (self.J.shape[-1],))
        return task + tau_0 - _times(_transpose(self.J), _times(_transpose(self.J_bar), tau_0))

    def _gate(self, name: str, value: ArrayLike) -> Floats:
        return as_batch(name, value, (self.J.shape[-2],))

    def _exert(self, tip_wrench: ArrayLike | None) -> Floats | float:
        return 0.0 if tip_wrench is None else self._gate("tip_wrench", tip_wrench)


def task_space(M: Floats, c: JointVector, g: JointVector, J: Floats, dJ: Floats, qd: JointVector) -> TaskSpace:
    """Lambda = (J M^-1 J')^-1, mu = J_bar' c - Lambda dJ qd, p = J_bar' g; J^-T M J^-1 and so on for a square J.

    Args:
        M: (*batch, n, n) mass matrix.
        c, g: (*batch, n) velocity and gravity efforts.
        J, dJ: (*batch, k, n) Jacobian and its time derivative, in the same frame.
        qd: (*batch, n) rates.
    """
    Minv_Jt: Floats = np.linalg.solve(M, _transpose(J)).astype(np.float64, copy=False)
    inverse = J @ Minv_Jt
    inverse = (inverse + _transpose(inverse)) / 2
    size = np.sqrt(np.maximum(np.einsum("...ii->...i", inverse), LEAST_DIVISOR))
    scaled = inverse / (size[..., :, None] * size[..., None, :])
    margin: Floats = np.linalg.eigvalsh(scaled)[..., 0].astype(np.float64, copy=False)
    singular: NDArray[np.bool_] = np.asarray(~(margin >= SINGULAR_TASK))
    guarded = np.where(singular[..., None, None], np.eye(J.shape[-2]), inverse)
    Lambda: Floats = np.where(singular[..., None, None], np.nan, np.linalg.inv(guarded)).astype(np.float64, copy=False)
    J_bar = Minv_Jt @ Lambda
    back = _transpose(J_bar)
    mu = _times(back, c) - _times(Lambda, _times(dJ, qd))
    return TaskSpace(J, inverse, Lambda, J_bar, mu, _times(back, g), margin, singular)


def _times(A: Floats, x: Floats) -> Floats:
    return np.einsum("...ij,...j->...i", A, x)


def _transpose(A: Floats) -> Floats:
    return np.swapaxes(A, -1, -2)
