"""Motions of a tip as references of task-space laws: a path of the tip with a law of time, or a pose to hold."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.algebra.euler_sequence import SEQUENCES
from mafsil.arrays import PoseMatrix, require_finite, single
from mafsil.control.laws.task_angles import axes_rate, rates_of_angles
from mafsil.control.laws.task_coordinates import TWISTS, TaskAxes, TaskCoordinates, TaskTarget
from mafsil.errors import InputError
from mafsil.geometry import euler, pose
from mafsil.robot import Robot
from mafsil.trajectory import Trajectory
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
    """A pose to be held.

    Args:
        T_sd: (4, 4) in {s}.

    Raises:
        InputError: it is no pose.
    """
    target = TaskTarget(require_finite("T_sd", pose.check(T_sd, "T_sd")), np.zeros(6), np.zeros(6))
    return lambda t: target


@dataclass(frozen=True, eq=False, slots=True)
class TipOfJoints:
    """What the tip does while the joints follow a trajectory; called with a time it gives a `TaskTarget`.

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
