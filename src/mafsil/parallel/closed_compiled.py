"""The compiled ways of one closed chain, each made at its first use; where there is none, the careful way remains.

Which rows of loops are independent, and which driven joints decide, once for a mechanism.

Compiled code of fixed size cannot look for the rank of the loops at each state. Rows are chosen at configurations
anywhere on the motion; every compiled result comes with a number, its doubt, that says whether they do at its state.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Integers
from mafsil.mechanics.loop_terms import Holding
from mafsil.model import Mechanism
from mafsil.parallel import closed_kernels
from mafsil.parallel.closed_kernels import Rows
from mafsil.parallel.closed_terms import Terms
from mafsil.parallel.tolerances import RANK
from mafsil.solvers import decompositions

REMAINDERS = (0.2, 0.02, 2e-3)
"""Shares of a row that must be left beside the rows before it for it to be taken, one pass after the other: the first
rows that are well apart, so that the choice is the same at nearly all configurations."""
MOST = 0.75
"""Share of the states at which that has to be so: a few may happen to be nearly singular."""
Run = Callable[..., Any]
LOOKED_AT = 24
"""Most of the given configurations that are looked at."""


class CompiledChain:
    """Compiled code of a closed chain, called like kernels; the last result says whether the others hold.

    Args:
        mechanism: with loops.
        driven: coordinates of the driven joints.
        tolerance: gap of a closed loop [rad | m].
        anywhere: gives terms at configurations anywhere on the motion, or None if none were met.
        terms: gives those of given coordinates.

    Attributes:
        forward: forward dynamics by the number of efforts; filled by `forward_for`.
        rank: number of independent rows of the loops.
        redundancy: dimensions of the preload.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        driven: Rows,
        tolerance: float,
        anywhere: Callable[[Mechanism], Terms | None],
        terms: Callable[[ArrayLike], Terms],
    ) -> None:
        self._mechanism, self._driven, self._tolerance = mechanism, driven, tolerance
        self._anywhere, self._terms = anywhere, terms
        self._ways: dict[str, Run | None] = {}
        self._holding: Holding | None = None
        self._looked = False
        self.forward: dict[int, Run | None] = {}
        self.rank = self.redundancy = 0

    def holding(self, q: ArrayLike) -> Holding | None:
        """How the loops hold the mechanism; None where no code of fixed size can do it.

        Args:
            q: (*batch, n) configurations that close the loops, looked at if no others were met by chance.
        """
        if not self._looked:
            found = _usual(self._mechanism, self._driven, self._anywhere)
            if found is None:
                found = _choice(self._terms(np.reshape(q, (-1, self._mechanism.n))[:LOOKED_AT]), self._driven)
            rows, deciding = found
            if rows is not None:
                self._holding = Holding(rows, self._driven, deciding or (), self._tolerance)
                self.rank, self.redundancy = len(rows), len(self._driven) - len(deciding or ())
            self._looked = True
        return self._holding

    def forward_for(self, tau: ArrayLike, q: ArrayLike) -> Run | None:
        """Forward dynamics for as many efforts as are given: of all joints or of the driven ones.

        Args:
            tau: (*batch, n) or (*batch, a) efforts.
            q: as for `holding`.
        """
        width, n = np.shape(tau)[-1] if np.ndim(tau) else 0, self._mechanism.n
        if width not in self.forward and width in (n, len(self._driven)):
            driven, holding = tuple(range(n)) if width == n else self._driven, self.holding(q)
            self.forward[width] = None
            if holding is not None and width:
                self.forward[width] = closed_kernels.forward_kernel(self._mechanism, holding, driven).call
        return self.forward.get(width)

    def inverse(self, q: ArrayLike) -> Run | None:
        """Inverse dynamics.

        Args:
            q: as for `holding`.
        """
        return self._way("inverse", q)

    def closing(self, q: ArrayLike) -> Run | None:
        """Coordinates and rates taken back to closed loops.

        Args:
            q: as for `holding`.
        """
        return self._way("closing", q)

    def following(self, q: ArrayLike) -> Run | None:
        """All joints while the driven ones move.

        Args:
            q: as for `holding`.
        """
        return self._way("following", q)

    def _way(self, name: str, q: ArrayLike) -> Run | None:
        if name not in self._ways:
            holding = self.holding(q)
            needed = {"inverse": holding and holding.deciding, "closing": holding, "following": self._driven}
            make = getattr(closed_kernels, f"{name}_kernel")
            self._ways[name] = make(self._mechanism, holding).call if holding and needed[name] else None
        return self._ways[name]


def is_certain(doubt: Any) -> bool:
    """Whether all results hold.

    Args:
        doubt: (*batch) that came with them.
    """
    return bool(doubt < 1.0) if isinstance(doubt, float) else bool(np.all(doubt < 1.0))


@lru_cache(maxsize=32)
def _usual(
    mechanism: Mechanism, driven: Rows, anywhere: Callable[[Mechanism], Terms | None]
) -> tuple[Rows | None, Rows | None] | None:
    """The choice at configurations anywhere; None if none were met."""
    found = anywhere(mechanism)
    return None if found is None else _choice(found, driven)


def _choice(found: Terms, driven: Rows) -> tuple[Rows | None, Rows | None]:
    """Independent rows, and the driven joints that decide."""
    rows = independent_rows(found.M, found.J)
    freedoms = found.J.shape[-1] - len(rows or ())
    return rows, None if rows is None else deciding_joints(found.J, np.array(driven, dtype=np.int64), freedoms)


def independent_rows(M: Floats, J: Floats) -> Rows | None:
    """Rows of loops that span all others, the same at most states; None where no such rows are found.

    1. Rows in kinetic energy, W = J L'^-1 with M = L L', and their rank; states of less than the largest are singular.
    2. A row is taken if at most of the other states enough of it is left beside those taken before.

    Args:
        M: (k, n, n) mass matrices of the tree.
        J: (k, m, n) rows of the loops.
    """
    try:
        W = np.swapaxes(np.linalg.solve(np.linalg.cholesky(M), np.swapaxes(J, -1, -2)), -1, -2)
    except np.linalg.LinAlgError:
        return None
    # 1
    values = np.linalg.svd(W, compute_uv=False)
    ranks = (values > RANK * values[:, :1]).sum(axis=1)
    rank = int(ranks.max(initial=0))
    W = W[ranks == rank]
    W = W / np.maximum(np.linalg.norm(W, axis=-1).max(axis=-1), RANK)[:, None, None]
    length = np.linalg.norm(W, axis=-1)
    # 2
    taken: list[int] = []
    for share in REMAINDERS:
        for k in range(W.shape[1]):
            left = np.linalg.norm(W[:, k], axis=-1)
            apart = left > share * np.maximum(length[:, k], share)
            if len(taken) < rank and apart.mean() >= MOST:
                along = np.where(apart, 1.0 / np.where(apart, left, 1.0), 0.0)[:, None] * W[:, k]
                W = W - (W @ along[..., None]) * along[:, None, :]
                taken.append(k)
    return tuple(sorted(taken)) if len(taken) == rank else None


def deciding_joints(J: Floats, driven: Integers, freedoms: int) -> Rows | None:
    """Which driven joints decide the efforts of all: as many as freedoms or as driven; None where they do not.

    Args:
        J: (k, m, n) rows of the loops.
        driven: (a,) coordinates of the driven joints.
        freedoms: of the mechanism.
    """
    if not len(driven) or not freedoms:
        return None
    allowed = np.eye(J.shape[-1]) - decompositions.pinv(J, RANK) @ J
    across = np.swapaxes(allowed[..., driven], -1, -2)
    rows = independent_rows(np.broadcast_to(np.eye(J.shape[-1]), (len(J), *allowed.shape[1:])), across)
    return rows if rows is not None and len(rows) == min(freedoms, len(driven)) else None
