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

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.solvers.decompositions import damped_inverse, svd

Numbers = NDArray[Any]
Equations = Callable[[Numbers], tuple[Numbers, Numbers]]
"""F (k, m) and its Jacobian (k, m, n) at x (k, n), real or complex, of unknowns and gaps of size about one."""

EXACT, FINEST = 1e-9, 1e-11
"""Gaps up to it are closed, of equations whose numbers have nine digits; and of such as have all."""
CLEAR = 30.0
"""Times as large as that they are open; in between they are in doubt."""
REACH = 0.4
"""Longest step. At an order of eight the gap there is 1e-3 times the eighth derivative, far above EXACT."""
STEPS = REACH / np.array([256.0, 64.0, 16.0, 4.0, 2.0, 1.0])
NEAR_STEPS = STEPS[2:]
"""Around a general point, which is far out itself."""
MOST_ORDER, JUMP = 12.0, 1e-6
"""A gap that grows faster from one step to the next, to more than this, is the end of a set smaller than the step."""
ROUNDING, CLOSED = 1e-15, 1e-12
"""Smallest gap that means anything; and gaps that Newton's method need not make smaller."""
LOOSE = 1e-5
"""Rank of the Jacobian at a point that was searched: a double solution is known to the root of rounding."""
SLIDING = 3.0
"""Steps by which Newton's method may slide, for the direction may be between tangents; farther off is another set."""
AIMED = 0.05
"""Share of it beyond which the next planes stand across where it came out."""
MOST_DIRECTIONS, MOST_POINTS, FEW_POINTS = 48, 8, 3
"""Directions that are tried, points at which the dimension is counted, and such at which that takes tangent by tangent:
those that are farthest apart."""
ALIKE, ALIKE_IF_SLID = 0.02, 0.3
"""Unit tangents nearer than this belong to one branch: the first step bends less. Where ways slid into a set that is
not reduced, that is as near as they come to it."""
FEW_STEPS, MOST_STEPS = 12, 60
DAMPING, SVD_DAMPING = (1e-6, 1e-10), (1e-14, 1e-26)
"""First and least, of normal equations and of singular values."""
REGULAR, CORRECTIONS = 1e-7, 2
"""A step along a shaky direction leaves a valley that bends: damping and number of the steps that lead back into it
before its gap is judged."""
STEADY = 0.3
"""Share of the step before that a step may be, from which on they shrink like those at a multiple solution."""
SPLIT = 1e3 * float(np.finfo(np.float64).eps)
"""A solution of multiplicity m is found to the m-th root of this."""
STALLED = 0.7
"""A step that leaves more of the gap than this ends: linear convergence to a solution of order p leaves e^-1 of it."""


class Way(IntEnum):
    """What the gaps along a direction say."""

    LOST = 0
    OPENS = 1
    IN_DOUBT = 2
    CLOSES = 3


@dataclass(frozen=True, eq=False)
class Ways:
    """What Newton's method finds in planes across directions from points.

    Attributes:
        steps: (s,) distances of the planes.
        points: (k, s, n) where the gap is least; NaN beyond the end of each.
        gaps: (k, s) what is left there.
        exact: gaps up to it are closed.
    """

    steps: Floats
    points: Numbers
    gaps: Floats
    exact: float

    @property
    def orders(self) -> Floats:
        """(k,) p of the gap r^p between the last step that closes, or the last but one, and the next; NaN of none."""
        there = np.isfinite(self.gaps)
        last = there.sum(axis=1) - 1
        closed = np.where(there & (self.gaps <= self.exact), np.arange(len(self.steps)), -1).max(axis=1)
        first = np.asarray(np.where(closed >= 0, np.minimum(closed, last - 1), last - 1), dtype=np.intp)
        rows, low = np.arange(len(last)), np.maximum(first, 0)
        high = np.minimum(low + 1, len(self.steps) - 1)
        before, after = np.maximum(self.gaps[rows, low], ROUNDING), np.maximum(self.gaps[rows, high], ROUNDING)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(first >= 0, np.log(after / before) / np.log(self.steps[high] / self.steps[low]), np.nan)

    @property
    def verdicts(self) -> NDArray[np.intp]:
        """(k,) of `Way`: closes to the last step or to where the set ends, opens with an order, in doubt, or lost."""
        there, k = np.isfinite(self.gaps), np.arange(len(self.gaps))
        last = np.maximum(there.sum(axis=1) - 1, 0)
        final = np.where(there.any(axis=1), self.gaps[k, last], np.inf)
        closed, opened = there & (self.gaps <= self.exact), there & (self.gaps > JUMP)
        ends = (closed[:, :-1] & opened[:, 1:]).any(axis=1) & (self.orders > MOST_ORDER)
        found = np.where(final > CLEAR * self.exact, Way.OPENS, Way.IN_DOUBT)
        closes = np.where(last == len(self.steps) - 1, Way.CLOSES, Way.LOST)
        return np.where(ends, Way.CLOSES, np.where(final <= self.exact, closes, found))


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
    null = _span(directions)
    found = ways(equations, starts, directions, null[None], planes, exact)
    verdict, orders = found.verdicts, found.orders
    opened = orders[(verdict == Way.OPENS) & np.isfinite(orders)]
    order = float(np.max(opened)) if len(opened) else float("nan")
    sure, doubtful = (np.flatnonzero(verdict == way) for way in (Way.CLOSES, Way.IN_DOUBT))
    if not len(sure):
        doubtful = np.flatnonzero((verdict == Way.IN_DOUBT) | (verdict == Way.LOST) & np.isfinite(found.gaps[:, 1]))
    ends: Numbers = _last_points(found)
    first, slid = _first_points(equations, x, found, null, exact)
    chords = _unit(np.nan_to_num(first - x))
    rows = _spread(chords, np.concatenate([sure, doubtful]), ALIKE)[:MOST_POINTS]
    low, high = (
        _dimensions(equations, ends[rows], _unit(ends[rows] - x), exact, seed).T if len(rows) else none[:0, :2].T
    )
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
    tried = _unit(some @ null)
    found = ways(equations, np.tile(x, (len(tried), 1)), tried, null[None], np.zeros((len(tried), 0, len(x))), exact)
    if (found.verdicts >= Way.IN_DOUBT).any():
        return 0
    order = max(1, round(float(np.nan_to_num(found.orders, nan=1.0).min())))
    return order if d == 1 or order == 1 else 2**d


def _dimensions(equations: Equations, points: Numbers, tangents: Numbers, exact: float, seed: int) -> NDArray[np.intp]:
    """(p, 2) dimensions at general points (p, n) of sets that go along tangents (p, n): what is sure, what may be.

    1. If ways close along a whole basis of the null space, it is the dimension.
    2. Else tangents are gathered one by one, at a few of them; zero stands at the others.
    """
    bases: list[Numbers] = [null_directions(J, LOOSE) for J in equations(points)[1]]
    along: list[Numbers] = [_unit((K @ (np.conj(K.T) @ t))[None]) for K, t in zip(bases, tangents, strict=True)]
    found = np.ones((len(points), 2), dtype=np.intp)
    for d in sorted({K.shape[1] for K in bases} - {0, 1}):
        alike: list[int] = [k for k, K in enumerate(bases) if K.shape[1] == d]
        across = np.concatenate([_across(bases[k], along[k]) for k in alike])
        starts = np.repeat(points[alike], d - 1, axis=0)
        planes = np.repeat(np.conj(np.array([along[k] for k in alike])), d - 1, axis=0)
        null = np.repeat(across.reshape(-1, d - 1, across.shape[1]), d - 1, axis=0)
        tried = ways(equations, starts, across, null, planes, exact, NEAR_STEPS)
        whole = (tried.verdicts.reshape(-1, d - 1) == Way.CLOSES).all(axis=1)
        rest = [k for k, good in zip(alike, whole.tolist(), strict=True) if not good]
        found[alike], found[rest] = d, 0
        for k in rest[:FEW_POINTS]:
            found[k] = _gathered(equations, points[k], bases[k], along[k], exact, seed)
    return found


def _gathered(
    equations: Equations, x: Numbers, K: Numbers, tangents: Numbers, exact: float, seed: int
) -> tuple[int, int]:
    """Step 2 at one point: each next tangent within the null space K (n, d) and the planes across those before."""
    rng, doubtful = np.random.default_rng(seed), False
    while len(tangents) < K.shape[1]:
        basis = _across(K, tangents)
        some = rng.normal(size=(4 * len(basis), len(basis))) if len(basis) > 1 else np.array([[1.0], [-1.0]])
        tried = _unit(some @ basis)
        starts, planes = np.tile(x, (len(tried), 1)), np.tile(np.conj(tangents), (len(tried), 1, 1))
        found = ways(equations, starts, tried, basis[None], planes, exact, NEAR_STEPS)
        verdict = found.verdicts
        doubtful = doubtful or bool((verdict == Way.IN_DOUBT).any())
        if not (verdict == Way.CLOSES).any():
            break
        along = np.conj(basis) @ (found.points[int((verdict == Way.CLOSES).argmax()), 0] - x)
        tangents = np.concatenate([tangents, _unit((along @ basis)[None])])
    return len(tangents), len(tangents) + int(doubtful)


def ways(
    equations: Equations, x: Numbers, directions: Numbers, null: Numbers, planes: Numbers, exact: float,
    steps: Floats = STEPS,
) -> Ways:  # fmt: skip
    """Solutions in planes ever farther along directions.

    1. Newton's method in the next plane, from where the last solutions lead; a way ends that comes out elsewhere, not
       along the null space, or opens twice.
    2. Where it slid far, for its direction was between tangents, the next planes stand across where it came out.

    Args:
        equations: analytic.
        x: (k, n) solutions.
        directions: (k, n) unit.
        null: (k | 1, d, n) orthonormal rows that span the null spaces in which directions are.
        planes: (k, c, n) orthonormal rows, across the null spaces, in which solutions have to lie.
        exact: gaps up to it are closed.
        steps: that grow.
    """
    k, n = x.shape
    rows = np.concatenate([planes, np.conj(directions)[:, None]], axis=1)
    points, gaps = np.full((k, len(steps), n), np.nan, dtype=x.dtype), np.full((k, len(steps)), np.nan)
    live: NDArray[np.intp] = np.arange(len(x))
    ahead = x + steps[0] * directions
    for i, r in enumerate(steps.tolist()):
        refined = exact if null.shape[1] > 1 else np.inf
        here, gap = solved_in_planes(equations, ahead, rows[live], r, refined, exact / 10)  # 1
        off: Floats = np.linalg.norm(here - ahead, axis=1)
        open_twice = (gap > CLEAR * exact) & (gaps[live, i - 1] > CLEAR * exact) if i else gap < 0
        gone = here - x[live]
        basis = null[live] if len(null) > 1 else null
        along = np.einsum("kdn,kd->kn", basis, np.einsum("kdn,kn->kd", np.conj(basis), gone))
        across: Floats = np.linalg.norm(gone - along, axis=1)
        kept = np.asarray((off <= SLIDING * r) & (across <= np.linalg.norm(along, axis=1)), dtype=np.bool_)
        points[live[kept], i], gaps[live[kept], i] = here[kept], gap[kept]
        going = np.asarray(kept & ~open_twice, dtype=np.bool_)
        live = np.asarray(live[going], dtype=np.intp)
        gone, along, slid = gone[going], along[going], np.asarray(off[going] > AIMED * r, dtype=np.bool_)
        if i + 1 == len(steps) or not len(live):
            break
        rows[live[slid], -1] = np.conj(_unit(along[slid]))  # 2
        ahead = x[live] + (steps[i + 1] / r) * gone
        if i:
            smooth = np.asarray(live[~slid], dtype=np.intp)
            bent = _extrapolated(gone[~slid], points[smooth, i - 1] - x[smooth], steps[: i + 2])
            ahead[~slid] = x[smooth] + bent
    return Ways(steps, points, gaps, exact)


def _extrapolated(gone: Numbers, before: Numbers, steps: Floats) -> Numbers:
    """(k, n) t r + c r^2 at the last of steps, through what was gone at the two before."""
    first, second, third = steps[-3:]
    bend = (gone / second - before / first) / (second - first)
    return third * (gone / second + bend * (third - second))


def solved_in_planes(
    equations: Equations, starts: Numbers, planes: Numbers, step: float, exact: float = FINEST, closed: float = CLOSED
) -> tuple[Numbers, Floats]:
    """Solutions in planes through starts, or where the gap is least: points (k, n) and gaps (k,).

    1. Damped Newton's method, its normal equations free of directions that fade.
    2. Where it leaves a gap that a shaky order above two could have, again with singular values, to rounding.

    Args:
        equations: analytic.
        starts: (k, n).
        planes: (k, c, n) orthonormal rows.
        step: how far from a solution the starts are.
        exact: gaps up to it are closed; infinite where no direction is left in which to slide.
        closed: gaps that need not become smaller; zero where multiple solutions are wanted to rounding.
    """
    x, gap = _newton(equations, starts, planes, step, damped_inverse, DAMPING, 0, closed)
    fine = np.flatnonzero((gap > (exact if closed else 0.0)) & (gap < step**2.5) & np.isfinite(exact))
    if len(fine):
        x[fine], gap[fine] = _newton(
            equations, x[fine], planes[fine], step, _svd_inverse, SVD_DAMPING, CORRECTIONS, closed
        )  # fmt: skip
    return x, gap


def _newton(
    equations: Equations,
    starts: Numbers,
    planes: Numbers,
    step: float,
    inverse: Any,
    damped: tuple[float, float],
    corrections: int,
    closed: float,
) -> tuple[Numbers, Floats]:
    """Damped Newton's method in planes; a row ends when a step leaves more than STALLED of its gap, or at rounding.

    At a solution of order p each step leaves 1 - 1/p of the way: steps that shrink steadily are prolonged to where they
    lead (Aitken), and taken back if that opens more.
    """
    x, damping = starts.copy(), np.full((len(starts), 1, 1), damped[0])
    before, plain = np.full(len(starts), np.inf), np.zeros(len(starts), dtype=np.bool_)
    F, J = equations(x)
    J = _within(J, planes)
    cost = np.linalg.norm(F, axis=1)
    live = np.flatnonzero(cost > closed)
    for _ in range(MOST_STEPS if corrections else FEW_STEPS):
        if not len(live):
            break
        move = -_step(inverse(J[live], damping[live]), F[live], planes[live])
        length = np.linalg.norm(move, axis=1)
        left = length / before[live]
        longer = np.where((left > STEADY) & (left < 1.0) & ~plain[live], 1.0 / np.maximum(1.0 - left, 0.02), 1.0)
        move *= (np.minimum(longer * length, step) / np.maximum(length, ROUNDING))[:, None]
        ahead, (F_ahead, J_ahead) = x[live] + move, equations(x[live] + move)
        for _ in range(corrections):
            back = damped_inverse(_within(J_ahead, planes[live]), REGULAR)
            ahead -= _step(back, F_ahead, planes[live])
            F_ahead, J_ahead = equations(ahead)
        after = np.linalg.norm(F_ahead, axis=1)
        better, tried = after < cost[live], longer > 1.0
        stalled = (after > STALLED * cost[live]) & (damping[live, 0, 0] <= damped[1])
        ends = np.asarray(np.where(better, stalled, ~tried & (damping[live, 0, 0] > 1.0)), dtype=np.bool_)
        taken = live[better]
        x[taken] = ahead[better]
        F[taken], J[taken], cost[taken] = F_ahead[better], _within(J_ahead[better], planes[taken]), after[better]
        before[live], plain[live] = np.where(better & ~tried, length, np.inf), tried & ~better
        damping[live] *= np.where(better, 1e-2, np.where(tried, 1.0, 1e2))[:, None, None]
        damping[live] = np.maximum(damping[live], damped[1])
        live = live[~ends & (cost[live] > closed)]
    return x, np.abs(F).max(axis=1, initial=0.0)


def _step(inverse: Numbers, F: Numbers, planes: Numbers) -> Numbers:
    """(k, n) without what rounding makes of it across the planes."""
    step = np.einsum("kij,kj->ki", inverse, F)
    return step - np.einsum("kci,kc->ki", np.conj(planes), np.einsum("kci,ki->kc", planes, step))


def _svd_inverse(J: Numbers, damping: Floats) -> Numbers:
    """(k, n, m) damped inverse by singular values, which keeps slopes that normal equations lose."""
    U, s, Vh = svd(J)
    square = s**2 + damping[:, 0] * np.maximum(s[:, :1] ** 2, ROUNDING)
    weights = s / np.maximum(square, np.finfo(np.float64).tiny)
    return np.conj(np.swapaxes(Vh, 1, 2)) @ (weights[:, :, None] * np.conj(np.swapaxes(U, 1, 2)))


def _within(J: Numbers, planes: Numbers) -> Numbers:
    """J without what it has across the planes."""
    return J - (J @ np.conj(np.swapaxes(planes, 1, 2))) @ planes if planes.shape[1] else J


def _across(K: Numbers, tangents: Numbers) -> Numbers:
    """(d - t, n) orthonormal basis of what the columns of K span beyond tangents."""
    rest = K - tangents.T @ (np.conj(tangents) @ K)
    U, _, _ = np.linalg.svd(rest, full_matrices=False)
    return U[:, : K.shape[1] - len(tangents)].T


def _span(vectors: Numbers) -> Numbers:
    """(d, n) orthonormal rows that span vectors (k, n)."""
    _, s, Vh = np.linalg.svd(vectors, full_matrices=False)
    return Vh[s > LOOSE * s[0]]


def _unit(x: Numbers) -> Numbers:
    return x / np.maximum(np.linalg.norm(x, axis=-1, keepdims=True), np.finfo(np.float64).tiny)


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
    along = _unit((ends[reached] - x) @ np.conj(null).T @ null)
    turned = np.linalg.norm(along - _unit(points[reached] - x), axis=1) > AIMED
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
