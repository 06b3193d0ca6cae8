"""The Routh-Hurwitz test of real polynomials, in batches: are all roots in the open left half plane?"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Floats
from mafsil.floating_point import EPS
from mafsil.one_joint.polynomial import coefficients_of, roots
from mafsil.one_joint.row_answer import RowAnswer

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
