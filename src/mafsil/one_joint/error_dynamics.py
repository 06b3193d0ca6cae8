"""Linear error dynamics of any order: a_n e^(n) + ... + a_1 e' + a_0 e = c, its roots, time constants and responses.

Force control along one axis: a quasi-static PI loop, a mass that presses on a wall, and the runaway without one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, frozen
from mafsil.errors import InputError
from mafsil.fields import check_fields
from mafsil.geometry.matrix_exponential import exponential
from mafsil.one_joint.polynomial import (
    Complexes,
    Stability,
    coefficients_of,
    companion,
    polynomial_value,
    roots,
    routh_hurwitz,
)
from mafsil.one_joint.rows import above_zero, check_batch, finite, magnitude, row, together

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


@dataclass(frozen=True, eq=False, slots=True)
class ForceLoop:
    """F = F_d + Kfp F_e + Kfi int F_e - K_damp v, F_e = F_d - F_app, F_app the force on the environment.

    Attributes:
        kfp, kfi: (*batch) [1], [1/s].
        damping: K_damp (*batch) [N s/m]; 0 for none.
    """

    kfp: Floats
    kfi: Floats
    damping: Floats
    __post_init__ = check_batch(kfp=magnitude, kfi=magnitude, damping=magnitude)

    @classmethod
    def of(cls, kfp: ArrayLike, kfi: ArrayLike = 0.0, damping: ArrayLike = 0.0) -> ForceLoop:
        """From its gains, each a number or (*batch).

        Raises:
            InputError: a negative gain, shapes that do not go together.
        """
        return cls(*together(kfp=kfp, kfi=kfi, damping=damping))

    @property
    def time_constant(self) -> Floats:
        """(*batch) (1 + Kfp) / Kfi [s] against a rigid wall; infinite without an integral."""
        with np.errstate(divide="ignore"):
            return (1.0 + self.kfp) / self.kfi

    def quasi_static_error(self, t: ArrayLike, disturbance: ArrayLike) -> Floats:
        """F_e (*batch, k) against a rigid wall: (1 + Kfp) F_e + Kfi int F_e = -w.

        Args:
            t: (k,) [s].
            disturbance: w (*batch), constant, such as gravity that is not compensated [N].

        Returns:
            -w / (1 + Kfp) e^(-t / time constant): the integral removes it.
        """
        time, w = magnitude("t", row("t", t)), finite("disturbance", disturbance)
        p, i, w = together(kfp=self.kfp, kfi=self.kfi, disturbance=w)
        return -(w / (1.0 + p))[..., None] * np.exp(-(i / (1.0 + p))[..., None] * time)

    def free_speed(self, t: ArrayLike, wanted: ArrayLike, mass: ArrayLike, speed: ArrayLike = 0.0) -> Floats:
        """Speed (*batch, k) after contact is lost: F_app = 0, so F_e = F_d, and the mass runs away.

        m v' = (1 + Kfp) F_d + Kfi F_d t - K_damp v. With damping, v = a (1 - e^(-K t / m)) + v0 e^(-K t / m) + Kfi F_d
        t / K, a = (1 + Kfp) F_d / K - m Kfi F_d / K^2: bounded only without the integral.

        Args:
            t: (k,) [s].
            wanted: F_d (*batch) [N].
            mass: m (*batch) [kg].
            speed: v at t = 0 (*batch) [m/s].
        """
        time = magnitude("t", row("t", t))
        F, m, v0, p, i, K = (
            each[..., None]
            for each in together(
                wanted=finite("wanted", wanted), mass=above_zero("mass", mass), speed=finite("speed", speed),
                kfp=self.kfp, kfi=self.kfi, damping=self.damping,
            )
        )  # fmt: skip
        # With x = K t / m: v0 e^-x + (1 + Kfp) F t / m (1 - e^-x) / x + Kfi F t^2 / m (x - 1 + e^-x) / x^2.
        x = K * time / m
        small = x < 1e-4
        safe = np.where(small, 1.0, x)
        first = np.where(small, 1.0 - x / 2.0 + x * x / 6.0, -np.expm1(-safe) / safe)
        second = np.where(small, 0.5 - x / 6.0 + x * x / 24.0, (safe + np.expm1(-safe)) / (safe * safe))
        return v0 * np.exp(-x) + (1.0 + p) * F * time / m * first + i * F * time * time / m * second

    def late_speed(self, t: ArrayLike, wanted: ArrayLike, mass: ArrayLike) -> Floats:
        """What `free_speed` tends to with damping: ((1 + Kfp) F_d + Kfi F_d t) / K - m Kfi F_d / K^2 (*batch, k)."""
        time = row("t", t)
        F, m, p, i, K = (
            each[..., None]
            for each in together(
                wanted=finite("wanted", wanted), mass=above_zero("mass", mass), kfp=self.kfp, kfi=self.kfi,
                damping=above_zero("damping", self.damping),
            )
        )  # fmt: skip
        return ((1.0 + p) * F + i * F * time) / K - m * i * F / (K * K)

    def wall_dynamics(self, mass: ArrayLike, wall_stiffness: ArrayLike, wall_damping: ArrayLike = 0.0) -> ErrorDynamics:
        """Error dynamics of a mass in contact with a wall that yields: m x'' = F - F_app, F_app = k x + c x'.

        m F_e''' + (K_damp + (1 + Kfp) c) F_e'' + ((1 + Kfp) k + Kfi c) F_e' + Kfi k F_e = 0 up to a factor; one order
        less without the integral.

        Args:
            mass: m (*batch) [kg].
            wall_stiffness: k (*batch) [N/m].
            wall_damping: c (*batch) [N s/m].
        """
        m, k, c, p, i, K = together(
            mass=above_zero("mass", mass), wall_stiffness=above_zero("wall_stiffness", wall_stiffness),
            wall_damping=magnitude("wall_damping", wall_damping), kfp=self.kfp, kfi=self.kfi, damping=self.damping,
        )  # fmt: skip
        second, first = K + (1.0 + p) * c, (1.0 + p) * k + i * c
        if not i.any():
            return ErrorDynamics.of(m, second, first)
        return ErrorDynamics.of(m, second, first, above_zero("kfi", i) * k)
