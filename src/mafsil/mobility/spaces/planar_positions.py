"""Positions of planar linkages in closed form: circles that meet, polygons of links, and how many pieces they have."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, as_batch, real_array, require_finite
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.mobility.tolerances import TOUCHING, TYPED


def circle_crossings(A: ArrayLike, a: ArrayLike, B: ArrayLike, b: ArrayLike) -> Floats:
    """(*batch, 2, 2) the two points at distances a from A and b from B: left of A -> B first.

    Where the circles do not meet, `circle_gap` is not zero and both are the point in the middle of that gap, the one
    nearest to both circles. Equal circles about one centre: two opposite points, of all that there are.

    Args:
        A, B: (*batch, 2) centres [m].
        a, b: (*batch,) radii [m].

    Raises:
        InputError: wrong shapes, a single radius that is not finite.
    """
    return _crossings(*_circles(A, a, B, b))[0]


def circle_gap(A: ArrayLike, a: ArrayLike, B: ArrayLike, b: ArrayLike) -> Floats:
    """(*batch,) width of the gap between two circles, outside or inside each other [m]; zero where they meet.

    Args:
        A, B: (*batch, 2) centres [m].
        a, b: (*batch,) radii [m].

    Raises:
        InputError: wrong shapes, a single radius that is not finite.
    """
    return _crossings(*_circles(A, a, B, b))[1]


def _circles(A: ArrayLike, a: ArrayLike, B: ArrayLike, b: ArrayLike) -> tuple[Floats, Floats, Floats, Floats]:
    start, end = as_batch("A", A, (2,)), as_batch("B", B, (2,))
    return start, finite_numbers("a", a), end, finite_numbers("b", b)


def _crossings(start: Floats, first: Floats, end: Floats, second: Floats) -> tuple[Floats, Floats]:
    """Both points and the gap."""
    along = end - start
    d = np.hypot(along[..., 0], along[..., 1])
    apart = d > 0.0
    way = np.where(apart, d, 1.0)
    u = np.where(apart[..., None], along, np.array([1.0, 0.0])) / way[..., None]
    outside, inside = d - (first + second), np.abs(first - second) - d
    foot = np.where(apart, (first - second) * (first + second) / (2 * way) + d / 2, 0.0)
    h2 = (first - foot) * (first + foot)
    small = TOUCHING * np.maximum(np.maximum(first, second), d) ** 2
    meets = (h2 > -small) & (apart | (first == second))
    within = np.where(first > second, first + d + second, d - first - second) / 2
    foot = np.where(meets, foot, np.where(outside >= inside, (d + first - second) / 2, within))
    h = np.sqrt(np.where(meets, np.maximum(h2, 0.0), 0.0))[..., None]
    across = np.stack([-u[..., 1], u[..., 0]], axis=-1)
    middle = start + foot[..., None] * u
    points = np.stack([middle + h * across, middle - h * across], axis=-2)
    return points, np.where(meets, 0.0, np.maximum(outside, inside))


def finite_numbers(name: str, value: ArrayLike) -> Floats:
    """(*batch,) real numbers; NaN and infinite ones, which stand for no angle and no length, are NaN in their rows.

    Raises:
        InputError: a single one is not finite.
    """
    number = real_array(name, value)
    return np.where(np.isinf(number), np.nan, number) if number.ndim else require_finite(name, number)


def wrap_angle(angle: ArrayLike) -> Floats:
    """(*batch,) angles in (-pi, pi]."""
    value = real_array("angle", angle)
    with np.errstate(invalid="ignore"):
        return -np.remainder(-value + np.pi, 2 * np.pi) + np.pi


class PolygonStatus(Status):
    """Whether links of these lengths close, and what their configurations are together."""

    SMOOTH = ("mobility.polygon_smooth", True)
    BRANCHED = ("mobility.polygon_branched", True)
    ISOLATED = ("mobility.polygon_isolated", True)
    SWINGS = ("mobility.polygon_swings", True)
    IMPOSSIBLE = ("mobility.polygon_impossible", False)


@dataclass(frozen=True, eq=False, repr=False)
class PolygonSpace(Answer, data="lengths components dimension smooth excess"):
    """All configurations of a closed planar chain of revolute joints, one link fixed; true if there are any.

    Attributes:
        lengths: of the links [m].
        components: connected pieces.
        dimension: n - 3 of n links, 0 if isolated, None if there are none.
        smooth: no configuration has all links on one line; None if there are none.
        excess: longest link minus the sum of the others [m]: positive if they cannot close.
    """

    lengths: tuple[float, ...]
    components: int
    dimension: int | None
    smooth: bool | None
    excess: float

    @property
    def status(self) -> PolygonStatus:
        """By dimension and smoothness."""
        if self.dimension is None:
            return PolygonStatus.IMPOSSIBLE
        if self.excess >= -TYPED * max(self.lengths):
            return PolygonStatus.SWINGS if self.dimension else PolygonStatus.ISOLATED
        return PolygonStatus.SMOOTH if self.smooth else PolygonStatus.BRANCHED

    def explain(self, language: str | None = None) -> str:
        """The finding in one sentence."""
        return self.status.sentence(
            language, components=self.components, dimension=self.dimension, excess=self.excess, n=len(self.lengths)
        )


def polygon_space(lengths: ArrayLike) -> PolygonSpace:
    """Pieces, dimension and smoothness of the configurations of a closed planar chain, one link fixed.

    1. The longest link at most as long as the others together: else none; equal: one stretched configuration.
    2. Links that can lie on one line (some sum of +-lengths is 0) make branch points.
    3. Two pieces if three links are pairwise longer than half of the circumference, else one. Links of length 0
       take any direction; if one of them is the ground, the others turn as a whole about its point.

    Args:
        lengths: (n,) of at least two links, none negative [m].

    Raises:
        InputError: fewer than two, negative or infinite lengths.

    Reference: M. Kapovich, J. Millson, On the moduli space of polygons in the Euclidean plane, J. Differential
    Geometry 42 (1995), theorem 1.
    """
    L = as_batch("lengths", lengths, (len(np.atleast_1d(real_array("lengths", lengths))),), finite=True)
    if L.ndim != 1 or not 2 <= len(L) <= 20 or L.min() < 0 or not L.max() > 0:
        raise InputError("mobility.polygon_lengths", got=np.shape(L))
    total, longest = float(L.sum()), float(L.max())
    excess, small = 2 * longest - total, TYPED * max(longest, LEAST_DIVISOR)
    n, given = len(L), tuple(L.tolist())
    if excess > small:
        return PolygonSpace(given, 0, None, None, excess)
    if excess >= -small:
        return PolygonSpace(given, 1, int((small >= L).sum()), False, excess)
    long = sorted(L)[-3:]
    pairs = all(a + b > total / 2 + small for a, b in combinations(long, 2))
    return PolygonSpace(given, 2 if pairs else 1, n - 3, not _can_line_up(L[L > small], small), excess)


def _can_line_up(L: Floats, small: float) -> bool:
    sums = np.array([L[0]])
    for length in L[1:]:
        sums = np.concatenate([sums + length, sums - length])
    return bool((np.abs(sums) <= small).any())
