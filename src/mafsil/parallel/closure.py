"""Loops as a system g(q) = 0: what rates its matrix leaves, which joints may be driven, and where both break.

H(q) = dg/dq, H q' = 0. With the driven joints a and the passive ones p: H_p q_p' = - H_a q_a'. The rank that H has on
most of the configurations (`rank`) decides, not its number of rows: rows of an overconstrained loop always depend.

References: Lynch & Park, Modern Robotics, sec. 7.3; Park and Kim, Singularity analysis of closed kinematic chains,
J. Mech. Design 121, 1999.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, as_batch, real_array
from mafsil.errors import InputError
from mafsil.parallel.tolerances import RANK
from mafsil.solvers.decompositions import ranks, singular_values


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
