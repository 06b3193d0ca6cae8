"""How much a loop bears: gain, phase and delay of a continuous one, period and delay of a sampled one.

Margins of L(s) = N(s) / D(s) come from the polynomials themselves, the stability of sampled loops from their exact step
matrix between readings and its spectral radius; so does the stiffest virtual wall against which a device is stable.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Floats, real_array, require_kind, whole
from mafsil.errors import InputError
from mafsil.one_joint.joint_law import JointArm, JointLaw, LawKind
from mafsil.one_joint.polynomial import coefficients_of, polynomial_value, roots, routh_hurwitz
from mafsil.one_joint.rows import RowAnswer, above_zero, finite, magnitude, row, together
from mafsil.one_joint.tolerances import NO_COEFFICIENT

AT_LIMIT = 1e-9
"""Distance of the spectral radius from 1 within which a loop counts as being at its limit."""
DECAYS = 1e-12
"""Distance of the spectral radius from 1 that eigenvalues show beyond their rounding: where searches for limits end."""
HALVINGS = 80
"""In the search."""
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
    sizes = np.abs(polynomial)
    p = np.trim_zeros(np.where(sizes > NO_COEFFICIENT * sizes.max(initial=0.0), polynomial, 0.0), "f")
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


class SampledStatus(Status):
    """Whether a sampled loop forgets its errors."""

    STABLE = ("one_joint.sampled_stable", True)
    MARGINAL = ("one_joint.sampled_marginal", False)
    UNSTABLE = ("one_joint.sampled_unstable", False)


@dataclass(frozen=True, eq=False, repr=False)
class SampledStability(RowAnswer):
    """Whether all eigenvalues of the step matrix lie within the unit circle; true if they do, in every row.

    Attributes:
        verdict: (*batch) which of `statuses`.
        spectral_radius: (*batch) factor by which errors grow in each period in the long run.
    """

    statuses: ClassVar[tuple[Status, ...]] = tuple(SampledStatus)
    verdict: NDArray[np.int8]
    spectral_radius: Floats

    @classmethod
    def of_matrix(cls, A: Floats) -> SampledStability:
        """Of step matrices (*batch, n, n)."""
        if np.ndim(A) < 2 or np.shape(A)[-1] != np.shape(A)[-2]:
            raise InputError("input.shape", name="A", expected="(*batch, n, n)", got=np.shape(A), hint="")
        values = np.linalg.eigvals(finite("A", A))
        return cls.of_radius(np.asarray(np.abs(values).max(axis=-1), dtype=np.float64))

    @classmethod
    def of_radius(cls, radius: Floats) -> SampledStability:
        """Of spectral radii (*batch)."""
        radius = real_array("radius", radius)
        verdict = np.where(radius < 1.0 - AT_LIMIT, 0, np.where(radius <= 1.0 + AT_LIMIT, 1, 2)).astype(np.int8)
        return cls(verdict, radius)


def step_matrix(arm: JointArm, law: JointLaw, period: ArrayLike, delay: int = 0) -> Floats:
    """The loop of the pseudo-code from reading to reading, exactly: (*batch, n, n), n = 4 + delay.

    State: theta, theta', the last reading, the integral, and the torques under way. The plant between commands,
    M theta'' + b theta' = tau with tau constant, is solved in closed form; set point zero, no gravity.

    Args:
        arm: its viscous friction counts.
        law: feedback.
        period: (*batch) [s].
        delay: whole periods from a reading to its torque.

    Raises:
        InputError: a law that is not feedback alone, a number out of its range.
    """
    require_kind("arm", arm, "JointArm", "gravity_moment", "friction")
    require_kind("law", law, "JointLaw", "kind", "model")
    if law.kind is not LawKind.FEEDBACK:
        raise InputError("input.choice", name="law.kind", value=law.kind.name, known=LawKind.FEEDBACK.name)
    d = whole("delay", delay, most=2000)
    M, b, kp, ki, kd, T = together(
        inertia=arm.inertia, friction=arm.friction.viscous, kp=law.kp, ki=law.ki, kd=law.kd,
        period=above_zero("period", period),
    )  # fmt: skip
    n = 4 + d
    A = np.zeros((*M.shape, n, n))
    # 1. theta after a period: theta + S theta' + P tau; theta': E theta' + Q tau.
    E, S, Q, P = held_plant(M, b, T)
    # 2. Torque of this reading: -(Kp + Ki T) theta + Ki I - Kd (theta - last) / T, with I the integral of -theta.
    torque = np.zeros((*M.shape, n))
    torque[..., 0], torque[..., 2], torque[..., 3] = -(kp + ki * T + kd / T), kd / T, ki
    acting = torque if d == 0 else np.zeros_like(torque)
    if d:
        acting[..., 4] = 1.0
    A[..., 0, 0], A[..., 0, 1] = 1.0, S
    A[..., 1, 1] = E
    A[..., 0, :] += P[..., None] * acting
    A[..., 1, :] += Q[..., None] * acting
    # 3. The last reading, the integral.
    A[..., 2, 0] = 1.0
    A[..., 3, 3], A[..., 3, 0] = 1.0, -T
    # 4. Torques under way move up; the youngest is this one.
    if d:
        A[..., np.arange(4, n - 1), np.arange(5, n)] = 1.0
        A[..., n - 1, :] = torque
    return A


def held_plant(M: Floats, b: Floats, T: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """With x = b T / M: e^-x, (1 - e^-x) M / b, (1 - e^-x) / b, (x - 1 + e^-x) M / b^2; series where x is small."""
    x = b * T / M
    small = x < 1e-3
    safe = np.where(small, 1.0, x)
    first = np.where(small, 1.0 - x / 2.0 + x * x / 6.0 - x**3 / 24.0 + x**4 / 120.0, -np.expm1(-safe) / safe)
    second = np.where(small, 0.5 - x / 6.0 + x * x / 24.0 - x**3 / 120.0, (safe + np.expm1(-safe)) / (safe * safe))
    return np.exp(-x), T * first, T / M * first, T * T / M * second


def sampled_stability(arm: JointArm, law: JointLaw, period: ArrayLike, delay: int = 0) -> SampledStability:
    """Stability of the loop of the pseudo-code with a delay of whole periods; arguments as of `step_matrix`."""
    A = step_matrix(arm, law, period, delay)
    if not law.ki.any():
        # Without an integral its state feeds nothing: the eigenvalue 1 that it leaves is no motion of the joint.
        kept = [k for k in range(A.shape[-1]) if k != 3]
        A = A[..., kept, :][..., kept]
    return SampledStability.of_matrix(A)


def first_unstable_delay(arm: JointArm, law: JointLaw, period: float, most: int = 1000) -> int | None:
    """The fewest periods of delay with which the loop is no longer stable; None if all up to `most` are stable.

    Args:
        arm, law: of one row.
        period: [s].
        most: delays that are looked at, one after the other.
    """
    for delay in range(whole("most", most, least=1, most=2000) + 1):
        if not (sampled_stability(arm, law, period, delay).spectral_radius < 1.0 - DECAYS).all():
            return delay
    return None


def stiffest_stable_wall(
    mass: ArrayLike, friction: ArrayLike, period: ArrayLike, wall_damping: ArrayLike = 0.0, delay: int = 0
) -> Floats:
    """Stiffest virtual wall against which a free device is stable by itself (*batch) [N/m].

    The wall is a sampled spring and differenced damper; by halving on the spectral radius of the exact step, to
    rounding of its eigenvalues; a spring alone without delay by its closed form. A hand that holds the device may still
    make it unstable: the passive limit is `mafsil.control.contact.stiffest_wall`.

    Args:
        mass: of the device (*batch) [kg].
        friction: b (*batch) of the device [N s/m].
        period: T (*batch) [s].
        wall_damping: B (*batch) [N s/m].
        delay: whole periods.

    Returns:
        0 where no wall is stable.
    """
    m, b, T, B = together(
        mass=above_zero("mass", mass), friction=magnitude("friction", friction), period=above_zero("period", period),
        wall_damping=magnitude("wall_damping", wall_damping),
    )  # fmt: skip
    late, device = whole("delay", delay), JointArm.of(m, friction=b)
    low, high = np.zeros_like(m), 16.0 * m / (T * T) + 16.0 * (b + B) / T
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        fine = sampled_stability(device, JointLaw.pid(middle, 0.0, B), T, late).spectral_radius < 1.0 - DECAYS
        low, high = np.where(fine, middle, low), np.where(fine, high, middle)
    if late:
        return low
    # A spring without delay: theta, theta' go by [[1 - P K, S], [-Q K, E]], stable while its determinant is below 1 and
    # no eigenvalue passes -1. No difference of nearly equal numbers is needed, however light the damping.
    E, S, Q, P = held_plant(m, b, T)
    turns, flips = S * Q - P * E, P * (1.0 + E) - S * Q
    with np.errstate(divide="ignore"):
        spring = np.minimum(-np.expm1(-b * T / m) / turns, np.where(flips > 0.0, 2.0 * (1.0 + E) / flips, np.inf))
    return np.where(B > 0.0, low, spring)
