"""Decompositions of batches of matrices: one that is not finite spoils no other, where LAPACK would refuse them all.

A matrix with NaN or infinity gets NaN in all of its results; single matrices too.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats


def svd(A: Floats) -> tuple[Floats, Floats, Floats]:
    """U (*batch, m, k), singular values (*batch, k), V' (*batch, k, n) of (*batch, m, n), k = min(m, n)."""
    clean, spoilt = _clean(A)
    U, s, Vt = np.linalg.svd(clean, full_matrices=False)
    return _marked(U, spoilt, 2), _marked(s, spoilt, 1), _marked(Vt, spoilt, 2)


def singular_values(A: Floats) -> Floats:
    """(*batch, k) largest first, of (*batch, m, n)."""
    clean, spoilt = _clean(A)
    return _marked(np.asarray(np.linalg.svd(clean, compute_uv=False)), spoilt, 1)


def pinv(A: Floats, rcond: float) -> Floats:
    """(*batch, n, m) pseudoinverses of (*batch, m, n); singular values below rcond times the largest count as 0."""
    clean, spoilt = _clean(A)
    return _marked(np.linalg.pinv(clean, rcond=rcond), spoilt, 2)


def symmetric_pinv(A: Floats, rcond: float) -> Floats:
    """(*batch, n, n) pseudoinverses of symmetric matrices; singular values below rcond times the largest count as 0."""
    clean, spoilt = _clean(A)
    return _marked(np.linalg.pinv(clean, rcond=rcond, hermitian=True), spoilt, 2)


def _clean(A: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    spoilt = np.asarray(~np.isfinite(A).all(axis=(-2, -1)))
    return (np.where(spoilt[..., None, None], 0.0, A) if spoilt.any() else A), spoilt


def _marked(result: NDArray[Any], spoilt: NDArray[np.bool_], core: int) -> Floats:
    return np.where(spoilt.reshape((*spoilt.shape, *(1,) * core)), np.nan, result) if spoilt.any() else result
