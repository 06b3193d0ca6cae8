"""The standard second-order error dynamics e'' + 2 zeta w e' + w^2 e = 0: damping, closed-form responses, measures."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.one_joint.error_dynamics import ErrorDynamics
from mafsil.one_joint.polynomial import Complexes
from mafsil.one_joint.rows import above_zero, check_batch, finite, magnitude, row, share, together
from mafsil.one_joint.tolerances import BELOW_ONE, LINEAR, NO_GAP

CRITICAL = 1e-9
"""Distance of the damping ratio from 1 below which the motion is called critically damped; responses do not ask."""

BISECTIONS = 80
"""Halvings of the interval in which the band is entered for good."""


class Damping(IntEnum):
    """The kind of decay of the error."""

    UNDERDAMPED = 0
    CRITICALLY_DAMPED = 1
    OVERDAMPED = 2
    UNDAMPED = 3

    def sentence(self, language: str | None = None) -> str:
        """What it means."""
        return say(f"one_joint.{self.name.lower()}", language=language)


@dataclass(frozen=True, eq=False, slots=True)
class SecondOrder:
    """e'' + 2 zeta w e' + w^2 e = 0, in batches.

    Attributes:
        natural_frequency: (*batch) w [rad/s].
        damping_ratio: (*batch) zeta.
    """

    natural_frequency: Floats
    damping_ratio: Floats
    __post_init__ = check_batch(natural_frequency=above_zero, damping_ratio=magnitude)

    @classmethod
    def of(cls, natural_frequency: ArrayLike, damping_ratio: ArrayLike) -> SecondOrder:
        """From natural frequency (*batch) [rad/s] and damping ratio (*batch).

        Raises:
            InputError: a frequency that is not positive, a negative damping ratio, shapes that do not go together.
        """
        return cls(*together(natural_frequency=natural_frequency, damping_ratio=damping_ratio))

    @classmethod
    def of_joint(cls, inertia: ArrayLike, damping: ArrayLike, kp: ArrayLike) -> SecondOrder:
        """M e'' + d e' + Kp e = 0: w = sqrt(Kp / M), zeta = d / (2 sqrt(Kp M)); under PD control d = b + Kd.

        Args:
            inertia: M, (*batch) [kg m^2 | kg].
            damping: d, (*batch) [N m s/rad | N s/m].
            kp: (*batch) [N m/rad | N/m].

        Raises:
            InputError: inertia or stiffness that is not positive, negative damping, shapes that do not go together.

        Reference: Lynch and Park, Modern Robotics, eq. (11.16).
        """
        M, d, k = together(
            inertia=above_zero("inertia", inertia), damping=magnitude("damping", damping), kp=above_zero("kp", kp)
        )
        return cls(np.sqrt(k / M), d / (2.0 * np.sqrt(k * M)))

    @property
    def dynamics(self) -> ErrorDynamics:
        """The same as error dynamics of order 2."""
        w, zeta = self.natural_frequency, self.damping_ratio
        return ErrorDynamics.of(np.ones_like(w), 2.0 * zeta * w, w * w)

    @property
    def roots(self) -> Complexes:
        """(*batch, 2) -zeta w +- w sqrt(zeta^2 - 1) [1/s], the slower first."""
        return self.dynamics.roots

    @property
    def damped_frequency(self) -> Floats:
        """(*batch) w sqrt(1 - zeta^2) [rad/s]; zero where nothing oscillates."""
        return self.natural_frequency * np.sqrt(np.maximum(1.0 - self.damping_ratio**2, 0.0))

    @property
    def damping(self) -> NDArray[np.int8]:
        """(*batch) the number of a `Damping`."""
        zeta = self.damping_ratio
        kinds = np.where(zeta < 1.0, Damping.UNDERDAMPED, Damping.OVERDAMPED)
        kinds = np.where(np.abs(zeta - 1.0) <= CRITICAL, Damping.CRITICALLY_DAMPED, kinds)
        return np.where(zeta == 0.0, Damping.UNDAMPED, kinds).astype(np.int8)

    @property
    def time_constants(self) -> Floats:
        """(*batch, 2) -1 / Re(s) [s], the slower first."""
        return self.dynamics.time_constants

    @property
    def settling_by_rule(self) -> Floats:
        """(*batch) four slowest time constants [s]: 31 % too low at critical damping; `settling_time` is exact."""
        return 4.0 * self.time_constants[..., 0]

    @property
    def overshoot(self) -> Floats:
        """(*batch) exp(-pi zeta / sqrt(1 - zeta^2)) of a unit step from rest; zero where nothing oscillates."""
        zeta = np.minimum(self.damping_ratio, 1.0)
        with np.errstate(divide="ignore"):
            return np.exp(-np.pi * zeta / np.sqrt(1.0 - zeta * zeta))

    @property
    def peak_time(self) -> Floats:
        """(*batch) pi / wd [s] of a step from rest; infinite where nothing oscillates."""
        with np.errstate(divide="ignore"):
            return np.pi / self.damped_frequency

    def response(self, t: ArrayLike, e0: ArrayLike = 1.0, v0: ArrayLike = 0.0) -> Floats:
        """(*batch, k) the error at times (k,) [s] from e(0) = e0, e'(0) = v0, in closed form for every damping."""
        return self.error_and_rate(t, e0, v0)[0]

    def error_and_rate(self, t: ArrayLike, e0: ArrayLike = 1.0, v0: ArrayLike = 0.0) -> tuple[Floats, Floats]:
        """Error and its rate in closed form.

        With S(t) = (e^(s1 t) - e^(s2 t)) / (s1 - s2) and C = S': e = e0 (C + 2 zeta w S) + v0 S. S is
        e^(-zeta w t) sin(wd t) / wd below critical damping, t e^(-w t) at it; no form divides by zero.

        Args:
            t: (k,) times from 0 on [s].
            e0, v0: (*batch) error and rate at t = 0.

        Returns:
            Both (*batch, k).

        Raises:
            InputError: not finite, a negative time, shapes that do not go together.
        """
        time = magnitude("t", row("t", t))
        w, zeta, e, v = self._with(e0, v0)
        return _response(w[..., None], zeta[..., None], e[..., None], v[..., None], time)

    def state_at(self, t: ArrayLike, e0: ArrayLike = 1.0, v0: ArrayLike = 0.0) -> tuple[Floats, Floats]:
        """Error and rate (*batch) of each row at its own time t >= 0 (*batch) [s]."""
        w, zeta, e, v = self._with(e0, v0)
        w, zeta, e, v, time = together(w=w, zeta=zeta, e0=e, v0=v, t=magnitude("t", t))
        return _response(w, zeta, e, v, time)

    def first_extremum(self, e0: ArrayLike = 1.0, v0: ArrayLike = 0.0) -> Floats:
        """(*batch) first time [s] after the start at which the error stands still; infinite if it never does."""
        return _first_extremum(*self._with(e0, v0))

    def opposite_peak(self, e0: ArrayLike = 1.0, v0: ArrayLike = 0.0) -> Floats:
        """(*batch) the largest error on the side opposite to e0 (an error >= 0): overshoot of any initial state.

        Args:
            e0, v0: (*batch) error, not zero, and rate at t = 0.
        """
        w, zeta, e, v = self._with(e0, v0)
        side = np.where(e < 0.0, -1.0, 1.0)
        first = _first_extremum(w, zeta, e, v)
        half = np.pi / np.maximum(w * np.sqrt(np.maximum(1.0 - zeta * zeta, 0.0)), LEAST_DIVISOR)
        largest = np.zeros_like(e)
        for when in (first, first + half):
            there = np.isfinite(when) & (when < 1e300)
            value = _response(w, zeta, e, v, np.where(there, when, 0.0))[0]
            largest = np.where(there, np.maximum(largest, -side * value), largest)
        return largest

    def settling_time(self, e0: ArrayLike = 1.0, v0: ArrayLike = 0.0, band: ArrayLike = 0.02) -> Floats:
        """(*batch) first time [s] after which |e| stays within band |e0|; infinite without damping.

        Args:
            e0, v0: (*batch) error, not zero, and rate at t = 0.
            band: (*batch) share of |e0|, 0.02 being the 2 % settling time.

        Returns:
            Exact to rounding: the last extremum outside the band is known in closed form, and after it the error falls
            monotonically into the band, where bisection finds it.
        """
        w, zeta, e, v = self._with(e0, v0)
        limit = share("band", band) * np.abs(e)
        w, zeta, e, v, limit = together(w=w, zeta=zeta, e0=e, v0=v, band=limit)
        begin, end = _last_stretch(w, zeta, e, v, limit)
        for _ in range(BISECTIONS):
            middle = 0.5 * (begin + end)
            outside = np.abs(_response(w, zeta, e, v, middle)[0]) > limit
            begin, end = np.where(outside, middle, begin), np.where(outside, end, middle)
        return np.where(zeta > 0.0, end, np.inf)

    def _with(self, e0: ArrayLike, v0: ArrayLike) -> tuple[Floats, ...]:
        return together(
            natural_frequency=self.natural_frequency,
            damping_ratio=self.damping_ratio,
            e0=finite("e0", e0),
            v0=finite("v0", v0),
        )


def _response(w: Floats, zeta: Floats, e0: Floats, v0: Floats, t: Floats) -> tuple[Floats, Floats]:
    """Error and rate."""
    S, C = _impulse(w, zeta, t)
    d, k = 2.0 * zeta * w, w * w
    return e0 * (C + d * S) + v0 * S, v0 * C - e0 * k * S


def _impulse(w: Floats, zeta: Floats, t: Floats) -> tuple[Floats, Floats]:
    """S and S' with S(0) = 0, S'(0) = 1.

    Above critical damping with s1 - s2 = 2 r, by e^(s1 t) (1 - e^(-2 r t)) / 2 r.
    """
    r, slow = _half_gap(w, zeta), -_slow_rate(w, zeta)
    decay, x = np.exp(slow * t), r * t
    tiny = np.abs(x) < LINEAR
    safe = np.where(tiny, 1.0, x)
    with np.errstate(over="ignore", invalid="ignore"):
        over = -np.expm1(-2.0 * safe) / (2.0 * safe)
        S = decay * t * np.where(tiny, 1.0, np.where(zeta > 1.0, over, np.sin(safe) / safe))
        C = np.where(zeta > 1.0, decay * 0.5 * (1.0 + np.exp(-2.0 * x)), decay * np.cos(x)) - zeta * w * S
    # Above critical damping cosh - zeta w S cancels; there S' = (s1 e^(s1 t) - s2 e^(s2 t)) / (s1 - s2) is taken.
    fast = slow - 2.0 * r
    apart = (zeta > 1.0) & (r > 1e-3 * w)
    gap = np.where(apart, slow - fast, 1.0)
    return S, np.where(apart, (slow * decay - fast * np.exp(fast * t)) / gap, C)


def _half_gap(w: Floats, zeta: Floats) -> Floats:
    """Half the distance of the roots: w sqrt|zeta^2 - 1|."""
    return w * np.sqrt(np.abs((zeta - 1.0) * (zeta + 1.0)))


def _slow_rate(w: Floats, zeta: Floats) -> Floats:
    """Minus the real part of the slower root; above critical damping w (zeta - sqrt(zeta^2 - 1)) without cancelling."""
    over = np.maximum(zeta, 1.0)
    return w * np.where(zeta > 1.0, 1.0 / (over + np.sqrt((over - 1.0) * (over + 1.0))), zeta)


def _first_extremum(w: Floats, zeta: Floats, e0: Floats, v0: Floats) -> Floats:
    """The first t > 0 with e' = v0 C - e0 w^2 S = 0; infinite if there is none.

    tan(wd t) / wd = v0 / (e0 w^2 + zeta w v0), tanh instead of tan above critical damping.
    """
    r = _half_gap(w, zeta)
    top, bottom = v0, e0 * w * w + zeta * w * v0
    with np.errstate(divide="ignore", invalid="ignore"):
        angle = np.arctan2(r * top, bottom) % np.pi
        under = np.where(angle > 0.0, angle, np.pi) / r
        ratio = r * top / bottom
        over = np.where((ratio > 0.0) & (ratio < 1.0), np.arctanh(np.clip(ratio, 0.0, BELOW_ONE)) / r, np.inf)
        critical = np.where(top * bottom > 0.0, top / bottom, np.inf)
    oscillates = zeta < 1.0
    none = (v0 == 0.0) & ~oscillates
    found = np.where(oscillates, under, np.where(r < NO_GAP * w, critical, over))
    return np.where(none | ~np.isfinite(found), np.inf, found)


def _last_stretch(w: Floats, zeta: Floats, e0: Floats, v0: Floats, limit: Floats) -> tuple[Floats, Floats]:
    """Where the error leaves its last extremum outside the band, and a later time at which it is inside."""
    first = _first_extremum(w, zeta, e0, v0)
    peak = np.abs(_response(w, zeta, e0, v0, np.where(np.isfinite(first), first, 0.0))[0])
    wd = w * np.sqrt(np.maximum(1.0 - zeta * zeta, 0.0))
    # 1. Below critical damping extrema follow each other by pi / wd, each smaller by e^(-zeta w pi / wd).
    with np.errstate(divide="ignore", invalid="ignore"):
        half = np.pi / wd
        count = np.where(peak > limit, np.ceil(np.log(peak / limit) / (zeta * w * half)) - 1.0, -1.0)
    count = np.where(np.isfinite(count), count, -1.0)
    oscillates = (zeta < 1.0) & np.isfinite(half)
    passed = np.where(oscillates, count >= 0.0, peak > limit) & np.isfinite(first)
    steps = np.where(oscillates & passed, count, 0.0) * np.where(oscillates, half, 0.0)
    begin = np.where(passed, first, 0.0) + steps
    # 2. The end of the stretch: the next extremum, or, without one, so many slow time constants that all is gone.
    slow = _slow_rate(w, zeta)
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        gone = begin + (60.0 + np.log1p((np.abs(v0) / w + np.abs(e0)) / limit)) / np.maximum(slow, LEAST_DIVISOR)
    end = np.where(oscillates, np.where(passed, begin + half, first), gone)
    return begin, np.minimum(np.where(np.isfinite(end), end, gone), gone)
