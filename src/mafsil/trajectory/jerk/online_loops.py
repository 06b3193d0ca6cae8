"""One cycle of a motion that is planned anew whenever its goal changes; nothing is allocated."""

from __future__ import annotations

from math import isfinite

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled
from mafsil.trajectory.jerk.plan_loops import PLANNED, plan
from mafsil.trajectory.jerk.sample_loops import advance

ELAPSED, DURATION, CYCLE, PLANS, FREE, STATUS, RULING = range(7)
"""Places of the clock's numbers."""


@compiled
def step(
    now: Floats,
    asked: Floats,
    free: bool,
    mode: int,
    clock: Floats,
    last: Floats,
    states: Floats,
    limits: Floats,
    scratch: Floats,
    count: Floats,
    pieces: Floats,
) -> int:
    """Move on by one cycle.

    1. Numbers that are not finite: nothing is done.
    2. A new goal, or a state that is not what the plan made of it, asks for a new plan.
    3. The state after one cycle; after its end the motion goes on with the goal's velocity.

    Args:
        now: (n, 3) position, velocity and acceleration; the next ones are written here.
        asked: (n, 2) position and velocity of the goal.
        free: whether the goal's position does not matter.
        mode: synchronisation, as in `plan`.
        clock: (7,) time since the plan, its duration, the cycle, number of plans, whether the plan's goal has no
            position, how the last planning ended and which coordinate that is due to.
        last: (n, 3) what `now` was when the last cycle ended.
        states: (2, n, 6) the problem of the present plan, and one to try.
        limits: (n, 6).
        scratch: (6, 7) to work in.
        count: (2, n) numbers of pieces, of the present plan and of one to try.
        pieces: (2, 2, n, 15) their durations and jerks.

    Returns:
        How planning ended; after a refusal the present plan goes on. -1 if a number is not finite: nothing is done.
    """
    # 1.
    n = len(now)
    for i in range(n):
        if not isfinite(asked[i, 0] + asked[i, 1] + now[i, 0] + now[i, 1] + now[i, 2]):
            return -1
    # 2.
    changed = clock[PLANS] == 0.0 or (clock[FREE] != 0.0) != free
    for i in range(n):
        changed |= asked[i, 1] != states[1, i, 4] or (not free and asked[i, 0] != states[1, i, 3])
        changed |= now[i, 0] != last[i, 0] or now[i, 1] != last[i, 1] or now[i, 2] != last[i, 2]
    if changed:
        _replan(now, asked, free, mode, clock, states, limits, scratch, count, pieces)
    # 3.
    clock[ELAPSED] += clock[CYCLE]
    for i in range(n):
        now[i, 0], now[i, 1], now[i, 2] = _state_at(states[0, i], count[0, i], pieces[0, :, i], clock[ELAPSED])
        last[i, 0], last[i, 1], last[i, 2] = now[i, 0], now[i, 1], now[i, 2]
    return int(clock[STATUS])


@compiled
def _replan(
    now: Floats,
    asked: Floats,
    free: bool,
    mode: int,
    clock: Floats,
    states: Floats,
    limits: Floats,
    scratch: Floats,
    count: Floats,
    pieces: Floats,
) -> None:
    """Try a plan from the present state, and take it if there is one; without any, rest where the state is."""
    n = len(now)
    for i in range(n):
        states[1, i, 0], states[1, i, 1], states[1, i, 2] = now[i, 0], now[i, 1], now[i, 2]
        states[1, i, 3], states[1, i, 4], states[1, i, 5] = asked[i, 0], asked[i, 1], 0.0
    status, ruling, _, duration = plan(
        states[1], limits, free, mode, 0.0, 0.0, scratch, count[1], pieces[1, 0], pieces[1, 1]
    )
    clock[STATUS], clock[RULING] = status, ruling
    if status == PLANNED:
        clock[ELAPSED], clock[DURATION], clock[FREE] = 0.0, duration, 1.0 if free else 0.0
        clock[PLANS] += 1.0
        states[0], count[0], pieces[0] = states[1], count[1], pieces[1]


@compiled
def _state_at(x: Floats, count: float, pieces: Floats, t: float) -> tuple[float, float, float]:
    """A coordinate's state at a time of its plan."""
    p, v, a = x[0], x[1], x[2]
    for k in range(int(count)):
        if t < pieces[0, k]:
            return advance(p, v, a, pieces[1, k], t)
        p, v, a = advance(p, v, a, pieces[1, k], pieces[0, k])
        t -= pieces[0, k]
    return p + t * v, v, a
