"""Linear error dynamics of any order: a_n e^(n) + ... + a_1 e' + a_0 e = c, its roots, time constants and responses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, frozen
from mafsil.errors import InputError
from mafsil.fields import check_fields
from mafsil.geometry.matrix_exponential import exponential
from mafsil.one_joint.arguments import finite, row, together
from mafsil.one_joint.polynomial import Complexes, coefficients_of, companion, polynomial_value, roots
from mafsil.one_joint.routh import Stability, routh_hurwitz

WELL_SEPARATED = 1e5
"""Condition of the scaled Vandermonde matrix of the roots up to which a response is the sum of their modes: that loses
five of sixteen digits. Beyond, roots nearly coincide and the matrix exponential is taken."""


@dataclass(frozen=True, eq=False, slots=True)
class ErrorDynamics:
    """a_n e^(n) + ... + a_1 e' + a_0 e = 0, in batches.

    Attributes:
        coefficients: (*batch, n + 1), highest derivative first.
    """

    coefficients: Floats
    __post_init__ = check_fields(coefficients=lambda _, value: frozen(coefficients_of(value)))

    @classmethod
    def of(cls, *coefficients: ArrayLike) -> ErrorDynamics:
        """From the coefficients of e^(n), ..., e', e, each a number or (*batch).

        Raises:
            InputError: not finite, fewer than two, a leading zero, shapes that do not go together.
        """
        named = {f"coefficients[{k}]": finite(f"coefficients[{k}]", each) for k, each in enumerate(coefficients)}
        if len(named) < 2:
            raise InputError("one_joint.few_coefficients", got=len(named))
        return cls(np.stack(together(**named), axis=-1))

    @classmethod
    def from_row(cls, coefficients: ArrayLike) -> ErrorDynamics:
        """From (*batch, n + 1), highest derivative first."""
        return cls(np.asarray(coefficients_of(coefficients)))

    @property
    def order(self) -> int:
        """Order n of the equation."""
        return self.coefficients.shape[-1] - 1

    @property
    def roots(self) -> Complexes:
        """(*batch, n) roots of the characteristic polynomial [1/s], the slowest first."""
        return roots(self.coefficients)

    @property
    def time_constants(self) -> Floats:
        """(*batch, n) -1 / Re(s): the time in which a mode falls to 37 % [s], the slowest first.

        Infinite for a root on the axis, negative for a mode that grows.
        """
        with np.errstate(divide="ignore"):
            return -1.0 / (self.roots.real + 0.0)

    def stability(self) -> Stability:
        """Whether the error dies out, by Routh's array."""
        return routh_hurwitz(self.coefficients)

    def response(self, t: ArrayLike, initial: ArrayLike, steady: ArrayLike = 0.0) -> Floats:
        """The error over time: `derivatives(...)[..., 0]`, (*batch, k)."""
        return self.derivatives(t, initial, steady)[..., 0]

    def derivatives(self, t: ArrayLike, initial: ArrayLike, steady: ArrayLike = 0.0) -> Floats:
        """The error and its derivatives over time, from any initial conditions.

        Args:
            t: (k,) times [s].
            initial: (*batch, n) e, e', ..., e^(n-1) at t = 0.
            steady: (*batch) the error that remains, c / a_0.

        Returns:
            (*batch, k, n) e, e', ..., e^(n-1). Memory: 32 n bytes for each time of each row.

        Raises:
            InputError: not finite, or shapes that do not go together.
        """
        time, x0, rest = row("t", t), row("initial", initial), finite("steady", steady)
        if time.ndim != 1:
            raise InputError("input.shape", name="t", expected="(k,)", got=time.shape, hint="")
        n = self.order
        if x0.shape[-1] != n:
            raise InputError("input.shape", name="initial", expected=f"(*batch, {n})", got=x0.shape, hint="")
        batch = np.broadcast_shapes(self.coefficients.shape[:-1], x0.shape[:-1], rest.shape)
        a = np.broadcast_to(self.coefficients, (*batch, n + 1)).reshape(-1, n + 1)
        offset = np.zeros((*batch, n))
        offset[..., 0] = rest
        start = (np.broadcast_to(x0, (*batch, n)) - offset).reshape(-1, n)
        return _free_response(a, time, start).reshape(*batch, len(time), n) + offset[..., None, :]

    def frequency_response(self, numerator: ArrayLike, frequency: ArrayLike) -> Complexes:
        """Numerator over characteristic polynomial at s = j w: how disturbances or references pass into the error.

        Args:
            numerator: (*batch, m + 1) coefficients in s, highest power first.
            frequency: (k,) w [rad/s].

        Returns:
            (*batch, k).
        """
        s: Complexes = (1j * row("frequency", frequency)).astype(np.complex128)
        return polynomial_value(row("numerator", numerator), s) / polynomial_value(self.coefficients, s)


def _free_response(a: Floats, t: Floats, start: Floats) -> Floats:
    """(rows, k, n) of x' = A x: by modes where the roots are well apart, by the matrix exponential elsewhere."""
    n = a.shape[1] - 1
    s = roots(a)
    size = np.abs(s).max(axis=1)
    size = np.where(size > 0.0, size, 1.0)  # All roots are zero: any unit of time will do.
    modes = (s / size[:, None])[:, None, :] ** np.arange(float(n))[:, None]
    with np.errstate(all="ignore"):
        apart = np.linalg.cond(modes) < WELL_SEPARATED
    result = np.empty((len(a), len(t), n))
    scale = size[:, None] ** np.arange(float(n))
    if apart.any():
        result[apart] = _modal(modes[apart], s[apart], t, start[apart] / scale[apart]) * scale[apart][:, None, :]
    if not apart.all():
        near = ~apart
        result[near] = _exponential(a[near], size[near], t, start[near] / scale[near]) * scale[near][:, None, :]
    return result


def _modal(modes: NDArray[np.complex128], s: Complexes, t: Floats, start: Floats) -> Floats:
    """X(t) = sum_j c_j v_j e^(s_j t), V c = x(0)."""
    c = np.linalg.solve(modes, start[..., None].astype(np.complex128))[..., 0]
    return np.einsum("bij,bj,bjk->bki", modes, c, np.exp(s[..., None] * t)).real


def _exponential(a: Floats, size: Floats, t: Floats, start: Floats) -> Floats:
    """X(t) = e^(A t) x(0) with time in units of 1 / size, in which A is of order 1."""
    n = a.shape[1] - 1
    units = np.asarray(size[:, None] ** np.arange(n + 1.0), dtype=np.float64)
    A = companion(a / a[:, :1] / units)
    result = np.empty((len(a), len(t), n))
    for k, now in enumerate(t.tolist()):
        result[:, k] = (exponential(A * (size * now)[:, None, None]) @ start[..., None])[..., 0]
    return result
