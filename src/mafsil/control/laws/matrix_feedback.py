"""Feedback with full matrices of gains: the error of one joint may act on another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, real_array, require_finite, whole
from mafsil.control.joints.friction_compensation import friction_along
from mafsil.control.laws.feedback import SummingRun
from mafsil.control.laws.law import Law
from mafsil.errors import InputError
from mafsil.fields import check_fields, square
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion


@dataclass(frozen=True, eq=False, slots=True)
class MatrixGains:
    """Kp, Kd, Ki as symmetric (n, n) matrices without negative eigenvalues.

    Attributes:
        kp, kd, ki: (n, n) in units of acceleration for computed torque, of effort for a law without a model's inertia.
    """

    kp: Floats
    kd: Floats
    ki: Floats
    __post_init__ = check_fields(kp=square, kd=square, ki=square)

    @classmethod
    def of(cls, n: int, kp: ArrayLike, kd: ArrayLike, ki: ArrayLike = 0.0) -> MatrixGains:
        """From numbers k, which stand for k I, diagonals (n,) or matrices (n, n).

        Raises:
            InputError: a wrong shape, a number that is not finite, a matrix that is not symmetric or has a negative
                eigenvalue.
        """
        return cls(*(symmetric(name, value, n) for name, value in (("kp", kp), ("kd", kd), ("ki", ki))))


def symmetric(name: str, value: ArrayLike, n: int) -> Floats:
    """(n, n) symmetric without negative eigenvalues, from a number, a diagonal (n,) or a matrix.

    Args:
        name: of the argument, for errors.
        value: as it was given.
        n: rows.

    Raises:
        InputError: a wrong shape, a number that is not finite, a matrix that is not symmetric or has a negative
            eigenvalue.
    """
    whole("n", n, 1)
    array = require_finite(name, real_array(name, value))
    if array.shape not in ((), (n,), (n, n)):
        raise InputError("input.shape", name=name, expected=(n, n), got=array.shape, hint="")
    full = array if array.shape == (n, n) else np.diag(np.broadcast_to(array, (n,)))
    if not np.allclose(full, full.T, rtol=1e-9, atol=0.0):
        raise InputError("control.not_symmetric", name=name)
    least = float(np.linalg.eigvalsh(full)[0])
    if least < -1e-12 * max(float(np.abs(full).max()), LEAST_DIVISOR):
        raise InputError("input.range", name=name, value=least, low=0.0, high=np.inf)
    return full.astype(np.float64)


@dataclass(frozen=True, eq=False, slots=True)
class MatrixFeedback:
    """PID with matrices of gains, alone, with gravity compensation, or inside computed torque; e = u - q.

    alone:            tau = Kp e + Kd e' + Ki int e
    gravity:          the same + g(q) + friction(v)
    computed torque:  tau = M(q) (a + Kp e + Kd e' + Ki int e) + c(q, qd) + g(q) + friction(v)

    Attributes:
        gains: matrices.
        model: the robot, or None for feedback alone.
        whole_model: whether all of the model counts (computed torque) or its gravity only.
        friction: whether the friction of the model is compensated, at the rates of the reference.
    """

    gains: MatrixGains
    model: Robot | None = None
    whole_model: bool = False
    friction: bool = True

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) without the integral term, which needs a session [N m | N]."""
        return self.effort(q, qd, reference, np.zeros(len(self.gains.kp)))

    def effort(self, q: JointVector, qd: JointVector, reference: Motion, integral: Floats) -> JointVector:
        """Joint efforts (*batch, n) [N m | N].

        Args:
            q, qd: (*batch, n) state.
            reference: where they should be.
            integral: (*batch, n) Ki times the error's integral.
        """
        pull = (reference.u - q) @ self.gains.kp + (reference.v - qd) @ self.gains.kd + integral
        if self.model is None:
            return pull
        if self.whole_model:
            effort = self.model.inverse_dynamics(q, qd, reference.a + pull)
        else:
            effort = pull + self.model.gravity_torque(q)
        return effort + friction_along(self.model, reference) if self.friction else effort

    def session(self, period: float) -> Law:
        """The law with a fresh integral; the law itself if Ki is zero."""
        if not self.gains.ki.any():
            return self
        return _WithIntegral(self, self.gains.ki * period, np.zeros(len(self.gains.ki)))


class _WithIntegral(SummingRun[MatrixFeedback]):
    """One run of a law with matrices of gains."""

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        return self._law.effort(q, qd, reference, self._sum.add((reference.u - q) @ self._weight))


def matrix_pid(n: int, kp: ArrayLike, kd: ArrayLike = 0.0, ki: ArrayLike = 0.0) -> MatrixFeedback:
    """PID of n joints with full matrices of gains.

    Args:
        n: number of joints.
        kp, kd, ki: a number, (n,) or (n, n), symmetric.

    Raises:
        InputError: a wrong shape, a number that is not finite, a matrix that is not symmetric or has a negative
            eigenvalue.
    """
    return MatrixFeedback(MatrixGains.of(whole("n", n, least=1), kp, kd, ki))


@of_robot
def matrix_gravity_compensation(
    robot: Robot, kp: ArrayLike, kd: ArrayLike, ki: ArrayLike = 0.0, *, friction: bool = True
) -> MatrixFeedback:
    """PD (or PID) with full matrices of gains plus the model's gravity and friction.

    Args:
        robot: the model.
        kp, kd, ki: a number, (n,) or (n, n), symmetric.
        friction: whether the friction that the description has is compensated; False for a plant without friction.

    Raises:
        InputError: as of `matrix_pid`.
    """
    return MatrixFeedback(MatrixGains.of(robot.n, kp, kd, ki), robot, friction=friction)


@of_robot
def matrix_computed_torque(
    robot: Robot, kp: ArrayLike, kd: ArrayLike, ki: ArrayLike = 0.0, *, friction: bool = True
) -> MatrixFeedback:
    """Computed torque with full matrices of gains: the errors obey e'' + Kd e' + Kp e + Ki int e = 0 together.

    Args:
        robot: the model.
        kp, kd, ki: a number, (n,) or (n, n), symmetric [1/s^2, 1/s, 1/s^3].
        friction: whether the friction that the description has is compensated; False for a plant without friction.

    Raises:
        InputError: as of `matrix_pid`.

    Reference: Lynch and Park, Modern Robotics, eq. (11.35).
    """
    return MatrixFeedback(MatrixGains.of(robot.n, kp, kd, ki), robot, True, friction)
