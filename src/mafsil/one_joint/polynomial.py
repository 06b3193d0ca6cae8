"""Real polynomials in batches, coefficients from the highest power to the lowest: roots, values, the test of Routh.

The test of Routh and Hurwitz tells whether all roots are in the open left half plane.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.floating_point import EPS
from mafsil.one_joint.rows import RowAnswer, row

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


ROUNDING = 64 * EPS
"""Share of its terms below which an element of Routh's array counts as zero."""
ON_AXIS = 1e-7
"""Real part over the size of the root below which a root counts as being on the axis, for rows where Routh's array has
a zero: a double root is known to half the digits."""


class StabilityStatus(Status):
    """Where the roots are."""

    STABLE = ("one_joint.stable", True)
    MARGINAL = ("one_joint.marginal", False)
    UNSTABLE = ("one_joint.unstable", False)


@dataclass(frozen=True, eq=False, repr=False)
class Stability(RowAnswer):
    """Whether all roots are in the open left half plane; true if they are, for every row.

    Attributes:
        verdict: (*batch) which of `statuses`.
        right_roots: (*batch) roots with positive real part, counted by Routh's array.
        first_column: (*batch, n + 1) first column of Routh's array, scaled to a positive first element; NaN below a
            zero.
        signs_agree: (*batch) whether all coefficients have one sign: necessary, up to order 2 sufficient.
    """

    statuses: ClassVar[tuple[Status, ...]] = tuple(StabilityStatus)
    verdict: NDArray[np.int8]
    right_roots: NDArray[np.int64]
    first_column: Floats
    signs_agree: NDArray[np.bool_]

    @property
    def stable(self) -> NDArray[np.bool_]:
        """(*batch) whether all roots are in the open left half plane."""
        return np.asarray(self.verdict == 0)


def routh_hurwitz(coefficients: ArrayLike) -> Stability:
    """Stability of a_n e^(n) + ... + a_1 e' + a_0 e = 0 by Routh's array.

    Order 1 and 2 are stable when all coefficients have one sign; order 3 needs besides a_2 a_1 > a_3 a_0.

    Args:
        coefficients: (*batch, n + 1), highest power first.

    Returns:
        Stable, marginal (a root on the imaginary axis, as far as rounding lets one see, and none to the right of it)
        or unstable, for each row. Rows in which the array has a zero are decided by their roots.

    Raises:
        InputError: not finite, fewer than two coefficients, or a leading zero (the order is lower than the shape says).

    Reference: Routh 1877; Gantmacher, The Theory of Matrices II, ch. XV.
    """
    a = coefficients_of(coefficients)
    batch, n = a.shape[:-1], a.shape[-1] - 1
    rows = a.reshape(-1, n + 1)
    rows = rows / rows[:, :1]
    column, changes, broken = _first_column(np.ascontiguousarray(rows.T))
    verdict = np.where(changes > 0, 2, 0).astype(np.int8)
    for k in np.flatnonzero(broken).tolist():
        verdict[k], changes[k] = _by_roots(rows[k])
    agree = np.asarray((rows > 0.0).all(axis=1), dtype=np.bool_)
    return Stability(
        verdict.reshape(batch), changes.reshape(batch), column.T.reshape(*batch, n + 1), agree.reshape(batch)
    )


def _first_column(a: Floats) -> tuple[Floats, NDArray[np.int64], NDArray[np.bool_]]:
    """Of (n + 1, rows): the first column, its changes of sign, and where a zero breaks it."""
    n, count = a.shape[0] - 1, a.shape[1]
    upper, lower = a[0::2].copy(), np.zeros((n // 2 + 1, count))
    lower[: (n + 1) // 2] = a[1::2]
    column = np.full((n + 1, count), np.nan)
    column[0], broken, changes = upper[0], np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.int64)
    small = np.zeros(count)
    with np.errstate(all="ignore"):
        for k in range(1, n + 1):
            # 1. A zero in the first column: from here on the row is for `_by_roots`.
            broken |= ~(np.abs(lower[0]) > ROUNDING * small)
            column[k] = np.where(broken, np.nan, lower[0])
            # 2. A change of sign is a root on the right.
            changes += (column[k] < 0.0) != (column[k - 1] < 0.0)
            # 3. The next row: c_i = a_{i+1} - (a_0 / b_0) b_{i+1}.
            product = (upper[0] / lower[0]) * lower[1:]
            small = np.abs(upper[1]) + np.abs(product[0]) if len(product) else small
            following = upper[1:] - product
            upper, lower = lower, np.concatenate([following, np.zeros((1, count))])
    changes[broken] = 0
    return column, changes, broken


def _by_roots(a: Floats) -> tuple[int, int]:
    """Verdict and count of right roots of one polynomial."""
    s = roots(a)
    size = np.maximum(np.abs(s), ON_AXIS * np.abs(s).max())
    right, axis = s.real > ON_AXIS * size, np.abs(s.real) <= ON_AXIS * size
    return (2 if right.any() else 1 if axis.any() else 0), int(right.sum())
