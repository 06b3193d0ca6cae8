"""Motion from noisy positions: local polynomials give position, rate and acceleration without any delay.

A kernel is the weighted least-squares fit of a polynomial to the samples around each instant; it is symmetric, so it
has zero phase, and half a window is lost at both ends. Efforts and everything that is compared with them go through the
same kernel, so that what the kernel takes away is taken from both sides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats
from mafsil.identification.log import MotionLog
from mafsil.identification.tolerances import LEAST_SHARE

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
