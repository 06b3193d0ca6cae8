"""Is the sampled loop stable? Its exact step matrix between readings, its spectral radius, the delay that it bears.

The stiffest virtual wall against which a sampled device is stable by itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Floats, real_array, require_kind, whole
from mafsil.errors import InputError
from mafsil.one_joint.arguments import above_zero, finite, magnitude, together
from mafsil.one_joint.joint_law import JointArm, JointLaw, LawKind
from mafsil.one_joint.row_answer import RowAnswer

AT_LIMIT = 1e-9
"""Distance of the spectral radius from 1 within which a loop counts as being at its limit."""
DECAYS = 1e-12
"""Distance of the spectral radius from 1 that eigenvalues show beyond their rounding: where searches for limits end."""


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


HALVINGS = 80
"""In the search."""


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
