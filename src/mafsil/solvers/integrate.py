"""The one fixed-step stepping loop, over batches of states; methods are data (`tableaus`)."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, isfinite
from time import perf_counter
from typing import TypeAlias

import numpy as np

from mafsil.arrays import Floats
from mafsil.solvers.outcome import Outcome, SolverStatus
from mafsil.solvers.tableaus import Method, Splitting, Tableau

Field: TypeAlias = Callable[[float, Floats], Floats]
"""dy/dt = f(t, y), y (*batch, m)."""
Acceleration: TypeAlias = Callable[[float, Floats, Floats], Floats]
"""d2q/dt2 = a(t, q, v), q and v (*batch, n)."""
State: TypeAlias = tuple[Floats, ...]
"""(y,) of a first-order or (q, v) of a second-order system."""
Step: TypeAlias = Callable[[float, State, float], State]
"""From the state at t to the state at t + h."""


def first_order(method: Tableau, field: Field) -> Step:
    """The step of a Runge-Kutta method for dy/dt = f(t, y); its states are (y,)."""

    def step(t: float, state: State, h: float) -> State:
        (y,) = state
        slopes: list[Floats] = []
        for row, node in zip(method.a, method.c, strict=True):
            slopes.append(field(t + node * h, _advance(y, h, row, slopes)))
        return (_advance(y, h, method.b, slopes),)

    return step


def second_order(method: Method, acceleration: Acceleration) -> Step:
    """The step of a method for q'' = a(t, q, q'); its states are (q, v)."""
    return _kick_and_drift(method, acceleration) if isinstance(method, Splitting) else _nystrom(method, acceleration)


def _nystrom(method: Tableau, acceleration: Acceleration) -> Step:
    """The Runge-Kutta step of the pair q' = v, v' = a."""

    def step(t: float, state: State, h: float) -> State:
        q, v = state
        rates: list[Floats] = []
        slopes: list[Floats] = []
        for row, node in zip(method.a, method.c, strict=True):
            here, rate = _advance(q, h, row, rates), _advance(v, h, row, slopes)
            rates.append(rate)
            slopes.append(acceleration(t + node * h, here, rate))
        return _advance(q, h, method.b, rates), _advance(v, h, method.b, slopes)

    return step


def _kick_and_drift(method: Splitting, acceleration: Acceleration) -> Step:
    """The step of a splitting method."""
    stages = tuple(zip(method.kicks, method.drifts, strict=True))

    def step(t: float, state: State, h: float) -> State:
        q, v = state
        now = t
        for kick, drift in stages:
            v = v + (kick * h) * acceleration(now, q, v)
            q = q + (drift * h) * v
            now += drift * h
        return q, v

    return step


def _advance(y: Floats, h: float, weights: tuple[float, ...], slopes: list[Floats]) -> Floats:
    """The sum y + h sum_i w_i k_i."""
    for weight, slope in zip(weights, slopes, strict=True):
        if weight:
            y = y + (h * weight) * slope
    return y


def integrate(step: Step, start: State, h: float, steps: int, t0: float = 0.0, seconds: float = inf) -> Outcome[State]:
    """March from `start` with a fixed step.

    Args:
        step: from `first_order` or `second_order`.
        start: state at t0, arrays of shape (*batch, m).
        h: step [s].
        steps: how many.
        t0: starting time [s].
        seconds: of wall-clock time that it may take.

    Returns:
        Arrays (k + 1, *batch, m) of the states at t0 + i h. k = steps, unless a number that is not finite appears:
        then the status is NOT_FINITE and the last finite state is the last row; or the time is over: BUDGET_SPENT.
    """
    deadline = perf_counter() + seconds
    history = tuple(np.empty((steps + 1, *part.shape)) for part in start)
    state = start
    _record(history, 0, state)
    for k in range(steps):
        if perf_counter() > deadline:
            return Outcome(tuple(part[: k + 1] for part in history), SolverStatus.BUDGET_SPENT, 0.0, k)
        state = step(t0 + k * h, state, h)
        if not finite(state):
            return Outcome(tuple(part[: k + 1] for part in history), SolverStatus.NOT_FINITE, np.inf, k)
        _record(history, k + 1, state)
    return Outcome(history, SolverStatus.CONVERGED, 0.0, steps)


def finite(state: State) -> bool:
    """Whether all numbers are finite; a sum shows any NaN or infinity at the cost of one pass."""
    return all(isfinite(np.add.reduce(part, axis=None)) for part in state)


def _record(history: State, k: int, state: State) -> None:
    for rows, part in zip(history, state, strict=True):
        rows[k] = part
