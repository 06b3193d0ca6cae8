"""Mobility at one configuration: the rank of what the loops ask, the rates that are left, and what they move.

Mobility by rank of many configurations at once: compiled, doubtful ones by singular values.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, positive
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.mobility.linkages.linkage import Linkage, on_linkage
from mafsil.mobility.linkages.loop_closure import (
    LoopState,
    configuration,
    coordinates,
    loop_state,
    reduced_screws,
    units,
)
from mafsil.mobility.tolerances import IN_SUPPORT, RANK
from mafsil.solvers import decompositions
from mafsil.solvers.decompositions import null_basis

if TYPE_CHECKING:
    import mafsil.mobility.rank_loops as rank_loops
else:
    rank_loops = lazily("mafsil.mobility.rank_loops")


class InstantStatus(Status):
    """Whether rates of the joints are possible that the loops allow to first order."""

    MOVES = ("mobility.instant_moves", True)
    FIXED = ("mobility.instant_fixed", False)


@dataclass(frozen=True, eq=False)
class IdleFreedom:
    """A motion that leaves the output body at rest.

    Attributes:
        joints: names of those that move.
        count: how many independent motions these joints have so.
    """

    joints: tuple[str, ...]
    count: int


@dataclass(frozen=True, eq=False, repr=False)
class InstantaneousMobility(
    Answer,
    data="mobility rank rows redundant output_mobility output_rotations kept dropped rates idle",
):
    """Mobility by rank at one configuration; true if something can move.

    Attributes:
        linkage: what was looked at.
        theta: (F,) where.
        rank: of the loop matrix.
        rows: 6 L, what the loops ask, dependent or not.
        rates: (F, d) orthonormal basis of the possible rates, translations over the size of the linkage.
        output_twists: (6, d) of the output body, about the middle of the linkage.
        kept, dropped: smallest singular value that counts and largest that does not, over the largest of all.
    """

    linkage: Linkage
    theta: Floats
    rank: int
    rows: int
    rates: Floats
    output_twists: Floats
    kept: float
    dropped: float

    @property
    def mobility(self) -> int:
        """d, number of independent rates."""
        return self.rates.shape[1]

    @property
    def redundant(self) -> int:
        """Number of constraints that others imply here."""
        return self.rows - self.rank

    @property
    def output_mobility(self) -> int:
        """Number of independent twists of the output body."""
        return _rank(self.output_twists)

    @property
    def output_rotations(self) -> int:
        """Number of independent angular velocities of the output body."""
        return _rank(self.output_twists[:3])

    @property
    def idle(self) -> tuple[IdleFreedom, ...]:
        """Motions that leave the output body at rest, split into those that share no joint."""
        return idle_freedoms(self)

    @property
    def status(self) -> InstantStatus:
        """By the number of rates."""
        return InstantStatus.MOVES if self.mobility else InstantStatus.FIXED

    def rates_of(self, joint: str) -> Floats:
        """(d,) or (f, d) rates of a joint in each basis motion [rad/s, m/s]."""
        columns = self.linkage.columns_of([joint])
        rows = self.rates[columns] * units(self.linkage)[columns, None]
        return rows[0] if len(rows) == 1 else rows

    def explain(self, language: str | None = None) -> str:
        """Rank, mobility, what the output body does of it, redundant constraints."""
        own = {"mobility": self.mobility, "freedoms": self.linkage.coordinates, "rank": self.rank}
        moved = {"mobility": self.output_mobility, "rotations": self.output_rotations, "output": self.linkage.output}
        lines = [say("mobility.instant", language=language, **own), say("mobility.output", language=language, **moved)]
        if self.redundant:
            lines.append(say("mobility.redundant", language=language, count=self.redundant, rows=self.rows))
        return "\n".join(lines)


@on_linkage
def instantaneous_mobility(
    linkage: Linkage, theta: ArrayLike | None = None, *, locked: Iterable[str] = (), share: float = RANK
) -> InstantaneousMobility:
    """Mobility by rank: rates of the joints that all loops allow to first order.

    1. Loop matrix A: each independent loop asks that the twists along it sum to zero.
    2. Singular values; those below a share of the largest count as zero.
    3. The null space of A holds the possible rates; the walk to the output body gives its twists.

    Args:
        linkage: as drawn.
        theta: (F,) coordinates that close all loops [rad | m]; as drawn if None.
        locked: names of joints that do not move.
        share: of the largest singular value: 1e-9 is what nine digits of a drawing leave.

    Raises:
        InputError: a share that is not positive.
    """
    value = configuration(linkage, theta)
    state = loop_state(linkage, value)
    moving = np.ones(linkage.coordinates)
    moving[linkage.columns_of(locked)] = 0.0
    return at_state(linkage, value, state, moving, positive("share", share))


def at_state(
    linkage: Linkage, theta: Floats, state: LoopState, moving: Floats, share: float = RANK
) -> InstantaneousMobility:
    """The same, of a state that is known; `moving` (F,) is 0 for locked coordinates."""
    free = np.flatnonzero(moving)
    rank, basis, kept, dropped = null_space(state.matrix[:, free], share)
    rates = np.zeros((linkage.coordinates, basis.shape[1]))
    rates[free] = basis
    screws = reduced_screws(linkage, state.screws)
    path = linkage.paths[linkage.bodies.index(linkage.output)][linkage.joint_of]
    return InstantaneousMobility(linkage, theta, rank, len(state.matrix), rates, (screws * path) @ rates, kept, dropped)


def null_space(A: Floats, share: float = RANK) -> tuple[int, Floats, float, float]:
    """Rank, orthonormal null space (n, d), smallest kept and largest dropped singular value over the largest."""
    m, n = A.shape
    if not m or not n:
        return 0, np.eye(n), 1.0, 0.0
    s = np.asarray(np.linalg.svd(A, compute_uv=False))
    largest = max(float(s[0]), LEAST_DIVISOR)
    rank = int((s > share * largest).sum()) if s[0] > 0 else 0
    dropped = float(s[rank] / largest) if rank < len(s) else 0.0
    return rank, null_basis(A, rank), float(s[rank - 1] / largest) if rank else 1.0, dropped


def idle_freedoms(found: InstantaneousMobility) -> tuple[IdleFreedom, ...]:
    """Motions without the output body.

    The projector on them is block diagonal where they share no joint: its blocks are the idle freedoms.
    """
    _, inner, _, _ = null_space(found.output_twists)
    quiet = found.rates @ inner
    if not quiet.shape[1]:
        return ()
    linked = np.abs(quiet @ quiet.T) > IN_SUPPORT
    owners = linkage_blocks(linked, found.linkage)
    blocks: list[IdleFreedom] = []
    for block in owners:
        rows = np.isin(found.linkage.joint_of, list(block))
        names = tuple(found.linkage.joints[k].name for k in sorted(block))
        blocks.append(IdleFreedom(names, round(float(np.sum(quiet[rows] ** 2)))))
    return tuple(blocks)


def linkage_blocks(linked: np.ndarray[tuple[int, int], np.dtype[np.bool_]], linkage: Linkage) -> list[set[int]]:
    """Sets of joints that a symmetric relation (F, F) of their coordinates connects."""
    sets: list[set[int]] = []
    for k in range(len(linked)):
        together = {int(linkage.joint_of[j]) for j in np.flatnonzero(linked[k])}
        if not together:
            continue
        joined = [one for one in sets if one & together]
        sets = [one for one in sets if not one & together] + [together.union(*joined)]
    return sorted(sets, key=min)


def _rank(A: Floats) -> int:
    s = np.linalg.svd(A, compute_uv=False) if A.size else np.zeros(0)
    return int((s > RANK**0.5 * max(1.0, float(s.max(initial=0.0)))).sum())


@dataclass(frozen=True, eq=False)
class _Pattern:
    """A linkage as arrays for the compiled loops; names as there."""

    units: Floats
    screws: Floats
    first: NDArray[np.int64]
    tree: NDArray[np.int64]
    ends: NDArray[np.int64]
    closing: NDArray[np.int64]
    cycles: NDArray[np.int64]


@lru_cache(maxsize=64)
def _pattern(linkage: Linkage) -> _Pattern:
    first = np.concatenate([[0], np.cumsum([each.freedoms for each in linkage.joints])]).astype(np.int64)
    tree = np.array([[k, int(forward)] for k, forward in linkage.tree], dtype=np.int64).reshape(-1, 2)
    screws, closing = np.ascontiguousarray(reduced_screws(linkage).T), np.array(linkage.closing, dtype=np.int64)
    ends, cycles = linkage.ends.astype(np.int64), linkage.cycles.astype(np.int64)
    return _Pattern(units(linkage), screws, first, tree, ends, closing, cycles)


@on_linkage
def batch_mobility(linkage: Linkage, theta: ArrayLike) -> NDArray[np.intp]:
    """(*batch,) mobility by rank of many configurations (*batch, F) at once; each must close the loops [rad | m].

    Memory beyond input and output: two bytes and a number for each row.
    """
    value = coordinates(linkage, theta)
    if linkage.apart or linkage.couplings or linkage.pairs:
        return by_singular_values(linkage, value.reshape(-1, linkage.coordinates)).reshape(value.shape[:-1])
    if not linkage.loops:
        return np.full(value.shape[:-1], linkage.coordinates, dtype=np.intp)
    p = _pattern(linkage)
    u = np.ascontiguousarray(value.reshape(-1, linkage.coordinates) / p.units)
    rank, doubt = np.zeros(len(u), dtype=np.int64), np.zeros(len(u), dtype=np.bool_)
    rank_loops.ranks(u, p.screws, p.first, p.tree, p.ends, p.closing, p.cycles, RANK, rank, doubt)
    if doubt.any():
        rank[doubt] = linkage.coordinates - by_singular_values(linkage, u[doubt] * p.units)
    return np.asarray(linkage.coordinates - rank.reshape(value.shape[:-1]), dtype=np.intp)


def by_singular_values(linkage: Linkage, theta: Floats) -> NDArray[np.intp]:
    """(k,) the same of a few configurations (k, F), without compiled loops."""
    A = loop_state(linkage, theta).matrix
    return np.asarray(linkage.coordinates - decompositions.ranks(A, RANK), dtype=np.intp)
