"""The one fixed-step stepping loop, over batches of states, and its methods as data.

A wrong digit of a method fails at import: each checks its own order conditions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, isfinite
from time import perf_counter
from typing import TypeAlias

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.solvers.outcome import Outcome, SolverStatus
from mafsil.solvers.tolerances import ORDER_CONDITION

Row = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Tableau:
    """An explicit Runge-Kutta method: k_i = f(t + c_i h, y + h sum_j a_ij k_j), y' = y + h sum_i b_i k_i.

    Attributes:
        name: as the field calls it.
        a: rows i of the lower triangle, row i of length i.
        b: (s,) weights.
        c: (s,) nodes, the row sums of a.
        order: of the global error, at most four.

    Raises:
        InputError: a row sum or an order condition is violated.

    Reference: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, sec. II.2.
    """

    name: str
    a: tuple[Row, ...]
    b: Row
    c: Row
    order: int

    def __post_init__(self) -> None:
        a = np.zeros((len(self.b), len(self.b)))
        for i, row in enumerate(self.a):
            a[i, :i] = row
        b, c = np.array(self.b), np.array(self.c)
        _require(self.name, "a 1 = c", float(np.abs(a.sum(axis=1) - c).max()))
        for order, law, value, expected in (
            (1, "b 1 = 1", b.sum(), 1.0),
            (2, "b c = 1/2", b @ c, 1 / 2),
            (3, "b c^2 = 1/3", b @ c**2, 1 / 3),
            (3, "b a c = 1/6", b @ a @ c, 1 / 6),
            (4, "b c^3 = 1/4", b @ c**3, 1 / 4),
            (4, "b (c a c) = 1/8", b @ (c * (a @ c)), 1 / 8),
            (4, "b a c^2 = 1/12", b @ a @ c**2, 1 / 12),
            (4, "b a a c = 1/24", b @ a @ a @ c, 1 / 24),
        ):
            if order <= self.order:
                _require(self.name, law, abs(float(value) - expected))

    @property
    def stages(self) -> int:
        """Evaluations of the right-hand side per step."""
        return len(self.b)


@dataclass(frozen=True, slots=True)
class Splitting:
    """A method for q'' = a(t, q, v) that alternates kicks v += k h a(t, q, v) and drifts q += d h v, kick first.

    Attributes:
        name: as the field calls it.
        kicks, drifts: (s,) fractions of the step; each sums to one.
        order: of the global error for forces that depend on the velocity.

    Raises:
        InputError: a sum differs from one.

    Reference: Hairer, Lubich and Wanner, Geometric Numerical Integration, sec. I.1.2.
    """

    name: str
    kicks: Row
    drifts: Row
    order: int

    def __post_init__(self) -> None:
        _require(self.name, "sum of kicks = 1", abs(sum(self.kicks) - 1.0))
        _require(self.name, "sum of drifts = 1", abs(sum(self.drifts) - 1.0))


def _require(name: str, law: str, error: float) -> None:
    if error > ORDER_CONDITION:
        raise InputError("solvers.tableau", name=name, law=law, error=error)


Method = Tableau | Splitting
EULER = Tableau("Euler", ((),), (1.0,), (0.0,), 1)
MIDPOINT = Tableau("midpoint", ((), (1 / 2,)), (0.0, 1.0), (0.0, 1 / 2), 2)
HEUN = Tableau("Heun", ((), (1.0,)), (1 / 2, 1 / 2), (0.0, 1.0), 2)
RK4 = Tableau(
    "classical Runge-Kutta",
    ((), (1 / 2,), (0.0, 1 / 2), (0.0, 0.0, 1.0)),
    (1 / 6, 1 / 3, 1 / 3, 1 / 6),
    (0.0, 1 / 2, 1 / 2, 1.0),
    4,
)
SEMI_IMPLICIT_EULER = Splitting("semi-implicit Euler", (1.0,), (1.0,), 1)


def method(name: str) -> Method:
    """The method of that name.

    Raises:
        InputError: there is none; the sentence lists the names.
    """
    if name not in METHODS:
        raise InputError("input.choice", name="method", value=name, known=", ".join(METHODS))
    return METHODS[name]


METHODS: dict[str, Method] = {
    "euler": EULER,
    "midpoint": MIDPOINT,
    "heun": HEUN,
    "rk4": RK4,
    "semi_implicit_euler": SEMI_IMPLICIT_EULER,
}

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
