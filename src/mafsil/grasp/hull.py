"""Hulls: the convex hull of any finite point set, and the least reach of a hull of discs.

The hull of points is a point, a segment, a flat polygon or a body, of whatever dimension. A hull of discs reaches least
far among neighbouring directions, found by Newton's method, where a mixture of the furthest points of some discs lies
along the direction u: sum l_i w_i = value u, l_i >= 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, require_finite
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.grasp.tolerances import CARRIES, NO_BEND, NOT_STATIONARY, RANK, ROUNDOFF, STATIONARY, TYPED

STEPS = 25
STILL = 1e-10
KINK = 0.1
"""Radii below this share of the disc's size: the disc may be met inside, square to u."""
SADDLES = 8


@dataclass(frozen=True, eq=False)
class Hull:
    """The convex hull.

    Attributes:
        points: (n, m) as given.
        vertices: indices of its corners, ascending; of polygons counter-clockwise in their own plane.
        dimension: of the hull: 0 a point, 1 a segment, 2 a flat polygon, up to m.
        basis: (dimension, m) orthonormal directions that span it.
        facets: (f, dimension + 1) rows (u, -d): in coordinates z along `basis` from the first point, u . z <= d.
    """

    points: Floats
    vertices: NDArray[np.int64]
    dimension: int
    basis: Floats
    facets: Floats

    def contains(self, point: ArrayLike, *, strictly: bool = False) -> bool:
        """Whether a point is in the hull; strictly: inside of it, which a flat hull has for no point of the space.

        Args:
            point: (m,).
            strictly: the boundary does not count.
        """
        p = np.asarray(point, float) - self.points[0]
        size = float(np.abs(self.points - self.points[0]).max()) or 1.0
        z = self.basis @ p
        if np.abs(p - z @ self.basis).max() > RANK * size or (strictly and self.dimension < len(p)):
            return False
        heights = self.facets[:, :-1] @ z + self.facets[:, -1]
        worst = float(heights.max()) if len(heights) else 0.0
        return worst < -RANK * size if strictly else worst <= RANK * size


def convex_hull(points: ArrayLike) -> Hull:
    """The convex hull of points in m dimensions, flat sets too.

    Args:
        points: (n, m), n >= 1.

    Raises:
        InputError: no points, or numbers that are not finite.
    """
    P = require_finite("points", np.asarray(points, float))
    if P.ndim != 2 or not P.size:
        raise InputError("grasp.no_hull", got=P.shape)
    offsets = P - P[0]
    _, s, Vt = np.linalg.svd(offsets)
    rank = int((s > RANK * s[0]).sum()) if s[0] > 0 else 0
    basis = Vt[:rank]
    z = offsets @ basis.T
    if rank == 0:
        return Hull(P, np.zeros(1, np.int64), 0, basis, np.zeros((0, 1)))
    if rank == 1:
        low, high = int(np.argmin(z[:, 0])), int(np.argmax(z[:, 0]))
        facets = np.array([[1.0, -z[high, 0]], [-1.0, z[low, 0]]])
        return Hull(P, np.array(sorted((low, high)), np.int64), 1, basis, facets)
    from scipy.spatial import ConvexHull

    found = ConvexHull(z)
    vertices = np.asarray(found.vertices, np.int64)
    return Hull(P, vertices if rank == 2 else np.sort(vertices), rank, basis, np.unique(found.equations, axis=0))


@dataclass(frozen=True, eq=False)
class Minimum:
    """A direction in which the set reaches least far among its neighbours.

    Attributes:
        u: (m,) unit direction.
        value: how far.
        pieces: discs that reach it.
        multipliers: of the pieces, sum 1, with sum of l_i w_i = value u.
        inner: (pieces, 2) where a disc square to u is met, |.| < 1; NaN for discs that are met at their rim.
    """

    u: Floats
    value: float
    pieces: list[int]
    multipliers: Floats
    inner: Floats


@dataclass(frozen=True, eq=False)
class _Local:
    """Discs seen along u: heights (k,), gradients (k, m), bends (k, m) q and radii r (k,) of q q' / r."""

    heights: Floats
    gradients: Floats
    bends: Floats
    radii: Floats


def _seen(discs: Floats, u: Floats) -> _Local:
    along = discs @ u
    x, y = along[:, 1], along[:, 2]
    r = np.hypot(x, y)
    safe = np.where(r > 0, r, 1.0)[:, None]
    sense = np.where(along[:, 3] >= 0, 1.0, -1.0)[:, None]
    gradients = discs[:, 0] + (x[:, None] * discs[:, 1] + y[:, None] * discs[:, 2]) / safe + sense * discs[:, 3]
    bends = (-y[:, None] * discs[:, 1] + x[:, None] * discs[:, 2]) / safe
    return _Local(along[:, 0] + r + np.abs(along[:, 3]), gradients, bends, r)


def minimum(discs: Floats, start: Floats) -> Minimum | None:
    """The minimum below a direction: Newton's method on its conditions, from saddles downhill; None if it is lost.

    Args:
        discs: (k, 4, m).
        start: (m,) unit direction.
    """
    for _ in range(SADDLES):
        found = _stationary(discs, start)
        if found is None:
            return None
        lower = _off_saddle(discs, found)
        if lower is None:
            return found
        start = lower
    return None


def _off_saddle(discs: Floats, found: Minimum) -> Floats | None:
    """A direction beside a saddle that reaches less far; None beside a minimum."""
    seen = _seen(discs[found.pieces], found.u)
    across = np.linalg.svd(found.u[None])[2][1:]
    kinks = [discs[i, 1:3] for i, n in zip(found.pieces, found.inner, strict=True) if not np.isnan(n[0])]
    _, s, Vt = np.linalg.svd(np.vstack([seen.gradients, *kinks]) @ across.T, full_matrices=True)
    flat = Vt[int((s > NO_BEND * found.value).sum()) :] @ across
    if not len(flat):
        return None
    q = np.where(np.isnan(found.inner[:, :1]), seen.bends, 0.0) @ flat.T
    safe = np.where(seen.radii > 0, seen.radii, 1.0)
    bend = np.einsum("i,ij,ik->jk", found.multipliers / safe, q, q) - found.value * np.eye(len(flat))
    values, directions = np.linalg.eigh(bend)
    if values[0] >= -STILL:
        return None
    aside = directions[:, 0] @ flat
    trials = [found.u + step * aside for step in (0.5, -0.5, 0.2, -0.2, 0.05, -0.05, 0.01, -0.01)]
    trials = [u / np.linalg.norm(u) for u in trials]
    heights = [float(_seen(discs, u).heights.max()) for u in trials]
    best = int(np.argmin(heights))
    return trials[best] if heights[best] < found.value else None


def _stationary(discs: Floats, start: Floats) -> Minimum | None:
    """Where Newton's method ends."""
    u = start / np.linalg.norm(start)
    seen = _seen(discs, u)
    value = float(seen.heights.max())
    multipliers = _first_multipliers(seen, u, value)
    pieces = [int(i) for i in np.flatnonzero(multipliers > CARRIES)]
    kinks = {i for i in pieces if seen.radii[i] < KINK * np.linalg.norm(discs[i, 1:3])}
    for _ in range(12):
        solved = _newton(discs, u, pieces, kinks, value)
        if solved is None:
            return None
        at, weights, inner, level = solved
        leaving = {i for i, w in zip(pieces, weights, strict=True) if w < -STILL}
        rims = {
            i for i, w, nu in zip(pieces, weights, inner, strict=True) if i in kinks and np.hypot(*nu) > max(w, 0.0)
        }
        heights = _seen(discs, at).heights
        beyond = int(np.argmax(heights))
        if leaving:
            pieces = [i for i in pieces if i not in leaving]
        elif rims:
            kinks -= rims
        elif heights[beyond] <= level * (1 + TYPED):
            positive = np.maximum(weights, LEAST_DIVISOR)
            where = np.where([[i in kinks] for i in pieces], inner / positive[:, None], np.nan)
            return Minimum(at, float(heights[beyond]), pieces, positive / positive.sum(), where)
        elif beyond in pieces:
            return None
        else:
            pieces = [*pieces, beyond]
        if not pieces:
            return None
    return None


def _first_multipliers(seen: _Local, u: Floats, value: float) -> Floats:
    """Multipliers that nearly balance, of discs that nearly reach."""
    import scipy.optimize

    solve: Any = scipy.optimize.nnls  # carries no types
    k = len(seen.heights)
    A = np.vstack([seen.gradients.T / value, np.ones(k), np.diag(3.0 * (value - seen.heights) / value)])
    return np.asarray(solve(A, np.concatenate([u, [1.0], np.zeros(k)]))[0], float)


def _newton(
    discs: Floats, u: Floats, pieces: list[int], kinks: set[int], value: float
) -> tuple[Floats, Floats, Floats, float] | None:
    """U, multipliers l, places n (times l) and value: sum l_i w_i = value u, h_i = value, |u| = 1.

    A disc square to u (a kink) is met at a + E n: E' u = 0 comes in, n is unknown with it.
    """
    m, p = len(u), len(pieces)
    bent = [k for k, i in enumerate(pieces) if i in kinks]
    E: Floats = np.array([discs[pieces[k], 1:3] for k in bent], float).reshape(-1, m)
    size = m + p + len(E) + 1
    x: Floats = np.asarray(np.concatenate([u, np.zeros(p + len(E)), [value]]), float)
    weights: Floats = np.zeros(p)
    nu: Floats = np.zeros(len(E))
    left: Floats = np.full(1, np.inf)
    for step in range(STEPS):
        u, weights, value = np.asarray(x[:m], float), np.asarray(x[m : m + p], float), float(x[-1])
        nu = np.asarray(x[m + p : -1], float)
        seen = _seen(discs[pieces], u)
        gradients, heights, bends = seen.gradients.copy(), seen.heights.copy(), seen.bends.copy()
        for k in bent:
            disc = discs[pieces[k]]
            gradients[k] = disc[0] + np.copysign(1.0, disc[3] @ u) * disc[3]
            heights[k], bends[k] = gradients[k] @ u, 0.0
        if step == 0:
            columns = np.hstack([gradients.T, E.T])
            x[m:-1] = np.linalg.lstsq(columns, value * u, rcond=None)[0]
            weights, nu = np.asarray(x[m : m + p], float), np.asarray(x[m + p : -1], float)
        parts = [gradients.T @ weights + E.T @ nu - value * u, heights - value, E @ u, [u @ u - 1.0]]
        left = np.asarray(np.concatenate(parts), float)
        if np.abs(left).max() <= STATIONARY * value:
            break
        J = np.zeros((size, size))
        safe = np.where(seen.radii > 0, seen.radii, 1.0)
        J[:m, :m] = np.einsum("i,ij,ik->jk", weights / safe, bends, bends) - value * np.eye(m)
        J[:m, m : m + p], J[m : m + p, :m] = gradients.T, gradients
        J[:m, m + p : -1], J[m + p : -1, :m] = E.T, E
        J[:m, -1], J[m : m + p, -1], J[-1, :m] = -u, -1.0, 2 * u
        change = np.linalg.lstsq(J, -left, rcond=ROUNDOFF)[0]
        far = float(np.linalg.norm(change[:m]))
        x = np.asarray(x + min(1.0, 0.3 / far if far > 0 else 1.0) * change, float)
    else:
        if np.abs(left).max() > NOT_STATIONARY * abs(value):
            return None
    inner = np.zeros((p, 2))
    inner[bent] = np.asarray(nu, float).reshape(-1, 2)
    return np.asarray(u / np.linalg.norm(u), float), weights, inner, value
