"""Events of an integration: zeros of functions of the state, found on the polynomial of each step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, real_array, require_finite, require_function
from mafsil.errors import InputError
from mafsil.solvers.bracketed_root import bracketed_root
from mafsil.solvers.solution import value_within
from mafsil.solvers.tolerances import AT_EVENT

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
