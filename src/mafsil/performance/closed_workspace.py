"""Workspaces known in closed form: the ring of a planar 2R arm, and the rings of a planar 3R arm."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import gate
from mafsil.errors import InputError


@dataclass(frozen=True, slots=True)
class Ring:
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
        distance = np.linalg.norm(gate("points", points, (2,)), axis=-1)
        return (distance >= self.inner) & (distance <= self.outer)


def planar_reach(lengths: ArrayLike) -> Ring:
    """The ring that the tip of a planar chain without joint limits reaches: 2R, 3R and longer.

    outer = sum of lengths; inner = longest - the others, or 0.

    Args:
        lengths: (k,) of the links [m], none negative.

    Raises:
        InputError: no lengths, or a negative one.
    """
    L = _lengths(lengths)
    return Ring(max(0.0, float(2 * L.max() - L.sum())), float(L.sum()))


def planar_dexterous(lengths: ArrayLike) -> Ring | None:
    """Where a planar 3R arm without joint limits has every orientation, or None.

    The last joint must be able to stand everywhere on the circle of radius L3 about the tip, that is within the ring of
    the first two links: inner + L3 <= r <= outer - L3, or a disc r <= min(L3 - inner, outer - L3) about the first axis.

    Args:
        lengths: (3,) of the links [m].
    """
    L = _lengths(lengths)
    if len(L) != 3:
        raise InputError("input.shape", name="lengths", expected="(3,)", got=L.shape, hint="")
    ring, last = planar_reach(L[:2]), float(L[2])
    if ring.inner + last <= ring.outer - last:
        if ring.inner == 0.0:
            return Ring(0.0, ring.outer - last)
        return Ring(ring.inner + last, ring.outer - last)
    disc = min(last - ring.inner, ring.outer - last)
    return Ring(0.0, disc) if disc > 0 else None


def _lengths(lengths: ArrayLike) -> NDArray[np.float64]:
    L = np.atleast_1d(gate("lengths", lengths, (), finite=True))
    if L.ndim != 1 or not len(L) or (L < 0).any():
        raise InputError("performance.lengths", got=L.tolist())
    return L
