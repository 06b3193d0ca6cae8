"""How much gain, phase and delay a loop bears: margins of L(s) = N(s) / D(s), from the polynomials themselves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Floats, require_kind
from mafsil.errors import InputError
from mafsil.one_joint.arguments import row
from mafsil.one_joint.joint_law import JointArm, JointLaw, LawKind
from mafsil.one_joint.polynomial import coefficients_of, polynomial_value, roots
from mafsil.one_joint.routh import routh_hurwitz
from mafsil.one_joint.row_answer import RowAnswer

REAL = 1e-7
"""Imaginary part over size below which a root counts as real: crossings may be double."""


class MarginStatus(Status):
    """Whether the closed loop is stable, without which margins mean nothing."""

    STABLE = ("one_joint.margins", True)
    UNSTABLE = ("one_joint.no_margins", False)


@dataclass(frozen=True, eq=False, repr=False)
class Margins(RowAnswer):
    """Margins of a stable closed loop; NaN where it is not stable.

    Attributes:
        verdict: (*batch) which of `statuses`.
        gain_above, gain_below: (*batch) factors by which the gain may grow and shrink; infinite and 0 if any.
        phase: (*batch) least phase [rad] that may be lost at a crossover; infinite without a crossover.
        delay: (*batch) least delay [s] that makes the loop unstable; infinite if none does.
        crossover: (*batch) frequency at which that delay does [rad/s]; NaN if none.
    """

    statuses: ClassVar[tuple[Status, ...]] = tuple(MarginStatus)
    verdict: NDArray[np.int8]
    gain_above: Floats
    gain_below: Floats
    phase: Floats
    delay: Floats
    crossover: Floats


def margins(numerator: ArrayLike, denominator: ArrayLike) -> Margins:
    """Margins of the loop L(s) = N(s) / D(s) under unit negative feedback.

    Crossovers are the real roots w of |N(jw)|^2 = |D(jw)|^2; the delay margin is the least of phase margin / w over
    them: e^(-j w T) takes the phase w T.

    Args:
        numerator: (*batch, m + 1) N, highest power first.
        denominator: (*batch, n + 1) D, n > m or n = m.

    Raises:
        InputError: not finite, a leading zero of D, a numerator of higher order.
    """
    N, D = row("numerator", numerator), coefficients_of(denominator, "denominator")
    if N.shape[-1] > D.shape[-1]:
        raise InputError("one_joint.locus_orders")
    batch = np.broadcast_shapes(N.shape[:-1], D.shape[:-1])
    N = np.broadcast_to(N, (*batch, N.shape[-1]))
    D = np.broadcast_to(D, (*batch, D.shape[-1]))
    N = np.concatenate([np.zeros((*batch, D.shape[-1] - N.shape[-1])), N], axis=-1).reshape(-1, D.shape[-1])
    D = D.reshape(N.shape)
    closed = D + N
    whole = np.abs(closed[:, 0]) > 0.0
    stable = np.zeros(len(D), dtype=np.bool_)
    if whole.any():
        stable[whole] = routh_hurwitz(closed[whole]).stable
    found = np.full((len(D), 5), np.nan)
    for k in np.flatnonzero(stable).tolist():
        found[k] = _margins(N[k], D[k])
    columns = found.reshape(*batch, 5)
    verdict = np.where(stable, 0, 1).astype(np.int8).reshape(batch)
    return Margins(verdict, *(columns[..., k] for k in range(5)))


def joint_margins(arm: JointArm, law: JointLaw) -> Margins:
    """Margins of feedback around a joint: L(s) = (Kd s^2 + Kp s + Ki) / (s^2 (M s + b)).

    Args:
        arm: its viscous friction counts; gravity does not.
        law: feedback with gains (*batch).

    Raises:
        InputError: a law that is not feedback alone.
    """
    require_kind("arm", arm, "JointArm", "gravity_moment", "friction")
    require_kind("law", law, "JointLaw", "kind", "model")
    if law.kind is not LawKind.FEEDBACK:
        raise InputError("input.choice", name="law.kind", value=law.kind.name, known=LawKind.FEEDBACK.name)
    M, b, kp, ki, kd = np.broadcast_arrays(arm.inertia, arm.friction.viscous, law.kp, law.ki, law.kd)
    zero = np.zeros_like(M)
    if ki.any() and not ki.all():
        raise InputError("one_joint.mixed_orders")
    if ki.any():
        return margins(np.stack([kd, kp, ki], axis=-1), np.stack([M, b, zero, zero], axis=-1))
    return margins(np.stack([kd, kp], axis=-1), np.stack([M, b, zero], axis=-1))


def _margins(N: Floats, D: Floats) -> tuple[float, float, float, float, float]:
    """Of one stable loop: gain above, gain below, phase, delay, crossover."""
    turn = 1j ** np.arange(len(D) - 1, -1, -1)
    n, d = N * turn, D * turn
    # 1. Crossovers: |N|^2 - |D|^2 = 0.
    w = _frequencies(np.real(np.convolve(n, np.conj(n)) - np.convolve(d, np.conj(d))))
    phase = np.mod(np.angle(_loop(n, d, w)) + np.pi, 2.0 * np.pi)
    # 2. Phase crossings: L real and negative; the gain may change by -1 / L.
    v = _frequencies(np.imag(np.convolve(n, np.conj(d))))
    L = _loop(n, d, v)
    factors = -1.0 / L.real[L.real < 0.0]
    above, below = factors[factors > 1.0], factors[factors < 1.0]
    either = np.minimum(phase, 2.0 * np.pi - phase)
    delays = phase / w
    last = int(np.argmin(delays)) if len(w) else -1
    return (
        float(above.min()) if len(above) else np.inf,
        float(below.max()) if len(below) else 0.0,
        float(either.min()) if len(w) else np.inf,
        float(delays[last]) if len(w) else np.inf,
        float(w[last]) if len(w) else np.nan,
    )


def _frequencies(polynomial: Floats) -> Floats:
    """Its positive real roots."""
    p = np.trim_zeros(np.where(np.abs(polynomial) > 1e-14 * np.abs(polynomial).max(initial=0.0), polynomial, 0.0), "f")
    w = roots(p) if len(p) > 1 else np.empty(0, dtype=np.complex128)
    size = np.abs(w).max(initial=0.0)
    return np.unique(w.real[(np.abs(w.imag) <= REAL * np.abs(w)) & (w.real > REAL * size)])


def _loop(n: NDArray[np.complex128], d: NDArray[np.complex128], w: Floats) -> NDArray[np.complex128]:
    return np.asarray(np.polyval(n, w) / np.polyval(d, w), dtype=np.complex128)


def sensitivity_peak(numerator: ArrayLike, denominator: ArrayLike, frequency: ArrayLike) -> Floats:
    """(*batch) largest |1 / (1 + L(jw))| over the frequencies (k,): 1 / distance to the critical point."""
    N, D = row("numerator", numerator), row("denominator", denominator)
    s = np.asarray(1j * row("frequency", frequency), dtype=np.complex128)
    n, d = polynomial_value(N, s), polynomial_value(D, s)
    return np.asarray(np.abs(d / (d + n)).max(axis=-1))
