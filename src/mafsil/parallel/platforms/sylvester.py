"""Sylvester's dialytic elimination: one unknown removed from two polynomials, numerically, for whole batches.

f = sum f_i x^i and g = sum g_j x^j have a common zero x where the determinant of the matrix of m + n shifted rows is
zero. If the coefficients are polynomials in another unknown t, its values at points of the circle |t| = r and a
discrete Fourier transform give the coefficients of the eliminant in t.

Reference: Raghavan and Roth, Solving polynomial systems for the kinematic analysis and synthesis of mechanisms and
robot manipulators, J. Mech. Design 117, 1995.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, not_negative, positive, real_array, whole
from mafsil.errors import InputError

Complexes = NDArray[np.complex128]


def half_angle_polynomial(constant: ArrayLike, cosine: ArrayLike, sine: ArrayLike) -> Floats:
    """(*batch, 3) of a + b cos x + c sin x in t = tan(x / 2), times 1 + t^2: a + b, 2 c, a - b, ascending."""
    a, b, c = np.broadcast_arrays(
        real_array("constant", constant), real_array("cosine", cosine), real_array("sine", sine)
    )
    return np.stack([a + b, 2 * c, a - b], axis=-1)


def sylvester_matrix(f: ArrayLike, g: ArrayLike) -> NDArray[np.inexact]:
    """(*batch, m + n, m + n) of polynomials of degrees m and n by ascending coefficients (*batch, m + 1), (.., n + 1).

    Args:
        f, g: real or complex coefficients.

    Raises:
        InputError: a polynomial is constant.
    """
    f, g = (np.atleast_1d(np.asarray(each)) * 1.0 for each in (f, g))
    m, n = f.shape[-1] - 1, g.shape[-1] - 1
    if m < 1 or n < 1:
        raise InputError("parallel.constant_polynomial", degrees=[m, n])
    shape = np.broadcast_shapes(f.shape[:-1], g.shape[:-1])
    M = np.zeros((*shape, m + n, m + n), dtype=np.result_type(f, g))
    for k in range(n):
        M[..., k, k : k + m + 1] = f
    for k in range(m):
        M[..., n + k, k : k + n + 1] = g
    return M


def resultant(f: ArrayLike, g: ArrayLike) -> NDArray[np.inexact]:
    """(*batch,) determinant of Sylvester's matrix: zero where both polynomials have a common zero."""
    return np.asarray(np.linalg.det(sylvester_matrix(f, g)))


def eliminant(values: Callable[[Complexes], NDArray[np.inexact]], degree: int, radius: float = 1.0) -> Complexes:
    """(degree + 1,) ascending coefficients of a polynomial known by its values.

    Args:
        values: of complex numbers (k,), to (k,): for example resultants whose coefficients are polynomials.
        degree: at least that of the polynomial.
        radius: of the circle on which it is taken; about the size of the zeros that matter.
    """
    most, r = whole("degree", degree, 1, 10_000), positive("radius", radius)
    count = 2 * (most + 1)
    points = np.asarray(r * np.exp(2j * np.pi * np.arange(count) / count), dtype=np.complex128)
    powers: Complexes = np.asarray(r ** np.arange(most + 1), dtype=np.complex128)
    c = np.fft.fft(np.asarray(values(points), dtype=np.complex128)) / count
    return np.asarray(c[: most + 1] / powers, dtype=np.complex128)


def trimmed(coefficients: Complexes, share: float = 1e-9) -> Complexes:
    """The coefficients without leading ones that are below a share of the largest."""
    share = not_negative("share", share)
    coefficients = np.atleast_1d(coefficients)
    size = np.abs(coefficients)
    kept = np.flatnonzero(size > share * size.max(initial=0.0))
    return coefficients[: int(kept[-1]) + 1] if len(kept) else coefficients[:1]


def zeros(coefficients: Complexes) -> Complexes:
    """All zeros of a polynomial by ascending coefficients, as eigenvalues of its companion matrix."""
    c = trimmed(np.asarray(coefficients, dtype=np.complex128), 0.0)
    companion = np.zeros((len(c) - 1, len(c) - 1), dtype=np.complex128)
    companion[1:, :-1] = np.eye(len(c) - 2)
    companion[:, -1] = -c[:-1] / c[-1]
    return np.asarray(np.linalg.eigvals(companion), dtype=np.complex128)
