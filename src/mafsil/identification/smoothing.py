"""Motion from noisy positions: local polynomials give position, rate and acceleration without any delay.

A kernel is the weighted least-squares fit of a polynomial to the samples around each instant; it is symmetric, so it
has zero phase, and half a window is lost at both ends. Efforts and everything that is compared with them go through the
same kernel, so that what the kernel takes away is taken from both sides.

Logs made ready for fitting: opened, checked against the robot, smoothed.

Logs in CSV files: named columns in any order, and a complaint that names the line.
"""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike

import numpy as np

from mafsil.arrays import Floats, positive
from mafsil.csv_table import CsvTable, read_csv_table
from mafsil.identification.log import MotionLog, Remark, log_of
from mafsil.identification.tolerances import LEAST_SHARE, NO_EFFORT, PART_OF_BAND
from mafsil.model.loading import RobotLike
from mafsil.robot import Robot, as_robot

ORDER = 5
"""Degree of the local polynomials."""
FLATNESS = 3e-4
"""By how much the kernels may miss rate and acceleration at the highest frequency of the motion, as a share."""
POWER = 0.999
"""Share of the power of the accelerations that lies below the band's end."""


@dataclass(frozen=True, eq=False, slots=True)
class SmoothMotion:
    """A motion on an even grid, measured efforts beside it.

    Attributes:
        period: sampling period [s].
        q, qd, qdd: (N, n) motion [rad | m] and time derivatives.
        tau: (N, n) efforts as measured [N m | N].
        half: half the window of the kernel for efforts, in samples.
    """

    period: float
    q: Floats
    qd: Floats
    qdd: Floats
    tau: Floats
    half: int


def kernels(half: int, period: float) -> Floats:
    """(3, 2 half + 1) weights for position, rate and acceleration: value = sum of weights times samples around it.

    Args:
        half: samples on either side, at least (ORDER + 1) / 2.
        period: sampling period [s].

    Reference: Savitzky & Golay 1964; weights (1 - u^2)^3 as in local regression.
    """
    u = np.arange(-half, half + 1) / half
    weight = np.sqrt((1.0 - (u * half / (half + 1)) ** 2) ** 3)
    powers = u[:, None] ** np.arange(ORDER + 1)
    fit = np.linalg.pinv(weight[:, None] * powers) * weight
    length = half * period
    return np.stack([fit[0], fit[1] / length, 2.0 * fit[2] / length**2])


def response(weights: Floats, period: float, frequency: float) -> Floats:
    """(3,) what the kernels make of a sine [Hz], against its true position, rate and acceleration."""
    w = 2.0 * np.pi * frequency
    half = weights.shape[1] // 2
    samples = np.asarray(np.arange(-half, half + 1), dtype=np.float64)
    angle = w * period * samples
    position, rate, acceleration = weights
    return np.array([position @ np.cos(angle), rate @ np.sin(angle) / w, -(acceleration @ np.cos(angle)) / w**2])


def half_window(band: float, period: float, samples: int) -> int:
    """The widest half window whose kernels are flat up to `band` [Hz], none wider than a log of so many samples."""
    low = (ORDER + 1) // 2 + 1
    high = max(round(min(2.0 / (band * period), samples)), low + 1)
    while high - low > 1:
        middle = (low + high) // 2
        flat = np.abs(response(kernels(middle, period), period, band) - 1.0).max() < FLATNESS
        low, high = (middle, high) if flat else (low, middle)
    return low


def band_of(log: MotionLog) -> float:
    """Highest frequency [Hz] of the motion in a log that stands out of the noise, found in its longest segment.

    In the spectrum of the accelerations the motion falls off and the noise of the encoders rises; the band ends in the
    valley between them, or before it where nearly all power is reached.
    """
    segment = max(log.segments(), key=lambda part: part.duration)
    period, signals = segment.even()
    frequency, power = _spectrum(signals["q"], period)
    lowest, highest = 2.0 / max(segment.duration, period), 0.1 / period
    ends: list[tuple[float, float]] = []
    for p in power.T:
        valley = _valley(frequency, p)
        acceleration = np.cumsum(p[:valley] * frequency[:valley] ** 4)
        if len(acceleration) and acceleration[-1] > 0.0:
            reached = int((acceleration >= POWER * acceleration[-1]).argmax())
            ends.append((float(acceleration[-1]), float(frequency[reached])))
    most = max((total for total, _ in ends), default=0.0)
    band = max((end for total, end in ends if total > LEAST_SHARE * most), default=lowest)
    return float(min(max(band, lowest), highest))


def _spectrum(q: Floats, period: float) -> tuple[Floats, Floats]:
    """Frequencies (F,) and power (F, n) of positions, ramps taken out, ends faded."""
    count = len(q)
    edge = max(count // 100, 1)
    level, end = q[:edge].mean(axis=0), q[-edge:].mean(axis=0)
    ramp = np.linspace(0.0, 1.0, count)[:, None]
    faded = (q - level - (end - level) * ramp) * np.hanning(count)[:, None]
    frequency = np.arange(count // 2 + 1) / (count * period)
    return frequency, np.abs(np.fft.rfft(faded, axis=0)) ** 2


def _valley(frequency: Floats, power: Floats) -> int:
    """Place of the frequency at which the acceleration's power, averaged over parts of an octave, is least."""
    edges = np.unique(np.geomspace(1, len(frequency), 6 * max(int(np.log2(len(frequency))), 1)).astype(int))
    starts, sizes = edges[:-1], np.diff(edges)
    rate = np.add.reduceat(power * frequency**2, starts)[: len(sizes)] / sizes
    acceleration = np.add.reduceat(power * frequency**4, starts)[: len(sizes)] / sizes
    peak = int(rate.argmax())
    return int(edges[peak + int(acceleration[peak:].argmin()) + 1])


def smooth_motions(log: MotionLog, band: float) -> list[SmoothMotion]:
    """The segments of a log as smooth motions; those shorter than a few windows are left out.

    Measured rates and accelerations are smoothed alike and stand in the place of derivatives.

    Args:
        log: the recorded motion.
        band: highest frequency of the motion [Hz].
    """
    motions: list[SmoothMotion] = []
    for segment in log.segments():
        period, signals = segment.even()
        half = half_window(band, period, len(signals["q"]))
        if len(signals["q"]) < 4 * half + 2:
            continue
        position, rate, acceleration = kernels(half, period)
        q = filter_samples(signals["q"], position)
        qd = filter_samples(signals["qd"], position) if "qd" in signals else filter_samples(signals["q"], rate)
        if "qdd" in signals:
            qdd = filter_samples(signals["qdd"], position)
        elif "qd" in signals:
            qdd = filter_samples(signals["qd"], rate)
        else:
            qdd = filter_samples(signals["q"], acceleration)
        motions.append(SmoothMotion(period, q, qd, qdd, signals["tau"][half : len(q) + half], max(half // 2, 3)))
    return motions


def filter_samples(samples: Floats, weights: Floats) -> Floats:
    """(N - 2 half, n) the samples (N, n) under the kernel; only where its window fits."""
    count, width = len(samples), len(weights)
    size = count + width - 1
    spectrum = np.fft.rfft(samples, size, axis=0) * np.fft.rfft(weights[::-1], size)[:, None]
    return np.fft.irfft(spectrum, size, axis=0)[width - 1 : count]


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
