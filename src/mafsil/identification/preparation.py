"""Logs made ready for fitting: opened, checked against the robot, smoothed.

Logs in CSV files: named columns in any order, and a complaint that names the line.
"""

from __future__ import annotations

from os import PathLike

import numpy as np

from mafsil.arrays import positive
from mafsil.csv_table import CsvTable, read_csv_table
from mafsil.identification.log import MotionLog, log_of
from mafsil.identification.remark import Remark
from mafsil.identification.smoothing import SmoothMotion, band_of, filter_samples, half_window, kernels, smooth_motions
from mafsil.identification.tolerances import NO_EFFORT, PART_OF_BAND
from mafsil.model.loading import RobotLike
from mafsil.robot import Robot, as_robot

SIGNALS = ("q", "tau", "qd", "qdd")
"""What a log may hold of every joint; the first two it must."""
Log = MotionLog | str | PathLike[str]
"""A log, or the file that holds it. Recordings of simulations count as logs too."""
SAME_RATES = 0.05
"""By how much measured rates may differ from the derivative of the positions before they are ignored."""


def opened(log: Log, robot: Robot, degrees: bool) -> MotionLog:
    """A log of this robot, read from its file if it is one."""
    if isinstance(log, str | PathLike):
        return read_log(log, robot, degrees=degrees)
    return log_of(log, robot.n)


def prepare_log(log: MotionLog, bandwidth: float | None) -> tuple[list[SmoothMotion], float, list[Remark]]:
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
    derived, measured = filter_samples(signals["q"], rate), filter_samples(signals["qd"], position)
    size = np.sqrt((derived**2).mean(axis=0))
    moving = size > PART_OF_BAND * max(float(size.max()), NO_EFFORT)
    return float((np.sqrt(((derived - measured) ** 2).mean(axis=0))[moving] / size[moving]).max(initial=0.0))


def read_log(path: str | PathLike[str], robot: RobotLike, *, degrees: bool = False) -> MotionLog:
    """A log from a CSV file with a heading line; columns in any order, others are passed over.

    `t` [s]; for every joint `q[NAME]` [rad | m] and `tau[NAME]` [N m | N], and if recorded `qd[NAME]` and `qdd[NAME]`.
    Instead of names, joints may be numbered from 1 in the robot's order: `q1`, `q_1` or `q[1]`.

    Args:
        path: of the file; comma, semicolon or tab between columns.
        robot: whose joints they are.
        degrees: whether revolute joints are in degrees, their rates and accelerations too.

    Raises:
        FileError: no such file, missing columns, a cell that is no number, times that do not increase; the line is
            named.
    """
    arm = as_robot(robot)
    recorded = read_csv_table(path)
    places = _places(recorded, arm)
    needed = sorted({k for group in places.values() for k in group})
    where = {column: k for k, column in enumerate(needed)}
    values = recorded.numbers(needed)
    arrays = {name: values[:, [where[k] for k in group]] for name, group in places.items()}
    if degrees:
        revolute = arm.mechanism.angular
        for name in ("q", "qd", "qdd"):
            if name in arrays:
                arrays[name] = np.where(revolute, np.radians(arrays[name]), arrays[name])
    times = arrays.pop("t")[:, 0]
    recorded.require_increasing(times)
    return MotionLog(t=times, source=recorded.file, lines=np.array(recorded.lines, dtype=np.int64), **arrays)


def _places(recorded: CsvTable, robot: Robot) -> dict[str, list[int]]:
    """Columns of time and of every signal, joints in the robot's order."""
    places = {"t": [recorded.time_column()]}
    for signal in SIGNALS:
        found = recorded.joint_columns(signal, robot.joint_names, required=signal in SIGNALS[:2])
        if found is not None:
            places[signal] = found
    return places
