"""Impedance rendered with a force sensor: the tip moves as a mass, a damper and a spring under what is felt.

Admittance commands the motion that follows from the force; impedance by force commands the force that follows from the
motion, fed back with an integral.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import (
    Floats,
    JointVector,
    PoseMatrix,
    not_negative,
    number,
    positive,
    require_finite,
    require_function,
)
from mafsil.control.contact.impedance import Impedance, require_size
from mafsil.control.contact.tip_sensor import TaskForceSensor, from_outside
from mafsil.control.laws.feedback import Gains, SummingRun
from mafsil.control.laws.law import Law
from mafsil.control.laws.task_coordinates import TaskCoordinates, TaskTarget, task_dynamics
from mafsil.control.laws.tip_motion import TipReference
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion

TRACKING = 20.0
"""With which an arm is held on its virtual mass where nobody says it [rad/s]."""


@dataclass(frozen=True, eq=False, slots=True)
class AdmittanceControl:
    """Force is sensed, motion commanded: dV/dt = D^-1 (F_ext - B V_x - K X_x), tracked by computed torque.

    With a state of its own the virtual mass moves by itself, velocity first, then position, and the arm is held on it:
    what the model does not know, friction above all, is not felt. Without one each period starts from the arm: the mass
    would be at V + dt dV/dt and X + dt V one period ahead, and gains pull the arm there. What the sensor reads is
    compensated, or it would push the arm itself.

    Attributes:
        robot: the model.
        coordinates: of the task.
        impedance: that the tip should have.
        gains: (m,) of the tracking, in units of acceleration.
        reference: from which its spring is measured.
        sensor: (q, qd) -> (m,) force from outside on the tip.
        own_state: whether a session lets the virtual mass move by itself.
        shift_acceleration: whether the mass too is measured from the reference, D (dV/dt - A_d).
        period: of the control [s]; set by the session.
    """

    robot: Robot
    coordinates: TaskCoordinates
    impedance: Impedance
    gains: Gains
    reference: TipReference
    sensor: TaskForceSensor
    own_state: bool = True
    shift_acceleration: bool = False
    period: float = 0.0

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) from the state of the arm alone [N m | N]."""
        now = task_dynamics(self.robot, q, qd, self.coordinates)
        outside = self.sensor(q, qd)
        wanted = self.virtual_acceleration(t, self.coordinates.pose(self.robot, q), now.V, outside)
        return now.effort(now.force(self.commanded_acceleration(now.V, wanted)) - outside)

    def virtual_acceleration(self, t: float, T: PoseMatrix, V: Floats, outside: Floats) -> Floats:
        """(*batch, m) dV/dt of the virtual mass.

        Args:
            t: time [s].
            T, V: (*batch, 4, 4) and (*batch, m) its pose and velocity.
            outside: (*batch, m) force on it.
        """
        X_e, V_e, ahead = self.coordinates.error(T, self.reference(t), V)
        own = self.impedance.acceleration(-X_e, -V_e, outside)
        return own + ahead if self.shift_acceleration else own

    def commanded_acceleration(self, V: Floats, wanted: Floats) -> Floats:
        """(*batch, m) acceleration that computed torque is given: dV/dt + Kp dt V + Kd dt dV/dt.

        Args:
            V: (*batch, m) velocity of the tip.
            wanted: (*batch, m) dV/dt of the virtual mass.
        """
        return wanted + self.gains.kp * self.period * V + self.gains.kd * self.period * wanted

    def session(self, period: float) -> Law:
        """The law at a control period, with a virtual mass that starts where the tip is."""
        law = replace(self, period=period)
        return _VirtualMass(law) if self.own_state else law


class _VirtualMass:
    """One run of an admittance law whose mass has a state of its own."""

    def __init__(self, law: AdmittanceControl) -> None:
        self._law = law
        self._state: tuple[PoseMatrix, Floats] | None = None
        self._earlier: tuple[PoseMatrix, Floats] | None = None

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N]; then the mass moves on by a period."""
        law, task = self._law, self._law.coordinates
        now, tip = task_dynamics(law.robot, q, qd, task), task.pose(law.robot, q)
        T, V = self._state or (tip, now.V)
        # 1. What the force makes the mass do, and the arm on it.
        outside = law.sensor(q, qd)
        wanted = law.virtual_acceleration(t, T, V, outside)
        X_e, V_e, ahead = task.error(tip, TaskTarget(T, task.all_six(V), task.all_six(wanted)), now.V)
        effort = now.effort(now.force(ahead + law.gains.kp * X_e + law.gains.kd * V_e) - outside)
        # 2. Velocity first, then position with the new velocity.
        V = V + law.period * wanted
        self._earlier, self._state = self._state, (task.integrate(T, law.period * V), V)
        return effort

    def go_on(self, before: _VirtualMass) -> None:
        # The state at which two runs meet is seen by both.
        self._state = before._earlier

    def session(self, period: float) -> Law:
        """A fresh run."""
        return self._law.session(period)


@of_robot
def admittance_control(
    robot: Robot,
    impedance: Impedance,
    reference: TipReference,
    sensor: TaskForceSensor,
    *,
    coordinates: TaskCoordinates | None = None,
    gains: Gains | None = None,
    own_state: bool = True,
    shift_acceleration: bool = False,
) -> AdmittanceControl:
    """Admittance control: the tip moves as a mass, damper and spring under the measured force.

    Suited to geared, stiff arms; renders high impedances well.

    Args:
        robot: the model.
        impedance: (m) that is wanted, with a mass in every direction.
        reference: of the tip.
        sensor: a `TipForceSensor`, or a function (q, qd) -> (m,) of the force from outside on the tip.
        coordinates: of the task; all six, decoupled, if None.
        gains: (m,) of the tracking. If None: critically damped at 20 rad/s with a state of its own; none without one,
            for the state itself is the start of each step.
        own_state: the virtual mass moves by itself, and the arm is held on it; if False each period starts from the
            arm, as in the books, and gains change what is felt (`effective_admittance`).
        shift_acceleration: D (dV/dt - A_d) instead of D dV/dt, which follows a moving reference exactly.

    Raises:
        InputError: an impedance of another size or without mass.

    Reference: Lynch and Park, Modern Robotics, eq. (11.67).
    """
    require_function("reference", reference, "function of time", 1)
    require_function("sensor", sensor, "function (q, qd)", 2)
    sensor = from_outside(sensor)
    task = coordinates or TaskCoordinates()
    require_size(impedance, task)
    m = len(task.rows)
    impedance.acceleration(np.zeros(m), np.zeros(m), np.zeros(m))
    tracking = gains or (Gains.from_natural_frequency(m, TRACKING) if own_state else Gains.of(m, 0.0, 0.0))
    return AdmittanceControl(robot, task, impedance, tracking, reference, sensor, own_state, shift_acceleration)


class EffectiveImpedance(NamedTuple):
    """The effective impedance of a sampled admittance loop with imperfect tracking."""

    inertia: float
    damping: float
    stiffness: float


def effective_admittance(
    inertia: float, damping: float, stiffness: float, *, kp: float, kd: float, period: float
) -> EffectiveImpedance:
    """The impedance along one direction that tracking a period ahead makes of a wanted one.

    The command (1 + kd dt) dV/dt + kp dt V is an impedance of D/(1 + kd dt), B/(1 + kd dt) ... in which kp dt D adds to
    what drives: D_e = D/(1 + kd dt),  B_e = B - kp dt D_e,  K_e = K.

    Args:
        inertia, damping, stiffness: D, B, K that are wanted.
        kp, kd: gains of the tracking [1/s^2, 1/s].
        period: dt [s].

    Raises:
        InputError: not numbers, or not finite.
    """
    D, B, K = _numbers(inertia=inertia, damping=damping, stiffness=stiffness)
    p, d = not_negative("kp", kp), not_negative("kd", kd)
    dt = positive("period", period)
    D = D / (1.0 + d * dt)
    return EffectiveImpedance(D, B - p * dt * D, K)


def _numbers(**values: float) -> tuple[float, ...]:
    return tuple(number(name, value) for name, value in values.items())


def least_virtual_mass(damping: float, stiffness: float, period: float) -> float:
    """The smallest mass that an admittance step can render: D > B dt/2 + K dt^2/4.

    Of the semi-implicit step (velocity first, then position with the new velocity); K is all that is against the tip,
    its own spring and the environment's.

    Args:
        damping, stiffness: B, and K with the environment's [N s/m, N/m].
        period: dt [s].
    """
    dt, (B, K) = positive("period", period), _numbers(damping=damping, stiffness=stiffness)
    return B * dt / 2.0 + K * dt * dt / 4.0


def admittance_radius(
    inertia: float, damping: float, stiffness: float, period: float, *, explicit: bool = False
) -> float:
    """Spectral radius of the admittance step of a virtual mass; below one it is stable.

    Args:
        inertia, damping, stiffness: D, B, K with the environment's.
        period: dt [s].
        explicit: position by the old velocity (which needs B > K dt) instead of the new one.
    """
    D, dt = positive("inertia", inertia), positive("period", period)
    B, K = _numbers(damping=damping, stiffness=stiffness)
    a, b = dt * K / D, 1.0 - dt * B / D
    step = np.array([[1.0, dt], [-a, b]]) if explicit else np.array([[1.0 - dt * a, dt * b], [-a, b]])
    return float(np.abs(np.linalg.eigvals(require_finite("step", step))).max())


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
        return _WithIntegral(self, self.gains.ki * period, np.zeros(len(self.clamp))) if self.gains.integrates else self


class _WithIntegral(SummingRun[ImpedanceByForce]):
    """One run of an impedance by force."""

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        law = self._law
        commanded, error = law.forces(t, q, qd)
        integral = self._sum.add(self._weight * error, law.clamp)
        return law.effort(q, qd, commanded + law.gains.kp * error + integral)


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
