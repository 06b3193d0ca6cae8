"""The least changes of a request that make it possible, one kind after the other."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from mafsil.arrays import Floats
from mafsil.messages import say
from mafsil.trajectory.checks.limit_check import check, extremes
from mafsil.trajectory.feasibility.request import MotionRequest

MOST = 1e3
"""A leg that needs to be this many times as long is not found a remedy."""
GROWTH = 1.05
"""Between the factors that are tried for one leg: feasible stretches of factors narrower than that may be missed."""
SHARP = 1e-9
"""Relative width to which the least factor of one leg is found."""


class RemedyKind(StrEnum):
    """What a remedy changes."""

    SLOWER = "slower"
    SLOWER_LEG = "slower_leg"
    STOP = "stop"
    LEAVE_OUT = "leave_out"


@dataclass(frozen=True, eq=False, slots=True)
class Remedy:
    """A change that makes a request possible; no smaller one of its kind does.

    Attributes:
        kind: what it changes.
        request: the request with the change.
        factor: of the durations, 1 where none changes.
        place: leg or point that it changes, counted from 1; 0 for all.
    """

    kind: RemedyKind
    request: MotionRequest
    factor: float = 1.0
    place: int = 0

    def explain(self, language: str | None = None) -> str:
        """The change as a sentence."""
        return say(
            f"trajectory.remedy_{self.kind}",
            language=language,
            percent=100.0 * (self.factor - 1.0),
            place=self.place,
            duration=self.request.duration,
        )


def remedies(request: MotionRequest) -> tuple[Remedy, ...]:
    """Least changes of every kind that make the request possible.

    Those that keep the points and pass them come first, then stops, then points left out; of each the quickest first.
    """
    order = (RemedyKind.SLOWER, RemedyKind.SLOWER_LEG), (RemedyKind.STOP,), (RemedyKind.LEAVE_OUT,)
    found = list(_found(request))
    return tuple(
        remedy
        for kinds in order
        for remedy in sorted((each for each in found if each.kind in kinds), key=lambda each: each.request.duration)
    )


def is_possible(request: MotionRequest) -> bool:
    """Whether the motion keeps all limits."""
    return bool(check(request.trajectory(), request.limits))


def slowing_needed(request: MotionRequest) -> float:
    """How many times as long the whole motion must take for velocity, acceleration and jerk; positions apart.

    The derivative of order k shrinks with the k-th power of the factor, so that it is known at once.
    """
    motion, limits = request.trajectory(), request.limits
    needed = 1.0
    for order, bounds in ((1, limits.velocity), (2, limits.acceleration), (3, limits.jerk)):
        _, values = extremes(motion, order)
        needed = max(needed, float(_ratio(values.min(axis=0), bounds[0]).max() ** (1.0 / order)))
        needed = max(needed, float(_ratio(values.max(axis=0), bounds[1]).max() ** (1.0 / order)))
    return needed


def _ratio(reached: Floats, bound: Floats) -> Floats:
    """Share of a bound that is used; infinite where nothing is allowed and something needed."""
    with np.errstate(divide="ignore", invalid="ignore"):
        share = reached / bound
    return np.where(
        reached * np.sign(bound) <= 0.0, np.where((bound == 0.0) & (np.abs(reached) > 0.0), np.inf, 0.0), share
    )


def _found(request: MotionRequest) -> Iterator[Remedy]:
    factor = slowing_needed(request)
    if np.isfinite(factor):
        slower = request.slower(factor)
        if is_possible(slower):
            yield Remedy(RemedyKind.SLOWER, slower, factor)
    inner = range(1, len(request.points) - 1)
    if len(request.durations) > 1:
        for leg in range(len(request.durations)):
            least = _least(lambda f, leg=leg: is_possible(request.slower(f, leg)))
            if least is not None:
                yield Remedy(RemedyKind.SLOWER_LEG, request.slower(least, leg), least, leg + 1)
    for point in inner:
        if request.curve == "spline" and is_possible(request.stopping_at(point)):
            yield Remedy(RemedyKind.STOP, request.stopping_at(point), place=point + 1)
        if is_possible(request.without(point)):
            yield Remedy(RemedyKind.LEAVE_OUT, request.without(point), place=point + 1)


def _least(suits: Callable[[float], bool]) -> float | None:
    """The least factor above 1 that suits, None if none is found up to MOST.

    1. Factors that grow evenly, until one suits.
    2. Halving of the interval between it and the one before.
    """
    # 1.
    low, high = 1.0, GROWTH
    while not suits(high):
        low, high = high, high * GROWTH
        if high > MOST:
            return None
    # 2.
    while high - low > SHARP * high:
        middle = (low + high) / 2
        low, high = (low, middle) if suits(middle) else (middle, high)
    return high
