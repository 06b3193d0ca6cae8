"""Gains from what is wanted: damping, settling time, roots, rest error; and how far they may go."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Floats, real_array
from mafsil.errors import InputError
from mafsil.one_joint.rows import RowAnswer, above_zero, finite, magnitude, share, together
from mafsil.one_joint.second_order import SecondOrder

REAL = 1e-9
"""Imaginary part, as a share of its terms, below which a gain made of conjugate roots is real."""


class DesignStatus(Status):
    """Whether gains that are not negative do what is wanted."""

    DESIGNED = ("one_joint.designed", True)
    TOO_MUCH_FRICTION = ("one_joint.too_much_friction", False)
    NEGATIVE_GAIN = ("one_joint.negative_gain", False)


@dataclass(frozen=True, eq=False, repr=False)
class DesignedGains(RowAnswer):
    """Gains of the torque; true if none is negative.

    Attributes:
        verdict: (*batch) which of `statuses`.
        kp, ki, kd: (*batch) [N m/rad, N m/(rad s), N m s/rad], or the same with N and m; as computed, even if negative.
    """

    statuses: ClassVar[tuple[Status, ...]] = tuple(DesignStatus)
    verdict: NDArray[np.int8]
    kp: Floats
    ki: Floats
    kd: Floats

    @classmethod
    def of(cls, kp: Floats, ki: Floats, kd: Floats) -> DesignedGains:
        """With the verdict that follows from the signs."""
        kp, ki, kd = together(kp=finite("kp", kp), ki=finite("ki", ki), kd=finite("kd", kd))
        verdict = np.where((kp < 0.0) | (ki < 0.0), 2, np.where(kd < 0.0, 1, 0)).astype(np.int8)
        return cls(verdict, kp, ki, kd)


def kp_for_damping_ratio(inertia: ArrayLike, damping: ArrayLike, damping_ratio: ArrayLike = 1.0) -> Floats:
    """Kp that gives a damping ratio while the damping is fixed: d^2 / (4 zeta^2 M); critical damping for zeta = 1.

    Args:
        inertia: M (*batch) [kg m^2 | kg].
        damping: d = b + Kd, (*batch) [N m s/rad | N s/m].
        damping_ratio: zeta > 0, (*batch).

    Returns:
        (*batch) [N m/rad | N/m].

    Raises:
        InputError: not positive, or shapes that do not go together.
    """
    M, d, zeta = together(
        inertia=above_zero("inertia", inertia),
        damping=above_zero("damping", damping),
        damping_ratio=above_zero("damping_ratio", damping_ratio),
    )
    return d * d / (4.0 * zeta * zeta * M)


def pd_for_settling(
    inertia: ArrayLike, friction: ArrayLike, damping_ratio: ArrayLike, settling_time: ArrayLike, band: ArrayLike = 0.02
) -> DesignedGains:
    """PD gains for a damping ratio and an exact settling time, from rest.

    The settling time of unit natural frequency, T1(zeta), is exact; times scale, so w = T1 / T.

    Args:
        inertia: M (*batch) [kg m^2 | kg].
        friction: b of the joint itself (*batch) [N m s/rad | N s/m].
        damping_ratio: zeta > 0, (*batch).
        settling_time: T (*batch) [s].
        band: share of the initial error within which the error stays from then on.

    Returns:
        Kp = M w^2 and Kd = 2 zeta w M - b; false where the friction alone damps more than is wanted.

    Raises:
        InputError: a number out of its range, shapes that do not go together.
    """
    M, b, zeta, T, part = together(
        inertia=above_zero("inertia", inertia),
        friction=magnitude("friction", friction),
        damping_ratio=above_zero("damping_ratio", damping_ratio),
        settling_time=above_zero("settling_time", settling_time),
        band=share("band", band),
    )
    w = SecondOrder.of(np.ones_like(zeta), zeta).settling_time(band=part) / T
    return DesignedGains.of(M * w * w, np.zeros_like(w), 2.0 * zeta * w * M - b)


def gains_from_roots(inertia: ArrayLike, friction: ArrayLike, wanted: ArrayLike) -> DesignedGains:
    """Gains that put the roots of the error dynamics where they are wanted: two roots PD, three PID.

    M (s - s1)(s - s2)(s - s3) = M s^3 + (b + Kd) s^2 + Kp s + Ki.

    Args:
        inertia: M (*batch) [kg m^2 | kg].
        friction: b of the joint itself (*batch) [N m s/rad | N s/m].
        wanted: (*batch, 2) or (*batch, 3) roots, real or conjugate pairs [1/s].

    Returns:
        The gains; false where one is negative.

    Raises:
        InputError: not two or three roots, not finite, or complex roots without their conjugates.
    """
    try:
        s: NDArray[Any] = np.asarray(wanted)
    except ValueError:
        raise InputError("input.numbers", name="wanted", got=type(wanted).__name__) from None
    if s.dtype.kind not in "fiuc" or s.ndim == 0 or s.shape[-1] not in (2, 3):
        raise InputError("input.shape", name="wanted", expected="(*batch, 2) or (*batch, 3)", got=s.shape, hint="")
    finite("wanted", np.stack([np.real(s), np.imag(s)]).astype(np.float64))
    a = np.ones((*s.shape[:-1], 1), dtype=np.complex128)
    scale = np.ones((*s.shape[:-1], 1))
    for k in range(s.shape[-1]):
        a = np.pad(a, [(0, 0)] * (a.ndim - 1) + [(0, 1)]) - s[..., k, None] * np.pad(
            a, [(0, 0)] * (a.ndim - 1) + [(1, 0)]
        )
        scale = np.pad(scale, [(0, 0)] * (scale.ndim - 1) + [(0, 1)]) + np.abs(s[..., k, None]) * np.pad(
            scale, [(0, 0)] * (scale.ndim - 1) + [(1, 0)]
        )
    if (np.abs(a.imag) > REAL * scale).any():
        raise InputError("one_joint.conjugate")
    M, b, lead = together(
        inertia=above_zero("inertia", inertia), friction=magnitude("friction", friction), wanted=a.real[..., 1]
    )
    ki = M * a.real[..., 3] if s.shape[-1] == 3 else np.zeros_like(lead)
    return DesignedGains.of(M * a.real[..., 2], ki, M * lead - b)


def ki_limit(
    inertia: ArrayLike,
    damping: ArrayLike,
    kp: ArrayLike,
    gravity_moment: ArrayLike = 0.0,
    goal: ArrayLike = 0.0,
) -> Floats:
    """The integral gain below which the loop is stable near its goal: d (Kp - m g r sin theta_d) / M.

    Without gravity it is the bound d Kp / M of a disturbance that does not depend on the angle; a link under gravity
    pulls away from the upright position and lowers it there.

    Args:
        inertia: M (*batch) [kg m^2].
        damping: d = b + Kd, (*batch) [N m s/rad].
        kp: (*batch) [N m/rad].
        gravity_moment: m g r (*batch) [N m], the gravity torque of the horizontal link.
        goal: theta_d (*batch) [rad], measured from the horizontal.

    Returns:
        (*batch) [N m/(rad s)]; at the limit itself the loop oscillates. Zero or negative: no integral gain is stable.

    Raises:
        InputError: a number out of its range, shapes that do not go together.

    Reference: Lynch and Park, Modern Robotics, eq. (11.24); with gravity linearised about the goal.
    """
    M, d, k, load, angle = together(
        inertia=above_zero("inertia", inertia),
        damping=magnitude("damping", damping),
        kp=magnitude("kp", kp),
        gravity_moment=finite("gravity_moment", gravity_moment),
        goal=finite("goal", goal),
    )
    return d * (k - load * np.sin(angle)) / M


def kp_for_rest_error(gravity_moment: ArrayLike, allowed: ArrayLike, torque_limit: ArrayLike = np.inf) -> Floats:
    """Smallest Kp with which PD control rests within an allowed error of any goal: m g r / |e|.

    Args:
        gravity_moment: m g r (*batch) [N m].
        allowed: |e| (*batch) [rad].
        torque_limit: of the drive (*batch) [N m].

    Returns:
        (*batch) [N m/rad]; NaN where no gain is enough, since the drive cannot hold m g r, the torque at rest.
    """
    load, error = together(
        gravity_moment=magnitude("gravity_moment", gravity_moment), allowed=above_zero("allowed", allowed)
    )
    limit = real_array("torque_limit", torque_limit)
    if not (limit > 0.0).all():
        raise InputError("input.positive", name="torque_limit", value=float(limit.min()))
    load, error, limit = together(gravity_moment=load, allowed=error, torque_limit=limit)
    return np.where(load <= limit, load / error, np.nan)
