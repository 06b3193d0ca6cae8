"""Time laws by name. A law is one row of `LAWS`: adding one is a row, and its name in `LawName`.

What its peaks are follows from the row, and everything that takes a law by its name (Cartesian lines, the moves of a
job, the table of `profiles`) knows it.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Literal, TypeAlias

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.trajectory.profiles.polynomial_law import PolynomialLaw as PolynomialLaw
from mafsil.trajectory.profiles.shaped_law import ExponentialApproach, Harmonic, Pieces, ShapedLaw
from mafsil.trajectory.profiles.time_law import TimeLaw as TimeLaw
from mafsil.trajectory.profiles.trapezoid import trapezoid
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial

LawName: TypeAlias = Literal["cubic", "quintic", "septic", "cosine", "cycloid", "trapezoid", "double_s", "bang_bang"]
"""Laws from rest to rest, whose speed does not jump."""
ProfileName: TypeAlias = LawName | Literal["exponential"]
"""All of them."""


@dataclass(frozen=True)
class TrapezoidLaw:
    """Constant acceleration, constant speed, constant deceleration.

    Attributes:
        blend: share of the duration that each blend takes where no limits shape it.
    """

    blend: float = 0.25

    @property
    def peaks(self) -> tuple[float, float, float]:
        """Largest |ds/dx| and |d2s/dx2| of the unit motion; between its jumps of acceleration it has no jerk."""
        return 1.0 / (1.0 - self.blend), 1.0 / (self.blend * (1.0 - self.blend)), 0.0

    def unit(self) -> PiecewisePolynomial:
        """s(t) from 0 to 1 within one second."""
        return trapezoid(0.0, 1.0, acceleration=self.peaks[1], duration=1.0).value

    def between(self, start: Floats, goal: Floats, duration: float) -> PiecewisePolynomial:
        """The motion from `start` to `goal` (*batch, n) that takes `duration` [s], in the shape of the unit motion."""
        way, unit = np.asarray(goal - start), self.unit()
        coefficients = unit.coefficients.reshape(unit.coefficients.shape[:2] + (1,) * way.ndim) * way
        coefficients[:, 0] += start
        return PiecewisePolynomial(unit.knots, coefficients).stretched(duration)

    def fastest(
        self,
        start: Floats,
        goal: Floats,
        *,
        velocity: Floats | float,
        acceleration: Floats | float,
        margin: float = 0.0,
        least: float = 0.0,
    ) -> PiecewisePolynomial:
        """The shortest motion; its peaks are the limits themselves, and its formula needs neither margin nor least."""
        return trapezoid(start, goal, velocity=velocity, acceleration=acceleration).value


def _seven_parts(accelerating: float, jerking: float) -> PiecewisePolynomial:
    """s(x) of seven parts of constant jerk, mirrored in the middle.

    Args:
        accelerating: share of the duration until the constant speed.
        jerking: share in which the acceleration grows, at most half of that.
    """
    parts = [jerking, accelerating - 2 * jerking, jerking, 1 - 2 * accelerating, jerking, accelerating - 2 * jerking]
    jerk = 1.0 / (jerking * (accelerating - jerking) * (1.0 - accelerating))
    pieces: list[list[float]] = []
    u = v = a = 0.0
    for h, j in zip([*parts, jerking], jerk * np.array([1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 1.0]), strict=True):
        pieces.append([u, v, a / 2, j / 6])
        u, v, a = u + h * (v + h * (a / 2 + h * j / 6)), v + h * (a + h * j / 2), a + h * j
    return PiecewisePolynomial.from_pieces([*parts, jerking], np.array(pieces)[..., None])


QUINTIC = PolynomialLaw((0, 0, 0, 10, -15, 6))
"""No acceleration at its ends. Reference: Craig, Introduction to Robotics, eq. (7.18)."""

LAWS: dict[ProfileName, TimeLaw] = {
    "cubic": PolynomialLaw((0, 0, 3, -2)),
    "quintic": QUINTIC,
    "septic": PolynomialLaw((0, 0, 0, 0, 35, -84, 70, -20)),
    "cosine": ShapedLaw(Harmonic(0.5, 0.0, 0.5, pi, -pi / 2)),
    "cycloid": ShapedLaw(Harmonic(0.0, 1.0, -0.5 / pi, 2 * pi, 0.0)),
    "exponential": ShapedLaw(ExponentialApproach(time_constants=5.0)),
    "trapezoid": TrapezoidLaw(),
    "double_s": ShapedLaw(Pieces(_seven_parts(accelerating=3 / 8, jerking=1 / 8))),
    "bang_bang": ShapedLaw(Pieces(trapezoid(0.0, 1.0, acceleration=4.0, duration=1.0).value)),
}
"""All laws by name."""


def time_law(name: ProfileName) -> TimeLaw:
    """The law of that name.

    Raises:
        InputError: there is none; the sentence lists those that are.
    """
    if name not in LAWS:
        raise InputError("input.choice", name="law", value=name, known=", ".join(LAWS))
    return LAWS[name]


def rest_law(name: LawName) -> TimeLaw:
    """The law of that name, for a motion from rest to rest whose speed does not jump.

    Raises:
        InputError: there is none; the sentence lists those that are.
    """
    known = [each for each in LAWS if each != "exponential"]
    if name not in known:
        raise InputError("input.choice", name="law", value=name, known=", ".join(known))
    return LAWS[name]
