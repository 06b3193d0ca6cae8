"""Real polynomials in batches, coefficients from the highest power to the lowest: roots and values."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.one_joint.arguments import row

Complexes = NDArray[np.complex128]


def coefficients_of(value: ArrayLike, name: str = "coefficients", least: int = 2) -> Floats:
    """(*batch, n + 1) coefficients with a leading one that is not zero.

    Raises:
        InputError: not finite, too few, or a leading zero: then the order is lower than the shape says.
    """
    a = row(name, value, least)
    if (a[..., 0] == 0.0).any():
        raise InputError("one_joint.leading_zero", name=name)
    return a


def roots(coefficients: ArrayLike) -> Complexes:
    """(*batch, n) roots of (*batch, n + 1) coefficients, the largest real part first.

    Order 1 and 2 by their formulas (nothing cancels), others as eigenvalues of the companion matrix.

    Args:
        coefficients: (*batch, n + 1), highest power first.

    Raises:
        InputError: not finite, or a leading zero.
    """
    a = coefficients_of(coefficients)
    n = a.shape[-1] - 1
    if n == 1:
        return np.asarray(-a[..., 1:] / a[..., :1], dtype=np.complex128)
    found: Complexes = _quadratic(a) if n == 2 else np.linalg.eigvals(companion(a)).astype(np.complex128)
    order = np.lexsort((-found.imag, -found.real), axis=-1)
    return np.asarray(np.take_along_axis(found, order, axis=-1), dtype=np.complex128)


def _quadratic(a: Floats) -> Complexes:
    """Real roots x1 = q / a2, x2 = a0 / q with q = -(a1 + sign(a1) sqrt(a1^2 - 4 a2 a0)) / 2; or a conjugate pair."""
    b, c = 0.5 * a[..., 1] / a[..., 0], a[..., 2] / a[..., 0]
    rest = b * b - c
    root = np.sqrt(np.abs(rest))
    larger = -(b + np.where(b < 0.0, -root, root))
    smaller = np.divide(c, larger, out=np.zeros_like(c), where=larger != 0.0)
    real = rest >= 0.0
    first = np.where(real, larger, -b) + np.where(real, 0.0, 1j * root)
    second = np.where(real, smaller, -b) - np.where(real, 0.0, 1j * root)
    return np.asarray(np.stack([first, second], axis=-1), dtype=np.complex128)


def companion(a: Floats) -> Floats:
    """(*batch, n, n) the matrix of x' = A x with x = (e, e', ..., e^(n-1))."""
    n = a.shape[-1] - 1
    A = np.zeros((*a.shape[:-1], n, n))
    A[..., np.arange(n - 1), np.arange(1, n)] = 1.0
    A[..., n - 1, :] = -a[..., :0:-1] / a[..., :1]
    return A


def polynomial_value(coefficients: Floats, s: Floats | Complexes) -> Complexes:
    """p(s) by Horner's rule: (*batch, n + 1) and (*batch, k) give (*batch, k)."""
    value: Complexes = np.zeros(
        np.broadcast_shapes(coefficients.shape[:-1], s.shape[:-1]) + s.shape[-1:], dtype=np.complex128
    )
    for k in range(coefficients.shape[-1]):
        value = value * s + coefficients[..., k, None]
    return value
