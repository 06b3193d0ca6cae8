"""What makes a requested motion impossible: which leg, which joint, and the least change that mends it.

The least changes of a request that make it possible, one kind after the other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.trajectory.checks.limit_check import Violation, check, extremes
from mafsil.trajectory.feasibility.request import Curve, MotionRequest, motion_request
from mafsil.trajectory.motion_limits import Limits
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial

MOST = 1e3
"""A leg that needs to be this many times as long is not found a remedy."""
GROWTH = 1.05
"""Between the factors that are tried for one leg: feasible stretches of factors narrower than that may be missed."""
SHARP = 1e-9
"""Relative width to which the least factor of one leg is found."""


class RequestStatus(Status):
    """Whether a requested motion is possible."""

    POSSIBLE = ("trajectory.request_possible", True)
    MENDABLE = ("trajectory.request_mendable", False)
    NO_REMEDY = ("trajectory.request_no_remedy", False)


@dataclass(frozen=True, slots=True)
class Obstruction:
    """One limit that the request breaks, and the leg on which it does so most.

    Attributes:
        leg: counted from 1.
        violation: joint, quantity, time, value and limit.
    """

    leg: int
    violation: Violation

    def explain(self, language: str | None = None) -> str:
        """Leg, joint and numbers in a sentence."""
        return say("trajectory.obstruction", language=language, leg=self.leg, what=self.violation.explain(language))


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class Diagnosis(Answer, entries="obstructions"):
    """True if the request is possible as it is; iterable over what obstructs it.

    Attributes:
        request: what was asked for.
        obstructions: limits that it breaks.
        remedies: least changes that make it possible: more time, then stops, then points left out; the quickest first.
    """

    request: MotionRequest
    obstructions: tuple[Obstruction, ...]
    remedies: tuple[Remedy, ...]

    def __bool__(self) -> bool:
        return not self.obstructions

    @property
    def status(self) -> RequestStatus:
        """Whether it is possible, or becomes so by one change."""
        if not self.obstructions:
            return RequestStatus.POSSIBLE
        return RequestStatus.MENDABLE if self.remedies else RequestStatus.NO_REMEDY

    def apply_fix(self, kind: RemedyKind | str | None = None) -> PiecewisePolynomial:
        """The motion after the first remedy, or after the first one of a kind.

        Args:
            kind: `slower`, `slower_leg`, `stop` or `leave_out`; any if None.

        Raises:
            InputError: there is no such remedy; `remedies` lists those that there are.
        """
        if not self.obstructions and kind is None:
            return self.request.trajectory()
        for remedy in self.remedies:
            if kind is None or remedy.kind == kind:
                return remedy.request.trajectory()
        known = ", ".join(dict.fromkeys(str(remedy.kind) for remedy in self.remedies))
        raise InputError("trajectory.no_such_remedy", kind=kind, known=known or "-")

    def explain(self, language: str | None = None) -> str:
        """What obstructs the motion, and what would mend it, a line each."""
        lines = [self.status.sentence(language, duration=self.request.duration)]
        lines += [obstruction.explain(language) for obstruction in self.obstructions]
        lines += [remedy.explain(language) for remedy in self.remedies]
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Status, obstructions and remedies as plain data."""
        return {
            "status": self.status.name.lower(),
            "duration": self.request.duration,
            "obstructions": [
                {
                    "leg": each.leg,
                    "joint": each.violation.joint,
                    "quantity": each.violation.quantity,
                    "time": each.violation.time,
                    "value": each.violation.value,
                    "limit": each.violation.limit,
                }
                for each in self.obstructions
            ],
            "remedies": [
                {
                    "kind": str(each.kind),
                    "place": each.place,
                    "factor": each.factor,
                    "durations": each.request.durations,
                    "duration": each.request.duration,
                }
                for each in self.remedies
            ],
        }


def suggest_fixes(
    points: ArrayLike,
    durations: ArrayLike,
    limits: Limits,
    *,
    curve: Curve = "spline",
    joints: Sequence[str] = (),
) -> Diagnosis:
    """Why a motion through points is impossible, and the least changes that make it possible.

    Changes that are tried: more time for all of it (exactly the least), more time for one leg (the least to nine
    digits), a stop at one point, one point less. Each that is offered was checked against all limits.

    Args:
        points: (k + 1, n) way points [rad | m].
        durations: (k,) of the legs between them [s].
        limits: a robot, or bounds of n coordinates.
        curve: `spline`: a cubic spline, at rest at both ends, where a jerk is limited with quartic ends that begin
            and end without acceleration; `stops`: quintics that rest at every point.
        joints: (n) names for the sentences; those of the robot if `limits` is one.

    Returns:
        The limits that are broken, each with its leg, joint and time, and the remedies.

    Raises:
        InputError: a wrong shape, a number that is not finite, a duration that is not positive, an unknown curve.

    Example: `mf.trajectory.suggest_fixes(points, [0.5, 0.2], robot).apply_fix()`
    """
    request = motion_request(points, durations, limits, curve=curve, joints=joints)
    violations = check(request.trajectory(), request.limits, request.joints)
    ends = np.cumsum(request.durations)
    found = tuple(
        Obstruction(min(int(np.searchsorted(ends, each.time, side="left")), len(ends) - 1) + 1, each)
        for each in violations.violations
    )
    return Diagnosis(request, found, remedies(request) if found else ())


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
    found = list(_find(request))
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


def _find(request: MotionRequest) -> Iterator[Remedy]:
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
