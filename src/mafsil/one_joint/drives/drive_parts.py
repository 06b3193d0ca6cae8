"""What drives a joint is made of: kinds of actuators, transmissions and brakes, and whether they suit it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Floats, positive
from mafsil.messages import say
from mafsil.one_joint.arguments import above_zero, finite, magnitude, together
from mafsil.one_joint.row_answer import RowAnswer

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
