"""Real polynomials in batches, coefficients from the highest power to the lowest: roots and values."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.floating_point import EPS
from mafsil.one_joint.arguments import row

Complexes = NDArray[np.complex128]

NEAR, NEAREST = 10.0, 1e-8
"""Distances, as shares of the largest root, within which roots may be one: rounding parts n equal ones by some
eps^(1/n), two of them by half of the digits."""

ROUNDED = 16 * EPS
"""Share of the terms of a coefficient by which it may have been rounded."""


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

    Order 1 and 2 by their formulas (nothing cancels), others as eigenvalues of the companion matrix. Roots that the
    rounding of the coefficients alone may have parted are given as one, several times: of m equal roots eigenvalues
    have the m-th part of the digits, their mean has all.

    Args:
        coefficients: (*batch, n + 1), highest power first.

    Raises:
        InputError: not finite, or a leading zero.
    """
    a = coefficients_of(coefficients)
    n = a.shape[-1] - 1
    if n == 1:
        return np.asarray(-a[..., 1:] / a[..., :1], dtype=np.complex128)
    found: Complexes = _quadratic(a) if n == 2 else _join(a, np.linalg.eigvals(companion(a)).astype(np.complex128))
    order = np.lexsort((-found.imag, -found.real), axis=-1)
    return np.asarray(np.take_along_axis(found, order, axis=-1), dtype=np.complex128)


def _quadratic(a: Floats) -> Complexes:
    """Real roots x1 = q / a2, x2 = a0 / q with q = -(a1 + sign(a1) sqrt(a1^2 - 4 a2 a0)) / 2; or a conjugate pair."""
    b, c = 0.5 * a[..., 1] / a[..., 0], a[..., 2] / a[..., 0]
    rest = b * b - c
    rest = np.where(np.abs(rest) <= ROUNDED * b * b, 0.0, rest)
    root = np.sqrt(np.abs(rest))
    larger = -(b + np.where(b < 0.0, -root, root))
    smaller = np.divide(c, larger, out=np.zeros_like(c), where=larger != 0.0)
    real = rest >= 0.0
    first = np.where(real, larger, -b) + np.where(real, 0.0, 1j * root)
    second = np.where(real, smaller, -b) - np.where(real, 0.0, 1j * root)
    return np.asarray(np.stack([first, second], axis=-1), dtype=np.complex128)


def _join(a: Floats, s: Complexes) -> Complexes:
    """(*batch, n) roots, those made equal that rounding may have parted; only where some are near."""
    n = s.shape[-1]
    rows, found = a.reshape(-1, n + 1), s.reshape(-1, n).copy()
    apart = np.full(len(found), np.inf)
    for i, j in combinations(range(n), 2):
        np.minimum(apart, np.abs(found[:, i] - found[:, j]), out=apart)
    for k in np.flatnonzero(apart <= _nearness(n)[0] * np.abs(found).max(axis=1)).tolist():
        found[k] = _coarsest(rows[k] / rows[k, 0], found[k])
    return np.asarray(found.reshape(s.shape), dtype=np.complex128)


def _nearness(n: int) -> list[float]:
    """Shares of the largest root within which roots of order n are grouped, the widest first."""
    widest = NEAR * EPS ** (1.0 / n)
    return [float(widest / 10.0**k) for k in range(int(np.log10(widest / NEAREST)) + 1)]


def _coarsest(a: Floats, s: Complexes) -> Complexes:
    """The roots of one polynomial in as few groups of equal ones as its coefficients, to rounding, still allow."""
    size = np.abs(s).max()
    terms = np.abs(np.poly(-np.abs(s)))
    for share in _nearness(len(s)):
        # 1. Groups: all that a chain of near roots joins.
        linked = np.abs(s[:, None] - s[None, :]) <= share * size
        for _ in range(len(s)):
            linked = linked @ linked
        # 2. Their means; conjugates stay conjugates.
        mean = (linked @ s) / linked.sum(axis=1)
        real, imaginary = (np.where(np.abs(part) <= ROUNDED * size, 0.0, part) for part in (mean.real, mean.imag))
        mean = np.asarray(real + 1j * imaginary, dtype=np.complex128)
        # 3. Kept if the polynomial with these roots is the given one.
        if (np.abs(np.poly(mean) - a) <= ROUNDED * len(s) * terms).all():
            return mean
    return s


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
