"""Sensors of a joint and of a tip: what of the truth arrives after bandwidth, bias, noise and quantisation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, positive, whole
from mafsil.messages import say
from mafsil.one_joint.arguments import above_zero, row

TURN = 2.0 * np.pi


@dataclass(frozen=True, slots=True)
class SensorKind:
    """A kind of sensor with typical figures, for a first choice; `dataclasses.replace` puts in those of a data sheet.

    Attributes:
        name: in code.
        measures: position, velocity, torque, force or acceleration; around the arm a place, a distance or a pressure.
        quantum: step of its reading; 0 if it has none. In SI units, as all that follows.
        noise: standard deviation of a reading.
        bias: constant error.
        bandwidth: of a lag of first order; infinite if it has none [rad/s].
    """

    name: str
    measures: str
    quantum: float = 0.0
    noise: float = 0.0
    bias: float = 0.0
    bandwidth: float = np.inf

    def read(self, truth: ArrayLike, period: float, *, seed: int = 0) -> Floats:
        """Readings (*batch, k) of a quantity sampled once every period; the same for the same seed.

        A lag of first order, exact for a truth that is constant within each period; then bias, noise, and rounding to
        the nearest quantum. At the start the lag is at rest.

        Args:
            truth: (*batch, k) in SI units.
            period: [s].
            seed: of the noise.

        Raises:
            InputError: not finite, no samples, a period that is not positive.
        """
        true, step = row("truth", truth), positive("period", period)
        readings = true.copy()
        if np.isfinite(self.bandwidth):
            kept = np.exp(-self.bandwidth * step)
            for k in range(1, true.shape[-1]):
                readings[..., k] = kept * readings[..., k - 1] + (1.0 - kept) * true[..., k - 1]
        rng = np.random.default_rng(whole("seed", seed))
        readings = readings + self.bias + self.noise * rng.standard_normal(readings.shape)
        return readings if not self.quantum else self.quantum * np.round(readings / self.quantum)

    def rate_noise(self, period: ArrayLike) -> Floats:
        """Standard deviation (*batch) of the rate that differencing two readings gives, sqrt(2 s^2 + Q^2/6) / T.

        Rounding counts as noise of variance Q^2/12, as it is for a truth that passes many quanta.

        Args:
            period: T (*batch) [s].
        """
        return np.sqrt(2.0 * self.noise**2 + self.quantum**2 / 6.0) / above_zero("period", period)

    def explain(self, language: str | None = None) -> str:
        """What it is used for, in a sentence."""
        return say(f"one_joint.sensor_{self.name}", language=language)


SENSORS = (
    SensorKind("potentiometer", "position", noise=2e-3, bias=5e-3),
    SensorKind("encoder", "position", quantum=TURN / 8192),
    SensorKind("resolver", "position", quantum=TURN / 65536, noise=1e-4, bandwidth=6000.0),
    SensorKind("tachometer", "velocity", noise=0.02, bias=0.01, bandwidth=600.0),
    SensorKind("strain_gauge", "torque", noise=0.05, bias=0.2, bandwidth=3000.0),
    SensorKind("joint_torque_sensor", "torque", quantum=0.02, noise=0.03, bias=0.1, bandwidth=6000.0),
    SensorKind("wrist_force_torque_sensor", "force", quantum=0.01, noise=0.05, bias=0.5, bandwidth=3000.0),
    SensorKind("accelerometer", "acceleration", quantum=2e-3, noise=0.02, bias=0.05, bandwidth=1500.0),
    SensorKind("camera", "place", quantum=5e-4, noise=5e-4, bias=1e-3, bandwidth=60.0),
    SensorKind("laser_scanner", "distance", quantum=1e-4, noise=2e-4, bias=2e-4, bandwidth=600.0),
    SensorKind("sonar", "distance", quantum=1e-3, noise=3e-3, bias=5e-3, bandwidth=60.0),
    SensorKind("tactile_array", "pressure", quantum=500.0, noise=300.0, bias=1000.0, bandwidth=300.0),
)
"""Kinds of sensors, with usual figures of makers' catalogues."""
