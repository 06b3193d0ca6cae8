"""Straight lines joined by blends, as a trajectory: at every time a coordinate is in a straight part or in a blend.

Shapes of a blend between two straight lines, as rows of one table: parabola and quintic.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from math import factorial
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.trajectory.motion import Motion, Printed, moving_at, times
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.tolerances import ROUNDING

BlendName: TypeAlias = Literal["parabolic", "quintic"]


class _Place(NamedTuple):
    """Where times lie: their leg (*times), themselves (*times, 1, ..), in a blend, in the one at the leg's end."""

    leg: NDArray[np.intp]
    time: Floats
    blending: NDArray[np.bool_]
    late: NDArray[np.bool_]


@dataclass(frozen=True, eq=False, repr=False)
class BlendedLines(Printed):
    """A polygon over time with a blend at each corner, the first and the last one inside their legs.

    Attributes:
        legs: (m,) times between which a leg is one straight line [s].
        corners: (m, *batch, n) times of the corners [s].
        points: (m, *batch, n) positions of the corners [rad | m].
        slopes: (m + 1, *batch, n) velocities before, between and after the corners; zero at both ends.
        blends: (m, *batch, n) durations of the blends, which lie evenly about their corners [s].
        shape: of all blends.
    """

    legs: Floats
    corners: Floats
    points: Floats
    slopes: Floats
    blends: Floats
    shape: BlendShape

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return float(self.legs[-1])

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return self.points.shape[-1]

    def breaks(self) -> Floats:
        """Starts and ends of all blends, 0 and the duration included [s]."""
        return self._breaks

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration at the times `t` (*times) [s]; at rest outside 0 .. duration."""
        moment = times(t)
        moving = moving_at(moment, self.duration, self.points.ndim - 1)
        u, v, a = self._derivatives(moment, (0, 1, 2))
        return Motion(u, v * moving, a * moving)

    def jerk(self, t: ArrayLike) -> Floats:
        """(*times, *batch, n) third derivative [rad/s^3 | m/s^3]; between parabolas it is zero, jumps apart."""
        moment = times(t)
        return self._derivatives(moment, (3,))[0] * moving_at(moment, self.duration, self.points.ndim - 1)

    def blending(self, t: ArrayLike) -> NDArray[np.bool_]:
        """(*times, *batch, n) whether each coordinate is in a blend; else it is in a straight part or at rest."""
        moment = times(t)
        within = ((moment >= 0.0) & (moment <= self.duration)).reshape(moment.shape + (1,) * (self.points.ndim - 1))
        return self._locate(moment).blending & within

    def to_polynomial(self) -> PiecewisePolynomial:
        """The same motion as one list of polynomials; of a batch all knots together, many for many rows."""
        knots, degree = self.breaks(), max(len(self.shape.coefficients) - 1, 2)
        if len(knots) == 1:
            return PiecewisePolynomial.from_pieces([0.0], self.points[:1, None])
        # What a piece is, its middle says; where it starts, its left end.
        values = self._derivatives(knots[:-1], range(degree + 1), (knots[:-1] + knots[1:]) / 2)
        pieces = np.stack([value / factorial(k) for k, value in enumerate(values)], axis=1)
        return PiecewisePolynomial.from_pieces(np.diff(knots), pieces)

    @cached_property
    def _breaks(self) -> Floats:
        ends = [(self.corners + side * self.blends / 2).ravel() for side in (-1.0, 1.0)]
        return np.unique(np.clip(np.concatenate([[0.0, self.duration], *ends]), 0.0, self.duration))

    def _locate(self, t: Floats) -> _Place:
        """Where each coordinate is at the times (*times)."""
        clamped = np.clip(t, 0.0, self.duration)
        leg = np.clip(np.searchsorted(self.legs, clamped, side="right") - 1, 0, len(self.legs) - 2)
        time = clamped.reshape(clamped.shape + (1,) * (self.points.ndim - 1))
        begin, end = leg, leg + 1
        late = (time >= self.corners[end] - self.blends[end] / 2) & (self.blends[end] > 0.0)
        early = (time < self.corners[begin] + self.blends[begin] / 2) & ~late
        return _Place(leg, time, early | late, late)

    def _derivatives(self, t: Floats, orders: Iterable[int], where: Floats | None = None) -> list[Floats]:
        """Derivatives at the times `t`, taken in the part in which `where` lies (`t` itself if None).

        straight: u = u_k + v (t - c_k);  blend: u = u_k - v b/2 + b (v s + dv g(s)),  s = (t - c_k)/b + 1/2
        """
        place = self._locate(t if where is None else where)
        time = place.time if where is None else t.reshape(place.time.shape)
        leg, late, blending = place.leg, place.late, place.blending
        c, u, b = (np.where(late, each[leg + 1], each[leg]) for each in (self.corners, self.points, self.blends))
        own = self.slopes[leg + 1]
        v = np.where(late | ~blending, own, self.slopes[leg])
        dv = np.where(late, self.slopes[leg + 2], own) - v
        b = np.where(blending, b, 1.0)
        s = np.where(blending, (time - c) / b + 0.5, 0.0)
        found: list[Floats] = []
        for order in orders:
            bend = dv * self.shape.g(s, order) / b ** (order - 1)
            line = (u + v * (time - c), v, 0.0)[min(order, 2)]
            found.append(np.where(blending, line + bend, line))
        return found


@dataclass(frozen=True)
class BlendShape:
    """How the speed changes from v to v + dv in a blend of duration b around a corner at u_k.

    u = u_k - v b/2 + b (v s + dv g(s)),  s from 0 to 1 in the blend.

    Attributes:
        coefficients: of g in ascending powers: g(0) = g'(0) = 0, g(1) = 1/2, g'(1) = 1.

    Raises:
        InputError: g does not lead from one line to the other.
    """

    coefficients: tuple[float, ...]

    def __post_init__(self) -> None:
        ends = [self._at(s, order) for order in (0, 1) for s in (0.0, 1.0)]
        if not np.allclose(ends, [0.0, 0.5, 0.0, 1.0], rtol=0.0, atol=1e-14):
            raise InputError("trajectory.blend_ends", coefficients=self.coefficients)

    def g(self, s: Floats, order: int) -> Floats:
        """A derivative of g by s.

        Args:
            s: share of the blend that has passed.
            order: 0 for g itself.
        """
        value = np.zeros_like(s)
        for c in np.polynomial.polynomial.polyder(np.array(self.coefficients), order)[::-1].tolist():
            value = value * s + c
        return value

    @cached_property
    def peak(self) -> float:
        """Peak acceleration over the mean one, dv/b: largest g''."""
        third = np.polynomial.polynomial.polyder(np.array(self.coefficients), 3)
        bends: NDArray[np.complex128] = np.asarray(np.polynomial.polynomial.polyroots(third), dtype=np.complex128)
        inside = [float(s) for s in bends.real[np.abs(bends.imag) < ROUNDING] if 0.0 < s < 1.0]
        return max(abs(self._at(s, 2)) for s in (0.0, *inside, 1.0))

    @property
    def miss(self) -> float:
        """Distance from the corner to the middle of the blend, as share of dv b."""
        return self._at(0.5, 0)

    def _at(self, s: float, order: int) -> float:
        return float(self.g(np.array(s), order))


BLENDS: dict[BlendName, BlendShape] = {
    "parabolic": BlendShape((0.0, 0.0, 0.5)),
    "quintic": BlendShape((0.0, 0.0, 0.0, 1.0, -0.5)),
}
"""All shapes by name. The quintic has no acceleration at its ends; its coefficient of the fifth power vanishes."""


def blend_shape(name: BlendName) -> BlendShape:
    """The shape of that name.

    Raises:
        InputError: there is none; the sentence lists those that are.
    """
    if name not in BLENDS:
        raise InputError("input.choice", name="blend", value=name, known=", ".join(BLENDS))
    return BLENDS[name]
