"""Measures of a recorded response: steady error, overshoot, peak, rise and settling, NaN where it shows none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.one_joint.arguments import finite, row, share, together
from mafsil.one_joint.row_answer import RowAnswer

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
    stepped = np.abs(step) > 1e-12 * np.abs(e).max(axis=-1)
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
