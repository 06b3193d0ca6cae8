"""Force control along one axis: a quasi-static PI loop, a mass that presses on a wall, and the runaway without one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats
from mafsil.one_joint.arguments import above_zero, check_batch, finite, magnitude, row, together
from mafsil.one_joint.error_dynamics import ErrorDynamics


@dataclass(frozen=True, eq=False, slots=True)
class ForceLoop:
    """F = F_d + Kfp F_e + Kfi int F_e - K_damp v, F_e = F_d - F_app, F_app the force on the environment.

    Attributes:
        kfp, kfi: (*batch) [1], [1/s].
        damping: K_damp (*batch) [N s/m]; 0 for none.
    """

    kfp: Floats
    kfi: Floats
    damping: Floats
    __post_init__ = check_batch(kfp=magnitude, kfi=magnitude, damping=magnitude)

    @classmethod
    def of(cls, kfp: ArrayLike, kfi: ArrayLike = 0.0, damping: ArrayLike = 0.0) -> ForceLoop:
        """From its gains, each a number or (*batch).

        Raises:
            InputError: a negative gain, shapes that do not go together.
        """
        return cls(*together(kfp=kfp, kfi=kfi, damping=damping))

    @property
    def time_constant(self) -> Floats:
        """(*batch) (1 + Kfp) / Kfi [s] against a rigid wall; infinite without an integral."""
        with np.errstate(divide="ignore"):
            return (1.0 + self.kfp) / self.kfi

    def quasi_static_error(self, t: ArrayLike, disturbance: ArrayLike) -> Floats:
        """F_e (*batch, k) against a rigid wall: (1 + Kfp) F_e + Kfi int F_e = -w.

        Args:
            t: (k,) [s].
            disturbance: w (*batch), constant, such as gravity that is not compensated [N].

        Returns:
            -w / (1 + Kfp) e^(-t / time constant): the integral removes it.
        """
        time, w = magnitude("t", row("t", t)), finite("disturbance", disturbance)
        p, i, w = together(kfp=self.kfp, kfi=self.kfi, disturbance=w)
        return -(w / (1.0 + p))[..., None] * np.exp(-(i / (1.0 + p))[..., None] * time)

    def free_speed(self, t: ArrayLike, wanted: ArrayLike, mass: ArrayLike, speed: ArrayLike = 0.0) -> Floats:
        """Speed (*batch, k) after contact is lost: F_app = 0, so F_e = F_d, and the mass runs away.

        m v' = (1 + Kfp) F_d + Kfi F_d t - K_damp v. With damping, v = a (1 - e^(-K t / m)) + v0 e^(-K t / m) + Kfi F_d
        t / K, a = (1 + Kfp) F_d / K - m Kfi F_d / K^2: bounded only without the integral.

        Args:
            t: (k,) [s].
            wanted: F_d (*batch) [N].
            mass: m (*batch) [kg].
            speed: v at t = 0 (*batch) [m/s].
        """
        time = magnitude("t", row("t", t))
        F, m, v0, p, i, K = (
            each[..., None]
            for each in together(
                wanted=finite("wanted", wanted), mass=above_zero("mass", mass), speed=finite("speed", speed),
                kfp=self.kfp, kfi=self.kfi, damping=self.damping,
            )
        )  # fmt: skip
        # With x = K t / m: v0 e^-x + (1 + Kfp) F t / m (1 - e^-x) / x + Kfi F t^2 / m (x - 1 + e^-x) / x^2.
        x = K * time / m
        small = x < 1e-4
        safe = np.where(small, 1.0, x)
        first = np.where(small, 1.0 - x / 2.0 + x * x / 6.0, -np.expm1(-safe) / safe)
        second = np.where(small, 0.5 - x / 6.0 + x * x / 24.0, (safe + np.expm1(-safe)) / (safe * safe))
        return v0 * np.exp(-x) + (1.0 + p) * F * time / m * first + i * F * time * time / m * second

    def late_speed(self, t: ArrayLike, wanted: ArrayLike, mass: ArrayLike) -> Floats:
        """What `free_speed` tends to with damping: ((1 + Kfp) F_d + Kfi F_d t) / K - m Kfi F_d / K^2 (*batch, k)."""
        time = row("t", t)
        F, m, p, i, K = (
            each[..., None]
            for each in together(
                wanted=finite("wanted", wanted), mass=above_zero("mass", mass), kfp=self.kfp, kfi=self.kfi,
                damping=above_zero("damping", self.damping),
            )
        )  # fmt: skip
        return ((1.0 + p) * F + i * F * time) / K - m * i * F / (K * K)

    def wall_dynamics(self, mass: ArrayLike, wall_stiffness: ArrayLike, wall_damping: ArrayLike = 0.0) -> ErrorDynamics:
        """Error dynamics of a mass in contact with a wall that yields: m x'' = F - F_app, F_app = k x + c x'.

        m F_e''' + (K_damp + (1 + Kfp) c) F_e'' + ((1 + Kfp) k + Kfi c) F_e' + Kfi k F_e = 0 up to a factor; one order
        less without the integral.

        Args:
            mass: m (*batch) [kg].
            wall_stiffness: k (*batch) [N/m].
            wall_damping: c (*batch) [N s/m].
        """
        m, k, c, p, i, K = together(
            mass=above_zero("mass", mass), wall_stiffness=above_zero("wall_stiffness", wall_stiffness),
            wall_damping=magnitude("wall_damping", wall_damping), kfp=self.kfp, kfi=self.kfi, damping=self.damping,
        )  # fmt: skip
        second, first = K + (1.0 + p) * c, (1.0 + p) * k + i * c
        if not i.any():
            return ErrorDynamics.of(m, second, first)
        return ErrorDynamics.of(m, second, first, above_zero("kfi", i) * k)
