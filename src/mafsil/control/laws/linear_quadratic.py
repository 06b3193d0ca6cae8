"""Linear-quadratic control about a pose: the gains that a quadratic cost of errors and efforts asks for."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, as_batch, frozen
from mafsil.control.laws.gains import Gains
from mafsil.control.laws.law import Law
from mafsil.errors import InputError
from mafsil.robot import Robot, of_robot
from mafsil.solvers.decompositions import riccati
from mafsil.trajectory import Motion

ANGLE = 1e-5
"""Step of the differences of gravity [rad | m]."""


@dataclass(frozen=True, eq=False, slots=True)
class LinearQuadratic:
    """tau = M(u) a + c(u, v) + g(u) + gain (u - q, v - qd): optimal for small errors about one pose.

    Attributes:
        robot: the model.
        pose: (n,) at which it was linearised [rad | m].
        gain: (n, 2 n) from errors of position and rate to efforts.
        A, B: (2 n, 2 n), (2 n, n) of the errors x' = A x - B (tau - tau_0) there.
        cost: (2 n, 2 n) P: what an error x costs from now on is x' P x.
    """

    robot: Robot
    pose: Floats
    gain: Floats
    A: Floats = field(repr=False)
    B: Floats = field(repr=False)
    cost: Floats = field(repr=False)

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Efforts (*batch, n) [N m | N]."""
        x = np.concatenate(np.broadcast_arrays(reference.u - q, reference.v - qd), axis=-1)
        return self.robot.inverse_dynamics(reference.u, reference.v, reference.a) + x @ self.gain.T

    @property
    def roots(self) -> NDArray[np.complex128]:
        """(2 n,) of the errors at the pose, the slowest first [1/s]."""
        found = np.linalg.eigvals(self.A - self.B @ self.gain)
        return np.asarray(found[np.argsort(-found.real)], dtype=np.complex128)

    def session(self, period: float) -> Law:
        """The law itself: it has no memory."""
        return self


@of_robot
def linear_quadratic(
    robot: Robot, pose: ArrayLike, *, position: ArrayLike = 100.0, rate: ArrayLike = 1.0, effort: ArrayLike = 1e-3
) -> LinearQuadratic:
    """The law that minimises the integral of position e^2 + rate e'^2 + effort (tau - tau_0)^2 about a pose.

    Args:
        robot: its model.
        pose: (n,) [rad | m].
        position, rate, effort: weights, each a number or (n,): such as one over the square of what is tolerable.

    Raises:
        InputError: a wrong shape, a number that is not finite, a negative weight, one of the effort or position that is
            zero.
        ModelError: the robot has no masses.

    Reference: Kalman, Contributions to the theory of optimal control, 1960; Siciliano et al., Robotics, app. C.
    """
    n = robot.n
    place = as_batch("pose", pose, (n,), finite=True).reshape(n)
    weights, costs = Gains.of(n, position, rate), Gains.of(n, effort, 0.0)
    for name, values in (("position", weights.kp), ("effort", costs.kp)):
        if not (values > 0.0).all():
            raise InputError("input.positive", name=name, value=float(values.min()))
    aside = ANGLE * np.eye(n)
    slope = (robot.gravity_torque(place + aside) - robot.gravity_torque(place - aside)).T / (2.0 * ANGLE)
    inverse: Floats = np.asarray(np.linalg.inv(robot.mass_matrix(place)), dtype=np.float64)
    zero = np.zeros((n, n))
    A = np.block([[zero, np.eye(n)], [-inverse @ slope, zero]])
    B = np.vstack([zero, inverse])
    P = riccati(A, B, np.diag(np.concatenate([weights.kp, weights.kd])), np.diag(costs.kp))
    if P is None:
        raise InputError("control.no_optimal_gain")
    return LinearQuadratic(robot, frozen(place), frozen((B.T @ P) / costs.kp[:, None]), A, B, P)
