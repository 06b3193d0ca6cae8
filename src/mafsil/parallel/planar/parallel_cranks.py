"""Three or more equal parallel cranks on one platform: movable although the count says it is not.

Coordinates: the angle of each crank and the angle psi of the platform; pivots on the ground and on the platform on the
x axis at the same places. Closure of crank i with the first: c_i + e(a_i) r = e(a_1) r + R(psi) c_i.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, frozen, positive, real_array, single
from mafsil.errors import InputError
from mafsil.parallel.loop_singularity import LoopSingularities, loop_singularities


@dataclass(frozen=True, eq=False)
class ParallelCranks:
    """A platform on equal cranks.

    Attributes:
        length: of the cranks [m].
        pivots: (n,) places along x, the first at 0 [m].
    """

    length: float
    pivots: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "length", positive("length", self.length))
        places = real_array("pivots", self.pivots)
        if places.ndim != 1 or len(places) < 2 or not np.isfinite(places).all() or places[0] != 0:
            raise InputError("parallel.pivots", got=np.asarray(self.pivots).tolist())
        object.__setattr__(self, "pivots", frozen(places))

    def closure(self, q: ArrayLike) -> Floats:
        """(*batch, 2 n - 2) what each crank misses: all x, then all y [m]; q (*batch, n + 1) angles, psi last."""
        a, psi = self._parts(q)
        c = self.pivots[1:]
        x = self.length * (np.cos(a[..., 1:]) - np.cos(a[..., :1])) + c * (1 - np.cos(psi))
        y = self.length * (np.sin(a[..., 1:]) - np.sin(a[..., :1])) - c * np.sin(psi)
        return np.concatenate([x, y], axis=-1)

    def loop_matrix(self, q: ArrayLike) -> Floats:
        """(*batch, 2 n - 2, n + 1) derivatives of the closure."""
        a, psi = self._parts(q)
        n = len(self.pivots)
        H = np.zeros((*a.shape[:-1], 2 * n - 2, n + 1))
        for k, (by_angle, by_psi) in enumerate(((-np.sin(a), np.sin(psi)), (np.cos(a), -np.cos(psi)))):
            rows = slice(k * (n - 1), (k + 1) * (n - 1))
            H[..., rows, 0] = -self.length * by_angle[..., :1]
            H[..., rows, 1:n] = self.length * by_angle[..., 1:, None] * np.eye(n - 1)
            H[..., rows, n] = self.pivots[1:] * by_psi
        return H

    def curvature(self, q: ArrayLike) -> Floats:
        """(*batch, 2 n - 2, n + 1, n + 1) second derivatives of the closure."""
        a, psi = self._parts(q)
        n = len(self.pivots)
        found = np.zeros((*a.shape[:-1], 2 * n - 2, n + 1, n + 1))
        for k, (bend, of_psi) in enumerate(((-np.cos(a), np.cos(psi)), (-np.sin(a), np.sin(psi)))):
            for i in range(1, n):
                row = k * (n - 1) + i - 1
                found[..., row, 0, 0] = -self.length * bend[..., 0]
                found[..., row, i, i] = self.length * bend[..., i]
                found[..., row, n, n] = self.pivots[i] * of_psi[..., 0]
        return found

    def singularity(self, q: ArrayLike, driven: Sequence[int] = (0,)) -> LoopSingularities:
        """What is singular at a configuration (n + 1,): of three cranks or more the rank of the loops is n at most.

        On the parallel motion, psi = 0, one row depends on the others for every crank after the second.
        """
        n = len(self.pivots)
        angles = single("q", q, (n + 1,))
        rank = n if n > 2 else 2
        return loop_singularities(
            self.loop_matrix(angles), self.curvature(angles), driven, full_rank=rank,
            closure=lambda x: (self.closure(x), self.loop_matrix(x)), q=angles,
        )  # fmt: skip

    def _parts(self, q: ArrayLike) -> tuple[Floats, Floats]:
        value = as_batch("q", q, (len(self.pivots) + 1,))
        return value[..., :-1], value[..., -1:]
