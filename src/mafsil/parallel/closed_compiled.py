"""The compiled ways of one closed chain, each made at its first use; where there is none, the careful way remains."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.mechanics.loop_terms import Holding
from mafsil.model import Mechanism
from mafsil.parallel import closed_kernels
from mafsil.parallel.closed_choice import deciding_joints, independent_rows
from mafsil.parallel.closed_kernels import Rows
from mafsil.parallel.closed_terms import Terms

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


def trusted(doubt: Any) -> bool:
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
