"""Sentences about jerk-limited motions, with the numbers that prove them.

How planning a jerk-limited motion ended.
"""

from __future__ import annotations

from mafsil.answer import Status
from mafsil.trajectory.jerk.problem import Problem


def sentence(problem: Problem, status: JerkStatus, joint: int, duration: float, language: str | None) -> str:
    """How planning ended: the coordinate, its numbers, and what would do.

    Args:
        problem: what was asked.
        status: how it ended.
        joint: the coordinate that it is about.
        duration: [s].
        language: `en` or `ar`; the current one if None.
    """
    p0, v0, a0, pf, vf, af = problem.states.reshape(-1, *problem.states.shape[-2:])[0, joint].tolist()
    v_lo, v_hi, a_lo, a_hi, j_lo, j_hi = problem.limits[joint].tolist()
    before = vf - 0.5 * af * af / j_hi if af > 0.0 and j_hi else vf
    if af < 0.0 and j_lo:
        before = vf - 0.5 * af * af / j_lo
    details = {
        "joint": joint,
        "duration": duration,
        "distance": pf - p0,
        "velocity": vf,
        "acceleration": af,
        "start_velocity": v0,
        "start_acceleration": a0,
        "before": before,
        "velocity_lower": v_lo,
        "velocity_upper": v_hi,
        "acceleration_lower": a_lo,
        "acceleration_upper": a_hi,
        "jerk_lower": j_lo,
        "jerk_upper": j_hi,
        "minimum": problem.minimum,
        "cycle": problem.cycle,
    }
    return status.sentence(language, **details)


class JerkStatus(Status):
    """How planning a jerk-limited motion ended; in the order of the codes of `plan_loops`."""

    PLANNED = ("jerk.planned", True)
    TARGET_OUTSIDE = ("jerk.target_outside", False)
    FROZEN = ("jerk.frozen", False)
    UNREACHABLE = ("jerk.unreachable", False)
    NO_COMMON_DURATION = ("jerk.no_common_duration", False)
    BEYOND_NUMBERS = ("jerk.beyond_numbers", False)


STATUSES = tuple(JerkStatus)
