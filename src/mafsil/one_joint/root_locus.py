"""The root locus D(s) + K N(s) = 0 over a gain: branches, where they meet, where they cross the imaginary axis."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages.tables import number, table
from mafsil.one_joint.polynomial import Complexes, coefficients_of, roots, routh_hurwitz
from mafsil.one_joint.rows import finite, magnitude, row
from mafsil.one_joint.tolerances import ROUNDOFF, SAME_MEETING

REAL = 1e-7
"""Imaginary part over size below which a root of the conditions below counts as real: they may be double."""


class LocusStatus(Status):
    """For which of the gains from zero to the largest asked the loop is stable."""

    ALWAYS = ("one_joint.locus_always", True)
    SOMETIMES = ("one_joint.locus_sometimes", True)
    NEVER = ("one_joint.locus_never", False)


@dataclass(frozen=True, eq=False, repr=False)
class RootLocus(Answer, data="gains roots stable meeting_gains meetings crossing_gains crossings"):
    """Roots over a gain; true if some gain asked is stable, iterable over the branches.

    Attributes:
        gains: (k,) rising.
        roots: (k, n) [1/s]; a column is a branch, followed from gain to gain.
        stable: (k,) whether all roots are in the open left half plane.
        meeting_gains, meetings: (m,) gains >= 0 at which two roots meet on the real axis (breakaway, break-in) or off
            it, and where [1/s].
        crossing_gains, crossings: (c,) gains >= 0 at which roots stand on the imaginary axis, and w >= 0 there [rad/s].
    """

    gains: Floats
    roots: Complexes
    stable: NDArray[np.bool_]
    meeting_gains: Floats
    meetings: Complexes
    crossing_gains: Floats
    crossings: Floats

    @property
    def status(self) -> LocusStatus:
        """By how many of the gains are stable."""
        if self.stable.all():
            return LocusStatus.ALWAYS
        return LocusStatus.SOMETIMES if self.stable.any() else LocusStatus.NEVER

    def __len__(self) -> int:
        return self.roots.shape[1]

    def __iter__(self) -> Iterator[Complexes]:
        return iter(self.roots.T)

    def _table(self) -> list[str]:
        cells = [
            ("meeting", *map(number, (gain, s.real, s.imag)))
            for gain, s in zip(self.meeting_gains.tolist(), self.meetings.tolist(), strict=True)
        ]
        cells += [
            ("crossing", *map(number, (gain, 0.0, w)))
            for gain, w in zip(self.crossing_gains.tolist(), self.crossings.tolist(), strict=True)
        ]
        return table(("", "K", "Re s [1/s]", "Im s [1/s]"), cells)

    def explain(self, language: str | None = None) -> str:
        """For which of the gains asked the loop is stable."""
        good = self.gains[self.stable]
        return self.status.sentence(
            language,
            count=int(self.stable.sum()),
            of=len(self.gains),
            low=float(good.min()) if len(good) else np.nan,
            high=float(good.max()) if len(good) else np.nan,
        )


def root_locus(denominator: ArrayLike, numerator: ArrayLike, gains: ArrayLike) -> RootLocus:
    """Roots of D(s) + K N(s) over gains K.

    Kp of a PD loop at fixed Kd: D = M s^2 + (b + Kd) s, N = 1. Ki of a PID loop: D = M s^3 + (b + Kd) s^2 + Kp s.

    Args:
        denominator: (n + 1,) D, highest power first.
        numerator: (m + 1,) N, m <= n.
        gains: (k,) K >= 0.

    Returns:
        Branches, and, whatever the gains asked: meetings, where D'N - DN' = 0 and K = -D / N is real and >= 0; and
        crossings, where D(jw) + K N(jw) = 0.

    Raises:
        InputError: not finite, a leading zero, a numerator of higher order, negative gains.

    Reference: Evans, Control system synthesis by root locus method, 1950.
    """
    D, N = coefficients_of(denominator, "denominator"), row("numerator", numerator)
    N = np.trim_zeros(N, "f")
    if D.ndim != 1 or N.ndim != 1 or len(N) > len(D) or not len(N):
        raise InputError("one_joint.locus_orders")
    K = np.sort(magnitude("gains", row("gains", np.atleast_1d(finite("gains", gains)))))
    if K.ndim != 1:
        raise InputError("input.shape", name="gains", expected="(k,)", got=K.shape, hint="")
    wide = np.concatenate([np.zeros(len(D) - len(N)), N])
    closed = D + K[:, None] * wide
    found = _follow(roots(closed))
    meetings = _meetings(D, N)
    crossings = _crossings(D, wide)
    return RootLocus(K, found, routh_hurwitz(closed).stable, *meetings, *crossings)


def _follow(found: Complexes) -> Complexes:
    """Each row reordered so that its roots continue the row before: the closest pairs first."""
    result = found.copy()
    for k in range(1, len(found)):
        distance = np.abs(result[k - 1][:, None] - found[k][None, :])
        for _ in range(found.shape[1]):
            i, j = np.unravel_index(int(np.argmin(distance)), distance.shape)
            result[k, i] = found[k, j]
            distance[i, :] = distance[:, j] = np.inf
    return result


def _meetings(D: Floats, N: Floats) -> tuple[Floats, Complexes]:
    """Gains and places of double roots.

    Where D and N share a root r, it is one for every K, and a double one for K = -D'(r) / N'(r).
    """
    condition = np.trim_zeros(np.polysub(np.polymul(np.polyder(D), N), np.polymul(D, np.polyder(N))), "f")
    s = roots(condition) if len(condition) > 1 else np.empty(0, dtype=np.complex128)
    s = np.asarray(np.where(np.abs(s.imag) <= REAL * np.abs(s), s.real, s), dtype=np.complex128)
    shared = _vanishes(N, s) & _vanishes(D, s)
    again = [bool(shared[k]) and bool((np.abs(s[k] - s[:k][shared[:k]]) <= SAME_MEETING).any()) for k in range(len(s))]
    once = ~np.array(again, dtype=np.bool_) & ((np.abs(np.polyval(N, s)) > 0.0) | shared)
    s, shared = s[once], shared[once]
    above, below = (np.where(shared, np.polyval(np.polyder(p), s), np.polyval(p, s)) for p in (D, N))
    with np.errstate(divide="ignore", invalid="ignore"):
        K: Complexes = np.asarray(-above / below, dtype=np.complex128)
        size = np.where(shared, np.polyval(np.abs(np.polyder(D)), np.abs(s)), np.polyval(np.abs(D), np.abs(s)))
        scale = size / np.abs(below)
    real = np.abs(K.imag) <= REAL * np.maximum(np.abs(K), LEAST_DIVISOR)
    kept = real & (K.real >= -ROUNDOFF * scale) & (s.imag >= 0.0)
    order = np.argsort(K.real[kept])
    return np.maximum(K.real[kept][order], 0.0), s[kept][order]


def _vanishes(p: Floats, s: Complexes) -> NDArray[np.bool_]:
    """(k,) whether a polynomial is zero at points, up to rounding."""
    size: Floats = np.asarray(np.polyval(np.abs(p), np.abs(s)), dtype=np.float64)
    return np.asarray(np.abs(np.polyval(p, s)) <= REAL * size, dtype=np.bool_)


def _crossings(D: Floats, N: Floats) -> tuple[Floats, Floats]:
    """Gains and frequencies at the imaginary axis: Im(D(jw) conj N(jw)) = 0 is a polynomial in w."""
    turn = 1j ** np.arange(len(D) - 1, -1, -1)
    d, n = D * turn, N * turn
    # p(w) = conj of N(jw): conjugate coefficients, since w is real.
    odd = np.trim_zeros(np.imag(np.convolve(d, np.conj(n))), "f")
    w = roots(odd) if len(odd) > 1 else np.zeros(1, dtype=np.complex128)
    real = np.abs(w.imag) <= REAL * np.maximum(np.abs(w), np.abs(w).max() * REAL)
    frequencies = np.unique(np.abs(w.real[real]))
    frequencies = frequencies[np.concatenate([[True], np.diff(frequencies) > REAL * frequencies[1:]])]
    D_w, N_w = (np.asarray(np.polyval(p, frequencies), dtype=np.complex128) for p in (d, n))
    on_axis = 1j * frequencies
    there = (np.abs(N_w) > 0.0) & ~(_vanishes(D, on_axis) & _vanishes(N, on_axis))
    K: Complexes = np.asarray(-(D_w[there] / N_w[there]), dtype=np.complex128)
    size = np.asarray(np.polyval(np.abs(D), frequencies[there]) / np.abs(N_w[there]), dtype=np.float64)
    kept = (np.abs(K.imag) <= REAL * np.maximum(size, LEAST_DIVISOR)) & (K.real >= -ROUNDOFF * size)
    order = np.argsort(K.real[kept])
    return np.maximum(K.real[kept][order], 0.0), frequencies[there][kept][order]
