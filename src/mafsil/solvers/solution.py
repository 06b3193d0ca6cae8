"""The solution of a differential equation over an interval: its steps, its values at any time between, and its events.

Events are zeros of functions of the state, found on the polynomial of each step: where the signs at two places differ,
the zero between them is known to rounding (`bracketed_root`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Status
from mafsil.arrays import Floats, frozen, real_array, require_finite, require_function
from mafsil.errors import InputError
from mafsil.solvers.tolerances import AT_EVENT, FEW_ROUNDINGS

MOST_CALLS, HALVED = 100, 8
"""Calls of the function, and each which of them halves the bracket, so that it cannot creep."""


class IntegrationStatus(Status):
    """How an integration ended."""

    COMPLETED = ("solvers.integrated", True)
    EVENT = ("solvers.terminal_event", True)
    BLOWN_UP = ("solvers.step_vanished", False)
    BUDGET_SPENT = ("solvers.steps_spent", False)
    TIME_SPENT = ("solvers.time_spent", False)
    CHATTERING = ("solvers.chattering", False)


@dataclass(frozen=True, slots=True)
class Crossing:
    """An event that happened.

    Attributes:
        t: when [s].
        event: its index in the list of events.
        batch: index of the state within the batch; () for a single one.
        y: (*batch, m) the whole state there, before a reset.
    """

    t: float
    event: int
    batch: tuple[int, ...]
    y: Floats


@dataclass(frozen=True, eq=False)
class Solution:
    """Steps of an integration with a polynomial on each.

    y(t_k + theta h_k) = y_k + sum_d Q_k[d] theta^(d+1)

    Attributes:
        t: (k + 1,) ends of the steps [s].
        y: (k + 1, *batch, m) states there; at a reset the state before it.
        start: (k, *batch, m) states from which the steps begin: y[:-1], except after resets.
        polynomial: (k, d, *batch, m) coefficients Q.
        crossings: events that happened, in time.
    """

    t: Floats
    y: Floats
    start: Floats
    polynomial: Floats
    crossings: tuple[Crossing, ...] = ()

    def of_batch(self, k: int) -> Solution:
        """The solution of one state of a batch, by the first batch index, with its own events."""
        events = tuple(
            replace(event, batch=event.batch[1:], y=event.y[k]) for event in self.crossings if event.batch[0] == k
        )
        return Solution(self.t, self.y[:, k], self.start[:, k], self.polynomial[:, :, k], events)

    def at(self, t: ArrayLike) -> Floats:
        """States (*times, *batch, m) at times within the interval; after a reset its result counts.

        Raises:
            InputError: a time outside the interval, or not finite.
        """
        times = require_finite("t", real_array("t", t))
        first, last = float(self.t[0]), float(self.t[-1])
        slack = 4.0 * np.spacing(max(abs(first), abs(last)))
        if times.size and not (times.min() >= first - slack and times.max() <= last + slack):
            outside = float(times.min() if times.min() < first - slack else times.max())
            raise InputError("input.range", name="t", value=outside, low=first, high=last)
        return self._evaluate(times, derivative=False)

    def rate_at(self, t: ArrayLike) -> Floats:
        """Derivatives dy/dt (*times, *batch, m) of the polynomials; times as in `at`."""
        self.at(t)
        return self._evaluate(real_array("t", t), derivative=True)

    def _evaluate(self, times: Floats, *, derivative: bool) -> Floats:
        if len(self.t) == 1:
            constant = np.zeros_like(self.y[0]) if derivative else self.y[0]
            return np.broadcast_to(constant, (*times.shape, *constant.shape)).copy()
        k = np.clip(np.searchsorted(self.t, times.ravel(), side="right") - 1, 0, len(self.t) - 2)
        h = self.t[k + 1] - self.t[k]
        theta = (times.ravel() - self.t[k]) / h
        exponents = np.arange(1.0, self.polynomial.shape[1] + 1.0)
        if derivative:
            powers = exponents * theta[:, None] ** (exponents - 1.0) / h[:, None]
        else:
            powers = theta[:, None] ** exponents
        found = np.einsum("td,td...->t...", powers, self.polynomial[k])
        if not derivative:
            found = found + self.start[k]
        return found.reshape(*times.shape, *self.y.shape[1:])


class SolutionBuilder:
    """Collects the steps of a running integration."""

    def __init__(self, t: float, y: Floats) -> None:
        self.t = [t]
        self.y = [y]
        self.start: list[Floats] = []
        self.polynomial: list[Floats] = []
        self.crossings: list[Crossing] = []

    def add(self, t: float, y: Floats, start: Floats, polynomial: Floats) -> None:
        """One step that ends at t with y."""
        self.t.append(t)
        self.y.append(y)
        self.start.append(start)
        self.polynomial.append(polynomial)

    def finish(self) -> Solution:
        """The collected steps as one value."""
        empty = np.zeros((0, *self.y[0].shape))
        return Solution(
            frozen(self.t),
            frozen(self.y),
            frozen(self.start) if self.start else empty,
            frozen(self.polynomial) if self.polynomial else np.zeros((0, 1, *self.y[0].shape)),
            tuple(self.crossings),
        )


def cut(polynomial: Floats, theta: float) -> Floats:
    """The polynomial (d, ...) of the first part of a step, theta of its length."""
    powers = theta ** np.arange(1.0, polynomial.shape[0] + 1.0)
    return polynomial * powers.reshape(-1, *(1,) * (polynomial.ndim - 1))


def value_within(start: Floats, polynomial: Floats, theta: float) -> Floats:
    """State at the fraction theta of a step."""
    powers = theta ** np.arange(1.0, polynomial.shape[0] + 1.0)
    return start + np.tensordot(powers, polynomial, axes=1)


PROBES = 8
"""Places within a step at which the sign is asked: two zeros of one event closer than that are not seen."""
Function: TypeAlias = Callable[[float, Floats], "Floats | float"]


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happens where a function of time and state changes its sign.

    A function that touches zero without changing its sign does not count, nor one that starts at zero and leaves it.

    Attributes:
        function: g(t, y), one number for each state of the batch (*batch,).
        direction: +1 counts rising zeros only, -1 falling ones, 0 both.
        terminal: whether the first zero ends the integration.
        reset: y_after(t, y_before), such as an impact: the integration goes on from there; None changes nothing.
        name: for sentences.

    Raises:
        InputError: a direction other than -1, 0, 1, or a function that cannot be called so.
    """

    function: Function
    direction: int = 0
    terminal: bool = False
    reset: Callable[[float, Floats], Floats] | None = None
    name: str = "event"

    def __post_init__(self) -> None:
        require_function("function", self.function, "function g(t, y)", 2)
        if self.reset is not None:
            require_function("reset", self.reset, "function reset(t, y)", 2)
        if self.direction not in (-1, 0, 1):
            raise InputError("input.choice", name="direction", value=self.direction, known="-1, 0, 1")

    def values(self, t: float, y: Floats) -> Floats:
        """The function at a time and state (*batch, m), checked: (*batch,)."""
        return self._check(self.name, self.function(t, y), y.shape[:-1])

    def after(self, t: float, y: Floats) -> Floats:
        """The state (*batch, m) that the reset makes, checked."""
        assert self.reset is not None
        return self._check(f"{self.name}.reset", self.reset(t, y), y.shape).copy()

    @staticmethod
    def _check(name: str, given: ArrayLike, shape: tuple[int, ...]) -> Floats:
        values = require_finite(name, real_array(name, given))
        if values.shape != shape:
            raise InputError("input.shape", name=name, expected=shape, got=values.shape, hint="")
        return values


def require_events(events: object) -> None:
    """Refuse what is no sequence of events.

    Raises:
        InputError: it is none.
    """
    kind = type(events).__name__
    if not isinstance(events, Sequence) or not all(
        isinstance(event, Event) for event in cast("Sequence[object]", events)
    ):
        raise InputError("input.kind", name="events", expected="list of mafsil.simulation.Event", got=kind)


@dataclass(frozen=True, slots=True)
class Zero:
    """A zero found within a step: the fraction of the step, the event, the flat index in the batch."""

    theta: float
    event: int
    row: int


class Watch:
    """Remembers on which side of zero each event of each state was seen last."""

    def __init__(self, events: Sequence[Event], t: float, y: Floats) -> None:
        self._events = events
        self._sides = [np.sign(self._values(event, t, y)) for event in events]

    def zeros(self, t: float, h: float, start: Floats, polynomial: Floats) -> list[Zero]:
        """Zeros of all events within a step from t of length h, in time; remembers the sides at its end.

        Args:
            t, h: beginning and length of the step [s].
            start: (*batch, m) state at its beginning.
            polynomial: (d, *batch, m) of the step.
        """
        found: list[Zero] = []
        for number, event in enumerate(self._events):
            sides, before = self._sides[number], 0.0
            for probe in range(1, PROBES + 1):
                theta = probe / PROBES
                values = self._values(event, t + theta * h, value_within(start, polynomial, theta))
                now = np.sign(values)
                crossed = np.flatnonzero((now * sides < 0.0) & ((event.direction == 0) | (now == event.direction)))
                for row in crossed:
                    place = self._locate(event, int(row), (before, theta), (t, h), start, polynomial)
                    found.append(Zero(place, number, int(row)))
                sides = np.where(now == 0.0, sides, now)
                if (now != 0.0).all():
                    before = theta
            self._sides[number] = sides
        return sorted(found, key=lambda zero: zero.theta)

    def restart(self, t: float, y: Floats, rate: Floats, span: float) -> None:
        """Look at the sides anew after a change of the state; where an event is zero, the side to which it moves."""
        for number, event in enumerate(self._events):
            here = self._values(event, t, y)
            ahead = self._values(event, t + span, y + span * rate)
            near = np.abs(here) <= AT_EVENT * np.maximum(1.0, np.abs(ahead - here) / span)
            self._sides[number] = np.where(near, np.sign(ahead - here), np.sign(here))

    @staticmethod
    def _values(event: Event, t: float, y: Floats) -> Floats:
        return event.values(t, y).ravel()

    def _locate(
        self,
        event: Event,
        row: int,
        bracket: tuple[float, float],
        clock: tuple[float, float],
        start: Floats,
        polynomial: Floats,
    ) -> float:
        """The zero between two fractions of a step, to rounding."""
        t, h = clock

        def g(theta: float) -> float:
            return float(self._values(event, t + theta * h, value_within(start, polynomial, theta))[row])

        return bracketed_root(g, *bracket)


def bracketed_root(g: Callable[[float], float], low: float, high: float) -> float:
    """Where a function changes its sign, seen from below: regula falsi (Illinois) kept in its bracket.

    Args:
        g: of one number in the order of one; its signs at both ends differ.
        low, high: the bracket.

    Returns:
        The upper end of the last bracket, on which g has the sign that it has at `high`, or an exact zero.
    """
    g_low, g_high = g(low), g(high)
    side = 0
    for count in range(MOST_CALLS):
        if high - low <= FEW_ROUNDINGS:
            break
        middle = (low * g_high - high * g_low) / (g_high - g_low) if g_low * g_high < 0.0 else high
        if not low < middle < high or count % HALVED == HALVED - 1:
            middle = (low + high) / 2.0
        value = g(middle)
        if value * g_high > 0.0:
            high, g_high = middle, value
            g_low = g_low / 2.0 if side < 0 else g_low
            side = -1
        else:
            low, g_low = middle, value
            g_high = g_high / 2.0 if side > 0 else g_high
            side = 1
            if value == 0.0:
                return middle
    return high
