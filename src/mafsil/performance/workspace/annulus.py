"""Workspaces known in closed form: the annulus of a planar 2R arm, and the annuli of a planar 3R arm."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import as_batch
from mafsil.errors import InputError


@dataclass(frozen=True, slots=True)
class Annulus:
    """All points whose distance from the first axis lies between two radii; a disc if the inner one is zero.

    Attributes:
        inner, outer: [m].
    """

    inner: float
    outer: float

    @property
    def area(self) -> float:
        """[m^2]."""
        return pi * (self.outer**2 - self.inner**2)

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """(*batch) whether points (*batch, 2), seen from the first axis, lie within."""
        distance = np.linalg.norm(as_batch("points", points, (2,)), axis=-1)
        return (distance >= self.inner) & (distance <= self.outer)


def reachable_annulus(lengths: ArrayLike) -> Annulus:
    """The annulus that the tip of a planar chain without joint limits reaches: 2R, 3R and longer.

    outer = sum of lengths; inner = longest - the others, or 0.

    Args:
        lengths: (k,) of the links [m], none negative.

    Raises:
        InputError: no lengths, or a negative one.
    """
    L = _lengths(lengths)
    return Annulus(max(0.0, float(2 * L.max() - L.sum())), float(L.sum()))


def dexterous_annuli(lengths: ArrayLike) -> tuple[Annulus, ...]:
    """Where a planar 3R arm without joint limits has every orientation: none, one or two annuli (or discs).

    The second joint's far end must reach the whole circle of radius L3 about the tip, at distances |r - L3| .. r + L3
    from the first axis, within the annulus of the first two links: r + L3 <= outer and |r - L3| >= inner.

    Args:
        lengths: (3,) of the links [m].
    """
    L = _lengths(lengths)
    if len(L) != 3:
        raise InputError("input.shape", name="lengths", expected="(3,)", got=L.shape, hint="")
    inner_annulus, last = reachable_annulus(L[:2]), float(L[2])
    most = inner_annulus.outer - last
    pieces = (
        [(0.0, most)]
        if inner_annulus.inner == 0.0
        else [(0.0, min(last - inner_annulus.inner, most)), (last + inner_annulus.inner, most)]
    )
    return tuple(Annulus(inner, outer) for inner, outer in pieces if inner <= outer and outer > 0.0)


def _lengths(lengths: ArrayLike) -> NDArray[np.float64]:
    L = np.atleast_1d(as_batch("lengths", lengths, (), finite=True))
    if L.ndim != 1 or not len(L) or (L < 0).any():
        raise InputError("performance.lengths", got=L.tolist())
    return L
