"""The solution of a differential equation over an interval: its steps, and its values at any time between."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Status
from mafsil.arrays import Floats, frozen, real_array, require_finite
from mafsil.errors import InputError


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
