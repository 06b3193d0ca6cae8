"""Laws of arms with elastic joints: motors held by springs of software, fast damping, exact linearisation.

An arm whose motors drive its links through springs: motors and links move each for themselves.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, frozen, positive, real_array, require_finite, require_kind, whole
from mafsil.control.laws.feedback import Gains
from mafsil.control.laws.law import Law, LawFunction, as_law
from mafsil.errors import InputError
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion, Trajectory

STENCIL = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
FIRST = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / 12.0
SECOND = np.array([-1.0, 16.0, -30.0, 16.0, -1.0]) / 12.0
"""Differences of fourth order for the first and second derivative."""
APART = 4e-3
"""Of the stencil's points [s]."""
ANGLE = 1e-5
"""Step of the differences of gravity [rad | m]."""
RANGE = np.pi
"""To which unlimited joints are sampled [rad]."""


class ElasticLaw(Protocol):
    """Maps time, the state of motors and links, and a reference of the links to efforts of the motors."""

    def __call__(self, t: float, state: ElasticState, reference: Motion) -> JointVector:
        """(*batch, n) at the joint [N m | N]."""
        ...

    def session(self, period: float) -> ElasticLaw:
        """The law with fresh memory, to be called once every `period` [s]."""
        ...


@dataclass(frozen=True, eq=False, slots=True)
class MotorFeedback:
    """tau = Kp (u + g(u) / K - motor) - Kd motor' + g(u): PD of the motors alone, with the gravity of the goal.

    Attributes:
        arm: the model.
        gains: of the motors, at the joint.
    """

    arm: ElasticArm
    gains: Gains

    def __call__(self, t: float, state: ElasticState, reference: Motion) -> JointVector:
        """Efforts (*batch, n) [N m | N]."""
        g = self.arm.links.gravity_torque(reference.u)
        goal = reference.u + g / self.arm.stiffness
        return self.gains.kp * (goal - state.motor) - self.gains.kd * state.motor_rate + g

    def session(self, period: float) -> ElasticLaw:
        """The law itself: it has no memory."""
        return self


def motor_feedback(arm: ElasticArm, kp: ArrayLike, kd: ArrayLike) -> MotorFeedback:
    """PD of the motors with the gravity of the goal: reaches set points without a sensor at the links.

    Args:
        arm: the model.
        kp, kd: a number or (n,) [N m/rad | N/m], per (rad/s | m/s).

    Raises:
        InputError: a wrong shape, a negative gain.

    Reference: Tomei, A simple PD controller for robots with elastic joints, IEEE Trans. Automatic Control 36(10), 1991.
    """
    require_kind("arm", arm, "ElasticArm", "links", "stiffness")
    return MotorFeedback(arm, Gains.of(arm.n, kp, kd))


class SetPointStatus(Status):
    """Whether every set point is reached from everywhere."""

    GLOBAL = ("control.elastic_set_point_global", True)
    NOT_SHOWN = ("control.elastic_set_point_not_shown", False)


@dataclass(frozen=True, eq=False, repr=False)
class SetPointCondition(Answer, data="stiffness gravity samples"):
    """Whether springs of joints and software outweigh gravity; true if every set point is then reached.

    Attributes:
        status: GLOBAL or NOT_SHOWN: the condition is sufficient, not necessary.
        stiffness: least eigenvalue of [[K, -K], [-K, K + Kp]] [N m/rad | N/m].
        gravity: largest norm of dg/dq over the configurations that were looked at [N m/rad | N/m].
        samples: how many these are.
    """

    status: SetPointStatus
    stiffness: float
    gravity: float
    samples: int

    def explain(self, language: str | None = None) -> str:
        """Both figures."""
        details = {"stiffness": self.stiffness, "gravity": self.gravity, "samples": self.samples}
        return self.status.sentence(language, **details)


def set_point_condition(law: MotorFeedback, samples: int = 2000, *, seed: int = 0) -> SetPointCondition:
    """Tomei's condition: the least stiffness of joints and law exceeds the steepest gravity.

    Args:
        law: of `motor_feedback`.
        samples: random configurations within the limits, at which gravity is differenced.
        seed: of these.

    Raises:
        InputError: another law, not a whole number of samples.
    """
    require_kind("law", law, "MotorFeedback", "arm", "gains")
    count, arm = whole("samples", samples, least=1), law.arm
    low, high = (np.clip(side, -RANGE, RANGE) for side in (arm.links.limits.lower, arm.links.limits.upper))
    q = np.random.default_rng(seed).uniform(low, high, (count, 1, arm.n))
    aside = ANGLE * np.eye(arm.n)
    slope = (arm.links.gravity_torque(q + aside) - arm.links.gravity_torque(q - aside)) / (2.0 * ANGLE)
    steepest = float(np.linalg.norm(slope, ord=2, axis=(-2, -1)).max())
    K, P = np.diag(arm.stiffness), np.diag(law.gains.kp)
    least = float(np.linalg.eigvalsh(np.block([[K, -K], [-K, K + P]]))[0])
    status = SetPointStatus.GLOBAL if least > steepest else SetPointStatus.NOT_SHOWN
    return SetPointCondition(status, least, steepest, count)


@dataclass(frozen=True, eq=False, slots=True)
class SingularPerturbationControl:
    """tau = law(q, qd) + Kv (qd - motor'): a law for the rigid arm, and damping of the springs (singular perturbation).

    Attributes:
        law: of the rigid arm, rotors included.
        damping: (n,) Kv [N m s/rad | N s/m].
    """

    law: Law
    damping: Floats

    def __call__(self, t: float, state: ElasticState, reference: Motion) -> JointVector:
        """Efforts (*batch, n) [N m | N]."""
        slow = self.law(t, state.q, state.qd, reference)
        return slow + self.damping * (state.qd - state.motor_rate)

    def session(self, period: float) -> ElasticLaw:
        """The law with a fresh session of the rigid one."""
        return SingularPerturbationControl(self.law.session(period), self.damping)


def singular_perturbation_control(
    arm: ElasticArm, law: Law | LawFunction, damping: ArrayLike
) -> SingularPerturbationControl:
    """Singular perturbation control: a rigid-joint law on stiff elastic joints, with damping of their springs.

    Args:
        arm: the model.
        law: of the rigid arm, such as `computed_torque(robot)`.
        damping: Kv, a number or (n,) [N m s/rad | N s/m]; about sqrt(K B) damps the motors well.

    Raises:
        InputError: a wrong shape, a negative number, no law.

    Reference: Spong, Khorasani and Kokotovic, An integral manifold approach to the feedback control of flexible joint
        robots, IEEE J. Robotics and Automation 3(4), 1987.
    """
    require_kind("arm", arm, "ElasticArm", "links", "stiffness")
    return SingularPerturbationControl(as_law(law), Gains.of(arm.n, 0.0, damping).kd)


@dataclass(frozen=True, eq=False, slots=True)
class ElasticLinearization:
    """The motors make the links obey e'''' + 4 p e''' + 6 p^2 e'' + 4 p^3 e' + p^4 e = 0: all four roots at -p.

    Algorithm, with h = M qdd + c + g, the model's efforts along a curve of q:
        1. Acceleration of the links from the springs; jerk from K (motor' - qd) = dh/dt.
        2. Wanted fourth derivative from the reference and the errors of all derivatives below.
        3. Along the curve with these derivatives tau = B (qdd + h''/K) + h. Derivatives of h are five-point
           differences, of relative error about 1e-8.

    Attributes:
        arm: the model, without damping of its springs.
        trajectory: of the links; continuous in its jerk.
        rate: p [1/s].
    """

    arm: ElasticArm
    trajectory: Trajectory
    rate: float

    def __call__(self, t: float, state: ElasticState, reference: Motion) -> JointVector:
        """Efforts (*batch, n) [N m | N]."""
        arm, q, qd = self.arm, state.q, state.qd
        # 1
        f = arm.spring_effort(state)
        qdd = arm.links.forward_dynamics(q, qd, f)
        still = np.zeros_like(qdd)
        slope = arm.stiffness * (state.motor_rate - qd) - self._derivative(FIRST, q, qd, qdd, still, still) / APART
        jerk = np.asarray(np.linalg.solve(arm.links.mass_matrix(q), slope[..., None])[..., 0], dtype=np.float64)
        # 2
        wanted, p = self._reference(t), self.rate
        weights = (p**4, 4.0 * p**3, 6.0 * p**2, 4.0 * p)
        own = (q, qd, qdd, jerk)
        snap = wanted[4] + sum(w * (x - y) for w, x, y in zip(weights, wanted, own, strict=False))
        # 3
        bend = self._derivative(SECOND, q, qd, qdd, jerk, snap) / APART**2
        return arm.motor_inertia * (qdd + bend / arm.stiffness) + f

    def session(self, period: float) -> ElasticLaw:
        """The law itself: it has no memory."""
        return self

    def _derivative(self, rule: Floats, q: Floats, qd: Floats, qdd: Floats, jerk: Floats, snap: Floats) -> Floats:
        """A difference of h along the curve of q with these derivatives."""
        s = APART * STENCIL.reshape(-1, *np.ones(np.ndim(qdd), dtype=int))
        place = q + s * (qd + s / 2.0 * (qdd + s / 3.0 * (jerk + s / 4.0 * snap)))
        speed = qd + s * (qdd + s / 2.0 * (jerk + s / 3.0 * snap))
        growth = qdd + s * (jerk + s / 2.0 * snap)
        return np.asarray(np.tensordot(rule, self.arm.links.inverse_dynamics(place, speed, growth), axes=1))

    def _reference(self, t: float) -> tuple[Floats, ...]:
        """Position and four derivatives (n,); jerk and its rate from differences of the acceleration."""
        now, rows = self.trajectory.at(t), self.trajectory.at(t + APART * STENCIL).a
        return now.u, now.v, now.a, FIRST @ rows / APART, SECOND @ rows / APART**2


def elastic_linearization(arm: ElasticArm, trajectory: Trajectory, *, rate: float = 20.0) -> ElasticLinearization:
    """Exact linearisation of an arm with elastic joints: its links follow as four integrators would.

    Args:
        arm: the model, without damping of its springs.
        trajectory: of the links; continuous in its jerk, or the error is set off anew where it jumps.
        rate: p [1/s].

    Raises:
        InputError: springs with damping, another number of joints, a rate that is not positive.

    Reference: Spong, Modeling and control of elastic joint robots, J. Dyn. Syst. Meas. Control 109, 1987.
    """
    require_kind("arm", arm, "ElasticArm", "links", "stiffness")
    require_kind("trajectory", trajectory, "Trajectory", "at", "n")
    positive("rate", rate)
    if arm.damping.any():
        raise InputError("control.damped_springs", value=float(arm.damping.max()))
    if trajectory.n != arm.n:
        details = {"expected": f"n = {arm.n}", "got": f"n = {trajectory.n}", "hint": ""}
        raise InputError("input.shape", name="trajectory", **details)
    return ElasticLinearization(arm, trajectory, float(rate))


class ElasticState(NamedTuple):
    """Positions and rates of links and motors, all at the joint: motor angles are divided by the gear ratio.

    Attributes:
        q, qd: (*batch, n) of the links [rad | m] and per second.
        motor, motor_rate: (*batch, n) of the motors, in the same units.
    """

    q: JointVector
    qd: JointVector
    motor: JointVector
    motor_rate: JointVector


@dataclass(frozen=True, eq=False, slots=True)
class ElasticArm:
    """M(q) qdd + c(q, qd) + g(q) = f,  B motor'' + f = tau,  f = K (motor - q) + D (motor' - qd).

    The rotors turn about their own axes only: gear ratios are high (Spong 1987).

    Attributes:
        links: the arm without its rotors.
        motor_inertia: (n,) B at the joint [kg m^2 | kg].
        stiffness, damping: (n,) K and D of the transmissions [N m/rad | N/m], times a second.
    """

    links: Robot
    motor_inertia: Floats
    stiffness: Floats
    damping: Floats

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.links.n

    def spring_effort(self, state: ElasticState) -> JointVector:
        """f (*batch, n) that the springs exert on the links [N m | N]."""
        return self.stiffness * (state.motor - state.q) + self.damping * (state.motor_rate - state.qd)

    def accelerations(self, state: ElasticState, tau: ArrayLike) -> tuple[JointVector, JointVector]:
        """(*batch, n) of the links and of the motors.

        Args:
            state: where they are.
            tau: (*batch, n) efforts of the motors at the joint [N m | N].
        """
        f = self.spring_effort(state)
        return self.links.forward_dynamics(state.q, state.qd, f), (np.asarray(tau) - f) / self.motor_inertia

    def energy(self, state: ElasticState) -> Floats:
        """(*batch) kinetic and potential energy of links, motors and springs [J]."""
        links = self.links.kinetic_energy(state.q, state.qd) + self.links.potential_energy(state.q)
        motors = 0.5 * (self.motor_inertia * state.motor_rate**2).sum(axis=-1)
        return links + motors + 0.5 * (self.stiffness * (state.motor - state.q) ** 2).sum(axis=-1)

    def at_rest(self, q: ArrayLike) -> ElasticState:
        """Links at rest at q (*batch, n), the motors ahead by what gravity winds up the springs."""
        places = require_finite("q", real_array("q", q))
        still = np.zeros_like(places)
        return ElasticState(places, still, places + self.links.gravity_torque(places) / self.stiffness, still)


@of_robot
def elastic_arm(
    robot: Robot, stiffness: ArrayLike, *, damping: ArrayLike = 0.0, motor_inertia: ArrayLike | None = None
) -> ElasticArm:
    """An arm with springs between its motors and its links.

    Args:
        robot: its model.
        stiffness: of each transmission, seen at the joint, a number or (n,) [N m/rad | N/m].
        damping: of each transmission, a number or (n,) [N m s/rad | N s/m].
        motor_inertia: at the joint, a number or (n,); G^2 I_m of the model's rotors if None [kg m^2 | kg].

    Raises:
        InputError: a wrong shape, a stiffness or motor inertia that is not positive.
        ModelError: the robot has no masses.

    Reference: Spong, Modeling and control of elastic joint robots, J. Dyn. Syst. Meas. Control 109, 1987.
    """
    joints = robot.mechanism.coordinates
    rotors = [0.0 if joint.actuator is None else joint.actuator.reflected_inertia for joint in joints]
    B = _row("motor_inertia", np.array(rotors) if motor_inertia is None else motor_inertia, robot.n, positive=True)
    bare = tuple(replace(joint, actuator=None) for joint in robot.mechanism.joints)
    links = Robot(replace(robot.mechanism, joints=bare))
    K, D = _row("stiffness", stiffness, robot.n, positive=True), _row("damping", damping, robot.n, positive=False)
    return ElasticArm(links, B, K, D)


def _row(name: str, value: ArrayLike, n: int, *, positive: bool) -> Floats:
    array = require_finite(name, real_array(name, value))
    if array.shape not in ((), (1,), (n,)):
        raise InputError("input.shape", name=name, expected=(n,), got=array.shape, hint="")
    if positive and not (array > 0.0).all():
        raise InputError("input.positive", name=name, value=float(array.min()))
    if not (array >= 0.0).all():
        raise InputError("input.range", name=name, value=float(array.min()), low=0.0, high=np.inf)
    return frozen(np.broadcast_to(array, (n,)))
