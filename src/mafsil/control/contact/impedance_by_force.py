"""Impedance rendered through its force: what the tip should exert is fed back from a force sensor, with an integral."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, not_negative, require_function
from mafsil.control.contact.impedance import Impedance, require_size
from mafsil.control.contact.tip_sensor import TaskForceSensor, from_outside
from mafsil.control.laws.feedback import RunningSum
from mafsil.control.laws.gains import Gains
from mafsil.control.laws.law import Law
from mafsil.control.laws.task_coordinates import TaskCoordinates
from mafsil.control.laws.task_dynamics import task_dynamics
from mafsil.control.laws.tip_motion import TipReference
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion


@dataclass(frozen=True, eq=False, slots=True)
class ImpedanceByForce:
    """tau = J' (Lambda dV/dt + gamma + eta + F_cmd + Kfp F_e + Kfi int F_e),  F_cmd = -(D dV/dt + B V_x + K X_x).

    F_e = F_cmd - F_app is what the force that the tip exerts lacks. With the error w of the model's forces it obeys
    (1 + Kfp) F_e + Kfi int F_e = -w, so that the wanted impedance is felt although the model is wrong. Without a
    measured acceleration Lambda dV/dt and D are left out: the arm's inertia counts as part of w.

    Attributes:
        robot: the model.
        coordinates: of the task.
        impedance: that the tip should have.
        reference: from which its spring is measured.
        sensor: (q, qd) -> (m,) force from outside on the tip, -F_app.
        gains: (m,) Kfp and Kfi, as kp and ki.
        acceleration: (q, qd) -> (m,) measured dV/dt, or None.
        clamp: (m,) largest magnitude of the integral term.
    """

    robot: Robot
    coordinates: TaskCoordinates
    impedance: Impedance
    reference: TipReference
    sensor: TaskForceSensor
    gains: Gains
    acceleration: TaskForceSensor | None
    clamp: Floats

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) without the integral term, which needs a session [N m | N]."""
        commanded, error = self.forces(t, q, qd)
        return self.effort(q, qd, commanded + self.gains.kp * error)

    def forces(self, t: float, q: JointVector, qd: JointVector) -> tuple[Floats, Floats]:
        """F_cmd and F_e, (*batch, m) each: what the tip should exert, and what it lacks.

        Args:
            t: time [s].
            q, qd: (*batch, n) state.
        """
        J, wanted = self.coordinates.jacobian(self.robot, q), self.impedance
        V = (J @ qd[..., None])[..., 0]
        X_e, V_e, _ = self.coordinates.error(self.coordinates.pose(self.robot, q), self.reference(t), V)
        commanded = X_e @ wanted.stiffness + V_e @ wanted.damping
        if self.acceleration is not None:
            commanded = commanded - self.acceleration(q, qd) @ wanted.inertia
        return commanded, commanded + self.sensor(q, qd)

    def effort(self, q: JointVector, qd: JointVector, force: Floats) -> JointVector:
        """Efforts (*batch, n) that exert a force [N m | N].

        Args:
            q, qd: (*batch, n) state.
            force: (*batch, m) in the coordinates of the task.
        """
        now = task_dynamics(self.robot, q, qd, self.coordinates)
        moving = 0.0 * force if self.acceleration is None else self.acceleration(q, qd)
        return now.effort(now.force(moving) + force)

    def session(self, period: float) -> Law:
        """The law with a fresh integral; the law itself if Kfi is zero."""
        return _WithIntegral(self, period) if self.gains.integrates else self


class _WithIntegral:
    """One run of an impedance by force."""

    def __init__(self, law: ImpedanceByForce, period: float) -> None:
        self._law, self._weight = law, law.gains.ki * period
        self._sum = RunningSum(np.zeros(len(law.clamp)))

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        law = self._law
        commanded, error = law.forces(t, q, qd)
        integral = self._sum.add(self._weight * error, law.clamp)
        return law.effort(q, qd, commanded + law.gains.kp * error + integral)

    def go_on(self, before: _WithIntegral) -> None:
        self._sum.go_on(before._sum)

    def session(self, period: float) -> Law:
        return self._law.session(period)


@of_robot
def impedance_by_force(
    robot: Robot,
    impedance: Impedance,
    reference: TipReference,
    sensor: TaskForceSensor,
    *,
    kp: ArrayLike = 0.0,
    ki: ArrayLike = 0.0,
    coordinates: TaskCoordinates | None = None,
    acceleration: TaskForceSensor | None = None,
    clamp: float = np.inf,
) -> ImpedanceByForce:
    """Impedance control with force feedback, exact despite errors of the model.

    Args:
        robot: the model.
        impedance: (m) that is wanted; its inertia needs an acceleration.
        reference: of the tip.
        sensor: a `TipForceSensor`, or a function (q, qd) -> (m,) of the force from outside on the tip.
        kp, ki: of the force error, a number or (m,) [1, 1/s].
        coordinates: of the task; all six, decoupled, if None.
        acceleration: (q, qd) -> (m,) measured dV/dt, as of an accelerometer at the tip.
        clamp: largest magnitude of the integral term: in the free it is what pulls the tip to its reference.

    Raises:
        InputError: an impedance of another size, a negative gain.

    Reference: Lynch and Park, Modern Robotics, sec. 11.7.1.
    """
    clamp = not_negative("clamp", clamp, unbounded=True)
    task = coordinates or TaskCoordinates()
    require_size(impedance, task)
    require_function("reference", reference, "function of time", 1)
    require_function("sensor", sensor, "function (q, qd)", 2)
    sensor = from_outside(sensor)
    if acceleration is not None:
        require_function("acceleration", acceleration, "function (q, qd)", 2)
    m = len(task.rows)
    gains = Gains.of(m, kp, 0.0, ki)
    return ImpedanceByForce(robot, task, impedance, reference, sensor, gains, acceleration, np.full(m, float(clamp)))
