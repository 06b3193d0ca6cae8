"""What makes a requested motion impossible: which leg, which joint, and the least change that mends it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.trajectory.checks.limit_check import Violation, check
from mafsil.trajectory.feasibility.remedies import Remedy, RemedyKind, remedies
from mafsil.trajectory.feasibility.request import Curve, MotionRequest, motion_request
from mafsil.trajectory.motion_limits import Limits
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial


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
class Diagnosis(Answer):
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

    def __len__(self) -> int:
        return len(self.obstructions)

    def __iter__(self) -> Iterator[Obstruction]:
        return iter(self.obstructions)

    def __repr__(self) -> str:
        return self.explain()

    @property
    def status(self) -> RequestStatus:
        """Whether it is possible, or becomes so by one change."""
        if not self.obstructions:
            return RequestStatus.POSSIBLE
        return RequestStatus.MENDABLE if self.remedies else RequestStatus.NO_REMEDY

    def mended(self, kind: RemedyKind | str | None = None) -> PiecewisePolynomial:
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
            "status": self.status.name,
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

    Example: `mf.trajectory.suggest_fixes(points, [0.5, 0.2], robot).mended()`
    """
    request = motion_request(points, durations, limits, curve=curve, joints=joints)
    violations = check(request.trajectory(), request.limits, request.joints)
    ends = np.cumsum(request.durations)
    found = tuple(
        Obstruction(min(int(np.searchsorted(ends, each.time, side="left")), len(ends) - 1) + 1, each)
        for each in violations
    )
    return Diagnosis(request, found, remedies(request) if found else ())
