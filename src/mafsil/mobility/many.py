"""Mobility by rank of many configurations at once: compiled, doubtful ones by singular values."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats
from mafsil.lazy_module import lazily
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.linkages.loop_closure import coordinates, loop_state, reduced_screws, units
from mafsil.mobility.on_linkage import on_linkage
from mafsil.mobility.tolerances import RANK
from mafsil.solvers import decompositions

if TYPE_CHECKING:
    import mafsil.mobility.rank_loops as rank_loops
else:
    rank_loops = lazily("mafsil.mobility.rank_loops")


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
def mobilities(linkage: Linkage, theta: ArrayLike) -> NDArray[np.intp]:
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
