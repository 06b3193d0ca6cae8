"""Integration with a step chosen by the error estimate: dense output, events, breaks, and an honest ending."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite
from time import perf_counter

import numpy as np

from mafsil.arrays import Floats, positive
from mafsil.errors import InputError
from mafsil.floating_point import EPS
from mafsil.solvers.embedded import EmbeddedPair
from mafsil.solvers.integrate import Field
from mafsil.solvers.outcome import Outcome
from mafsil.solvers.solution import (
    Crossing,
    Event,
    IntegrationStatus,
    Solution,
    SolutionBuilder,
    Watch,
    cut,
    value_within,
)
from mafsil.solvers.tolerances import (
    AFTER_RESET,
    CLOSE_RESETS,
    EARLIEST,
    FEW_ROUNDINGS,
    FIRST_STEP,
    LAST_STEP,
    LEAST_ERROR,
    NO_SPEED,
)

SAFETY, LEAST, MOST = 0.9, 0.2, 8.0
"""Share of the predicted step that is taken; bounds of the change from step to step."""
MEMORY = 0.3
"""Share of the exponent that the previous error has: the P of PI control against hunting step sizes."""
RESETS = 10_000
"""Resets after which an integration counts as chattering."""
IN_A_ROW = 20
EDGE = 32 * EPS
"""Share of its time by which a break is approached: the value before it counts up to there."""


@dataclass(frozen=True, slots=True)
class Tolerance:
    """Error per step that is accepted: root mean square of e_i / (absolute + relative |y_i|) at most one.

    Attributes:
        relative: share of each component, a number or (m,); zero where only the absolute one counts.
        absolute: a number or (m,), in units of the state.

    Raises:
        InputError: an absolute tolerance that is not positive, a relative one that double precision cannot keep.
    """

    relative: Floats | float = 1e-9
    absolute: Floats | float = 1e-12

    def __post_init__(self) -> None:
        for value in np.ravel(self.relative).tolist():
            if value != 0.0 and not FEW_ROUNDINGS <= value <= 1.0:
                raise InputError("solvers.tolerance", value=value, low=FEW_ROUNDINGS)
        least = float(np.min(self.absolute))
        if not 0.0 < least < inf:
            raise InputError("input.positive", name="tolerance", value=least)


@dataclass(frozen=True, slots=True)
class Budget:
    """The budget of an integration.

    Attributes:
        steps: accepted and rejected ones together.
        seconds: of wall-clock time.
        longest: step that may be taken [s].

    Raises:
        InputError: a time that is not positive.
    """

    steps: int = 1_000_000
    seconds: float = inf
    longest: float = inf

    def __post_init__(self) -> None:
        if self.seconds != inf:
            positive("seconds", self.seconds)


def integrate_adaptively(
    pair: EmbeddedPair,
    field: Field,
    start: Floats,
    interval: tuple[float, float],
    *,
    tolerance: Tolerance | None = None,
    budget: Budget | None = None,
    events: Sequence[Event] = (),
    breaks: Sequence[float] = (),
) -> Outcome[Solution]:
    """Solve dy/dt = f(t, y) forward in time.

    All states of a batch share the step, which the worst of them decides. A number that is not finite rejects a step;
    when no step is short enough, the solution up to the last good state is returned with the status BLOWN_UP.

    Args:
        pair: method, from `embedded.pair`.
        field: f(t, y), y (*batch, m).
        start: (*batch, m) state at the beginning.
        interval: beginning and end [s].
        tolerance: of the error of a step.
        budget: of steps and time.
        events: what to look for.
        breaks: times at which f is not smooth: steps end there, and f is asked on both sides, never across.

    Returns:
        The solution, its status, the estimated error of the last step, the number of steps tried.

    Raises:
        InputError: an interval that is not finite or does not go forward.
    """
    if not -inf < interval[0] < interval[1] < inf:
        raise InputError("solvers.interval", begin=interval[0], end=interval[1])
    run = _Adaptive(pair, field, start, interval, tolerance or Tolerance(), budget or Budget(), events)
    ends = [*sorted(b for b in breaks if interval[0] < b < interval[1]), interval[1]]
    status = IntegrationStatus.COMPLETED
    for end in ends:
        run.edge = inf if end is ends[-1] else end - EDGE * abs(end)
        status = run.until(end)
        if status is not IntegrationStatus.COMPLETED:
            break
    details = {"time": run.t, "end": interval[1], "events": len(run.builder.crossings)}
    return Outcome(run.builder.finish(), status, run.error, run.tried, details=details)


class _Adaptive:
    """State of a running integration."""

    def __init__(
        self,
        pair: EmbeddedPair,
        field: Field,
        start: Floats,
        interval: tuple[float, float],
        tolerance: Tolerance,
        budget: Budget,
        events: Sequence[Event],
    ) -> None:
        self.pair, self.field, self.tolerance, self.budget, self.events = pair, field, tolerance, budget, events
        self.t: float = interval[0]
        self.y: Floats = np.array(start, dtype=np.float64)
        self.span = interval[1] - interval[0]
        self.stages = np.empty((len(pair.c), *self.y.shape))
        self.flat = self.stages.reshape(len(pair.c), -1)
        self.builder = SolutionBuilder(self.t, self.y)
        self.watch = Watch(events, self.t, self.y)
        self.tried, self.resets, self.close = 0, 0, 0
        self.last_reset: float = -inf
        self.error = self.previous = 1.0
        self.h: float = 0.0
        self.edge: float = inf
        self.deadline = perf_counter() + budget.seconds

    def until(self, end: float) -> IntegrationStatus:
        """Integrate to a time; the field is smooth up to there."""
        self.stages[0] = self.field(self.t, self.y)
        if not (np.isfinite(self.stages[0]).all() and np.isfinite(self.y).all()):
            return IntegrationStatus.BLOWN_UP
        self.h = self._first_step() if not self.h else self.h
        while self.t < end:
            if self.tried >= self.budget.steps:
                return IntegrationStatus.BUDGET_SPENT
            if perf_counter() > self.deadline:
                return IntegrationStatus.TIME_SPENT
            status = self._step(end)
            if status is not None:
                return status
        return IntegrationStatus.COMPLETED

    def _step(self, end: float) -> IntegrationStatus | None:
        """Try one step; a status if the integration ends with it."""
        whole = min(self.h, self.budget.longest)
        last = self.t + whole * (1.0 + LAST_STEP) >= end
        h = end - self.t if last else whole
        if h <= 10.0 * np.spacing(abs(self.t)) and not last:
            return IntegrationStatus.BLOWN_UP
        self.tried += 1
        y = self._stages(h)
        error = self._error(h, y)
        if not error <= 1.0:
            factor = max(LEAST, SAFETY * error ** (-1.0 / self.pair.error_order)) if isfinite(error) else LEAST
            self.h = h * factor
            return IntegrationStatus.BLOWN_UP if self.h <= 10.0 * np.spacing(max(abs(self.t), EARLIEST)) else None
        k = self.pair.error_order
        size = max(error, LEAST_ERROR)
        factor = SAFETY * size ** (-(1.0 - MEMORY) / k) * (max(self.previous, LEAST_ERROR) / size) ** (MEMORY / k)
        suggested = h * min(MOST, max(LEAST, factor))
        self.h = max(suggested, whole) if last else suggested
        self.previous = self.error = error
        return self._accept(h, y, end if last else self.t + h)

    def _stages(self, h: float) -> Floats:
        """All stages of the step proper; the result is where the last is asked."""
        pair, shape, y = self.pair, self.y.shape, self.y
        for i in range(1, pair.steps):
            y = self.y + (h * (pair.a[i, :i] @ self.flat[:i])).reshape(shape)
            self.stages[i] = self.field(min(self.t + pair.c[i] * h, self.edge), y)
        return y

    def _error(self, h: float, y: Floats) -> float:
        """The largest error of the batch in units of the tolerance."""
        scale = self.tolerance.absolute + self.tolerance.relative * np.maximum(np.abs(self.y), np.abs(y))
        estimates = [(e @ self.flat[: self.pair.steps]).reshape(self.y.shape) * (h / scale) for e in self.pair.error]
        squares = [_mean_square(estimate) for estimate in estimates]
        if len(squares) == 2:
            with np.errstate(invalid="ignore", divide="ignore"):
                mixed = squares[0] / np.sqrt(squares[0] + 0.01 * squares[1])
            norm = np.where(squares[0] == 0.0, 0.0, mixed)
        else:
            norm = np.sqrt(squares[0])
        return float(norm.max(initial=0.0)) if np.isfinite(norm).all() and np.isfinite(y).all() else inf

    def _accept(self, h: float, y: Floats, t: float) -> IntegrationStatus | None:
        """Keep a step, up to the first event that ends it or resets the state."""
        pair, begin = self.pair, self.t
        after = self.stages[pair.steps - 1].copy()
        for i in range(pair.steps, len(pair.c)):
            inner = self.y + (h * (pair.a[i, :i] @ self.flat[:i])).reshape(self.y.shape)
            self.stages[i] = self.field(min(begin + pair.c[i] * h, self.edge), inner)
        polynomial = np.tensordot(h * pair.dense.T, self.stages, axes=1)
        zeros = self.watch.zeros(begin, h, self.y, polynomial) if self.events else []
        for zero in zeros:
            event = self.events[zero.event]
            at, state = begin + zero.theta * h, value_within(self.y, polynomial, zero.theta)
            batch = tuple(int(i) for i in np.unravel_index(zero.row, self.y.shape[:-1]))
            self.builder.crossings.append(Crossing(at, zero.event, batch, state))
            if event.terminal or event.reset is not None:
                if at > begin:
                    self.builder.add(at, state, self.y, cut(polynomial, zero.theta))
                self.t, self.y = at, state
                return IntegrationStatus.EVENT if event.terminal else self._reset(event)
        self.builder.add(t, y, self.y, polynomial)
        self.t, self.y = t, y
        self.stages[0] = after
        return None

    def _reset(self, event: Event) -> IntegrationStatus | None:
        """Go on from the state that an event makes."""
        self.y = event.after(self.t, self.y)
        self.stages[0] = self.field(self.t, self.y)
        self.h = min(self.h, self._first_step())
        self.watch.restart(self.t, self.y, self.stages[0], AFTER_RESET * self.h)
        self.resets += 1
        self.close = self.close + 1 if self.t - self.last_reset <= CLOSE_RESETS * self.span else 0
        self.last_reset = self.t
        chattering = self.resets >= RESETS or self.close >= IN_A_ROW
        return IntegrationStatus.CHATTERING if chattering else None

    def _first_step(self) -> float:
        """A cautious first step from the sizes of y, f and the change of f along it.

        Reference: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, sec. II.4.
        """
        scale = self.tolerance.absolute + self.tolerance.relative * np.abs(self.y)
        rate = self.stages[0]
        size, speed = _size(self.y / scale), _size(rate / scale)
        guess = FIRST_STEP if size < NO_SPEED or speed < NO_SPEED else 0.01 * size / speed
        guess = min(guess, self.span)
        ahead = self.field(self.t + guess, self.y + guess * rate)
        bend = _size((ahead - rate) / scale) / guess
        most = max(speed, bend)
        if not isfinite(most):
            return guess
        power = 1.0 / (self.pair.order + 1.0)
        careful = max(FIRST_STEP, AFTER_RESET * guess) if most <= FEW_ROUNDINGS else (0.01 / most) ** power
        return min(100.0 * guess, careful, self.span)


def _size(x: Floats) -> float:
    """Root mean square of the worst state of a batch."""
    return float(np.sqrt(_mean_square(x)).max(initial=0.0))


def _mean_square(x: Floats) -> Floats:
    """Over the last axis; zero where it is empty."""
    return np.einsum("...i,...i->...", x, x) / max(1, x.shape[-1])
