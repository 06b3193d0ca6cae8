"""A jerk-limited motion that is asked for its next state in every cycle, and planned anew when its goal changes."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, positive, real_array, require_finite
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.trajectory.jerk.problem import (
    MODES,
    STATUSES,
    JerkStatus,
    Problem,
    Synchronise,
    packed_limits,
    problem_of,
    require_finite_states,
    sentence,
)
from mafsil.trajectory.motion_limits import Limits

if TYPE_CHECKING:
    import mafsil.trajectory.jerk.online_loops as online_loops
else:
    online_loops = lazily("mafsil.trajectory.jerk.online_loops")

MOST_PIECES = 15
ELAPSED, DURATION, CYCLE, PLANS, FREE, STATUS, RULING = range(7)
"""Places of the clock's numbers, as in `online_loops`."""


class Online:
    """The state of a motion, one step of it for each cycle; `online` makes it.

    Attributes:
        position, velocity, acceleration: (n,) the present state. Written by `step`; whoever writes other numbers into
            them (a measured state) gets a plan from there in the next step.
        limits: (n, 6) lower and upper velocity, acceleration and jerk.
        worst_time: longest time that a step has taken so far, planning included [s].
    """

    def __init__(self, states: Floats, limits: Floats, cycle: float, mode: int) -> None:
        n = len(limits)
        self.limits = limits
        self.worst_time = 0.0
        self._now = np.ascontiguousarray(states[:, :3])
        self.position, self.velocity, self.acceleration = self._now.T
        self._asked = np.zeros((n, 2))
        self._goal, self._goal_velocity = self._asked.T
        self._goal[:] = self.position
        self._mode = mode
        self._clock = np.zeros(7)
        self._clock[CYCLE] = cycle
        self._last = self._now.copy()
        self._states = np.zeros((2, n, 6))
        self._scratch = np.zeros((6, 7))
        self._count = np.zeros((2, n))
        self._pieces = np.zeros((2, 2, n, MOST_PIECES))
        self._states[0, :, :3] = self._now
        self._states[1] = np.nan

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return len(self._now)

    @property
    def cycle(self) -> float:
        """Time between two steps [s]."""
        return float(self._clock[CYCLE])

    @property
    def remaining(self) -> float:
        """Time until the goal is reached [s]; zero when it has been."""
        return max(float(self._clock[DURATION] - self._clock[ELAPSED]), 0.0)

    @property
    def plans(self) -> int:
        """How often a motion was planned so far."""
        return int(self._clock[PLANS])

    def step(self, goal: Floats, goal_velocity: Floats | float = 0.0) -> JerkStatus:
        """Move on by one cycle towards a goal; arrived there with a velocity, the motion goes on with it.

        Nothing is allocated when the arguments are float64 arrays.

        Args:
            goal: (n,) position [rad | m].
            goal_velocity: (n,) or one number [rad/s | m/s].

        Returns:
            Whether the goal can be reached; if not, the motion planned before goes on, and `explain()` says why.

        Raises:
            InputError: a wrong shape, or a number that is not finite.
        """
        begun = perf_counter()
        self._goal[:] = goal if type(goal) is np.ndarray and goal.shape == self._goal.shape else self._row("goal", goal)
        self._set_velocity(goal_velocity)
        return self._step(False, begun)

    def step_velocity(self, goal_velocity: Floats | float) -> JerkStatus:
        """Move on by one cycle towards a steady velocity, wherever that is reached.

        Args:
            goal_velocity: (n,) or one number [rad/s | m/s].

        Returns:
            As `step`.

        Raises:
            InputError: a wrong shape, or a number that is not finite.
        """
        begun = perf_counter()
        self._goal[:] = 0.0
        self._set_velocity(goal_velocity)
        return self._step(True, begun)

    def explain(self, language: str | None = None) -> str:
        """How the last planning ended: its duration, or which coordinate cannot reach the goal and why."""
        status = STATUSES[int(self._clock[STATUS])]
        problem = Problem(self._states[1], self.limits)
        return sentence(problem, status, int(self._clock[RULING]), float(self._clock[DURATION]), language)

    def _set_velocity(self, given: Floats | float) -> None:
        if type(given) is float or (type(given) is np.ndarray and given.shape == self._goal.shape):
            self._goal_velocity[:] = given
        else:
            self._goal_velocity[:] = self._row("goal_velocity", given)

    def _row(self, name: str, value: ArrayLike) -> Floats:
        row = real_array(name, value)
        if row.shape not in ((), (self.n,)):
            raise InputError("input.shape", name=name, expected=(self.n,), got=row.shape, hint="")
        return row

    def _step(self, free: bool, begun: float) -> JerkStatus:
        code = online_loops.step(
            self._now,
            self._asked,
            free,
            self._mode,
            self._clock,
            self._last,
            self._states,
            self.limits,
            self._scratch,
            self._count,
            self._pieces,
        )
        if code < 0:
            require_finite("goal", self._goal)
            require_finite("goal_velocity", self._goal_velocity)
            require_finite("state", self._now)
        taken = perf_counter() - begun
        if taken > self.worst_time:
            self.worst_time = taken
        return STATUSES[code]


def online(
    position: ArrayLike,
    limits: Limits,
    cycle: float,
    *,
    velocity: ArrayLike = 0.0,
    acceleration: ArrayLike = 0.0,
    synchronise: Synchronise = "time",
) -> Online:
    """Online trajectory generation: the next state in every cycle, towards a goal that may change at any time.

    Args:
        position: (n,) at the start [rad | m].
        limits: of the n coordinates, as for `jerk_limited`.
        cycle: time between two steps [s].
        velocity, acceleration: (n,) or one number, at the start [rad/s, rad/s^2 | m/s, m/s^2].
        synchronise: `time`, `phase` or `none`, as for `jerk_limited`.

    Returns:
        The motion; its `step(goal)` gives the next state in `position`, `velocity` and `acceleration`.

    Raises:
        InputError: a wrong shape, a number that is not finite, a cycle that is not positive, an infinite jerk.
    """
    problem = problem_of((position, velocity, acceleration, position, 0.0, 0.0), limits, synchronise=synchronise)
    if problem.states.ndim != 2:
        raise InputError("input.shape", name="position", expected="(n,)", got=problem.states.shape[:-1], hint="")
    require_finite_states(problem.states)
    packed = packed_limits(limits, problem.states.shape[0])
    return Online(problem.states, packed, positive("cycle", cycle), MODES.index(synchronise))
