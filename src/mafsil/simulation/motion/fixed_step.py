"""Forward dynamics with a fixed step: methods of tableaus and variational ones, joined by quintic polynomials.

Variational integration of a robot: momenta of symmetries are kept exactly, the energy does not drift.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from time import perf_counter

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.simulation.motion.system import DrivenRobot, variational_kernel
from mafsil.simulation.tolerances import FAILED, NEWTON_RESIDUAL, PART_OF_STEP
from mafsil.solvers import integrate, method, second_order
from mafsil.solvers.integrate import State
from mafsil.solvers.outcome import Outcome, SolverStatus
from mafsil.solvers.solution import Crossing, Event, IntegrationStatus, Solution, Watch, cut, value_within

NEWTON = 30
"""Newton steps at most; three or four are usual."""
_SUZUKI = 1.0 / (4.0 - 4.0 ** (1.0 / 3.0))
RUNAWAY = 1e8
"""Joint rate [rad/s | m/s] beyond which a motion counts as blown up."""


@dataclass(frozen=True, slots=True)
class Clock:
    """Equal steps, and perhaps a shorter one at the end.

    Attributes:
        step: [s].
        count: how many of them.
        rest: length of the last, shorter step; zero if there is none [s].
    """

    step: float
    count: int
    rest: float = 0.0

    @classmethod
    def until(cls, end: float, step: float) -> Clock:
        """The clock that ends at a time."""
        count = int(end / step + PART_OF_STEP)
        rest = end - count * step
        return cls(step, count, rest if rest > PART_OF_STEP * step else 0.0)

    @property
    def lengths(self) -> Floats:
        """Of all steps (k,) [s]."""
        return np.append(np.full(self.count, self.step), [self.rest] if self.rest else [])

    @property
    def times(self) -> Floats:
        """Ends of the steps (k + 1,), beginning with zero [s]."""
        whole: Floats = np.arange(self.count + 1.0) * self.step
        return np.append(whole, [whole[-1] + self.rest] if self.rest else [])


def fixed_step_solution(
    system: DrivenRobot,
    name: str,
    start: tuple[Floats, Floats],
    clock: Clock,
    events: Sequence[Event],
    seconds: float = inf,
) -> Outcome[Solution]:
    """The motion at the ends of the steps, up to the last finite state or the first terminal event.

    Args:
        system: the robot and what acts on it.
        name: of the method.
        start: q and qd, (*batch, n) each.
        clock: the steps.
        events: looked for on the polynomials between the steps.
        seconds: of wall-clock time that it may take.
    """
    q, qd, residual, in_time = _march(system, name, start, clock, seconds)
    t, lengths = clock.times, clock.lengths
    good = np.isfinite(qd).all(axis=tuple(range(1, qd.ndim))) & (
        np.abs(qd).max(axis=tuple(range(1, qd.ndim)), initial=0.0) < RUNAWAY
    )
    kept = len(good) if good.all() else max(1, int(np.argmin(good)))
    status = IntegrationStatus.COMPLETED
    if kept < len(t):
        status = IntegrationStatus.BLOWN_UP if in_time else IntegrationStatus.TIME_SPENT
    q, qd, ends = q[:kept], qd[:kept], t[:kept]
    h = lengths[: kept - 1].reshape(-1, *(1,) * (q.ndim - 1))
    polynomial = _quintic(q, qd, _accelerations(system, ends, q, qd), h)
    y = np.concatenate([q, qd], axis=-1)
    solution = Solution(ends, y, y[:-1], polynomial)
    if events:
        solution, ended = _watch(solution, events)
        status = IntegrationStatus.EVENT if ended else status
    details = {"time": float(solution.t[-1]), "end": float(t[-1]), "events": len(solution.crossings)}
    return Outcome(solution, status, residual, len(solution.t) - 1, details=details)


def _march(
    system: DrivenRobot, name: str, start: tuple[Floats, Floats], clock: Clock, seconds: float
) -> tuple[Floats, Floats, float, bool]:
    """All states, as far as they are finite; the largest relative residual of implicit steps; whether time was left."""
    fractions, _ = COMPOSITIONS.get(name, ((), 0))

    def pieces(state: State, h: float, count: int, t0: float) -> Outcome[State]:
        if fractions:
            return march(system, (state[0], state[1]), h, count, fractions, t0, seconds)
        return integrate(second_order(method(name), system.acceleration), state, h, count, t0, seconds)

    first = (start[0], system.momentum(*start)) if fractions else start
    with np.errstate(over="ignore", invalid="ignore"):
        found = pieces(first, clock.step, clock.count, 0.0)
        (q, second), worst = found.value, found.residual
        if clock.rest and len(q) == clock.count + 1:
            found = pieces((q[-1], second[-1]), clock.rest, 1, clock.count * clock.step)
            worst = max(worst, found.residual)
            q, second = (np.concatenate([x, last[1:]]) for x, last in zip((q, second), found.value, strict=True))
    qd = second
    if fractions:
        qd = system.rate_of(q, second)
        qd[0] = start[1]
    return q, qd, worst if fractions else 0.0, found.status is not SolverStatus.BUDGET_SPENT


def _accelerations(system: DrivenRobot, t: Floats, q: Floats, qd: Floats) -> Floats:
    """qdd (k, *batch, n) at the steps."""
    if system.unloaded:
        return system.robot.forward_dynamics(q, qd, np.zeros(system.n))
    return np.stack([system.acceleration(*row) for row in zip(t.tolist(), q, qd, strict=True)])


def _quintic(q: Floats, v: Floats, a: Floats, h: Floats) -> Floats:
    """Coefficients (k, 5, *batch, 2 n) in theta of the quintics through positions, rates and accelerations.

    The second half holds their derivatives by time, so that the rate is exactly that of the position.
    """
    c1, c2 = h * v[:-1], h * h * a[:-1] / 2.0
    D = q[1:] - q[:-1] - c1 - c2
    E = h * v[1:] - c1 - 2.0 * c2
    F = h * h * a[1:] - 2.0 * c2
    c3, c4, c5 = 10.0 * D - 4.0 * E + F / 2.0, -15.0 * D + 7.0 * E - F, 6.0 * D - 3.0 * E + F / 2.0
    position = np.stack([c1, c2, c3, c4, c5], axis=1)
    rate = np.stack([2.0 * c2 / h, 3.0 * c3 / h, 4.0 * c4 / h, 5.0 * c5 / h, np.zeros_like(c5)], axis=1)
    return np.concatenate([position, rate], axis=-1)


def _watch(solution: Solution, events: Sequence[Event]) -> tuple[Solution, bool]:
    """The solution with its events, cut at the first terminal one."""
    watch = Watch(events, 0.0, solution.y[0])
    crossings: list[Crossing] = []
    for k in range(len(solution.t) - 1):
        t, start, polynomial = float(solution.t[k]), solution.start[k], solution.polynomial[k]
        h = float(solution.t[k + 1]) - t
        for zero in watch.zeros(t, h, start, polynomial):
            state = value_within(start, polynomial, zero.theta)
            batch = tuple(int(i) for i in np.unravel_index(zero.row, state.shape[:-1]))
            crossings.append(Crossing(t + zero.theta * h, zero.event, batch, state))
            if events[zero.event].terminal and zero.theta > 0.0:
                times = np.append(solution.t[: k + 1], t + zero.theta * h)
                pieces = solution.polynomial[: k + 1].copy()
                pieces[k] = cut(polynomial, zero.theta)
                y = np.concatenate([solution.y[: k + 1], state[None]])
                return Solution(times, y, solution.start[: k + 1], pieces, tuple(crossings)), True
    found = Solution(solution.t, solution.y, solution.start, solution.polynomial, tuple(crossings))
    return found, False


def _symmetric(*half: float) -> tuple[float, ...]:
    """Steps g_1 ... g_m ... g_1 with the middle one making the sum one."""
    return (*half, 1.0 - 2.0 * sum(half), *reversed(half))


COMPOSITIONS: dict[str, tuple[tuple[float, ...], int]] = {
    "variational": ((1.0,), 2),
    "variational4": (_symmetric(_SUZUKI, _SUZUKI), 4),
    "variational6": (
        _symmetric(0.39216144400731413928, 0.33259913678935943860, -0.70624617255763935981, 0.082213596293550800230),
        6,
    ),
    "variational8": (
        _symmetric(
            0.13020248308889008088, 0.56116298177510838456, -0.38947496264484728641, 0.15884190655515560090,
            -0.39590389413323757734, 0.18453964097831570709, 0.25837438768632204729, 0.29501172360931029887,
        ),
        8,
    ),
}  # fmt: skip
"""Fractions of the step that the midpoint rule makes one after another, and the order of the whole.

References: Suzuki, Phys. Lett. A 146, 1990 (4); Kahan and Li, Composition constants for raising the orders of
unconventional schemes for ordinary differential equations, Math. Comp. 66, 1997 (6, 8).
"""


def march(
    system: DrivenRobot,
    start: tuple[Floats, Floats],
    step: float,
    steps: int,
    composition: tuple[float, ...],
    t0: float = 0.0,
    seconds: float = inf,
) -> Outcome[tuple[Floats, Floats]]:
    """Coordinates and momenta (k + 1, *batch, n) at the times i step.

    Efforts act with their value in the middle of each midpoint step.

    Args:
        system: the robot and what acts on it.
        start: q and p, (*batch, n) each.
        step: of the whole composition [s].
        steps: how many.
        composition: fractions of the step, from COMPOSITIONS.
        t0: starting time [s].
        seconds: of wall-clock time that it may take.
    """
    (q, p), deadline = start, perf_counter() + seconds
    all_q, all_p = np.empty((2, steps + 1, *q.shape))
    all_q[0], all_p[0] = q, p
    solver = _MidpointStep(system)
    before, h_before = None, 0.0
    v = system.rate_of(q, p)
    for k in range(steps):
        if perf_counter() > deadline:
            return Outcome((all_q[: k + 1], all_p[: k + 1]), SolverStatus.BUDGET_SPENT, solver.worst, k)
        t = t0 + k * step
        for number, fraction in enumerate(composition):
            h = fraction * step
            found = solver.solve(t, q, p, v, h)
            if found is None:
                kept = (all_q[: k + 1], all_p[: k + 1])
                return Outcome(kept, SolverStatus.NOT_FINITE, np.inf, k)
            moved, p = found
            q, t = q + h * moved, t + h
            # The mean rates belong to the middles of the substeps; the next guess lies on their line.
            ahead = (h + composition[(number + 1) % len(composition)] * step) / 2.0
            v = moved if before is None else moved + (moved - before) * (ahead / ((h + h_before) / 2.0))
            before, h_before = moved, h
        all_q[k + 1], all_p[k + 1] = q, p
    return Outcome((all_q, all_p), SolverStatus.CONVERGED, solver.worst, steps)


class _MidpointStep:
    """Solves one step of the midpoint rule by Newton's method."""

    def __init__(self, system: DrivenRobot) -> None:
        self.system = system
        self.kernel = variational_kernel(system.robot.mechanism)
        self.free = system.unloaded
        self.zero = np.zeros(system.n)
        self.worst = 0.0

    def solve(self, t: float, q: Floats, p: Floats, v: Floats, h: float) -> tuple[Floats, Floats] | None:
        """Mean rate over the step and momentum at its end; None if there is no solution near the guess."""
        n, system = self.system.n, self.system
        size = float(np.abs(p).max(initial=0.0)) + LEAST_DIVISOR
        clock, before, stuck = np.asarray(h), np.inf, 0
        for _ in range(NEWTON):
            load = self.zero if self.free else system.load(t + h / 2.0, q + (h / 2.0) * v, v)
            try:
                table = self.kernel(q, p, v, load, clock)
            except InputError:
                return None
            left = float(np.abs(table[..., 2 * n :]).max(initial=0.0))
            moved = float(np.abs(table[..., n : 2 * n]).max(initial=0.0)) + size
            if not left < np.inf:
                return None
            if left <= NEWTON_RESIDUAL * moved or stuck >= 2:
                self.worst = max(self.worst, left / moved)
                return (v, table[..., n : 2 * n]) if left <= FAILED * moved else None
            stuck = stuck + 1 if left >= before else 0
            before = min(left, before)
            v = table[..., :n]
        return None
