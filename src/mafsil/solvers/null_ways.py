"""Ways along null directions of analytic equations F(x) = 0: Newton's method in planes ever farther from a solution.

Along a motion the gap stays rounding, out to REACH; at an isolated solution it grows with a power of the step. Near
solutions of order p Newton's method converges with 1 - 1/p, in valleys that bend: its steps are prolonged to where they
lead, and corrected before they are judged.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.floating_point import LEAST_DIVISOR
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
SURE = 1e-4 / FINEST
"""Times the gap that is closed, of equations that have all their digits: below it a gap c r^p leaves its c in doubt.
Where parts of very different size share a block, Newton's method stops that near to a motion beside its direction."""
BENT = 1.5
"""Orders above it are those of solutions that are not simple."""
MOST_ORDER, JUMP = 12.0, 1e-6
"""A gap that grows faster from one step to the next, to more than this, is the end of a set smaller than the step."""
ROUNDING, CLOSED = 1e-15, 1e-12
"""Smallest gap that means anything; and gaps that Newton's method need not make smaller."""
SLIDING = 3.0
"""Steps by which Newton's method may slide, for the direction may be between tangents; farther off is another set."""
AIMED = 0.05
"""Share of it beyond which the next planes stand across where it came out."""
FEW_STEPS, MOST_STEPS = 12, 60
DAMPING, SVD_DAMPING = (1e-6, 1e-10), (1e-14, 1e-26)
"""First and least, of normal equations and of singular values."""
REGULAR, CORRECTIONS = 1e-7, 2
"""A step along a shaky direction leaves a valley that bends: damping and number of the steps that lead back into it
before its gap is judged."""
STEADY = 0.3
"""Share of the step before that a step may be, from which on they shrink like those at a multiple solution."""
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

    def _least(self, last: NDArray[np.intp]) -> Floats:
        """(k,) gaps at the last steps, of the order of each, that are surely open."""
        powers = self.steps[last] ** np.clip(np.nan_to_num(self.orders), BENT, MOST_ORDER)
        return np.asarray(SURE * min(self.exact, FINEST) * powers, dtype=np.float64)

    @property
    def verdicts(self) -> NDArray[np.intp]:
        """(k,) of `Way`: closes to the last step or to where the set ends, opens with an order, in doubt, or lost."""
        there, k = np.isfinite(self.gaps), np.arange(len(self.gaps))
        last = np.maximum(there.sum(axis=1) - 1, 0)
        final = np.where(there.any(axis=1), self.gaps[k, last], np.inf)
        closed, opened = there & (self.gaps <= self.exact), there & (self.gaps > JUMP)
        ends = (closed[:, :-1] & opened[:, 1:]).any(axis=1) & (self.orders > MOST_ORDER)
        clear = (final > CLEAR * self.exact) & ~((self.orders > BENT) & (final < self._least(last)))
        found = np.where(clear, Way.OPENS, Way.IN_DOUBT)
        closes = np.where(last == len(self.steps) - 1, Way.CLOSES, Way.LOST)
        return np.where(ends, Way.CLOSES, np.where(final <= self.exact, closes, found))


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
        rows[live[slid], -1] = np.conj(unit(along[slid]))  # 2
        ahead = x[live] + (steps[i + 1] / r) * gone
        if i:
            smooth = np.asarray(live[~slid], dtype=np.intp)
            bent = _extrapolate(gone[~slid], points[smooth, i - 1] - x[smooth], steps[: i + 2])
            ahead[~slid] = x[smooth] + bent
    return Ways(steps, points, gaps, exact)


def _extrapolate(gone: Numbers, before: Numbers, steps: Floats) -> Numbers:
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
    weights = s / np.maximum(square, LEAST_DIVISOR)
    return np.conj(np.swapaxes(Vh, 1, 2)) @ (weights[:, :, None] * np.conj(np.swapaxes(U, 1, 2)))


def _within(J: Numbers, planes: Numbers) -> Numbers:
    """J without what it has across the planes."""
    return J - (J @ np.conj(np.swapaxes(planes, 1, 2))) @ planes if planes.shape[1] else J


def unit(x: Numbers) -> Numbers:
    """Vectors (*batch, n) over their lengths; zero stays zero."""
    return x / np.maximum(np.linalg.norm(x, axis=-1, keepdims=True), LEAST_DIVISOR)
