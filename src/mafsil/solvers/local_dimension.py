"""What the solutions of analytic equations F(x) = 0 are around one of them: isolated, simple or multiple, or a set.

Where the Jacobian has rank n, the solution is simple. Else each direction u of its null space is tried: Newton's
method, to rounding, in the planes u . (y - x) = r at steps r that grow from REACH / 256 to REACH. Along a motion the
gap stays rounding; at an isolated solution it grows as r^p, which is told from two steps. A set of dimension k meets
planes through a general point of it, across k - 1 of its tangents, in curves: its dimension is counted tangent by
tangent. Real solutions are looked for among real numbers, complex ones among complex.

A gap that is neither exact nor clear leaves two numbers: the dimension that is sure, and the one that may be.

References: Bates, Hauenstein, Peterson and Sommese, A numerical local dimension test for points on the solution set of
a system of polynomial equations, SIAM J. Numer. Anal. 47, 2009; Sommese and Wampler, The Numerical Solution of Systems
of Polynomials, 2005, ch. 13 (slices by planes).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.floating_point import EPS
from mafsil.solvers.null_ways import (
    AIMED,
    CLEAR,
    FINEST,
    ROUNDING,
    STEPS,
    Equations,
    Numbers,
    Way,
    Ways,
    solved_in_planes,
    unit,
    ways,
)

NEAR_STEPS = STEPS[2:]
"""Around a general point, which is far out itself."""
LOOSE = 1e-5
"""Rank of the Jacobian at a point that was searched: a double solution is known to the root of rounding."""
MOST_DIRECTIONS, MOST_POINTS, FEW_POINTS = 48, 8, 3
"""Directions that are tried, points at which the dimension is counted, and such at which that takes tangent by tangent:
those that are farthest apart."""
ALIKE, ALIKE_IF_SLID = 0.02, 0.3
"""Unit tangents nearer than this belong to one branch: the first step bends less. Where ways slid into a set that is
not reduced, that is as near as they come to it."""
SPLIT = 1e3 * EPS
"""A solution of multiplicity m is found to the m-th root of this."""


@dataclass(frozen=True, eq=False)
class LocalSet:
    """The solutions around one of them.

    Attributes:
        dimension: largest that is sure; 0 if isolated.
        at_most: largest that may be; above `dimension` where a gap is neither exact nor clear.
        dimensions: those of the sets through it that were found, largest first.
        tangents: (k, n) unit directions along which solutions were found.
        points: (k, n) solutions at the first step along them.
        order: with which the gap grows along null directions that no set follows; of one such direction the
            multiplicity of an isolated solution; NaN if there is none.
        gap: that left the doubt, or the widest that was taken for none.
        far: (k, n) solutions at the longest step.
        lines: number of different lines among the tangents.
    """

    dimension: int
    at_most: int
    dimensions: tuple[int, ...]
    tangents: Numbers
    points: Numbers
    order: float
    gap: float
    far: Numbers
    lines: int


def null_directions(J: Numbers, share: float) -> Numbers:
    """(n, d) orthonormal basis of the null space of J (m, n), singular values below a share of the largest as zero."""
    _, s, Vh = np.linalg.svd(J)
    rank = int((s > share * max(float(s.max(initial=0.0)), ROUNDING)).sum())
    return np.conj(Vh[rank:]).T


def local_set(equations: Equations, x: Numbers, directions: Numbers, exact: float = FINEST, seed: int = 0) -> LocalSet:
    """The solutions around one that is not simple.

    1. Ways along the directions, and what their gaps say.
    2. Where they closed, at points apart from each other, the dimension, tangent by tangent.

    Args:
        equations: analytic.
        x: (n,) a solution.
        directions: (k, n) unit vectors of the null space of the Jacobian, which tangents of sets may be.
        exact: gaps up to it are closed.
        seed: of the directions tried at other points.
    """
    none = np.zeros((0, len(x)), dtype=x.dtype)
    directions = apart(directions, ALIKE)[:MOST_DIRECTIONS]
    if not len(directions):
        return LocalSet(0, 0, (), none, none, float("nan"), 0.0, none, 0)
    starts, planes = np.tile(x, (len(directions), 1)), np.zeros((len(directions), 0, len(x)))
    null = null_directions(equations(x[None])[1][0], LOOSE).T
    found = ways(equations, starts, directions, null[None], planes, exact)
    verdict, orders = found.verdicts, found.orders
    opened = orders[(verdict == Way.OPENS) & np.isfinite(orders)]
    order = float(np.max(opened)) if len(opened) else float("nan")
    sure, doubtful = (np.flatnonzero(verdict == way) for way in (Way.CLOSES, Way.IN_DOUBT))
    if not len(sure):
        doubtful = np.flatnonzero((verdict == Way.IN_DOUBT) | (verdict == Way.LOST) & np.isfinite(found.gaps[:, 1]))
    ends: Numbers = _last_points(found)
    first, slid = _first_points(equations, x, found, null, exact)
    chords = unit(np.nan_to_num(first - x))
    rows = _spread(chords, np.concatenate([sure, doubtful]), ALIKE)[:MOST_POINTS]
    low, high = _dimensions(equations, ends[rows], unit(ends[rows] - x), exact, seed).T if len(rows) else none[:0, :2].T
    known, at_most = low[(verdict[rows] == Way.CLOSES) & (low > 0)].tolist(), int(max(high, default=0))
    gaps = np.concatenate([np.nanmax(found.gaps[[*sure, *doubtful]], axis=1, initial=0.0), [0.0]])
    return LocalSet(
        max(known, default=0), at_most, tuple(sorted(set(known), reverse=True)), chords[sure], first[sure],
        order, float(gaps.max()), ends[sure], len(_spread(chords, sure, ALIKE_IF_SLID if slid else ALIKE)),
    )  # fmt: skip


def multiplicity(equations: Equations, x: Numbers, share: float, exact: float) -> int:
    """Of an isolated solution (n,), made exact before; 0 on a set, or in doubt of one.

    A general plane near a set meets it. Along one null direction the gap grows with the multiplicity; of d null
    directions without a linear term it is 2^d at least.

    Args:
        equations: analytic, as many as unknowns.
        x: (n,) a solution, to rounding.
        share: singular values below this share of the largest are zero.
        exact: gaps up to it are closed.
    """
    null = null_directions(equations(x[None])[1][0], share).T
    d = len(null)
    if not d:
        return 1
    some = np.random.default_rng(0).normal(size=(2, d)) if d > 1 else np.ones((1, 1))
    tried = unit(some @ null)
    found = ways(equations, np.tile(x, (len(tried), 1)), tried, null[None], np.zeros((len(tried), 0, len(x))), exact)
    if (found.verdicts >= Way.IN_DOUBT).any():
        return 0
    order = max(1, round(float(np.nan_to_num(found.orders, nan=1.0).min())))
    return order if d == 1 or order == 1 else 2**d


def _dimensions(equations: Equations, points: Numbers, tangents: Numbers, exact: float, seed: int) -> NDArray[np.intp]:
    """(p, 2) dimensions at general points (p, n) of sets that go along tangents (p, n): what is sure, what may be.

    1. If ways close along a whole basis of the null space and along its sum, it is the dimension. Ways that slide say
       nothing: where the set is thinner, several of them end on one line of it.
    2. Else tangents are gathered one by one, at a few of them; zero stands at the others.
    """
    bases: list[Numbers] = [null_directions(J, LOOSE) for J in equations(points)[1]]
    along: list[Numbers] = [unit((K @ (np.conj(K.T) @ t))[None]) for K, t in zip(bases, tangents, strict=True)]
    found = np.ones((len(points), 2), dtype=np.intp)
    for d in sorted({K.shape[1] for K in bases} - {0, 1}):
        alike: list[int] = [k for k, K in enumerate(bases) if K.shape[1] == d]
        across = np.array([_across(bases[k], along[k]) for k in alike])
        beside = np.concatenate([across, unit(across.sum(axis=1, keepdims=True))], axis=1)[:, : d if d > 2 else 1]
        each = beside.shape[1]
        aimed, starts = np.concatenate(beside), np.repeat(points[alike], each, axis=0)
        planes = np.repeat(np.conj(np.array([along[k] for k in alike])), each, axis=0)
        null = np.repeat(across, each, axis=0)
        tried = ways(equations, starts, aimed, null, planes, exact, NEAR_STEPS)
        closes = (tried.verdicts == Way.CLOSES) & ~(_slid(tried.points[:, 0] - starts, aimed, null) > AIMED)
        whole = closes.reshape(-1, each).all(axis=1)
        rest = [k for k, good in zip(alike, whole.tolist(), strict=True) if not good]
        found[alike], found[rest] = d, 0
        for k in rest[:FEW_POINTS]:
            found[k] = _gather(equations, points[k], bases[k], along[k], exact, seed)
    return found


def _slid(gone: Numbers, aimed: Numbers, null: Numbers) -> Floats:
    """(k,) how far ways (k, n), within null spaces (k, d, n), turned from unit directions (k, n)."""
    along = np.einsum("kdn,kd->kn", null, np.einsum("kdn,kn->kd", np.conj(null), gone))
    return np.linalg.norm(unit(along) - aimed, axis=1)


def _gather(
    equations: Equations, x: Numbers, K: Numbers, tangents: Numbers, exact: float, seed: int
) -> tuple[int, int]:
    """Step 2 at one point: each next tangent within the null space K (n, d) and the planes across those before."""
    rng, doubtful = np.random.default_rng(seed), False
    while len(tangents) < K.shape[1]:
        basis = _across(K, tangents)
        some = rng.normal(size=(4 * len(basis), len(basis))) if len(basis) > 1 else np.array([[1.0], [-1.0]])
        tried = unit(some @ basis)
        starts, planes = np.tile(x, (len(tried), 1)), np.tile(np.conj(tangents), (len(tried), 1, 1))
        found = ways(equations, starts, tried, basis[None], planes, exact, NEAR_STEPS)
        verdict = found.verdicts
        doubtful = doubtful or bool((verdict == Way.IN_DOUBT).any())
        if not (verdict == Way.CLOSES).any():
            break
        along = np.conj(basis) @ (found.points[int((verdict == Way.CLOSES).argmax()), 0] - x)
        tangents = np.concatenate([tangents, unit((along @ basis)[None])])
    return len(tangents), len(tangents) + int(doubtful)


def _across(K: Numbers, tangents: Numbers) -> Numbers:
    """(d - t, n) orthonormal basis of what the columns of K span beyond tangents."""
    rest = K - tangents.T @ (np.conj(tangents) @ K)
    U, _, _ = np.linalg.svd(rest, full_matrices=False)
    return U[:, : K.shape[1] - len(tangents)].T


def apart(vectors: Numbers, least: float) -> Numbers:
    """Of vectors (k, n) the first of those that are nearer to each other."""
    kept: list[Numbers] = []
    for one in vectors:
        if not kept or float(np.linalg.norm(np.array(kept) - one, axis=1).min()) > least:
            kept.append(one)
            if len(kept) == MOST_DIRECTIONS:
                break
    return np.array(kept, dtype=vectors.dtype).reshape(-1, vectors.shape[1])


def _first_points(equations: Equations, x: Numbers, found: Ways, null: Numbers, exact: float) -> tuple[Numbers, bool]:
    """(k, n) points at the first step; of ways that slid, of the set in which they ended, followed back to there.

    And whether any did.
    """
    points: Numbers = found.points[:, 0].copy()
    ends: Numbers = found.points[:, -1]
    reached = np.flatnonzero(np.isfinite(ends).all(axis=1))
    along = unit((ends[reached] - x) @ np.conj(null).T @ null)
    turned = np.linalg.norm(along - unit(points[reached] - x), axis=1) > AIMED
    slid, u = reached[turned], along[turned]
    if not len(slid):
        return points, False
    here = ends[slid]
    for step, before in zip(found.steps[-2::-1], found.steps[:0:-1], strict=True):
        gone, less = (here - x), float(step / before)
        straight = (np.conj(u) * gone).sum(axis=1, keepdims=True) * u
        ahead = x + less * straight + less**2 * (gone - straight)
        here, _ = solved_in_planes(equations, ahead, np.conj(u)[:, None], float(step), exact)
    points[slid] = here
    return points, True


def _last_points(found: Ways) -> Numbers:
    """(k, n) the farthest point of each way that closes: a general one."""
    good = np.isfinite(found.gaps) & (found.gaps <= CLEAR * found.exact)
    last = np.asarray(np.where(good, np.arange(len(found.steps)), 0).max(axis=1), dtype=np.intp)
    return found.points[np.arange(len(last)), last]


def _spread(chords: Numbers, rows: NDArray[np.intp], alike: float) -> NDArray[np.intp]:
    """Of rows those whose lines differ, each the farthest from those before."""
    kept: list[int] = []
    cosine, near = np.abs(np.conj(chords) @ chords.T), np.zeros(len(chords))
    while len(rows):
        best = int(near[rows].argmin())
        if kept and near[rows[best]] > np.cos(alike):
            break
        kept.append(int(rows[best]))
        near = np.maximum(near, cosine[kept[-1]])
    return np.array(kept, dtype=np.intp)
