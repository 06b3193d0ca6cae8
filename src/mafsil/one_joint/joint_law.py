"""Laws of one joint as numbers, the one-joint arm that they move, and the loops of the pseudo-code.

Laws are PID and its special cases, feedforward, both, computed torque. The arm is a single link with inertia, gravity
and friction: its torques, accelerations and energy. The loops are for joints that are really there: readings in,
torques out, once a period.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from math import exp
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, require_finite, require_function, require_kind, whole
from mafsil.errors import InputError
from mafsil.one_joint.drives.dry_friction import SpeedFriction
from mafsil.one_joint.error_dynamics import ErrorDynamics
from mafsil.one_joint.rows import above_zero, check_batch, finite, magnitude, together

Bias = Callable[[Floats, Floats], ArrayLike]
"""h(theta, theta'): torques (n,) besides acceleration."""
Inertia = Callable[[Floats], ArrayLike]
"""M(theta): (n, n), or (n,) if it is diagonal."""


@dataclass(frozen=True, eq=False, slots=True)
class JointArm:
    """tau = M theta'' + m g r cos(theta) + friction(theta'), theta from the horizontal, in batches.

    Attributes:
        inertia: M (*batch) about the axis [kg m^2].
        gravity_moment: m g r (*batch) [N m]; zero in a horizontal plane.
        friction: law of the speed, set-valued at rest.
    """

    inertia: Floats
    gravity_moment: Floats
    friction: SpeedFriction
    __post_init__ = check_batch(inertia=above_zero, gravity_moment=finite)

    @classmethod
    def of(
        cls,
        inertia: ArrayLike,
        mass: ArrayLike = 0.0,
        radius: ArrayLike = 0.0,
        friction: SpeedFriction | ArrayLike = 0.0,
        gravity: ArrayLike = 9.81,
    ) -> JointArm:
        """From the link.

        Args:
            inertia: M (*batch) about the axis [kg m^2].
            mass: m (*batch) [kg].
            radius: r (*batch), distance of the centre of mass from the axis [m].
            friction: a law, or a viscous coefficient (*batch) [N m s/rad].
            gravity: g (*batch) [m/s^2]; 0 for a horizontal plane.

        Raises:
            InputError: a number out of its range, shapes that do not go together.
        """
        law = friction if isinstance(friction, SpeedFriction) else SpeedFriction.viscous_only(friction)
        M, m, r, g, _ = together(
            inertia=above_zero("inertia", inertia),
            mass=magnitude("mass", mass),
            radius=finite("radius", radius),
            gravity=finite("gravity", gravity),
            friction=law.static,
        )
        return cls(M, m * g * r, law)

    @property
    def batch(self) -> tuple[int, ...]:
        """Leading dimensions."""
        return self.inertia.shape

    def bias(self, theta: ArrayLike, speed: ArrayLike, applied: ArrayLike = 0.0) -> Floats:
        """h(theta, theta') = m g r cos(theta) + friction (*batch) [N m]: what torque does besides accelerating.

        Args:
            theta: (*batch) [rad].
            speed: (*batch) [rad/s].
            applied: motor torque (*batch) [N m], which friction holds at rest as far as it can.
        """
        q, w, tau, _ = together(
            theta=finite("theta", theta), speed=finite("speed", speed), applied=finite("applied", applied),
            inertia=self.inertia,
        )  # fmt: skip
        weight = self.gravity_moment * np.cos(q)
        return weight + self.friction.torque(w, tau - weight)

    def torque(self, theta: ArrayLike, speed: ArrayLike, acceleration: ArrayLike) -> Floats:
        """Inverse dynamics (*batch) [N m]; at rest without acceleration friction is taken as zero."""
        q, a, _ = together(
            theta=finite("theta", theta), acceleration=finite("acceleration", acceleration), inertia=self.inertia
        )
        return self.inertia * a + self.bias(q, speed, self.gravity_moment * np.cos(q))

    def acceleration(self, theta: ArrayLike, speed: ArrayLike, torque: ArrayLike) -> Floats:
        """Forward dynamics (*batch) [rad/s^2]: zero at rest as long as friction holds."""
        applied = finite("torque", torque)
        return (applied - self.bias(theta, speed, applied)) / self.inertia

    def energy(self, theta: ArrayLike, speed: ArrayLike) -> Floats:
        """Kinetic and potential energy (*batch) [J], constant without friction and torque."""
        q, w, _ = together(theta=finite("theta", theta), speed=finite("speed", speed), inertia=self.inertia)
        return 0.5 * self.inertia * w * w + self.gravity_moment * np.sin(q)

    def moves_from_rest(self, theta: ArrayLike, torque: ArrayLike) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """(*batch) whether motor torque and weight overcome stiction."""
        q, tau, _ = together(theta=finite("theta", theta), torque=finite("torque", torque), inertia=self.inertia)
        load = tau - self.gravity_moment * np.cos(q)
        return np.asarray(self.friction.holds(load).verdict == 1)


class LawKind(IntEnum):
    """What the law computes."""

    FEEDBACK = 0
    FEEDFORWARD = 1
    FEEDFORWARD_FEEDBACK = 2
    COMPUTED_TORQUE = 3


NO_MODEL = JointArm.of(1.0)
"""What a law without a model carries: unit inertia, nothing else."""


@dataclass(frozen=True, eq=False, slots=True)
class JointLaw:
    """A law of one joint; e = theta_d - theta.

    FEEDBACK              tau = Kp e + Ki int e + Kd e'
    FEEDFORWARD           tau = M^ theta_d'' + h^(theta_d, theta_d')
    FEEDFORWARD_FEEDBACK  their sum
    COMPUTED_TORQUE       tau = M^ (theta_d'' + Kp e + Ki int e + Kd e') + h^(theta, theta')

    Attributes:
        kind: which of them.
        kp, ki, kd: (*batch) gains: torques per error, for computed torque accelerations per error.
        model: M^, h^; apart from the arm, so that it can be wrong.
    """

    kind: LawKind
    kp: Floats
    ki: Floats
    kd: Floats
    model: JointArm = NO_MODEL
    __post_init__ = check_batch(kp=magnitude, ki=magnitude, kd=magnitude)

    @classmethod
    def pid(cls, kp: ArrayLike = 0.0, ki: ArrayLike = 0.0, kd: ArrayLike = 0.0) -> JointLaw:
        """Feedback alone; P, I, D, PD, PI by gains of zero.

        Args:
            kp, ki, kd: (*batch) [N m/rad, N m/(rad s), N m s/rad].

        Raises:
            InputError: a negative gain, shapes that do not go together.
        """
        return cls._of(LawKind.FEEDBACK, NO_MODEL, kp, ki, kd)

    @classmethod
    def feedforward(cls, model: JointArm) -> JointLaw:
        """The torque of the reference, blind to the state: exact with a perfect model from a matching start."""
        return cls._of(LawKind.FEEDFORWARD, model)

    @classmethod
    def feedforward_pid(cls, model: JointArm, kp: ArrayLike, ki: ArrayLike = 0.0, kd: ArrayLike = 0.0) -> JointLaw:
        """Feedforward and PID added."""
        return cls._of(LawKind.FEEDFORWARD_FEEDBACK, model, kp, ki, kd)

    @classmethod
    def computed_torque(cls, model: JointArm, kp: ArrayLike, ki: ArrayLike = 0.0, kd: ArrayLike = 0.0) -> JointLaw:
        """Feedback that the model makes linear; gains are accelerations per error: divide torque gains by M."""
        return cls._of(LawKind.COMPUTED_TORQUE, model, kp, ki, kd)

    @classmethod
    def _of(
        cls, kind: LawKind, model: JointArm, kp: ArrayLike = 0.0, ki: ArrayLike = 0.0, kd: ArrayLike = 0.0
    ) -> JointLaw:
        require_kind("model", model, "JointArm", "gravity_moment", "friction")
        p, i, d = together(kp=kp, ki=ki, kd=kd)
        return cls(kind, p, i, d, model)

    @property
    def letters(self) -> NDArray[np.str_]:
        """(*batch) which terms the gains leave: "P", "PI", "PD", "PID", "I", "D", "ID", or "" for none."""
        names = np.where(self.kp > 0.0, "P", "").astype("<U3")
        names = np.char.add(names, np.where(self.ki > 0.0, "I", ""))
        return np.char.add(names, np.where(self.kd > 0.0, "D", ""))

    def error_dynamics(self, arm: JointArm) -> ErrorDynamics:
        """Linear error dynamics of the arm under this law about a set point, without gravity.

        M e'' + (b + Kd) e' + Kp e = 0, and one order more with an integral: the order that is actually closed, so gains
        Ki must be all zero or all positive. Of computed torque with an exact model, e'' + Kd e' + Kp e + Ki int e = 0.

        Args:
            arm: the true arm; only its viscous friction counts.

        Raises:
            InputError: some Ki zero and others not; a law without feedback.
        """
        require_kind("arm", arm, "JointArm", "gravity_moment", "friction")
        M, b = arm.inertia, arm.friction.viscous
        if self.kind is LawKind.COMPUTED_TORQUE:
            M, b = np.ones_like(M), np.zeros_like(b)
        terms = [M, b + self.kd, self.kp]
        if not self.ki.any():
            return ErrorDynamics.of(*terms)
        if not self.ki.all():
            raise InputError("one_joint.mixed_orders")
        return ErrorDynamics.of(*terms, self.ki)


class Desired(NamedTuple):
    """The reference at one time, each (n,) or a number."""

    theta: ArrayLike
    speed: ArrayLike = 0.0
    acceleration: ArrayLike = 0.0


class DiscreteLoop:
    """Feedback, feedforward or computed torque of n joints, in the order of the book's pseudo-code.

    Sense, difference (zero at the first reading), filter, update the integral, then use it. Units of the gains are
    those of the torque, for computed torque those of the acceleration.
    """

    def __init__(
        self,
        period: float,
        kp: ArrayLike = 0.0,
        ki: ArrayLike = 0.0,
        kd: ArrayLike = 0.0,
        *,
        inertia: Inertia | None = None,
        bias: Bias | None = None,
        feedforward: bool = False,
        filter_time: float = 0.0,
    ) -> None:
        """A loop at rest.

        Args:
            period: of the loop [s].
            kp, ki, kd: a number or (n,).
            inertia, bias: the model, both or none. With a model the loop is computed torque.
            feedforward: evaluate the model at what is wanted instead, and add the feedback as torque.
            filter_time: time constant of the filter on the differences [s].

        Raises:
            InputError: a negative gain, half a model, feedforward without a model.
        """
        self.period = float(above_zero("period", period))
        self.gains = tuple(magnitude(name, value) for name, value in (("kp", kp), ("ki", ki), ("kd", kd)))
        if (inertia is None) != (bias is None) or (feedforward and inertia is None):
            raise InputError("one_joint.half_a_model")
        if inertia is not None and bias is not None:
            require_function("inertia", inertia, "function M(theta)", 1)
            require_function("bias", bias, "function h(theta, theta')", 2)
        self.model = None if inertia is None or bias is None else (inertia, bias)
        self.feedforward = feedforward
        lag = float(magnitude("filter_time", filter_time))
        self.keep = exp(-self.period / lag) if lag else 0.0
        self.integral: Floats | float = 0.0
        self.speed: Floats | float = 0.0
        self._last: Floats | None = None

    def reset(self) -> None:
        """Forget readings and integral."""
        self.integral, self.speed, self._last = 0.0, 0.0, None

    def update(self, reading: ArrayLike, desired: Desired) -> Floats:
        """Torques (n,) for a reading of the positions (n,).

        Raises:
            InputError: a reading that is not finite or of another shape than the last one: nothing is remembered of it.
        """
        theta = finite("reading", reading)
        if self._last is not None and theta.shape != self._last.shape:
            raise InputError("input.shape", name="reading", expected=self._last.shape, got=theta.shape, hint="")
        require_kind("desired", desired, "Desired", "__len__", "__getitem__")
        if len(desired) != 3:
            raise InputError("input.shape", name="desired", expected=(3,), got=(len(desired),), hint="")
        u, v, a = (finite(f"desired[{k}]", part) for k, part in enumerate(desired))
        kp, ki, kd = self.gains
        # 1. Differences of the readings, filtered; zero at the first.
        if self._last is not None:
            self.speed = self.keep * self.speed + (1.0 - self.keep) * (theta - self._last) / self.period
        self._last = theta.copy()
        # 2. The integral, updated before it is used.
        e = u - theta
        self.integral = self.integral + e * self.period
        feedback = kp * e + ki * self.integral + kd * (v - self.speed)
        # 3. Torque.
        if self.model is None:
            return np.asarray(feedback)
        if self.feedforward:
            still = np.zeros_like(theta)
            return feedback + self._model(u + still, v + still, a + still)
        return self._model(theta, np.asarray(self.speed + np.zeros_like(theta)), a + feedback)

    def _model(self, theta: Floats, speed: Floats, acceleration: Floats) -> Floats:
        assert self.model is not None
        M, h = (np.asarray(each, dtype=np.float64) for each in (self.model[0](theta), self.model[1](theta, speed)))
        product = M @ acceleration if M.ndim == 2 else M * acceleration
        return require_finite("model", product + h)


def run_loop(
    loop: DiscreteLoop,
    sense: Callable[[], ArrayLike],
    command: Callable[[Floats], object],
    desired: Callable[[float], Desired],
    ticks: int,
) -> None:
    """Sense, update, command, `ticks` times; waiting for the next period is up to `command` or `sense`.

    Args:
        loop: the law with its memory.
        sense: gives the positions (n,) [rad | m].
        command: takes the torques (n,) [N m | N].
        desired: of time [s].
        ticks: how many.

    Raises:
        InputError: a callback that cannot be called so, or a reading that is not finite: no torque follows it.
    """
    require_kind("loop", loop, "DiscreteLoop", "update", "period")
    for name, function, count in (("sense", sense, 0), ("command", command, 1), ("desired", desired, 1)):
        require_function(name, function, f"function of {count} arguments", count)
    for k in range(whole("ticks", ticks)):
        command(loop.update(sense(), desired(k * loop.period)))
