"""Play of a gear (backlash): the link follows the motor with a gap, so that its place depends on what was before."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.one_joint.arguments import above_zero, check_batch, finite, magnitude, together


@dataclass(frozen=True, eq=False, slots=True)
class Backlash:
    """A gap between motor and link, both measured at the link.

    Attributes:
        gap: g (*batch) whole width [rad | m].
        stiffness: k (*batch) of the teeth once they touch [N m/rad | N/m].
    """

    gap: Floats
    stiffness: Floats
    __post_init__ = check_batch(gap=magnitude, stiffness=above_zero)

    @classmethod
    def of(cls, gap: ArrayLike, stiffness: ArrayLike = 1.0) -> Backlash:
        """From its numbers, each a number or (*batch).

        Raises:
            InputError: a negative gap, a stiffness that is not positive, shapes that do not go together.
        """
        return cls(*together(gap=gap, stiffness=stiffness))

    def torque(self, twist: ArrayLike) -> Floats:
        """(*batch) what passes for a twist of the motor against the link: nothing within the gap, k beyond [N m | N].

        Args:
            twist: (*batch) motor minus link [rad | m].
        """
        u = finite("twist", twist)
        return self.stiffness * np.sign(u) * np.maximum(np.abs(u) - self.gap / 2.0, 0.0)

    def link_position(self, motor: ArrayLike, start: ArrayLike | None = None) -> Floats:
        """(*batch, k) where a link with friction and without inertia stands while the motor goes its way: hysteresis.

        The link rests until a tooth touches: y_k is the place nearest to y_(k-1) within half a gap of the motor.

        Args:
            motor: (*batch, k) places of the motor in time [rad | m].
            start: (*batch) of the link before; the motor's first place if None.
        """
        u = finite("motor", motor)
        if u.ndim == 0:
            raise InputError("input.shape", name="motor", expected="(*batch, k)", got=u.shape, hint="")
        half = self.gap / 2.0
        shape = np.broadcast_shapes(u.shape[:-1], half.shape)
        y = np.empty((*shape, u.shape[-1]))
        here = np.broadcast_to(u[..., :1].sum(axis=-1) if start is None else finite("start", start), shape)
        for k in range(u.shape[-1]):
            here = np.clip(here, u[..., k] - half, u[..., k] + half)
            y[..., k] = here
        return y

    def describing_function(self, amplitude: ArrayLike) -> NDArray[np.complex128]:
        """(*batch) N(A): the first harmonic of the link over that of the motor, for a motor that swings by A.

        With z = 1 - g / A: pi Re N = pi/2 + arcsin z + z sqrt(1 - z^2), pi Im N = -(1 - z^2). Zero below A = g / 2.

        Args:
            amplitude: A (*batch) of the motor [rad | m].

        Reference: A. Gelb, W. E. Vander Velde, Multiple-input describing functions, 1968, table of hysteresis elements.
        """
        A = above_zero("amplitude", amplitude)
        z = np.clip(1.0 - self.gap / A, -1.0, 1.0)
        real = (np.pi / 2.0 + np.arcsin(z) + z * np.sqrt(1.0 - z**2)) / np.pi
        return np.asarray(real - 1j * (1.0 - z**2) / np.pi)
