"""Forward dynamics with a fixed step: methods of tableaus and variational ones, joined by quintic polynomials."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mafsil.arrays import Floats
from mafsil.simulation.motion.system import DrivenRobot
from mafsil.simulation.motion.variational import COMPOSITIONS, march
from mafsil.solvers import integrate, method, second_order
from mafsil.solvers.events import Event, Watch
from mafsil.solvers.outcome import Outcome
from mafsil.solvers.solution import Crossing, IntegrationStatus, Solution, cut, value_within

RUNAWAY = 1e8
"""Joint rate [rad/s | m/s] beyond which a motion counts as blown up."""


def fixed_step_solution(
    system: DrivenRobot,
    name: str,
    start: tuple[Floats, Floats],
    step: float,
    steps: int,
    events: Sequence[Event],
) -> Outcome[Solution]:
    """The motion at the times i step, up to the last finite state or the first terminal event.

    Args:
        system: the robot and what acts on it.
        name: of the method.
        start: q and qd, (*batch, n) each.
        step: [s].
        steps: how many.
        events: looked for on the polynomials between the steps.
    """
    q, qd, residual = _marched(system, name, start, step, steps)
    good = np.isfinite(qd).all(axis=tuple(range(1, qd.ndim))) & (
        np.abs(qd).max(axis=tuple(range(1, qd.ndim)), initial=0.0) < RUNAWAY
    )
    kept = len(good) if good.all() else max(1, int(np.argmin(good)))
    blown = kept < steps + 1
    q, qd = q[:kept], qd[:kept]
    t: Floats = np.arange(float(kept)) * step
    polynomial = _quintic(q, qd, _accelerations(system, t, q, qd), step)
    y = np.concatenate([q, qd], axis=-1)
    status = IntegrationStatus.BLOWN_UP if blown else IntegrationStatus.COMPLETED
    solution = Solution(t, y, y[:-1], polynomial)
    if events:
        solution, ended = _watched(solution, events)
        status = IntegrationStatus.EVENT if ended else status
    facts = {"time": float(solution.t[-1]), "end": steps * step, "events": len(solution.crossings)}
    return Outcome(solution, status, residual, len(solution.t) - 1, facts=facts)


def _marched(
    system: DrivenRobot, name: str, start: tuple[Floats, Floats], step: float, steps: int
) -> tuple[Floats, Floats, float]:
    """All states, as far as they are finite, and the largest relative residual of implicit steps."""
    if name in COMPOSITIONS:
        fractions, _ = COMPOSITIONS[name]
        found = march(system, start[0], system.momentum(*start), step, steps, fractions)
        q, p = found.value
        qd = system.rate_of(q, p)
        qd[0] = start[1]
        return q, qd, found.residual
    with np.errstate(over="ignore", invalid="ignore"):
        marched = integrate(second_order(method(name), system.acceleration), start, step, steps)
    return marched.value[0], marched.value[1], 0.0


def _accelerations(system: DrivenRobot, t: Floats, q: Floats, qd: Floats) -> Floats:
    """Qdd (k, *batch, n) at the steps."""
    if system.unloaded:
        return system.robot.forward_dynamics(q, qd, np.zeros(system.n))
    return np.stack([system.acceleration(*row) for row in zip(t.tolist(), q, qd, strict=True)])


def _quintic(q: Floats, v: Floats, a: Floats, h: float) -> Floats:
    """Coefficients (k, 5, *batch, 2 n) in theta of the quintics through positions, rates and accelerations.

    The second half holds their derivatives by time, so that the rate is exactly that of the position.
    """
    c1, c2 = h * v[:-1], h * h * a[:-1] / 2.0
    D = q[1:] - q[:-1] - c1 - c2
    E = h * v[1:] - c1 - 2.0 * c2
    F = h * h * a[1:] - 2.0 * c2
    c3, c4, c5 = 10.0 * D - 4.0 * E + F / 2.0, -15.0 * D + 7.0 * E - F, 6.0 * D - 3.0 * E + F / 2.0
    position = np.stack([c1, c2, c3, c4, c5], axis=1)
    rate = np.stack([2.0 * c2, 3.0 * c3, 4.0 * c4, 5.0 * c5, np.zeros_like(c5)], axis=1) / h
    return np.concatenate([position, rate], axis=-1)


def _watched(solution: Solution, events: Sequence[Event]) -> tuple[Solution, bool]:
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
