"""Motion of closed chains over time: the loops stay closed, by projection after every step.

1. A step of Runge and Kutta's method of order four with the accelerations of the closed chain.
2. Newton's method takes the coordinates back to closed loops by the shortest step.
3. Rates lose what would open the loops, with the least kinetic energy.

Reference: Hairer, Lubich and Wanner, Geometric Numerical Integration, sec. IV.4 (standard projection).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, Integers, JointVector, as_batch, positive
from mafsil.errors import InputError, ModelError
from mafsil.parallel.closed_chain import ClosedChain

Efforts: TypeAlias = Callable[[float, JointVector, JointVector], ArrayLike]
"""Efforts (*batch, n | a) at a time [s], coordinates and rates (*batch, n)."""
MOST_STEPS = 10_000_000
STARTS_OPEN = 1e-6
"""Gap over the size beyond which a start is refused instead of closed."""


class ClosedRunStatus(Status):
    """How a run of a closed chain ended."""

    FINISHED = ("parallel.run_finished", True)
    LOST = ("parallel.run_lost", False)
    NOT_FINITE = ("parallel.run_not_finite", False)


@dataclass(frozen=True, eq=False, repr=False)
class ClosedMotion(Answer, data="t q qd energy error rank"):
    """A run; true if it came to its end with closed loops.

    Attributes:
        status: how it ended.
        t: (k,) times [s]; of a run that ended early, until then.
        q, qd: (k, *batch, n) coordinates and rates.
        energy: (k, *batch) kinetic and potential [J].
        error: (k, *batch) largest gap of a loop [rad | m].
        rank: (k, *batch) independent rows of the loops; less than elsewhere at singular configurations.
    """

    status: ClosedRunStatus
    t: Floats
    q: JointVector
    qd: JointVector
    energy: Floats
    error: Floats
    rank: Integers

    def explain(self, language: str | None = None) -> str:
        """How it ended, the largest gap, and how much the energy changed."""
        drift = np.abs(self.energy - self.energy[0]).max(initial=0.0)
        return self.status.sentence(
            language, time=float(self.t[-1]), error=float(self.error.max()), drift=float(drift),
            least=int(self.rank.min()), most=int(self.rank.max()),
        )  # fmt: skip


def simulate_closed(
    chain: ClosedChain,
    q: ArrayLike,
    qd: ArrayLike | None = None,
    efforts: Efforts | ArrayLike | None = None,
    *,
    duration: float,
    step: float = 1e-3,
) -> ClosedMotion:
    """The motion of a closed chain under efforts.

    Args:
        chain: what moves.
        q: (*batch, n) coordinates that close the loops, as `chain.close_loops` gives them.
        qd: (*batch, n) rates; those that would open the loops are taken away. At rest if None.
        efforts: (*batch, n) of all joints or (*batch, a) of the driven ones, or a function of time, coordinates and
            rates; none if None [N m | N].
        duration: [s].
        step: of the integrator [s].

    Returns:
        The motion at every step. Memory: 2 n + 3 numbers for each step and row.

    Raises:
        InputError: the start does not close the loops, too many steps, efforts of a wrong shape.
        ModelError: a joint moves no mass.
    """
    h, end = positive("step", step), positive("duration", duration)
    if end / h > MOST_STEPS:
        raise InputError("parallel.too_many_steps", steps=end / h, most=MOST_STEPS)
    start = chain.close_loops(q)
    moved = np.abs(start.q - np.asarray(q)).max(initial=0.0)
    if not start or moved > STARTS_OPEN * chain.size:
        raise InputError("parallel.starts_open", error=float(chain.error(q).max(initial=0.0)), why=start.explain())
    x = start.q
    if not chain.forward_dynamics(x, np.zeros_like(x), np.zeros(chain.n)):
        raise ModelError("parallel.closed_singular_mass")
    given = np.zeros_like(x) if qd is None else as_batch("qd", qd, (chain.n,), finite=True)
    x, v = np.broadcast_arrays(x, chain.rates(x, np.broadcast_to(given, np.broadcast_shapes(x.shape, given.shape))))
    torque = _torque(chain, efforts)
    count = max(int(np.ceil(end / h - 1e-9)), 1)
    h = end / count
    t: Floats = h * np.arange(count + 1, dtype=np.float64)
    places, rates = (np.empty((count + 1, *x.shape)) for _ in range(2))
    energy, error = (np.empty((count + 1, *x.shape[:-1])) for _ in range(2))
    rank = np.empty((count + 1, *x.shape[:-1]), dtype=np.int64)
    status, last = ClosedRunStatus.FINISHED, count
    for k in range(count + 1):
        places[k], rates[k] = x, v
        energy[k], error[k] = chain.terms(x, v).energy, chain.error(x)
        now = chain.forward_dynamics(x, v, torque(t[k], x, v))
        rank[k] = now.rank
        if k == count:
            break
        x, v = _step(chain, torque, float(t[k]), h, x, v, now.qdd)
        if not (np.isfinite(x).all() and np.isfinite(v).all()):
            status, last = ClosedRunStatus.NOT_FINITE, k
            break
        back, v = chain.closed_state(x, v)
        if not back:
            status, last = ClosedRunStatus.LOST, k
            break
        x = back.q
    kept = slice(0, last + 1)
    return ClosedMotion(status, t[kept], places[kept], rates[kept], energy[kept], error[kept], rank[kept])


def _step(
    chain: ClosedChain, torque: Efforts, t: float, h: float, x: JointVector, v: JointVector, a: JointVector
) -> tuple[JointVector, JointVector]:
    """Coordinates and rates a step of Runge and Kutta later, before projection."""

    def slope(moment: float, place: JointVector, rate: JointVector) -> JointVector:
        if not (np.isfinite(place).all() and np.isfinite(rate).all()):
            return np.full_like(rate, np.nan)  # The run says so; neither the chain nor efforts are asked there.
        return chain.forward_dynamics(place, rate, torque(moment, place, rate)).qdd

    v2 = v + h / 2 * a
    a2 = slope(t + h / 2, x + h / 2 * v, v2)
    v3 = v + h / 2 * a2
    a3 = slope(t + h / 2, x + h / 2 * v2, v3)
    v4 = v + h * a3
    a4 = slope(t + h, x + h * v3, v4)
    return x + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a + 2 * a2 + 2 * a3 + a4)


def _torque(chain: ClosedChain, efforts: Efforts | ArrayLike | None) -> Efforts:
    """Efforts as a function."""
    if callable(efforts):
        return efforts
    fixed = np.zeros(chain.n) if efforts is None else np.asarray(efforts, dtype=np.float64)
    return lambda _t, _q, _qd: fixed
