"""What a trajectory must do, as data: pass here, keep clear of, take so long, be so smooth; and whether it does.

How smooth a trajectory is, measured from itself: the jumps of its derivatives where its parts meet.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer
from mafsil.arrays import Floats, not_negative, number, positive, require_kind, whole
from mafsil.errors import InputError
from mafsil.fields import check_fields, finite
from mafsil.messages import say
from mafsil.trajectory.checks.jumps import JUMP, Jump, jumps
from mafsil.trajectory.motion import ContinuityStatus, RequirementStatus, Trajectory

NAMES = ("upper", "velocity", "acceleration", "jerk")
"""Names of derivatives 0 to 3 in the catalogue of sentences."""
SAMPLES = 64
"""Of each piece, around the best of which a distance is refined."""
REFINED = 6
"""Rounds of refinement; each looks eight times as close."""
Forward: TypeAlias = Callable[[Floats], Floats]
"""(k, n) coordinates -> (k, m) the place that is meant, such as the tip of an arm."""


def _last(name: str, value: object) -> float:
    """A time that may be infinite."""
    return not_negative(name, value, unbounded=True)


@dataclass(frozen=True, eq=False)
class PassThrough:
    """Spatial: comes within a distance of a point.

    Attributes:
        point: (m,) [rad | m].
        distance: [rad | m].
        begin, end: the times between which it does [s].
        place: of coordinates; the coordinates themselves if None.
    """

    point: ArrayLike
    distance: float
    begin: float = 0.0
    end: float = np.inf
    place: Forward | None = None
    __post_init__ = check_fields(point=finite(0, 1), distance=positive, begin=number, end=_last)


@dataclass(frozen=True, eq=False)
class KeepsClear:
    """Spatial: never comes nearer to a point than a distance.

    Attributes:
        point: (m,) [rad | m].
        distance: [rad | m].
        begin, end: the times between which it does not [s].
        place: of coordinates; the coordinates themselves if None.
    """

    point: ArrayLike
    distance: float
    begin: float = 0.0
    end: float = np.inf
    place: Forward | None = None
    __post_init__ = check_fields(point=finite(0, 1), distance=positive, begin=number, end=_last)


@dataclass(frozen=True)
class MaxDuration:
    """Temporal: lasts between two durations.

    Attributes:
        least, most: [s].
    """

    least: float = 0.0
    most: float = np.inf
    __post_init__ = check_fields(least=not_negative, most=_last)


@dataclass(frozen=True)
class MaxDerivativeJump:
    """Smoothness: continuous up to a derivative, measured from the trajectory.

    Attributes:
        order: 0 position, 1 velocity, 2 acceleration, 3 jerk.
        ends: whether start and end count, before and after which it rests.
    """

    order: int
    ends: bool = True


Requirement: TypeAlias = PassThrough | KeepsClear | MaxDuration | MaxDerivativeJump


@dataclass(frozen=True, slots=True)
class Finding:
    """One requirement and what was measured.

    Attributes:
        requirement: what was asked.
        met: whether the number keeps it.
        measured: least distance, duration, or order of continuity.
        time: of the least distance; NaN for others [s].
    """

    requirement: Requirement
    met: bool
    measured: float
    time: float

    def explain(self, language: str | None = None) -> str:
        """What was asked, what was measured."""
        asked = self.requirement
        details: dict[str, object] = {"measured": self.measured, "time": self.time}
        if isinstance(asked, PassThrough | KeepsClear):
            key, details["wanted"] = "near" if isinstance(asked, PassThrough) else "clear", asked.distance
        elif isinstance(asked, MaxDuration):
            key, details["least"], details["most"] = "takes", asked.least, asked.most
        else:
            key, details["wanted"] = "smooth", asked.order
        met = RequirementStatus.MET if self.met else RequirementStatus.NOT_MET
        return f"{say(f'trajectory.require_{key}', language=language, **details)}: {met.sentence(language)}"


@dataclass(frozen=True, slots=True, repr=False)
class RequirementCheck(Answer, entries="findings"):
    """True if all requirements are met; iterable over what was found.

    Attributes:
        findings: one for each requirement, in their order.
    """

    findings: tuple[Finding, ...]

    def __bool__(self) -> bool:
        return all(finding.met for finding in self.findings)

    @property
    def status(self) -> RequirementStatus:
        """MET if all are."""
        return RequirementStatus.MET if self else RequirementStatus.NOT_MET

    def explain(self, language: str | None = None) -> str:
        """One line for each requirement."""
        return "\n".join(finding.explain(language) for finding in self.findings)

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        rows = [
            {"kind": type(f.requirement).__name__, "met": f.met, "measured": f.measured, "time": f.time} for f in self
        ]
        return {"status": self.status.name.lower(), "findings": rows}


def require(trajectory: Trajectory, *requirements: Requirement) -> RequirementCheck:
    """Hold a trajectory against what it must do.

    Distances are searched: pieces are sampled and the neighbourhoods of the nearest samples refined; a pass closer than
    that, between two samples of a motion that wriggles faster, is not found.

    Args:
        trajectory: without batch dimensions.
        requirements: any number, of `PassThrough`, `KeepsClear`, `MaxDuration`, `MaxDerivativeJump`.

    Raises:
        InputError: no trajectory, a point of another length, a distance that is not positive.
    """
    require_kind("trajectory", trajectory, "Trajectory", "duration", "at", "breaks")
    return RequirementCheck(tuple(_finding(trajectory, each) for each in requirements))


def _finding(trajectory: Trajectory, asked: Requirement) -> Finding:
    """One requirement measured."""
    if isinstance(asked, MaxDuration):
        met = asked.least <= trajectory.duration <= asked.most
        return Finding(asked, met, trajectory.duration, np.nan)
    if isinstance(asked, MaxDerivativeJump):
        order = continuity(trajectory, ends=asked.ends).order
        return Finding(asked, order >= whole("order", asked.order, 0, 3), float(order), np.nan)
    nearest, time = _nearest(trajectory, asked)
    met = nearest <= asked.distance if isinstance(asked, PassThrough) else nearest >= asked.distance
    return Finding(asked, met, nearest, time)


def _nearest(trajectory: Trajectory, asked: PassThrough | KeepsClear) -> tuple[float, float]:
    """Least distance from the point, and its time."""
    point = np.atleast_1d(asked.point)
    begin, end = max(asked.begin, 0.0), min(asked.end, trajectory.duration)
    if not begin <= end:
        raise InputError("input.range", name="begin", value=asked.begin, low=0.0, high=end)
    breaks = np.clip(trajectory.breaks(), begin, end)
    inside = np.linspace(breaks[:-1], breaks[1:], SAMPLES, axis=-1).ravel()
    t = np.unique(np.concatenate([[begin, end], inside]))
    for _ in range(REFINED):
        gaps = _distances(trajectory, asked, point, t)
        # The nearest sample, and all whose neighbourhood could be nearer still.
        closest = np.argsort(gaps)[:4]
        near = [np.linspace(t[max(k - 1, 0)], t[min(k + 1, len(t) - 1)], 17) for k in closest]
        t = np.unique(np.concatenate([[t[closest[0]]], *near]))
    gaps = _distances(trajectory, asked, point, t)
    best = int(gaps.argmin())
    return float(gaps[best]), float(t[best])


def _distances(trajectory: Trajectory, asked: PassThrough | KeepsClear, point: Floats, t: Floats) -> Floats:
    """(k,) distances at times."""
    u = trajectory.at(t).u
    place = u if asked.place is None else np.asarray(asked.place(u), dtype=np.float64)
    if place.shape != (len(t), len(point)):
        raise InputError("input.shape", name="point", expected=place.shape[1:], got=point.shape, hint="")
    return np.linalg.norm(place - point, axis=1)


@dataclass(frozen=True, slots=True, repr=False)
class Continuity(Answer, data="order jumps", entries="jumps"):
    """How often a trajectory is continuously differentiable; true if its velocity does not jump.

    Attributes:
        order: of the highest derivative up to which all are continuous; -1 if the position jumps, 3 is the highest.
        jumps: all of the first derivative that is not continuous, in the order of time.
    """

    order: int
    jumps: tuple[Jump, ...]

    def __bool__(self) -> bool:
        return self.order >= 1

    @property
    def status(self) -> ContinuityStatus:
        """Whether an arm can follow: its velocity cannot jump."""
        return ContinuityStatus.CONTROLLABLE if self else ContinuityStatus.NOT_CONTROLLABLE

    def explain(self, language: str | None = None) -> str:
        """Which derivative jumps first, where most and by how much."""
        if not self.jumps:
            return say("trajectory.no_jump", language=language)
        worst = max(self.jumps, key=lambda jump: abs(jump.size))
        quantity = say(f"trajectory.{NAMES[worst.order]}", language=language)
        sentence = say("trajectory.jump", language=language, quantity=quantity, count=len(self.jumps), **asdict(worst))
        return f"{sentence}; {self.status.sentence(language)}"


def continuity(trajectory: Trajectory, *, ends: bool = True, tolerance: float = JUMP) -> Continuity:
    """Measure the jumps of position, velocity, acceleration and jerk at all breaks.

    Args:
        trajectory: without batch dimensions.
        ends: whether start and end count, before and after which a trajectory rests.
        tolerance: relative to the largest value of each derivative: smaller differences are no jumps.
    """
    tolerance = not_negative("tolerance", tolerance)
    for order in range(4):
        found = jumps(trajectory, order, ends=ends, tolerance=tolerance)
        if found:
            return Continuity(order - 1, found)
    return Continuity(3, ())
