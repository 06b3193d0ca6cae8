"""Directions in which a four-bar moves: along its one branch, or along both that cross where its links are on one line.

The rates that keep the three closure equations A theta' = 0 are the minors of A. Where all links lie on one line they
vanish. With signed lengths a, b, c of crank, coupler and rocker along the ground and their rates u, v, w, the first
order is then a u + b v + c w = 0 and the second a u^2 + b v^2 + c w^2 = 0, so that

    c (b + c) w^2 + 2 a c u w + a (a + b) u^2 = 0,

whose discriminant - a b c (a + b + c) is negative where the linkage cannot move.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.mobility.tolerances import TYPED

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
