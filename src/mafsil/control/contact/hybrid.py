"""Hybrid motion-force control: motion along what the environment leaves free, force against what it blocks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, PoseMatrix, as_batch, real_array, require_finite, require_function
from mafsil.control.contact.constraint import constrained_dynamics, require_independent
from mafsil.control.contact.tip_sensor import TaskForceSensor
from mafsil.control.laws.feedback import RunningSum
from mafsil.control.laws.gains import Gains
from mafsil.control.laws.law import Law
from mafsil.control.laws.task_coordinates import TaskCoordinates
from mafsil.control.laws.task_dynamics import TaskDynamics, task_dynamics
from mafsil.control.laws.tip_motion import TipReference
from mafsil.errors import InputError
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion

Constraint: TypeAlias = Callable[[PoseMatrix, Floats], tuple[Floats, Floats]]
"""(pose (4, 4), velocity (m,)) -> A (k, m) and dA/dt (k, m) in the coordinates of the task."""
TaskForce: TypeAlias = Callable[[PoseMatrix], Floats]
"""pose (4, 4) -> (m,) force that the tip should exert there, in the coordinates of the task."""


def constant_constraint(A: ArrayLike) -> Constraint:
    """A constraint that is the same everywhere: A V = 0.

    Args:
        A: (k, m).
    """
    rows = require_finite("A", np.atleast_2d(real_array("A", A)))
    still = np.zeros_like(rows)
    return lambda T, V: (rows, still)


@dataclass(frozen=True, eq=False, slots=True)
class HybridControl:
    """tau = J' (P Lambda (A_d + Kp X_e + Ki int X_e + Kd V_e) + (I - P) (F_d + Kfp F_e + Kfi int F_e) - bend + h).

    Motion errors obey the equation of computed torque inside the freedoms of motion, force errors
    (1 + Kfp) lambda_e + Kfi int lambda_e = 0 along the constraint; h = gamma + eta, and `bend`
    cancels what a curved constraint takes. Of X_e and V_e only what is at right angles to the rows of A counts, of F_e
    only what is along them: what a soft wall and friction add is left out.

    Attributes:
        robot: the model.
        coordinates: of the task.
        constraint: A and dA/dt.
        gains: (m,) of the motion, in units of acceleration.
        force_gains: (m,) kp and ki of the force error.
        reference: of the tip.
        force: (m,) F_d that the tip should exert, or as a function of its pose.
        sensor: what it exerts; None for the open loop of force.
    """

    robot: Robot
    coordinates: TaskCoordinates
    constraint: Constraint
    gains: Gains
    force_gains: Gains
    reference: TipReference
    force: Floats | TaskForce
    sensor: TaskForceSensor | None

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (n,) without the integral terms, which need a session [N m | N]."""
        m = len(self.coordinates.rows)
        return self.errors(t, q, qd).effort(np.zeros(m), np.zeros(m))

    def errors(self, t: float, q: JointVector, qd: JointVector) -> HybridErrors:
        """What is off at a state, from which the efforts follow.

        Args:
            t: time [s].
            q, qd: (n,) state.
        """
        now = task_dynamics(self.robot, q, qd, self.coordinates)
        T = self.coordinates.pose(self.robot, q)
        X_e, V_e, ahead = self.coordinates.error(T, self.reference(t), now.V)
        A, A_rate = self.constraint(T, now.V)
        along = np.linalg.pinv(A) @ A
        # Friction is felt across A: taken out, or its integral would grow and Lambda turn it into a force along A.
        F_d = self.force(T) if callable(self.force) else self.force
        F_e = np.zeros_like(F_d) if self.sensor is None else along @ (F_d - self.sensor(q, qd))
        return HybridErrors(self, now, A, A_rate, along, X_e, V_e, ahead, F_d, F_e)

    def session(self, period: float) -> Law:
        """The law with fresh integrals; the law itself if there are none."""
        return _WithIntegrals(self, period) if self.gains.integrates or self.force_gains.integrates else self


class _WithIntegrals:
    """One run of a hybrid law."""

    def __init__(self, law: HybridControl, period: float) -> None:
        m = len(law.coordinates.rows)
        self._law, self._period = law, period
        self._position, self._force = RunningSum(np.zeros(m)), RunningSum(np.zeros(m))

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        law = self._law
        errors = law.errors(t, q, qd)
        position = self._position.add(law.gains.ki * self._period * errors.configuration)
        return errors.effort(position, self._force.add(law.force_gains.ki * self._period * errors.force))

    def go_on(self, before: _WithIntegrals) -> None:
        self._position.go_on(before._position)
        self._force.go_on(before._force)

    def session(self, period: float) -> Law:
        return self._law.session(period)


class HybridErrors(NamedTuple):
    """Errors of a hybrid law at a state.

    Attributes:
        law: whose they are.
        now: the arm at its tip.
        A, A_rate: (k, m) the constraint.
        along: (m, m) projection on it.
        configuration, velocity, ahead: (m,) errors of the motion, and the acceleration to feed forward.
        wanted, force: (m,) force that the tip should exert, and its error.
    """

    law: HybridControl
    now: TaskDynamics
    A: Floats
    A_rate: Floats
    along: Floats
    configuration: Floats
    velocity: Floats
    ahead: Floats
    wanted: Floats
    force: Floats

    def effort(self, position_integral: Floats, force_integral: Floats) -> JointVector:
        """Efforts (n,) [N m | N].

        Args:
            position_integral, force_integral: (m,) gains times the errors' integrals.
        """
        law, now = self.law, self.now
        # A wall that gives way leaves errors along A: taken out, or Lambda would turn them into others.
        free = np.eye(len(self.along)) - self.along
        push = self.wanted + law.force_gains.kp * self.force + force_integral
        pull = law.gains.kp * self.configuration + law.gains.kd * self.velocity + position_integral
        motion = now.inertia @ (self.ahead + free @ pull)
        held = constrained_dynamics(now.inertia, np.zeros_like(motion), self.A, motion, now.V, self.A_rate)
        part = held.P @ motion + push - held.P @ push - held.curvature_force
        return now.effort(part + now.velocity_force + now.gravity_force)


@of_robot
def hybrid_control(
    robot: Robot,
    reference: TipReference,
    constraint: Constraint | ArrayLike,
    force: TaskForce | ArrayLike,
    *,
    coordinates: TaskCoordinates | None = None,
    gains: Gains | None = None,
    sensor: TaskForceSensor | None = None,
    force_kp: ArrayLike = 0.0,
    force_ki: ArrayLike = 0.0,
) -> HybridControl:
    """Hybrid control: motion along the free directions, force along the constrained ones.

    Args:
        robot: the model.
        reference: of the tip; what it asks for along the constraint is ignored.
        constraint: (k, m) A of a flat constraint, or a function that gives A and dA/dt.
        force: (m,) that the tip should exert, or a function of its pose; only its part along the constraint counts.
        coordinates: of the task; all six, decoupled, if None.
        gains: (m,) of the motion; critically damped at 20 rad/s if None.
        sensor: (q, qd) -> (m,) force that the tip exerts.
        force_kp, force_ki: of the force error, a number or (m,) [1, 1/s].

    Raises:
        InputError: a wrong shape, rows that depend on each other, a negative gain, force gains without a sensor.

    Reference: Lynch and Park, Modern Robotics, eq. (11.61); Raibert and Craig, Hybrid position/force control, 1981.
    """
    require_function("reference", reference, "function of time", 1)
    if sensor is not None:
        require_function("sensor", sensor, "function (q, qd)", 2)
    task = coordinates or TaskCoordinates()
    m = len(task.rows)
    if callable(constraint):
        held = constraint
    else:
        rows = as_batch("constraint", np.atleast_2d(real_array("constraint", constraint)), (m,), finite=True)
        require_independent(rows)
        held = constant_constraint(rows)
    force_gains = Gains.of(m, force_kp, 0.0, force_ki)
    if sensor is None and (force_gains.kp.any() or force_gains.integrates):
        raise InputError("control.no_sensor")
    motion = gains or Gains.from_natural_frequency(m, 20.0)
    F = force if callable(force) else as_batch("force", force, (m,), finite=True)
    return HybridControl(robot, task, held, motion, force_gains, reference, F, sensor)
