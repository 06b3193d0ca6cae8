"""Which reduction lets a motor do what a joint needs: torque, heat and speed, over a whole motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Floats, require_kind
from mafsil.errors import InputError
from mafsil.one_joint.rows import RowAnswer, above_zero, check_batch, finite, magnitude, row, share, together


@dataclass(frozen=True, eq=False, slots=True)
class MotorRating:
    """Ratings of a motor from its data sheet.

    Attributes:
        peak_torque: for short times (*batch) [N m].
        continuous_torque: for ever, as root mean square (*batch) [N m].
        speed: highest (*batch) [rad/s].
        inertia: of the rotor (*batch) [kg m^2].
    """

    peak_torque: Floats
    continuous_torque: Floats
    speed: Floats
    inertia: Floats
    __post_init__ = check_batch(
        peak_torque=above_zero, continuous_torque=above_zero, speed=above_zero, inertia=magnitude
    )

    @classmethod
    def of(
        cls, peak_torque: ArrayLike, continuous_torque: ArrayLike, speed: ArrayLike, inertia: ArrayLike = 0.0
    ) -> MotorRating:
        """From its data sheet, each a number or (*batch).

        Raises:
            InputError: a number out of its range, shapes that do not go together.
        """
        return cls(
            *together(peak_torque=peak_torque, continuous_torque=continuous_torque, speed=speed, inertia=inertia)
        )


class SizingStatus(Status):
    """Whether there is a reduction, or what forbids it."""

    SIZED = ("one_joint.sized", True)
    TOO_FAST = ("one_joint.too_fast_for_torque", False)
    OVERHEATS = ("one_joint.overheats", False)
    TOO_WEAK = ("one_joint.too_weak", False)


STATUSES = tuple(SizingStatus)


@dataclass(frozen=True, eq=False, repr=False)
class DriveSizing(RowAnswer):
    """The reductions with which a motor suffices; true if there are some, in every row.

    Attributes:
        verdict: (*batch) which of `statuses`.
        least: (*batch) ratio from which on the torque suffices; infinite where none does.
        most: (*batch) ratio up to which the speed, and the rotor's own inertia, allow it.
        ratio: (*batch) with the least heat among these; without any, the one with the least heat at all.
        peak: (*batch) largest torque of the motor there, as share of what it may.
        heat: (*batch) root mean square of its torque there, as share of what it may.
        speed: (*batch) its highest speed there, as share of what it may.
    """

    statuses: ClassVar[tuple[Status, ...]] = STATUSES
    verdict: NDArray[np.int8]
    least: Floats
    most: Floats
    ratio: Floats
    peak: Floats
    heat: Floats
    speed: Floats


def size_drive(
    motor: MotorRating,
    torque: ArrayLike,
    speed: ArrayLike,
    acceleration: ArrayLike = 0.0,
    *,
    t: ArrayLike | None = None,
    efficiency: ArrayLike = 1.0,
) -> DriveSizing:
    """The reductions G with which a motor drives a joint along a motion, in closed form.

    The motor gives m = a / G + I_m G alpha at every moment, a the joint's torque with the gear's losses (they add
    while it drives and help while it brakes). Each condition leaves one interval of G, or none:

    1. speed: G max |omega| is at most that of the motor;
    2. peak: |m| at every moment is at most its peak torque;
    3. heat: mean m^2 = A / G^2 + 2 B + C G^2 is at most the square of its continuous torque.

    The ratio with the least heat is (A / C)^(1/4), as near as the interval allows.

    Args:
        motor: (*batch) with its rotor.
        torque: (*batch, k) of the joint along the motion, such as `inverse_dynamics` gives [N m | N].
        speed: (*batch, k) of the joint [rad/s | m/s].
        acceleration: (*batch, k) of the joint [rad/s^2 | m/s^2].
        t: (k,) increasing times of the samples; evenly spaced if None [s].
        efficiency: of the gear (*batch).

    Raises:
        InputError: not finite, out of range, shapes that do not go together; a joint that never moves and needs
            nothing.
    """
    require_kind("motor", motor, "MotorRating", "peak_torque", "inertia")
    tau, omega, alpha = together(
        torque=row("torque", torque), speed=row("speed", speed), acceleration=finite("acceleration", acceleration)
    )
    if not (tau.any(axis=-1) | omega.any(axis=-1)).all():
        raise InputError("one_joint.nothing_to_drive")
    weights = _weights(t, tau.shape[-1])
    eta = share("efficiency", efficiency)[..., None]
    a, c, limit = together(
        torque=tau * np.where(tau * omega >= 0.0, 1.0 / eta, eta),
        inertia=motor.inertia[..., None] * alpha,
        peak_torque=motor.peak_torque[..., None],
    )
    # 1
    with np.errstate(divide="ignore"):
        by_speed = motor.speed / np.abs(omega).max(axis=-1)
    # 2
    low, high = _between(a, c, limit)
    peak_low, peak_high = low.max(axis=-1), high.min(axis=-1)
    # 3
    A, B, C = (np.asarray(pair @ weights) for pair in (a * a, a * c, c * c))
    heat_low, heat_high = (np.sqrt(end) for end in _between(A, C, motor.continuous_torque**2 - 2.0 * B))
    least = np.maximum(peak_low, heat_low)
    most = np.minimum(np.minimum(by_speed, peak_high), heat_high)
    failed = [least <= most, heat_low > heat_high, peak_low > peak_high]
    order = [SizingStatus.SIZED, SizingStatus.OVERHEATS, SizingStatus.TOO_WEAK]
    verdict = np.select(failed, [STATUSES.index(status) for status in order], STATUSES.index(SizingStatus.TOO_FAST))
    # Without any that suffices the ratio of least heat that the speed allows shows how much is missing.
    coolest = np.where(C > 0.0, np.sqrt(np.sqrt(A / np.where(C > 0.0, C, 1.0))), by_speed)
    ratio = np.minimum(np.maximum(coolest, np.where(verdict == 0, least, 0.0)), np.where(verdict == 0, most, by_speed))
    ratio = np.where(
        np.isfinite(ratio) & (ratio > 0.0), ratio, np.where(np.isfinite(least), np.maximum(least, 1.0), 1.0)
    )
    m = np.abs(a / ratio[..., None] + c * ratio[..., None])
    heat = np.sqrt(m * m @ weights) / motor.continuous_torque
    columns = together(
        least=least, most=most, ratio=ratio, peak=m.max(axis=-1) / motor.peak_torque, heat=heat, speed=ratio / by_speed
    )
    return DriveSizing(verdict.astype(np.int8), *columns)


def _between(p: Floats, q: Floats, r: Floats) -> tuple[Floats, Floats]:
    """The interval of x > 0 in which -r <= p / x + q x <= r; infinity and zero where there is none.

    With s = sqrt(r^2 - 4 p q) it is |p| / x_low = (r + s) / 2 = |q| x_high, whatever the signs of p and q.
    """
    square = r * r - 4.0 * p * q
    half = (r + np.sqrt(np.maximum(square, 0.0))) / 2.0
    possible = (square >= 0.0) & (r > 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(possible, np.abs(p) / half, np.inf), np.where(possible, half / np.abs(q), 0.0)


def _weights(t: ArrayLike | None, k: int) -> Floats:
    """(k,) shares of the time that samples stand for: between them the trapezoidal rule."""
    if t is None:
        return np.full(k, 1.0 / k)
    times = row("t", t)
    if times.shape != (k,) or k < 2 or not (np.diff(times) > 0.0).all():
        raise InputError("one_joint.sample_times", k=k, got=times.shape)
    steps = np.diff(times)
    return (np.append(steps, 0.0) + np.insert(steps, 0, 0.0)) / (2.0 * steps.sum())
