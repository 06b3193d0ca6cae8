"""How fast need a loop be? The same run at many periods, and from which one on more ticks gain nothing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Floats, require_kind
from mafsil.errors import InputError
from mafsil.one_joint.arguments import above_zero, row, share
from mafsil.one_joint.joint_arm import JointArm
from mafsil.one_joint.joint_law import JointLaw
from mafsil.one_joint.joint_run import IDEAL, LoopConditions, simulate_sampled
from mafsil.one_joint.response_measures import measure_response
from mafsil.one_joint.row_answer import RowAnswer

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
