"""Motions of a tip as references of task-space laws: a path of the tip with a law of time, or a pose to hold.

Computed torque in task space: the error of the tip obeys linear equations.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.algebra.euler_sequence import SEQUENCES
from mafsil.arrays import Floats, JointVector, PoseMatrix, require_finite, require_function, require_kind, single
from mafsil.control.laws.feedback import Gains, SummingRun
from mafsil.control.laws.law import Law
from mafsil.control.laws.task_coordinates import (
    TWISTS,
    TaskAxes,
    TaskCoordinates,
    TaskTarget,
    axes_rate,
    rates_of_angles,
    task_dynamics,
)
from mafsil.errors import InputError
from mafsil.geometry import euler, pose
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion, Trajectory
from mafsil.trajectory.paths import TipPath

TipReference: TypeAlias = Callable[[float], TaskTarget]
"""What the tip should do at a time [s]: pose, and velocity and acceleration in the axes of the task."""


@dataclass(frozen=True, eq=False, slots=True)
class TipMotion:
    """A path of the tip run by a law of time; called with a time it gives a `TaskTarget`.

    Attributes:
        path: of the tip, over s in 0 .. 1.
        law: s over time, one coordinate.
        axes: of the velocities and accelerations.
    """

    path: TipPath
    law: Trajectory
    axes: TaskAxes = "decoupled"

    def __call__(self, t: float) -> TaskTarget:
        """The target at a time [s]: V = V_s s',  dV/dt = V_s' s'^2 + V_s s''."""
        s, rate, growth = (float(part[..., 0]) for part in self.law.at(t))
        T = self.path.poses(s)
        V, slope = self.path.twists(s)
        return target_in_axes(T, V * rate, slope * rate**2 + V * growth, self.axes)


def hold_pose(T_sd: ArrayLike) -> TipReference:
    """The target of a tip that holds a pose.

    Args:
        T_sd: (4, 4) in {s}.

    Raises:
        InputError: it is no pose.
    """
    target = TaskTarget(require_finite("T_sd", pose.check(T_sd, "T_sd")), np.zeros(6), np.zeros(6))
    return lambda t: target


@dataclass(frozen=True, eq=False, slots=True)
class TipOfJoints:
    """The motion of the tip while the joints follow a trajectory; called with a time it gives a `TaskTarget`.

    V = J(u) v,  dV/dt = J(u) a + dJ/dt(u, v) v, with decoupled axes.

    The last answer is kept: the parts of a law ask for the same time again and again.

    Attributes:
        robot: whose tip it is.
        trajectory: of its joints.
    """

    robot: Robot
    trajectory: Trajectory
    _kept: list[tuple[float, TaskTarget]] = field(
        default_factory=list[tuple[float, TaskTarget]], init=False, repr=False
    )

    def __call__(self, t: float) -> TaskTarget:
        """The target at a time [s]."""
        for time, known in self._kept:
            if time == t:
                return known
        found = self._target(t)
        self._kept[:] = [(t, found)]
        return found

    def _target(self, t: float) -> TaskTarget:
        u, v, a = self.trajectory.at(t)
        task = TaskCoordinates()
        J, rate = task.jacobian(self.robot, u), task.jacobian_rate(self.robot, u, v)
        return TaskTarget(self.robot.forward_kinematics(u), J @ v, J @ a + rate @ v)


def target_in_axes(T: PoseMatrix, V: ArrayLike, A: ArrayLike, axes: TaskAxes) -> TaskTarget:
    """A target from a pose, a body twist and its derivative.

    Args:
        T: (4, 4) pose.
        V, A: (6,) body twist and its derivative.
        axes: in which velocity and acceleration are wanted.
    """
    T, V, A = single("T", T, (4, 4)), single("V", V, (6,)), single("A", A, (6,))
    if axes not in (*TWISTS, *SEQUENCES):
        raise InputError("input.choice", name="axes", value=axes, known=", ".join((*TWISTS, *SEQUENCES)))
    if axes == "body":
        return TaskTarget(T, V, A)
    if axes == "space":
        Ad = pose.adjoint(T)
        return TaskTarget(T, Ad @ V, Ad @ A)
    R = T[:3, :3]
    omega, alpha = R @ V[:3], R @ A[:3]
    if axes in SEQUENCES:
        angles = euler.to_euler(R, axes)
        back = rates_of_angles(angles, axes)
        omega = back @ omega
        alpha = back @ (alpha - axes_rate(angles, omega, axes) @ omega)
    bend = A[3:] + np.cross(V[:3], V[3:])
    return TaskTarget(T, np.concatenate([omega, R @ V[3:]]), np.concatenate([alpha, R @ bend]))


@dataclass(frozen=True, eq=False, slots=True)
class TaskComputedTorque:
    """tau = J' (Lambda (A_d + Kp X_e + Ki int X_e + Kd V_e) + gamma + eta) + N tau_0.

    The error obeys V_e' + Kd V_e + Kp X_e + Ki int X_e = 0: exactly for positions, to first order in X_e for rotations.
    A redundant arm's null space is damped and drawn to the joints' reference.

    Attributes:
        robot: the model; it may differ from the plant.
        coordinates: of the task.
        gains: (m,) in units of acceleration.
        reference: of the tip.
        rest_gains: (n,) gains of the joints' reference in the null space [1/s^2, 1/s], as efforts by M.
    """

    robot: Robot
    coordinates: TaskCoordinates
    gains: Gains
    reference: TipReference
    rest_gains: Gains

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) without the integral term, which needs a session [N m | N]."""
        return self.effort(t, q, qd, reference, np.zeros(len(self.gains.kp)))[0]

    def effort(
        self, t: float, q: JointVector, qd: JointVector, reference: Motion, more: Floats
    ) -> tuple[JointVector, Floats]:
        """Efforts (*batch, n), and the configuration error (*batch, m).

        Args:
            t: time [s].
            q, qd: (*batch, n) state.
            reference: of the joints, for the null space.
            more: (*batch, m) acceleration that is added.
        """
        now = task_dynamics(self.robot, q, qd, self.coordinates)
        X_e, V_e, ahead = self.coordinates.error(self.coordinates.pose(self.robot, q), self.reference(t), now.V)
        force = now.force(ahead + self.gains.kp * X_e + self.gains.kd * V_e + more)
        if self.robot.n == len(self.coordinates.rows):
            return now.effort(force), X_e
        pull = reference.a + self.rest_gains.kp * (reference.u - q) + self.rest_gains.kd * (reference.v - qd)
        return now.effort(force, self.robot.inverse_dynamics(q, qd, pull)), X_e

    def session(self, period: float) -> Law:
        """The law with a fresh integral; the law itself if Ki is zero."""
        if not self.gains.integrates:
            return self
        return _WithIntegral(self, self.gains.ki * period, np.zeros(len(self.coordinates.rows)))


class _WithIntegral(SummingRun[TaskComputedTorque]):
    """One run of a task-space law."""

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        X_e = self._law.effort(t, q, qd, reference, self._sum.value)[1]
        return self._law.effort(t, q, qd, reference, self._sum.add(self._weight * X_e))[0]


@of_robot
def task_computed_torque(
    robot: Robot,
    reference: TipReference,
    *,
    coordinates: TaskCoordinates | None = None,
    natural_frequency: ArrayLike = 20.0,
    damping_ratio: ArrayLike = 1.0,
    integral: ArrayLike = 0.0,
    rest_frequency: float = 2.0,
) -> TaskComputedTorque:
    """Computed torque of the tip, with gains by natural frequency and damping.

    Args:
        robot: the model.
        reference: of the tip, such as a `TipMotion` or `hold(T_sd)`; its velocities in the axes of the coordinates.
        coordinates: of the task; all six, decoupled, if None.
        natural_frequency: w, a number or (m,) [rad/s].
        damping_ratio: zeta, a number or (m,).
        integral: Ki, a number or (m,) [1/s^3]; below 2 zeta w^3.
        rest_frequency: of what a redundant arm does beside the task, critically damped [rad/s].

    Raises:
        InputError: a wrong shape, a negative number, an integral gain that makes the loop unstable.

    Reference: Lynch and Park, Modern Robotics, eq. (11.47); Khatib 1987.
    """
    require_function("reference", reference, "function of time", 1)
    require_kind("robot", robot, "Robot", "mass_matrix")
    task = coordinates or TaskCoordinates()
    gains = Gains.from_natural_frequency(len(task.rows), natural_frequency, damping_ratio, integral)
    return TaskComputedTorque(robot, task, gains, reference, Gains.from_natural_frequency(robot.n, rest_frequency))
