"""The one-joint arm: inertia, gravity and friction of a single link; its torques, accelerations and energy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats
from mafsil.one_joint.arguments import above_zero, check_batch, finite, magnitude, together
from mafsil.one_joint.drives.dry_friction import SpeedFriction


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
