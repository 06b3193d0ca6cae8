"""The border of jerk-limited motions: what users give, as one array of states and one of limits.

Sentences about jerk-limited motions, with the numbers that prove them.

How planning a jerk-limited motion ended.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Status
from mafsil.arrays import Floats, real_array, require_finite
from mafsil.errors import InputError
from mafsil.trajectory.motion_limits import Limits, motion_limits

Synchronise = Literal["time", "phase", "none"]
MODES: tuple[Synchronise, ...] = ("time", "phase", "none")
"""In the order of the codes of `plan_loops`."""
NAMES = ("start", "start_velocity", "start_acceleration", "goal", "goal_velocity", "goal_acceleration")
"""Columns of the states."""


class Problem(NamedTuple):
    """From states to states within limits.

    Attributes:
        states: (*batch, n, 6) position, velocity and acceleration at the start and at the goal.
        limits: (n, 6) lower and upper velocity, acceleration and jerk.
        free: whether the position at the goal does not matter.
        mode: index into MODES.
        minimum, cycle: least duration, and what durations are multiples of [s]; zero for neither.
    """

    states: Floats
    limits: Floats
    free: bool = False
    mode: int = 0
    minimum: float = 0.0
    cycle: float = 0.0


def problem_of(
    given: tuple[ArrayLike, ...],
    limits: Limits,
    *,
    free: bool = False,
    synchronise: str = "time",
    minimum: float = 0.0,
    cycle: float = 0.0,
) -> Problem:
    """The problem, its arguments checked.

    Args:
        given: the six of NAMES, (*batch, n) or one number each.
        limits: of the n coordinates.
        free, minimum, cycle: as the attributes of `Problem`.
        synchronise: one of MODES.

    Raises:
        InputError: a wrong shape, a number that is not finite, an infinite jerk, a time that is negative, a choice that
            is none, or a moving goal of coordinates that do not arrive together.
    """
    states = _states(given)
    if synchronise == "time" and minimum == 0.0 == cycle:
        return Problem(states, packed_limits(limits, states.shape[-2]), free)
    if synchronise not in MODES:
        raise InputError("input.choice", name="synchronise", value=synchronise, known=", ".join(MODES))
    if synchronise == "none" and (states[..., 5].any() or (not free and states[..., 4].any())):
        raise InputError("jerk.moving_apart")
    times = {"minimum_duration": minimum, "cycle": cycle}
    for name, value in times.items():
        if not 0.0 <= value < np.inf:
            raise InputError("input.range", name=name, value=value, low=0.0, high=np.inf)
    packed = packed_limits(limits, states.shape[-2])
    return Problem(states, packed, free, MODES.index(synchronise), float(minimum), float(cycle))


def packed_limits(limits: Limits, n: int) -> Floats:
    """(n, 6) lower and upper velocity, acceleration and jerk.

    Raises:
        InputError: limits of another number of coordinates, or no finite jerk.
    """
    global _last_packed
    known, packed = _last_packed
    if known is limits and len(packed) == n:
        return packed
    bounds = motion_limits(limits, n)
    packed = np.empty((n, 6))
    packed[:, 0:2], packed[:, 2:4], packed[:, 4:6] = bounds.velocity.T, bounds.acceleration.T, bounds.jerk.T
    packed += 0.0  # no negative zeros
    if not np.isfinite(packed[:, 4:]).all():
        unbounded = np.flatnonzero(~np.isfinite(packed[:, 4:]).all(axis=1))
        raise InputError("jerk.unbounded_jerk", index=int(unbounded[0]))
    if bounds is limits and not any(x.flags.writeable for x in (bounds.velocity, bounds.acceleration, bounds.jerk)):
        _last_packed = limits, packed
    return packed


_last_packed: tuple[object, Floats] = (None, np.empty((0, 6)))
"""The limits of the last problem, and what they are packed: programs ask many problems of the same limits."""


def as_rows(given: tuple[ArrayLike, ...]) -> list[Floats] | None:
    """Six rows (n,) of a single problem as programs give it, in which zero stands for zeros; None of any other."""
    start = given[0]
    if type(start) is not np.ndarray or start.ndim != 1 or not len(start):
        return None
    shape, rows = start.shape, list[Floats]()
    for value in given:
        if type(value) is np.ndarray and value.shape == shape and value.dtype == np.float64:
            # Loops are compiled anew for arrays that are not contiguous, or may not be written.
            rows.append(value if value.flags.carray else value.copy())
        elif type(value) is float and value == 0.0:
            rows.append(_zeros(shape))
        else:
            return None
    return rows


@lru_cache(maxsize=64)
def _zeros(shape: tuple[int, ...]) -> Floats:
    return np.zeros(shape)


def _states(given: tuple[ArrayLike, ...]) -> Floats:
    """(*batch, n, 6) of six arguments that fit each other; of a single problem NaN is found by the planner."""
    ready = as_rows(given)
    if ready is not None:
        return np.stack(ready, axis=-1)
    arrays = [real_array(name, value) for name, value in zip(NAMES, given, strict=True)]
    shape = max((array.shape for array in arrays), key=len)
    shape = shape if shape else (1,)
    try:
        shape = np.broadcast_shapes(shape, *(array.shape for array in arrays))
    except ValueError:
        name, array = next((n, a) for n, a in zip(NAMES, arrays, strict=True) if not _fits(a.shape, shape))
        raise InputError("input.shape", name=name, expected=shape, got=array.shape, hint="") from None
    if shape[-1] == 0:
        raise InputError("input.shape", name="start", expected="(*batch, n)", got=shape, hint="")
    states = np.empty((*shape, 6))
    for k, array in enumerate(arrays):
        states[..., k] = array
    require_finite_states(states)
    return states


def require_finite_states(states: Floats) -> None:
    """Nothing, if all numbers are finite.

    Raises:
        InputError: names the argument and the index of the first that is not.
    """
    if not np.isfinite(states).all():
        for k, name in enumerate(NAMES):
            require_finite(name, states[..., k])


def _fits(got: tuple[int, ...], shape: tuple[int, ...]) -> bool:
    return all(a in (1, b) for a, b in zip(got[::-1], shape[::-1], strict=False))


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
