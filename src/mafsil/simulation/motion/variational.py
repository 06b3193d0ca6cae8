"""Variational integration of a robot: momenta of symmetries are kept exactly, the energy does not drift."""

from __future__ import annotations

from math import inf
from time import perf_counter

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.simulation.motion.system import DrivenRobot, variational_kernel
from mafsil.simulation.tolerances import FAILED, NEWTON_RESIDUAL, SMALLEST
from mafsil.solvers.outcome import Outcome, SolverStatus

NEWTON = 30
"""Newton steps at most; three or four are usual."""


def _symmetric(*half: float) -> tuple[float, ...]:
    """Steps g_1 ... g_m ... g_1 with the middle one making the sum one."""
    return (*half, 1.0 - 2.0 * sum(half), *reversed(half))


_SUZUKI = 1.0 / (4.0 - 4.0 ** (1.0 / 3.0))

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
        size = float(np.abs(p).max(initial=0.0)) + SMALLEST
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
