"""Laws of one joint as numbers: PID and its special cases, feedforward, both, computed torque.

The one-joint arm: inertia, gravity and friction of a single link; its torques, accelerations and energy.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, require_kind
from mafsil.errors import InputError
from mafsil.one_joint.arguments import above_zero, check_batch, finite, magnitude, together
from mafsil.one_joint.drives.dry_friction import SpeedFriction
from mafsil.one_joint.error_dynamics import ErrorDynamics


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
