"""Decompositions of batches of matrices: one that is not finite spoils no other, where LAPACK would refuse them all.

A matrix with NaN or infinity gets NaN in all of its results; single matrices too.

The algebraic Riccati equation of linear-quadratic control, in continuous time.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, Integers
from mafsil.floating_point import LEAST_DIVISOR


def svd(A: Floats) -> tuple[Floats, Floats, Floats]:
    """U (*batch, m, k), singular values (*batch, k), V' (*batch, k, n) of (*batch, m, n), k = min(m, n)."""
    clean, spoilt = _clean(A)
    U, s, Vt = np.linalg.svd(clean, full_matrices=False)
    return _spoil(U, spoilt, 2), _spoil(s, spoilt, 1), _spoil(Vt, spoilt, 2)


def singular_values(A: Floats) -> Floats:
    """(*batch, k) largest first, of (*batch, m, n)."""
    clean, spoilt = _clean(A)
    return _spoil(np.asarray(np.linalg.svd(clean, compute_uv=False)), spoilt, 1)


def pinv(A: Floats, rcond: float) -> Floats:
    """(*batch, n, m) pseudoinverses of (*batch, m, n); singular values below rcond times the largest count as 0."""
    clean, spoilt = _clean(A)
    return _spoil(np.linalg.pinv(clean, rcond=rcond), spoilt, 2)


def symmetric_pinv(A: Floats, rcond: float) -> Floats:
    """(*batch, n, n) pseudoinverses of symmetric matrices; singular values below rcond times the largest count as 0."""
    clean, spoilt = _clean(A)
    return _spoil(np.linalg.pinv(clean, rcond=rcond, hermitian=True), spoilt, 2)


def damped_inverse(A: NDArray[Any], damping: float | Floats) -> NDArray[Any]:
    """(*batch, n, m) A' (A A' + damping a 1)^-1 of (*batch, m, n), with the mean square a of the rows of each.

    Real or complex; `damping` is one number, or (*batch, 1, 1).

    A pseudoinverse in which directions fade instead of ending, where their singular value gets small. It needs a
    Cholesky-like solution instead of singular vectors: a tenth of the time, and the same on any number of BLAS threads.
    """
    clean, spoilt = _clean(A)
    m, n = A.shape[-2:]
    turned: NDArray[Any] = np.conj(np.swapaxes(clean, -1, -2))
    gram: NDArray[Any] = clean @ turned if m <= n else turned @ clean
    a = np.real(np.einsum("...ij,...ji->...", clean, turned))[..., None, None] / max(m, 1)
    inverse: Any = np.linalg.inv
    inner: NDArray[Any] = inverse(gram + np.eye(min(m, n)) * (damping * a + LEAST_DIVISOR))
    return _spoil(turned @ inner if m <= n else inner @ turned, spoilt, 2)


def ranks(A: Floats, share: float) -> Integers:
    """(*batch,) numbers of singular values of (*batch, m, n) above this share of the largest; zero of zero matrices."""
    if not A.size:
        return np.zeros(A.shape[:-2], dtype=np.int64)
    s = np.linalg.svd(A, compute_uv=False)
    return np.asarray((s > share * np.maximum(s[..., :1], LEAST_DIVISOR)).sum(axis=-1), dtype=np.int64)


def null_basis(A: Floats, rank: int) -> Floats:
    """(n, n - rank) orthonormal basis of the null space of A (m, n) of known rank, by a QR with pivots of A'.

    Singular vectors of a matrix of fifty rows cost ten times as much, and two hundred times where threads of BLAS wait
    for each other on a busy machine.
    """
    if not rank:
        return np.eye(A.shape[1])
    # Here, for it takes a tenth of a second to import.
    from scipy.linalg import qr

    basis: Floats = qr(A.T, pivoting=True)[0]
    return basis[:, rank:]


def _clean(A: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    spoilt = np.asarray(~np.isfinite(A).all(axis=(-2, -1)))
    return (np.where(spoilt[..., None, None], 0.0, A) if spoilt.any() else A), spoilt


def _spoil(result: NDArray[Any], spoilt: NDArray[np.bool_], core: int) -> Floats:
    return np.where(spoilt.reshape((*spoilt.shape, *(1,) * core)), np.nan, result) if spoilt.any() else result


def solve_banded(bands: Floats, right: Floats) -> Floats:
    """x (k, m) of A x = right for A (k, k) without entries farther than p from its diagonal: work k p^2, memory k p.

    Args:
        bands: (2 p + 1, k), A[i, j] in bands[p + i - j, j].
        right: (k, m).
    """
    import scipy.linalg

    library: Any = scipy.linalg  # its types leave this one out
    reach = len(bands) // 2
    return np.asarray(library.solve_banded((reach, reach), bands, right), dtype=np.float64)


def riccati(A: Floats, B: Floats, Q: Floats, R: Floats) -> Floats | None:
    """P (n, n) with A' P + P A - P B R^-1 B' P + Q = 0 and A - B R^-1 B' P stable; None if there is none.

    Args:
        A, B: (n, n), (n, m) of x' = A x + B u.
        Q, R: (n, n), (m, m) weights of x' Q x + u' R u; Q not negative, R positive.
    """
    import scipy.linalg

    library: Any = scipy.linalg  # its types leave this one out
    try:
        P = np.asarray(library.solve_continuous_are(A, B, Q, R), dtype=np.float64)
    except np.linalg.LinAlgError:
        return None
    return 0.5 * (P + P.T)
