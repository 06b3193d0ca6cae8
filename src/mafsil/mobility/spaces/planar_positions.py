"""Positions of planar linkages in closed form: circles that meet, polygons of links, and how many pieces they have.

Directions in which a four-bar moves: along its one branch, or along both that cross where its links are on one line.

The rates that keep the three closure equations A theta' = 0 are the minors of A. Where all links lie on one line they
vanish. With signed lengths a, b, c of crank, coupler and rocker along the ground and their rates u, v, w, the first
order is then a u + b v + c w = 0 and the second a u^2 + b v^2 + c w^2 = 0, so that

    c (b + c) w^2 + 2 a c u w + a (a + b) u^2 = 0,

whose discriminant - a b c (a + b + c) is negative where the linkage cannot move.
"""

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


ROUNDING = 1e-14
"""Areas below it, over the square of the longest link, are rounding."""


def directions(lengths: Floats, A: Floats, theta: Floats) -> Floats:
    """(*batch, 2, 4) unit directions of both branches, equal ones where one passes; zeros where it cannot move.

    Args:
        lengths: (4,) [m].
        A: (*batch, 3, 4) derivatives of the closure equations.
        theta: (*batch, 4) relative angles [rad].
    """
    minors = np.stack([(-1) ** k * np.linalg.det(np.delete(A, k, axis=-1)) for k in range(4)], axis=-1)
    minors[np.abs(minors) <= ROUNDING * lengths.max() ** 2] = 0.0
    found = np.stack([minors, minors], axis=-2)
    in_line = ~minors.any(axis=-1)
    if in_line.any():
        found[in_line] = _crossing(lengths, theta[in_line])
    length = np.linalg.norm(found, axis=-1, keepdims=True)
    return found / np.where(length > 0.0, length, 1.0)


def per_crank(along: Floats) -> Floats:
    """Directions (*batch, 4) as rates for a crank of rate 1: infinite with their signs where the crank stands."""
    crank = along[..., :1]
    infinite = np.copysign(np.where(along == 0.0, 0.0, np.inf), along)
    infinite[..., 0] = along.any(axis=-1)
    return np.where(crank == 0.0, infinite, along / np.where(crank == 0.0, 1.0, crank))


def _crossing(lengths: Floats, theta: Floats) -> Floats:
    """(k, 2, 4) directions at configurations (k, 4) with all links on one line, that of the slower rocker first."""
    a, b, c = np.moveaxis(lengths[:3] * np.sign(np.cos(np.cumsum(theta, axis=-1)[..., :3])), -1, 0)
    small = TYPED * lengths.max()
    square = np.where(np.abs(b + c) <= small, 0.0, c * (b + c))
    last = np.where(np.abs(a + b) <= small, 0.0, a * (a + b))
    inside = -a * b * c * (a + b + c)
    # Zeros w : u of the quadratic, both without a difference of nearly equal numbers.
    root = -(a * c + np.copysign(np.sqrt(np.maximum(inside, 0.0)), a * c))
    w, u = np.stack([root, last], axis=-1), np.stack([square, root], axis=-1)
    w, u = np.where(u < 0.0, -w, w), np.abs(u)
    w = np.where(u == 0.0, np.abs(w), w)
    slope = np.divide(w, u, out=np.full_like(w, np.inf), where=u > 0.0)
    order = np.argsort(slope, axis=-1)
    w, u = np.take_along_axis(w, order, axis=-1), np.take_along_axis(u, order, axis=-1)
    v = -(a[:, None] * u + c[:, None] * w) / b[:, None]
    found = np.stack([u, v - u, w - v, -w], axis=-1)
    found[np.abs(found) <= TYPED * np.abs(found).max(axis=-1, keepdims=True)] = 0.0
    return np.where((inside > 0.0)[:, None, None], found, 0.0) + 0.0
