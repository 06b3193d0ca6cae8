"""Loops as a system g(q) = 0: what rates its matrix leaves, which joints may be driven, and where both break.

H(q) = dg/dq, H q' = 0. With the driven joints a and the passive ones p: H_p q_p' = - H_a q_a'. The rank that H has on
most of the configurations (`rank`) decides, not its number of rows: rows of an overconstrained loop always depend.

References: Lynch & Park, Modern Robotics, sec. 7.3; Park and Kim, Singularity analysis of closed kinematic chains,
J. Mech. Design 121, 1999.

Configurations that close all loops of a chain: Newton's method with shortest steps, from one start and from others.

1. From the start itself.
2. While it stays open, from starts ever farther away, a few at a time: of those that close, the nearest in its round.
3. Of rows that never closed the one that gapes least, made to gape still less by least squares.

How near loops come to closing where they cannot: the distance to what is feasible, found by least squares.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, Integers, JointVector, as_batch, real_array
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.model import JointKind
from mafsil.parallel import closed_terms
from mafsil.parallel.closed_answers import ClosedConfigurations
from mafsil.parallel.closed_terms import LoopConditions
from mafsil.parallel.tolerances import RANK
from mafsil.solvers import levenberg_marquardt
from mafsil.solvers.decompositions import ranks, singular_values

ROTATIONS = {
    JointKind.FIXED: 3, JointKind.PRISMATIC: 3, JointKind.REVOLUTE: 2, JointKind.HELICAL: 2, JointKind.CYLINDRICAL: 2,
    JointKind.UNIVERSAL: 1, JointKind.SPHERICAL: 0, JointKind.PLANAR: 2,
}  # fmt: skip
"""Directions about which a joint does not let its child rotate: the first rows of its loop."""
CLOSED = 1e-13
"""Gap over the size of the mechanism, or in radians, at which a loop is closed: some hundred roundings."""
TYPED = 1e-9
"""Gap likewise, which rows that depend on others may leave: numbers of a file contradict each other in their last
digits, and nothing can close what they leave."""
LONGEST_STEP = 0.3
"""Of one coordinate in a Newton step [rad | sizes]."""
AT_ONCE = 8
"""How many searches begin at once after the first."""
FARTHEST_START = 1.0
"""How far from the first start the last one is [rad | sizes]."""


class DrivenStatus(Status):
    """Whether driven joints decide the others."""

    REGULAR = ("parallel.driven_regular", True)
    FREE = ("parallel.driven_free", False)
    FORBIDDEN = ("parallel.driven_forbidden", False)
    BOTH = ("parallel.driven_both", False)


@dataclass(frozen=True, eq=False, repr=False)
class DrivenRates(Answer, data="driven rank rank_passive passive_map admissible forbidden free"):
    """Rates of the passive joints of one configuration for chosen driven ones; true if these decide them.

    Attributes:
        driven, passive: indices of joints.
        rank: of H on most configurations.
        rank_passive: rank of H_p.
        independent: whether every rate of the driven joints is admissible.
        passive_map: (p, a) rates of the passive joints per rate of the driven ones, least norm; of inadmissible
            rates the nearest.
        admissible: (a, k) orthonormal rates of the driven joints that the loops allow.
        forbidden: (a, l) orthonormal rates that no motion has: driving along them breaks the mechanism.
        free: (p, f) orthonormal rates of the passive joints with the driven ones locked.
        internal: (m, f') combinations of the rows of H that no passive joint feels.
        singular_values: of H_p.
    """

    driven: tuple[int, ...]
    passive: tuple[int, ...]
    rank: int
    rank_passive: int
    independent: bool
    passive_map: Floats
    admissible: Floats
    forbidden: Floats
    free: Floats
    internal: Floats
    singular_values: Floats

    @property
    def actuation(self) -> Literal["under", "exact", "redundant"]:
        """Whether there are fewer, as many or more driven joints than first-order motions of the loops."""
        spare = len(self.driven) - (len(self.driven) + len(self.passive) - self.rank)
        return "under" if spare < 0 else "redundant" if spare else "exact"

    @property
    def regular(self) -> bool:
        """The driven joints decide all others to first order, and may be moved independently."""
        return self.rank_passive == len(self.passive) and self.independent

    @property
    def status(self) -> DrivenStatus:
        """Whether passive joints are free with the driven ones locked, and whether these can be moved independently."""
        free = self.rank_passive < len(self.passive)
        if free:
            return DrivenStatus.FREE if self.independent else DrivenStatus.BOTH
        return DrivenStatus.REGULAR if self.independent else DrivenStatus.FORBIDDEN

    def explain(self, language: str | None = None) -> str:
        """The status, with the rank, the rates that nothing decides, and those that would break the mechanism."""
        return self.status.sentence(
            language, rank=self.rank_passive, wanted=len(self.passive), free=self.free.shape[1],
            forbidden=self.forbidden.T.round(6).tolist(), least=float(self.singular_values.min(initial=np.inf)),
        )  # fmt: skip


def numerical_rank(M: Floats) -> int:
    """Number of singular values above RANK times the largest."""
    return int(ranks(M, RANK))


def kernel(M: Floats, scale: float | None = None) -> Floats:
    """(n, k) orthonormal basis of the vectors that M (m, n) maps to zero.

    Args:
        M: matrix.
        scale: singular values below RANK times it are zero; the largest of them if None.
    """
    _, s, right = np.linalg.svd(M)
    limit = RANK * (float(s.max(initial=0.0)) if scale is None else scale)
    return right[int((s > limit).sum()) :].T


def driven_rates(H: ArrayLike, driven: Sequence[int], rank: int | None = None) -> DrivenRates:
    """Rates of the passive joints for chosen driven joints, at one configuration.

    Args:
        H: (m, n) matrix of the loops, H q' = 0.
        driven: indices of the joints that are driven.
        rank: of H on most configurations; its rank here if None.

    Raises:
        InputError: no matrix, indices that are not there or doubled.
    """
    matrix = real_array("H", H)
    if matrix.ndim != 2:
        raise InputError("input.shape", name="H", expected="(m, n)", got=matrix.shape, hint="")
    n = matrix.shape[1]
    given = real_array("driven", driven)
    if given.ndim != 1 or not (np.isfinite(given) & (given == np.round(given))).all():
        raise InputError("parallel.driven", driven=given.tolist(), most=n - 1)
    chosen = tuple(int(k) for k in given)
    if len(set(chosen)) != len(chosen) or not all(0 <= k < n for k in chosen):
        raise InputError("parallel.driven", driven=list(chosen), most=n - 1)
    passive = tuple(k for k in range(n) if k not in chosen)
    H_a, H_p = matrix[:, list(chosen)], matrix[:, list(passive)]
    scale = float(np.linalg.norm(matrix, 2)) if matrix.size else 1.0
    left = kernel(H_p.T, scale)
    resisted = left.T @ H_a
    forbidden = _row_space(resisted, scale)
    admissible = kernel(forbidden.T, 1.0) if forbidden.size else np.eye(len(chosen))
    inverse = np.linalg.pinv(H_p, rcond=RANK)
    return DrivenRates(
        chosen, passive, numerical_rank(matrix) if rank is None else rank, numerical_rank(H_p), not forbidden.size,
        -inverse @ H_a, admissible, forbidden, kernel(H_p, scale), left, singular_values(H_p),
    )  # fmt: skip


def _row_space(M: Floats, scale: float) -> Floats:
    """(n, k) orthonormal basis of the rows of M."""
    _, s, right = np.linalg.svd(M, full_matrices=False)
    return right[s > RANK * scale].T


def second_form(hessians: ArrayLike, w: ArrayLike, basis: ArrayLike) -> Floats:
    """(k, k) the quadratic form w . g''(N x, N x) of the curvature of loops on a basis N of motions.

    Args:
        hessians: (m, n, n) second derivatives of g.
        w: (m,) a combination of the rows that vanishes to first order.
        basis: (n, k) motions.
    """
    N = real_array("basis", basis)
    return np.einsum("m,mij,ia,jb->ab", real_array("w", w), as_batch("hessians", hessians, (N.shape[0],) * 2), N, N)


def close_loops(chain: LoopConditions, q: JointVector, free: Integers, most: int, tries: int) -> ClosedConfigurations:
    """The nearest configurations that close all loops, as `ClosedChain.close_loops` says.

    Args:
        chain: with loops.
        q: (*batch, n) where the search begins [rad | m].
        free: indices of the coordinates that may change.
        most: steps of a search.
        tries: searches for each row.
    """
    begin, more, bound = q.reshape(-1, chain.n), tries - 1, CLOSED * chain.size
    # 1
    best, error, steps, left = _search(chain, begin, free, most)
    # 2
    rng, done = np.random.default_rng(0), 0
    while done < more and len(open_ := np.flatnonzero(error > np.maximum(bound, left))):
        count = min(AT_ONCE, more - done)
        reach = FARTHEST_START * (done + count) / more
        starts = np.repeat(begin[open_, None], count, axis=1)
        starts[..., free] += reach * rng.uniform(-1.0, 1.0, (len(open_), count, len(free))) * chain.unit[free]
        found, gap, taken, rest = _search(chain, starts.reshape(-1, chain.n), free, most)
        found, gap, rest = found.reshape(starts.shape), gap.reshape(-1, count), rest.reshape(-1, count)
        far = np.abs((found - begin[open_, None]) / chain.unit).max(axis=2)
        pick = _nearest(gap, far, np.maximum(bound, rest))
        each = np.arange(len(open_))
        better = gap[each, pick] < error[open_]
        best[open_[better]], error[open_[better]] = found[each, pick][better], gap[each, pick][better]
        left[open_[better]] = rest[each, pick][better]
        steps[open_] += taken.reshape(-1, count).sum(axis=1)
        done += count
    limits = np.maximum(bound, left)
    # 3
    widest, shape = _widest(chain, best, error, limits, free, refined=tries > 1), q.shape[:-1]
    return ClosedConfigurations(
        best.reshape(*shape, chain.n), error.reshape(shape), steps.reshape(shape), limits.reshape(shape), *widest
    )


def _search(chain: LoopConditions, rows: Floats, free: Integers, most: int) -> tuple[Floats, Floats, Integers, Floats]:
    """Newton's method from each row: the best configuration, its gap, steps, and what dependent rows leave of the gap.

    Args:
        chain: with loops.
        rows: (k, n) where it begins.
        free: indices of the coordinates that may change.
        most: steps.
    """
    rows = rows.copy()
    best, steps = rows.copy(), np.zeros(len(rows), dtype=np.int64)
    error, left = np.full(len(rows), np.inf), np.zeros(len(rows))
    open_, found = np.arange(len(rows)), chain.terms(rows)
    for _ in range(most + 1):
        gap = closed_terms.error_of(found)
        better = gap < error[open_]
        error[open_[better]], best[open_[better]] = gap[better], rows[open_[better]]
        going = gap > CLOSED * chain.size
        open_ = open_[going]
        if not len(open_):
            break
        gap, J = gap[going], found.J[going]
        move = closed_terms.correction(J[:, :, free], found.gap[going])
        spent = _spent(chain, J, found.gap[going], gap)
        if spent.any():
            left[open_[spent]] = gap[spent]
            open_, move = open_[~spent], move[~spent]
            if not len(open_):
                break
        longest = np.abs(move / chain.unit[free]).max(axis=1, initial=0.0)
        rows[open_[:, None], free] += move * np.minimum(1.0, LONGEST_STEP / np.maximum(longest, LEAST_DIVISOR))[:, None]
        steps[open_] += 1
        found = chain.terms(rows[open_])
    return best, error, steps, left


def _spent(chain: LoopConditions, J: Floats, gaps: Floats, widest: Floats) -> Booleans:
    """(k,) whether a gap is that of digits which contradict each other: no coordinate would make it smaller.

    Args:
        chain: with loops.
        J: (k, m, n) rows of the loops by all coordinates.
        gaps: (k, m).
        widest: (k,) the largest of each, infinite where a loop is closed the wrong way round.
    """
    spent = np.asarray(widest <= TYPED * chain.size)
    if spent.any():
        step = closed_terms.correction(J[spent], gaps[spent])
        within_reach = np.abs(np.einsum("kmn,kn->km", J[spent], step)).max(axis=1, initial=0.0)
        spent[spent] = within_reach <= CLOSED * chain.size
    return spent


def _nearest(gap: Floats, far: Floats, bound: Floats) -> Integers:
    """(rows,) of searches (rows, k) the nearest that closed, or the one with the least gap where none did."""
    closed = gap <= bound
    near, least = np.argmin(np.where(closed, far, np.inf), axis=1), np.argmin(gap, axis=1)
    return np.asarray(np.where(np.any(closed, axis=1), near, least), dtype=np.int64)


def _widest(
    chain: LoopConditions, best: Floats, error: Floats, bound: Floats, free: Integers, *, refined: bool
) -> tuple[str, float, float]:
    """The loop that gapes most in the row that gapes most, and by how much [m], [rad]; an empty name if none does.

    Args:
        chain: with loops.
        best, error: rows and their gaps; the row is changed to the one nearest to closing.
        bound: of gaps that count as closed.
        free: indices of the coordinates that may change.
        refined: whether to look for less than Newton's method left.
    """
    if not (error > bound).any():
        return "", 0.0, 0.0
    row = int(np.where(error > bound, error, -1.0).argmax())
    if refined and np.isfinite(error[row]):
        best[row] = least_open(chain, best[row], free)
        error[row] = float(closed_terms.error_of(chain.terms(best[row])))
    return widest_loop(chain, best[row])


def least_open(chain: LoopConditions, q: JointVector, free: Integers) -> JointVector:
    """(n,) coordinates near q at which the loops gape least: squares of angles, and of lengths over the size.

    Newton's method asks for loops that close; where they cannot it wanders, and its gap says nothing.

    Args:
        chain: with loops.
        q: (n,) where the search begins [rad | m].
        free: indices of the coordinates that may change.
    """
    lengths = np.concatenate([np.repeat([1.0, chain.size], split) for split in _splits(chain)])

    def gaps(x: Floats) -> tuple[Floats, Floats]:
        here = q.copy()
        here[free] = x * chain.unit[free]
        found = chain.terms(here)
        return found.gap / lengths, found.J[:, free] * chain.unit[free] / lengths[:, None]

    nearest = q.copy()
    nearest[free] = levenberg_marquardt(gaps, q[free] / chain.unit[free]).value * chain.unit[free]
    return nearest


def widest_loop(chain: LoopConditions, q: JointVector) -> tuple[str, float, float]:
    """The loop that gapes most at coordinates (n,), and by how much [m], [rad]."""
    first, gap, loop = 0, chain.terms(q).gap, int(chain.loop_errors(q).argmax())
    for rotations, shifts in _splits(chain)[:loop]:
        first += rotations + shifts
    rotations, shifts = _splits(chain)[loop]
    own = gap[first : first + rotations + shifts]
    distance, angle = float(np.linalg.norm(own[rotations:])), float(np.linalg.norm(own[:rotations]))
    return chain.robot.mechanism.loops[loop].name, distance, angle


def _splits(chain: LoopConditions) -> list[tuple[int, int]]:
    """For each loop its numbers of rows about and along directions."""
    kinds = [loop.kind for loop in chain.robot.mechanism.loops]
    return [(ROTATIONS[kind], 6 - kind.freedoms - ROTATIONS[kind]) for kind in kinds]
