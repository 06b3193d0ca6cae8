"""What drives a joint and measures it: kinds of actuators, transmissions, brakes and sensors, and whether they suit it.

Of what a sensor measures arrives what bandwidth, bias, noise and quantisation leave.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Floats, positive, whole
from mafsil.messages import say
from mafsil.one_joint.rows import RowAnswer, above_zero, finite, magnitude, row, together

TURN = 2.0 * np.pi
RPM = 2.0 * np.pi / 60.0
"""[rad/s]"""
ARC_MINUTE = np.pi / 10800.0
"""[rad]"""


@dataclass(frozen=True, slots=True)
class ActuatorKind:
    """A kind of actuator with typical figures, for a first choice; data sheets have the real ones.

    Attributes:
        name: in code.
        linear: whether it pushes instead of turning.
        speeds: lowest and highest usual speed under load [rad/s | m/s].
        regulated: whether its force is regulated finely enough to close a position loop around it.
    """

    name: str
    linear: bool
    speeds: tuple[float, float]
    regulated: bool

    def reduction(self, joint_speed: float) -> tuple[float, float]:
        """Ratios between its lowest and highest usual speed and that of a joint: large ones mean a reduction.

        Args:
            joint_speed: highest of the joint; behind a linear actuator that of its point of attack [rad/s | m/s].
        """
        speed = positive("joint_speed", joint_speed)
        return self.speeds[0] / speed, self.speeds[1] / speed

    def explain(self, language: str | None = None) -> str:
        """What it is used for, in a sentence."""
        return say(f"one_joint.actuator_{self.name}", language=language)


ACTUATORS = (
    ActuatorKind("dc_servo", False, (2000 * RPM, 6000 * RPM), True),
    ActuatorKind("ac_servo", False, (2000 * RPM, 6000 * RPM), True),
    ActuatorKind("stepper", False, (100 * RPM, 1000 * RPM), False),
    ActuatorKind("pneumatic_cylinder", True, (0.1, 1.5), False),
    ActuatorKind("hydraulic_cylinder", True, (0.01, 0.5), True),
    ActuatorKind("combustion_engine", False, (1000 * RPM, 6000 * RPM), False),
)
"""Kinds of actuators, with the usual speeds of makers' catalogues."""


@dataclass(frozen=True, slots=True)
class TransmissionKind:
    """A kind of transmission with typical figures, for a first choice.

    Attributes:
        name: in code.
        slip: share of the motion that may get lost for good, without a sensor at the joint.
        backlash: free play at the output, as angle; of a screw, per turn of it [rad].
        efficiency: share of the power that passes a stage.
        ratio: usual highest one of a stage.
    """

    name: str
    slip: float
    backlash: float
    efficiency: float
    ratio: float

    def explain(self, language: str | None = None) -> str:
        """What it is used for, in a sentence."""
        return say(f"one_joint.transmission_{self.name}", language=language)


TRANSMISSIONS = (
    TransmissionKind("friction_belt", 0.02, 0.0, 0.95, 6.0),
    TransmissionKind("toothed_belt", 0.0, 15 * ARC_MINUTE, 0.97, 8.0),
    TransmissionKind("chain", 0.0, 60 * ARC_MINUTE, 0.97, 6.0),
    TransmissionKind("spur_gear", 0.0, 20 * ARC_MINUTE, 0.97, 6.0),
    TransmissionKind("low_backlash_gear", 0.0, 3 * ARC_MINUTE, 0.95, 10.0),
    TransmissionKind("harmonic_drive", 0.0, 0.5 * ARC_MINUTE, 0.75, 160.0),
    TransmissionKind("ball_screw", 0.0, 0.5 * ARC_MINUTE, 0.9, 1.0),
)
"""Kinds of transmissions, with usual figures of makers' catalogues."""


class TransmissionStatus(Status):
    """Whether a transmission is precise enough."""

    PRECISE = ("one_joint.precise", True)
    SLIPS = ("one_joint.slips", False)
    TOO_MUCH_PLAY = ("one_joint.too_much_play", False)


@dataclass(frozen=True, eq=False, repr=False)
class TransmissionAnswer(RowAnswer):
    """Whether transmissions suit a joint; true if all do.

    Attributes:
        verdict: (*batch) which of `statuses`.
        play: (*batch) free motion of the tip from backlash, reach times backlash [m].
        lost: (*batch) what slip loses of a motion of the joint through one radian, at the tip [m].
        allowed: (*batch) [m].
    """

    statuses: ClassVar[tuple[Status, ...]] = tuple(TransmissionStatus)
    verdict: NDArray[np.int8]
    play: Floats
    lost: Floats
    allowed: Floats


def transmission_suits(
    backlash: ArrayLike, reach: ArrayLike, repeatability: ArrayLike, *, slip: ArrayLike = 0.0
) -> TransmissionAnswer:
    """Whether play and slip of a joint's transmission leave the tip within its repeatability.

    Args:
        backlash: at the joint (*batch) [rad].
        reach: distance of the tip from the joint's axis (*batch) [m].
        repeatability: allowed error of the tip (*batch) [m].
        slip: share of the motion that gets lost (*batch).

    Raises:
        InputError: a number out of its range, shapes that do not go together.
    """
    play, lever, allowed, share = together(
        backlash=magnitude("backlash", backlash), reach=above_zero("reach", reach),
        repeatability=above_zero("repeatability", repeatability), slip=magnitude("slip", slip),
    )  # fmt: skip
    free, lost = play * lever, share * lever
    verdict = np.where(lost > allowed, 1, np.where(free > allowed, 2, 0)).astype(np.int8)
    return TransmissionAnswer(verdict, free, lost, allowed)


class BrakeStatus(Status):
    """Whether a brake holds, and stops a joint."""

    HOLDS = ("one_joint.brake_holds", True)
    GIVES_WAY = ("one_joint.brake_gives_way", False)


@dataclass(frozen=True, eq=False, repr=False)
class Braking(RowAnswer):
    """Braking of a moving joint under a constant load; true if the brake holds it, in every row.

    Attributes:
        verdict: (*batch) which of `statuses`.
        time: (*batch) from the command until it stands; infinite where the load is stronger [s].
        angle: (*batch) moved through meanwhile [rad].
        heat: (*batch) that the brake takes up [J].
        margin: (*batch) its torque over the load; infinite without load.
    """

    statuses: ClassVar[tuple[Status, ...]] = tuple(BrakeStatus)
    verdict: NDArray[np.int8]
    time: Floats
    angle: Floats
    heat: Floats
    margin: Floats


def brake(
    torque: ArrayLike, inertia: ArrayLike, speed: ArrayLike = 0.0, load: ArrayLike = 0.0, delay: ArrayLike = 0.0
) -> Braking:
    """How a brake stops a joint, and whether it holds it afterwards.

    Until it grips, the load accelerates the joint; then M w' = load - torque sign(w): times and angles in closed form.

    Args:
        torque: of the brake at the joint (*batch) [N m].
        inertia: M that moves (*batch) [kg m^2].
        speed: when the command comes (*batch) [rad/s].
        load: torque that acts on, such as gravity at its worst; positive in the joint's sense (*batch) [N m].
        delay: until it grips (*batch) [s].

    Raises:
        InputError: a number out of its range, shapes that do not go together.
    """
    tau, M, w, pull, wait = together(
        torque=above_zero("torque", torque), inertia=above_zero("inertia", inertia), speed=finite("speed", speed),
        load=finite("load", load), delay=magnitude("delay", delay),
    )  # fmt: skip
    grip = w + pull / M * wait
    before = w * wait + pull / M * wait**2 / 2.0
    stands = np.abs(pull) < tau
    # The brake acts against the motion, the load with it or against it.
    slowing = np.where(stands, tau - pull * np.sign(grip), 1.0) / M
    after = grip * np.abs(grip) / (2.0 * slowing)
    with np.errstate(divide="ignore"):
        margin = tau / np.abs(pull)
    return Braking(
        np.where(stands, 0, 1).astype(np.int8),
        np.where(stands, wait + np.abs(grip) / slowing, np.inf),
        np.where(stands, before + after, np.copysign(np.inf, pull)),
        np.where(stands, tau * np.abs(after), np.inf),
        margin,
    )


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
