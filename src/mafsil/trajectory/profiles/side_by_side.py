"""Several axes at once: each its own trajectory, on one clock."""

from __future__ import annotations

from collections.abc import Sequence as Several
from dataclasses import dataclass
from math import factorial

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, require_kind
from mafsil.errors import InputError
from mafsil.trajectory.motion import Motion, Stretchable, Trajectory, times
from mafsil.trajectory.overview import Printed
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial


@dataclass(frozen=True, eq=False, repr=False)
class SideBySide(Printed):
    """The coordinates of several trajectories, one after the other; what ends earlier rests at its end.

    Attributes:
        parts: trajectories without batch dimensions.
    """

    parts: tuple[Trajectory, ...]

    @property
    def duration(self) -> float:
        """Length in time, of the longest [s]."""
        return max(part.duration for part in self.parts)

    @property
    def n(self) -> int:
        """Number of coordinates of all together."""
        return sum(part.n for part in self.parts)

    def breaks(self) -> Floats:
        """Times between which all are smooth [s]."""
        return np.unique(np.concatenate([part.breaks() for part in self.parts]))

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration at the times `t` (*times) [s]; at rest outside 0 .. duration."""
        moment = times(t)
        found = [part.at(moment) for part in self.parts]
        u, v, a = (np.concatenate([each[order] for each in found], axis=-1) for order in range(3))
        return Motion(u, v, a)

    def jerk(self, t: ArrayLike) -> Floats:
        """(*times, n) third derivative at the times `t` [rad/s^3 | m/s^3]."""
        moment = times(t)
        return np.concatenate([part.jerk(moment) for part in self.parts], axis=-1)

    def stretched(self, factor: float) -> SideBySide:
        """The same path, `factor` times as slow; all parts must be of a kind that can be."""
        return SideBySide(tuple(part.stretched(factor) for part in self.parts if isinstance(part, Stretchable)))


def synchronised(*parts: Stretchable) -> SideBySide:
    """Axes that start and arrive together: each is slowed as a whole to the slowest of them.

    Args:
        parts: at least one trajectory, such as the shortest of each axis under its limits.

    Raises:
        InputError: no part, or one that cannot be slowed.
    """
    if not parts:
        raise InputError("trajectory.no_parts")
    for k, part in enumerate(parts):
        require_kind(f"parts[{k}]", part, "Trajectory", "duration", "at", "stretched")
    longest = max(part.duration for part in parts)
    return SideBySide(tuple(part.stretched(longest / part.duration) if part.duration else part for part in parts))


def on_common_knots(columns: Several[PiecewisePolynomial]) -> PiecewisePolynomial:
    """Piecewise polynomials of equal duration and any degrees as one, on the knots of all.

    Args:
        columns: without batch dimensions; their coordinates follow one another.
    """
    degree = max(column.degree for column in columns)
    knots = np.unique(np.concatenate([column.knots for column in columns]))
    lengths = np.diff(knots)
    # Knots that differ by rounding alone are one.
    kept = np.concatenate([[True], lengths > 4e-15 * max(float(knots[-1]), 1e-300)])
    knots = knots[kept]
    if len(knots) < 2:
        return PiecewisePolynomial.from_pieces([0.0], np.concatenate([c.coefficients[:1, :1] for c in columns], -1))
    rows = [_on_knots(column, knots, degree) for column in columns]
    return PiecewisePolynomial.from_pieces(np.diff(knots), np.concatenate(rows, axis=-1))


def _on_knots(column: PiecewisePolynomial, knots: Floats, degree: int) -> Floats:
    """(pieces, degree + 1, n) ascending coefficients at the starts of finer pieces, each of the piece it lies in."""
    return np.stack(
        [
            column.derivative(knots[:-1], order, within=(knots[:-1] + knots[1:]) / 2) / factorial(order)
            for order in range(degree + 1)
        ],
        axis=1,
    )
