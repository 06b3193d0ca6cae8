"""Positions of planar linkages in closed form: circles that meet, polygons of links, and how many pieces they have."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import SingleAnswer, Status
from mafsil.arrays import Floats, as_batch, real_array
from mafsil.errors import InputError
from mafsil.mobility.tolerances import TOUCHING, TYPED


def circle_crossings(A: ArrayLike, a: ArrayLike, B: ArrayLike, b: ArrayLike) -> Floats:
    """(*batch, 2, 2) the two points at distances a from A and b from B: left of A -> B first; NaN if there are none.

    Args:
        A, B: (*batch, 2) centres [m].
        a, b: (*batch,) radii [m].
    """
    start, end = as_batch("A", A, (2,)), as_batch("B", B, (2,))
    along = end - start
    d = np.hypot(along[..., 0], along[..., 1])
    first, second = real_array("a", a), real_array("b", b)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = along / d[..., None]
        foot = (first**2 - second**2 + d**2) / (2 * d)
        h2 = (first - foot) * (first + foot)
        small = TOUCHING * np.maximum(np.maximum(first, second), d) ** 2
        h = np.sqrt(np.where(h2 > -small, np.maximum(h2, 0.0), h2))
    across = np.stack([-u[..., 1], u[..., 0]], axis=-1)
    middle = start + foot[..., None] * u
    return np.stack([middle + h[..., None] * across, middle - h[..., None] * across], axis=-2)


def numbers_or_nan(name: str, value: ArrayLike) -> Floats:
    """(*batch,) real numbers; infinite ones, which stand for no angle and no length, as NaN."""
    number = real_array(name, value)
    return np.where(np.isinf(number), np.nan, number)


def wrapped(angle: ArrayLike) -> Floats:
    """(*batch,) angles in (-pi, pi]."""
    value = numbers_or_nan("angle", angle)
    return -np.remainder(-value + np.pi, 2 * np.pi) + np.pi


class PolygonStatus(Status):
    """Whether links of these lengths close, and what their configurations are together."""

    SMOOTH = ("mobility.polygon_smooth", True)
    BRANCHED = ("mobility.polygon_branched", True)
    ISOLATED = ("mobility.polygon_isolated", True)
    SWINGS = ("mobility.polygon_swings", True)
    IMPOSSIBLE = ("mobility.polygon_impossible", False)


@dataclass(frozen=True, eq=False, repr=False)
class PolygonSpace(SingleAnswer):
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

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "status": self.status.name.lower(), "lengths": list(self.lengths), "components": self.components,
            "dimension": self.dimension, "smooth": self.smooth, "excess": self.excess,
        }  # fmt: skip


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
    excess, small = 2 * longest - total, TYPED * max(longest, 1e-300)
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
