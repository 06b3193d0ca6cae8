"""Measures of a recorded response: steady error, overshoot, peak, rise and settling, NaN where it shows none.

How fast need a loop be? The same run at many periods, and from which one on more ticks gain nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Floats, require_kind
from mafsil.errors import InputError
from mafsil.one_joint.joint_law import JointArm, JointLaw
from mafsil.one_joint.joint_run import IDEAL, LoopConditions, simulate_sampled
from mafsil.one_joint.rows import RowAnswer, above_zero, finite, row, share, together
from mafsil.one_joint.tolerances import ROUNDOFF

TAIL = 0.05
"""Share of the record at whose end the steady error is looked for."""
SEEN_AT_REST = 0.15
"""Share of the record at whose end an error has to keep within the band about its own mean, or it has not been seen to
come to rest: of an exponential that is cut off there the settling time is at most a quarter too short."""


class MeasureStatus(Status):
    """Whether the record shows the response to its end."""

    SETTLED = ("one_joint.settled", True)
    NOT_SETTLED = ("one_joint.not_settled", False)
    NO_STEP = ("one_joint.no_step", False)
    STILL_MOVING = ("one_joint.still_moving", False)


@dataclass(frozen=True, eq=False, repr=False)
class ResponseMeasures(RowAnswer):
    """Measures of a response; true if it settled within the record.

    Attributes:
        verdict: (*batch) which of `statuses`.
        steady_error: (*batch) given, or the mean of the last twentieth of the record.
        overshoot: (*batch) max(0, -(e - e_ss) / (e(0) - e_ss)): share of the step; NaN without a step, and where no
            steady error is given and the record ends before the error has come to rest.
        peak_time: (*batch) of that largest excursion [s]; NaN without overshoot.
        rise_time: (*batch) from 90 % to 10 % of the step [s]; NaN if not reached.
        settling_time: (*batch) after which the error stays within the band [s], between samples by a straight line; NaN
            if it does not settle within the record.
        rms: (*batch) root of the mean squared error.
        integral_absolute: (*batch) integral of |e| [s].
    """

    statuses: ClassVar[tuple[Status, ...]] = tuple(MeasureStatus)
    verdict: NDArray[np.int8]
    steady_error: Floats
    overshoot: Floats
    peak_time: Floats
    rise_time: Floats
    settling_time: Floats
    rms: Floats
    integral_absolute: Floats


def measure_response(
    t: ArrayLike, error: ArrayLike, steady_error: ArrayLike | None = None, band: float = 0.02
) -> ResponseMeasures:
    """Measures of recorded errors, for steps to either side.

    Args:
        t: (k,) rising [s].
        error: (*batch, k).
        steady_error: (*batch) from a model; None takes the mean of the last twentieth of the record, if the error keeps
            within the band about it over the last 15 %.
        band: share of the step, 0.02 for 2 %.

    Raises:
        InputError: wrong shapes, times that do not rise, not finite.
    """
    time, e = row("t", t, 2), row("error", error, 2)
    if time.ndim != 1 or e.shape[-1] != len(time):
        raise InputError("input.shape", name="error", expected=f"(*batch, {len(time)})", got=e.shape, hint="")
    if (np.diff(time) <= 0.0).any():
        raise InputError("one_joint.times")
    part = float(share("band", band))
    last = max(1, round(TAIL * len(time)))
    rest = e[..., -last:].mean(axis=-1) if steady_error is None else finite("steady_error", steady_error)
    _, rest = together(error=e[..., 0], steady_error=rest)
    if rest.shape != e.shape[:-1]:
        raise InputError("input.shape", name="steady_error", expected=e.shape[:-1], got=rest.shape, hint="")
    step = e[..., 0] - rest
    stepped = np.abs(step) > ROUNDOFF * np.abs(e).max(axis=-1)
    y = (e - rest[..., None]) / np.where(stepped, step, 1.0)[..., None]
    overshoot = np.maximum(-y.min(axis=-1), 0.0)
    peak = np.where(overshoot > 0.0, time[np.argmin(y, axis=-1)], np.nan)
    settling, settled = _settling(time, np.abs(y), part)
    rise = _first_below(time, y, 0.1) - _first_below(time, y, 0.9)
    known = np.full(settled.shape, fill_value=True)
    if steady_error is None:
        known = (np.abs(y[..., -max(1, round(SEEN_AT_REST * len(time))) :]) <= part).all(axis=-1)
    verdict = np.where(~stepped, 2, np.where(~known, 3, np.where(settled, 0, 1))).astype(np.int8)
    nan = np.where(stepped & known, 0.0, np.nan)
    duration = time[-1] - time[0]
    return ResponseMeasures(
        verdict, rest.copy(), overshoot + nan, peak + nan, rise + nan, np.where(settled, settling, np.nan) + nan,
        np.sqrt(np.trapezoid(e * e, time) / duration), np.asarray(np.trapezoid(np.abs(e), time)),
    )  # fmt: skip


def _settling(t: Floats, size: Floats, band: float) -> tuple[Floats, NDArray[np.bool_]]:
    """The last entry into the band, by a straight line, and whether it stays there to the end."""
    outside = size > band
    k = size.shape[-1]
    last = k - 1 - np.argmax(outside[..., ::-1], axis=-1)
    ever = outside.any(axis=-1)
    settled = ~outside[..., -1]
    after = np.minimum(last + 1, k - 1)
    a, b = (np.take_along_axis(size, i[..., None], -1)[..., 0] for i in (last, after))
    fraction = np.where(a > b, (a - band) / np.where(a > b, a - b, 1.0), 0.0)
    when = t[last] + fraction * (t[after] - t[last])
    return np.where(ever, when, t[0]), np.asarray(settled, dtype=np.bool_)


def _first_below(t: Floats, y: Floats, level: float) -> Floats:
    """First time at or below a level, by a straight line; NaN if never."""
    below = y <= level
    k = np.maximum(np.argmax(below, axis=-1), 1)
    a, b = (np.take_along_axis(y, i[..., None], -1)[..., 0] for i in (k - 1, k))
    fraction = np.where(a > b, (a - level) / np.where(a > b, a - b, 1.0), 0.0)
    return np.where(below.any(axis=-1), t[k - 1] + fraction * (t[k] - t[k - 1]), np.nan)


PARTS = 10.0
"""Ticks within the fastest time constant of the error, the usual advice."""


class RateStatus(Status):
    """What a period of the loop is worth."""

    ENOUGH = ("one_joint.rate_enough", True)
    TOO_SLOW = ("one_joint.rate_too_slow", False)
    GROWS = ("one_joint.rate_grows", False)


@dataclass(frozen=True, eq=False, repr=False)
class RateSweep(RowAnswer):
    """A step of a sampled loop at many periods; true if all of them are fast enough.

    Attributes:
        verdict: (k,) which of `statuses`: as good as the shortest period, worse, or growing.
        period: (k,) falling [s].
        settling_time: (k,) NaN if it does not settle [s].
        overshoot: (k,) share of the step.
        rms: (k,) root of the mean squared error [rad].
        advised: (k,) the fastest time constant of the error over ten, the same for all [s].
        longest: (k,) the longest period that is fast enough, the same for all; NaN if even the shortest grows [s].
    """

    statuses: ClassVar[tuple[Status, ...]] = tuple(RateStatus)
    verdict: NDArray[np.int8]
    period: Floats
    settling_time: Floats
    overshoot: Floats
    rms: Floats
    advised: Floats
    longest: Floats


def sweep_rate(
    arm: JointArm,
    law: JointLaw,
    goal: float,
    duration: float,
    periods: ArrayLike,
    *,
    start: float = 0.0,
    conditions: LoopConditions = IDEAL,
    gain: float = 0.05,
) -> RateSweep:
    """The effect of the update rate on a step: run at each period, measured, held against the shortest one.

    Args:
        arm, law: of one row; the law is feedback or computed torque.
        goal: set point [rad].
        duration: of each run, a whole number of each period [s].
        periods: (k,) of the loop [s].
        start: position at rest [rad].
        conditions: limits, delay, sensors.
        gain: a period counts as fast enough, with all shorter ones, if its root of the mean squared error is within
            this share of that of the shortest.

    Raises:
        InputError: a number out of its range, a law that is pure feedforward, more than one row.

    Reference: Lynch and Park, Modern Robotics, sec. 11.1.
    """
    require_kind("arm", arm, "JointArm", "gravity_moment", "friction")
    require_kind("law", law, "JointLaw", "kind", "model")
    steps = np.sort(row("periods", above_zero("periods", periods)))[::-1]
    if steps.ndim != 1 or np.ndim(law.kp) or np.ndim(arm.inertia):
        raise InputError(
            "input.shape", name="periods", expected="(k,), with one arm and one law", got=steps.shape, hint=""
        )
    part = float(share("gain", gain))
    # 1. The fastest mode of the continuous loop.
    constants = law.error_dynamics(arm).time_constants
    fastest = float(constants[constants > 0.0].min(initial=np.inf))
    # 2. Runs and what they show.
    table, grows = np.full((3, len(steps)), np.nan), np.ones(len(steps), dtype=np.bool_)
    for k, h in enumerate(steps.tolist()):
        found = simulate_sampled(arm, law, goal, duration, period=h, start=start, conditions=conditions)
        if found:
            seen = measure_response(found.t, found.error)
            table[:, k] = float(seen.settling_time), float(seen.overshoot), float(seen.rms)
            late = np.abs(found.error[-max(1, len(found.t) // 10) :]).max()
            grows[k] = bool(late > np.abs(found.error[0]))
    # 3. From the shortest period upwards, as long as nothing is lost.
    rms = table[2]
    enough = ~grows & (np.abs(rms - rms[-1]) <= part * rms[-1])
    enough = np.logical_and.accumulate(enough[::-1])[::-1]
    verdict = np.where(grows, 2, np.where(enough, 0, 1)).astype(np.int8)
    longest = float(steps[enough].max(initial=-np.inf))
    return RateSweep(
        verdict, steps.copy(), table[0], table[1], rms, np.full(len(steps), fastest / PARTS),
        np.full(len(steps), longest if np.isfinite(longest) else np.nan),
    )  # fmt: skip
