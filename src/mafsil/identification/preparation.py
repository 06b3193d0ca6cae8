"""Logs made ready for fitting: opened, checked against the robot, smoothed."""

from __future__ import annotations

from os import PathLike

import numpy as np

from mafsil.arrays import positive
from mafsil.identification.log import MotionLog, log_of
from mafsil.identification.log_file import read_log
from mafsil.identification.remark import Remark
from mafsil.identification.smoothing import SmoothMotion, band_of, filtered, half_window, kernels, smooth_motions
from mafsil.identification.tolerances import NO_EFFORT, PART_OF_BAND
from mafsil.robot import Robot

Log = MotionLog | str | PathLike[str]
"""A log, or the file that holds it. Recordings of simulations count as logs too."""
SAME_RATES = 0.05
"""By how much measured rates may differ from the derivative of the positions before they are ignored."""


def opened(log: Log, robot: Robot, degrees: bool) -> MotionLog:
    """A log of this robot, read from its file if it is one."""
    if isinstance(log, str | PathLike):
        return read_log(log, robot, degrees=degrees)
    return log_of(log, robot.n)


def prepared(log: MotionLog, bandwidth: float | None) -> tuple[list[SmoothMotion], float, list[Remark]]:
    """Smooth motions of a log, their band [Hz], and what was ignored."""
    band = band_of(log) if bandwidth is None else positive("bandwidth", bandwidth)
    remarks: list[Remark] = []
    if log.qd is not None:
        worst = _rate_mismatch(log, band)
        if worst > SAME_RATES:
            remarks.append(Remark("identification.rates_ignored", {"percent": 100 * worst}))
            log = log.without_rates()
    return smooth_motions(log, band), band, remarks


def _rate_mismatch(log: MotionLog, band: float) -> float:
    """How far measured rates are from the derivative of the positions, as a share, in the worst joint."""
    segment = max(log.segments(), key=lambda part: part.duration)
    period, signals = segment.even()
    half = half_window(band, period, len(signals["q"]))
    if len(signals["q"]) < 2 * half + 2:
        return 0.0
    position, rate, _ = kernels(half, period)
    derived, measured = filtered(signals["q"], rate), filtered(signals["qd"], position)
    size = np.sqrt((derived**2).mean(axis=0))
    moving = size > PART_OF_BAND * max(float(size.max()), NO_EFFORT)
    return float((np.sqrt(((derived - measured) ** 2).mean(axis=0))[moving] / size[moving]).max(initial=0.0))
