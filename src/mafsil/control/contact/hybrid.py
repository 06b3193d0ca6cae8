"""Hybrid motion-force control: motion along what the environment leaves free, force against what it blocks.

The certificate tells whether it did along a motion what its two parts promise: each error obeys an equation of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import (
    Floats,
    JointVector,
    PoseMatrix,
    as_batch,
    not_negative,
    real_array,
    require_finite,
    require_function,
    require_kind,
    single,
)
from mafsil.control.contact.constraint import constrained_dynamics, require_independent
from mafsil.control.contact.force import sampled_force_radius
from mafsil.control.contact.tip_sensor import TaskForceSensor
from mafsil.control.laws.feedback import Gains, RunningSum
from mafsil.control.laws.law import Law
from mafsil.control.laws.task_coordinates import TaskCoordinates, TaskDynamics, task_dynamics
from mafsil.control.laws.tip_motion import TipReference
from mafsil.errors import InputError
from mafsil.one_joint import roots
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


class HybridStatus(Status):
    """Whether both errors obeyed their equations, and whether these die out."""

    OBEYED = ("control.hybrid_obeyed", True)
    DEPARTED = ("control.hybrid_departed", False)
    UNSTABLE = ("control.hybrid_unstable", False)


@dataclass(frozen=True, eq=False, repr=False)
class HybridCertificate(Answer, data="t motion force motion_share force_share slowest_root force_radius"):
    """Residuals of the error equations of hybrid control along a motion; true if the errors obeyed stable ones.

    Attributes:
        status: OBEYED, DEPARTED or UNSTABLE.
        t: (k,) times [s].
        motion: (k - 1, m) what the equation of the motion's error lacks, within the freedoms of motion, from each time
            to the next [rad/s^2 | m/s^2].
        force: (k - 1, m) what that of the force's error lacks, along the constraint [N m | N]; zero without forces.
        motion_share, force_share: largest of each, as share of the largest acceleration that is asked for within the
            freedoms, and of the largest force.
        slowest_root: largest real part of the roots of the motion's equation [1/s].
        force_radius: factor by which the slowest force error changes from tick to tick; 0 without feedback of force.
    """

    status: HybridStatus
    t: Floats = field(repr=False)
    motion: Floats = field(repr=False)
    force: Floats = field(repr=False)
    motion_share: float
    force_share: float
    slowest_root: float
    force_radius: float

    def explain(self, language: str | None = None) -> str:
        """The status with both shares and what makes the equations stable."""
        names = ("motion_share", "force_share", "slowest_root", "force_radius")
        return self.status.sentence(language, **{name: getattr(self, name) for name in names})


def hybrid_certificate(
    law: HybridControl, t: ArrayLike, q: ArrayLike, qd: ArrayLike, wrench: ArrayLike | None = None, *,
    allowed: float = 0.05,
) -> HybridCertificate:  # fmt: skip
    """Hybrid control held against a motion: with the right model two equations hold that know nothing of each other.

        motion, within the freedoms:  dV_e/dt + Kd V_e + Kp X_e + Ki int X_e = 0
        force, along the constraint:  F_e + Kfp F_e' + Kfi int F_e' = 0, with F_e' what was read a period before

    A wrong model, efforts at their limits, friction, a surface that gives way, or a reference that does not keep the
    constraint leave a rest. The second equation is that of a rigid surface.

    Args:
        law: of the motion.
        t: (k,) times at which it was called, evenly spaced [s].
        q, qd: (k, n) measured motion, such as that of a recording.
        wrench: (k, 6) of the world on the tip in the tip frame, such as `contact_wrench` of a recording; the force's
            equation is left out if None.
        allowed: shares up to which rests count as those of the sampling.

    Raises:
        InputError: another law, a wrong shape, a number that is not finite, fewer than three times, uneven ones.

    Reference: Lynch and Park, Modern Robotics, sec. 11.6.
    """
    allowed = not_negative("allowed", allowed)
    require_kind("law", law, "HybridControl", "constraint", "force_gains")
    n = law.robot.n
    times = single("t", t, (np.size(t),))
    if len(times) < 3 or np.ptp(np.diff(times)) > 1e-6 * (times[1] - times[0]):
        raise InputError("control.uneven_times", count=len(times))
    q, qd = (as_batch(name, x, (len(times), n), finite=True) for name, x in (("q", q), ("qd", qd)))
    period = float(times[1] - times[0])
    errors = (_errors(law, *moment) for moment in zip(times.tolist(), q, qd, strict=True))
    along, X_e, V_e, ahead, F_d = (np.stack(part) for part in zip(*errors, strict=True))
    free = np.eye(along.shape[-1]) - along
    motion = _motion_rest(law.gains, period, free, X_e, V_e)
    force, force_share = np.zeros_like(motion), 0.0
    if wrench is not None:
        W = as_batch("wrench", wrench, (len(times), 6), finite=True)
        F_e = _times(along, F_d - _exert(law, q, W))
        force = _force_rest(law.force_gains, period, F_e, _times(along, F_d))
        force_share = _share(force, _times(along, F_d), F_e)
    motion_share = _share(motion, _times(free, ahead), _times(free, law.gains.kp * X_e))
    root, radius = _slowest_root(law.gains), _radius(law, period)
    status = HybridStatus.OBEYED if max(motion_share, force_share) <= allowed else HybridStatus.DEPARTED
    if not (root < 0.0 and radius < 1.0):
        status = HybridStatus.UNSTABLE
    return HybridCertificate(status, times, motion, force, motion_share, force_share, root, radius)


def _errors(law: HybridControl, t: float, q: Floats, qd: Floats) -> tuple[Floats, ...]:
    """Projection on the constraint, X_e, V_e, acceleration of the reference, and F_d."""
    task = law.coordinates
    T, V = task.pose(law.robot, q), task_dynamics(law.robot, q, qd, task).V
    A = law.constraint(T, V)[0]
    return (
        np.linalg.pinv(A) @ A,
        *task.error(T, law.reference(t), V),
        law.force(T) if callable(law.force) else law.force,
    )


def _motion_rest(gains: Gains, period: float, free: Floats, X_e: Floats, V_e: Floats) -> Floats:
    """(k - 1, m) what dV_e/dt + Kd V_e + Kp X_e + Ki int X_e is, within the freedoms."""
    X_e, V_e = _times(free, X_e), _times(free, V_e)
    stored = np.cumsum(gains.ki * period * X_e, axis=0)
    return _times(free[:-1], np.diff(V_e, axis=0) / period + (gains.kp * X_e + gains.kd * V_e + stored)[:-1])


def _force_rest(gains: Gains, period: float, F_e: Floats, F_d: Floats) -> Floats:
    """(k - 1, m) what F_e + Kfp F_e' + Kfi int F_e' is; the first reading F_e' is of a force that is zero."""
    read = np.concatenate([F_d[:1], F_e[:-1]])
    return (F_e + gains.kp * read + np.cumsum(gains.ki * period * read, axis=0))[1:]


def _share(rest: Floats, *sizes: Floats) -> float:
    """The largest rest as share of the largest of what it is held against."""
    largest = max(float(np.abs(each).max()) for each in sizes)
    return float(np.abs(rest).max()) / largest if largest > 0.0 else 0.0


def _exert(law: HybridControl, q: Floats, wrench: Floats) -> Floats:
    """(k, m) what the tip exerts, in the coordinates of the task."""
    R = law.coordinates.pose(law.robot, q)[:, :3, :3]
    both = -np.concatenate([_times(R, wrench[:, :3]), _times(R, wrench[:, 3:])], axis=-1)
    return both[:, list(law.coordinates.rows)]


def _slowest_root(gains: Gains) -> float:
    rows = np.stack([np.ones_like(gains.kp), gains.kd, gains.kp, gains.ki], axis=-1)
    return max(float(roots(row if row[-1] else row[:-1]).real.max()) for row in rows)


def _radius(law: HybridControl, period: float) -> float:
    """Of the order that is closed: without an integral F_e = -Kfp F_e', and nothing without a gain."""
    kp, step = law.force_gains.kp, law.force_gains.ki * period
    return float(np.where(step > 0.0, sampled_force_radius(kp, step), kp).max())


def _times(A: Floats, x: Floats) -> Floats:
    return (A @ x[..., None])[..., 0]
