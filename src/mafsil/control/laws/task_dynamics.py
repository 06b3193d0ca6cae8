"""The dynamics of an arm seen at its tip: inertia, velocity and gravity forces in task coordinates.

What a redundant arm does beside its task: its joints are drawn to their reference without moving the tip.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, as_batch, real_array
from mafsil.control.laws.gains import Gains
from mafsil.control.laws.law import Law
from mafsil.control.laws.task_coordinates import TaskCoordinates
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion

LOST = 1e-12
"""Share of the largest eigenvalue of J M^-1 J' below which a direction of the task is lost: no force acts along it."""


@dataclass(frozen=True, eq=False, slots=True)
class TaskDynamics:
    """F = Lambda dV/dt + gamma + eta, with tau = J' F.

    Attributes:
        J, J_rate: (*batch, m, n) Jacobian and its derivative in time.
        inertia: (*batch, m, m) Lambda = (J M^-1 J')^-1.
        velocity_force: (*batch, m) gamma = Lambda (J M^-1 c - dJ/dt qd).
        gravity_force: (*batch, m) eta = Lambda J M^-1 g.
        inverse: (*batch, n, m) M^-1 J' Lambda, the inverse of J of least kinetic energy.
        V: (*batch, m) velocity.
    """

    J: Floats
    J_rate: Floats
    inertia: Floats
    velocity_force: Floats
    gravity_force: Floats
    inverse: Floats
    V: Floats

    def force(self, acceleration: Floats) -> Floats:
        """(*batch, m) that makes the tip accelerate so.

        Args:
            acceleration: (*batch, m) dV/dt.
        """
        return _times(self.inertia, acceleration) + self.velocity_force + self.gravity_force

    def effort(self, force: Floats, rest: Floats | None = None) -> JointVector:
        """(*batch, n) tau = J' F, and what does not move the tip: (I - J' Jbar') tau_0.

        Args:
            force: (*batch, m) at the tip, in the coordinates of the task.
            rest: (*batch, n) efforts of which only the part in the null space is taken.
        """
        tau = _times(np.swapaxes(self.J, -1, -2), force)
        if rest is None:
            return tau
        felt = _times(np.swapaxes(self.inverse, -1, -2), rest)
        return tau + rest - _times(np.swapaxes(self.J, -1, -2), felt)


@of_robot
def task_dynamics(
    robot: Robot, q: ArrayLike, qd: ArrayLike | None = None, coordinates: TaskCoordinates | None = None
) -> TaskDynamics:
    """Inertia, velocity and gravity forces at the tip.

    In directions that the arm has lost (at a singularity) the inverse is that of Moore and Penrose.

    Args:
        robot: its model; friction is not part of it.
        q, qd: (*batch, n) positions and rates; at rest if None [rad | m].
        coordinates: of the task; all six, decoupled, if None.

    Raises:
        InputError: a wrong shape, a number that is not finite.
        ModelError: the robot has no masses.

    Reference: Khatib, A unified approach for motion and force control of robot manipulators, 1987; Lynch and Park,
        Modern Robotics, eq. (8.90).
    """
    task = coordinates or TaskCoordinates()
    q = as_batch("q", q, (robot.n,), finite=True)
    qd = np.zeros_like(q) if qd is None else as_batch("qd", qd, (robot.n,), finite=True)
    J, J_rate = task.jacobian(robot, q), task.jacobian_rate(robot, q, qd)
    M = robot.mass_matrix(q)
    c, g = robot.velocity_torque(q, qd), robot.gravity_torque(q)
    columns = np.concatenate([np.swapaxes(J, -1, -2), c[..., None], g[..., None]], axis=-1)
    solved = real_array("mass_matrix", np.linalg.solve(M, columns))
    m = J.shape[-2]
    inertia = _inverse(J @ solved[..., :m])
    pulls = J @ solved[..., m:]
    gamma = _times(inertia, pulls[..., 0] - _times(J_rate, qd))
    eta = _times(inertia, pulls[..., 1])
    return TaskDynamics(J, J_rate, inertia, gamma, eta, solved[..., :m] @ inertia, _times(J, qd))


def _inverse(A: Floats) -> Floats:
    """(*batch, m, m) of Moore and Penrose, of a symmetric A; `np.linalg.pinv` sorts and checks for 45 us more."""
    sizes, axes = np.linalg.eigh(A)
    kept = np.abs(sizes) > LOST * np.abs(sizes).max(axis=-1, keepdims=True)
    with np.errstate(divide="ignore"):
        shares = np.where(kept, 1.0 / sizes, 0.0)
    return real_array("A", (axes * shares[..., None, :]) @ np.swapaxes(axes, -1, -2))


def _times(A: Floats, x: Floats) -> Floats:
    return (A @ x[..., None])[..., 0]


@dataclass(frozen=True, eq=False, slots=True)
class NullSpaceFeedback:
    """tau = (I - J' Jbar') (M (a + Kp (u - q) + Kd (v - qd)) + c + g): efforts that do not accelerate the tip.

    Laws of the tip bear what they feel of gravity; the rest of it, along motions that leave the tip at rest, is borne
    here.

    Attributes:
        robot: the model.
        coordinates: of the task that is left alone.
        gains: (n,) in units of acceleration.
    """

    robot: Robot
    coordinates: TaskCoordinates
    gains: Gains

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N]."""
        now = task_dynamics(self.robot, q, qd, self.coordinates)
        pull = reference.a + self.gains.kp * (reference.u - q) + self.gains.kd * (reference.v - qd)
        return now.effort(np.zeros_like(now.V), self.robot.inverse_dynamics(q, qd, pull))

    def session(self, period: float) -> Law:
        """The law itself: it has no memory."""
        return self


@of_robot
def null_space_feedback(
    robot: Robot, *, coordinates: TaskCoordinates | None = None, natural_frequency: ArrayLike = 2.0
) -> NullSpaceFeedback:
    """Joint feedback in the null space of a task; combine it with a task-space law.

    Args:
        robot: the model, with more joints than the task has coordinates.
        coordinates: of the task; all six, decoupled, if None.
        natural_frequency: w, a number or (n,), critically damped [rad/s].

    Reference: Khatib, A unified approach for motion and force control of robot manipulators, 1987.
    """
    gains = Gains.from_natural_frequency(robot.n, natural_frequency)
    return NullSpaceFeedback(robot, coordinates or TaskCoordinates(), gains)
