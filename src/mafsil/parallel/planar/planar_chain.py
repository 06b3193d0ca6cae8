"""Closed planar chains of links on hinges by relative angles: closure, its rates and curvature, all singular points.

Links L_1 ... L_n-1 as a chain from the first ground pivot at the origin, angles theta_i relative to the link before;
the last link is the ground of length L_n, from the origin along x. With s_i = theta_1 + ... + theta_i:
sum L_i cos s_i = L_n, sum L_i sin s_i = 0, and sum of all n angles = pi modulo 2 pi.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, frozen, real_array
from mafsil.errors import InputError
from mafsil.mobility.spaces.planar_positions import wrapped
from mafsil.mobility.tolerances import TYPED


@dataclass(frozen=True, eq=False)
class PlanarChain:
    """A closed planar chain of n links on n hinges.

    Attributes:
        lengths: (n,) of the links, the ground last [m].
    """

    lengths: Floats

    def __post_init__(self) -> None:
        L = real_array("lengths", self.lengths)
        if L.ndim != 1 or len(L) < 3 or not (np.isfinite(L).all() and (L > 0).all()):
            raise InputError("parallel.chain_lengths", got=np.asarray(self.lengths).tolist())
        object.__setattr__(self, "lengths", frozen(L))

    @property
    def size(self) -> float:
        """The longest link [m]."""
        return float(self.lengths.max())

    def last_angle(self, theta: ArrayLike) -> Floats:
        """(*batch,) the last angle, at the second ground pivot: pi minus the sum of the others, in (-pi, pi]."""
        return wrapped(np.pi - self._given(theta).sum(axis=-1))

    def closure(self, theta: ArrayLike) -> Floats:
        """(*batch, 2) how far the chain misses the second ground pivot, for the n - 1 angles (*batch, n - 1) [m]."""
        s = np.cumsum(self._given(theta), axis=-1)
        L = self.lengths[:-1]
        return np.stack([np.cos(s) @ L - self.lengths[-1], np.sin(s) @ L], axis=-1)

    def closure_matrix(self, theta: ArrayLike) -> Floats:
        """(*batch, 2, n - 1) derivatives of `closure` by the angles."""
        s = np.cumsum(self._given(theta), axis=-1)
        x, y = self.lengths[:-1] * np.cos(s), self.lengths[:-1] * np.sin(s)
        return np.stack([-_tails(y), _tails(x)], axis=-2)

    def loop_matrix(self, theta: ArrayLike) -> Floats:
        """(*batch, 3, n) the same with all n angles and a third row, that their sum stays: any joint may be driven."""
        H = self.closure_matrix(theta)
        wide = np.concatenate([H, np.zeros((*H.shape[:-1], 1))], axis=-1)
        return np.concatenate([wide, np.ones((*wide.shape[:-2], 1, wide.shape[-1]))], axis=-2)

    def curvature(self, theta: ArrayLike) -> Floats:
        """(*batch, 3, n, n) second derivatives of the rows of the loop by all n angles."""
        angles = self._given(theta)
        s = np.cumsum(angles, axis=-1)
        x, y = _tails(self.lengths[:-1] * np.cos(s)), _tails(self.lengths[:-1] * np.sin(s))
        n = len(self.lengths)
        later = np.maximum(np.arange(n - 1)[:, None], np.arange(n - 1))
        found = np.zeros((*angles.shape[:-1], 3, n, n))
        found[..., 0, :-1, :-1], found[..., 1, :-1, :-1] = -x[..., later], -y[..., later]
        return found

    def collinear_configurations(self) -> Floats:
        """(k, n - 1) all configurations with every link on one line: there the rank of the loop drops, nowhere else.

        Signs e with sum e_i L_i = L_n. Each absolute angle is 0 or pi.
        """
        found: list[Floats] = []
        L = self.lengths
        for signs in product([1.0, -1.0], repeat=len(L) - 1):
            if abs(np.dot(signs, L[:-1]) - L[-1]) <= TYPED * self.size:
                absolute = np.where(np.array(signs) > 0, 0.0, np.pi)
                found.append(wrapped(np.diff(absolute, prepend=0.0)))
        return np.array(found).reshape(-1, len(L) - 1)

    def _given(self, theta: ArrayLike) -> Floats:
        return as_batch("theta", theta, (len(self.lengths) - 1,))


def _tails(v: Floats) -> Floats:
    """Sums from each entry to the last."""
    return np.cumsum(v[..., ::-1], axis=-1)[..., ::-1]
