"""What a trajectory must do, as data (pass here, keep clear of, take so long, be so smooth), and its jumps.

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
from mafsil.floating_point import EPS
from mafsil.messages import say
from mafsil.trajectory.motion import ContinuityStatus, RequirementStatus, Trajectory, derivative
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial

NEAR = 1e-6
"""How far beside a break a derivative is looked at, relative to the shorter piece beside it."""
JUMP = 1e-6
"""A jump, relative to the largest value of its derivative and in SI units for the position; below it is rounding."""
CLOSEST = 16 * EPS
"""Share of the duration below which two times are one."""
CONSTRUCTED = 64 * EPS
"""Share of the position, over the k-th power of a piece's length, by which derivative k is off by rounding."""
INSIDE = np.array([0.1, 0.21, 0.38, 0.5, 0.62, 0.79, 0.9])
"""Shares of a piece at which its derivatives are looked at: of no smooth motion all are zeros."""
SCANNED, BISECTIONS = 2048, 40
"""Where breaks are not known: evenly spaced times, and halvings of an interval that holds a jump."""
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


@dataclass(frozen=True, slots=True)
class Jump:
    """A derivative that is not continuous.

    Attributes:
        order: 0 for the position, to 3 for the jerk.
        time: [s].
        coordinate: index.
        size: value after less value before.
    """

    order: int
    time: float
    coordinate: int
    size: float


def jumps(trajectory: Trajectory, order: int, *, ends: bool = True, tolerance: float = JUMP) -> tuple[Jump, ...]:
    """The jumps of one derivative, in the order of time.

    Polynomials are evaluated on both sides of their knots. Of other motions the values beside a break at two distances
    give the jump without its slope: 2 J(h) - J(2 h), where J(h) = f(t + h) - f(t - h).

    Args:
        trajectory: without batch dimensions.
        order: of the derivative, 0 to 3.
        ends: whether start and end count, before and after which a trajectory rests.
        tolerance: relative to the largest value of the derivative: smaller differences are no jumps.
    """
    duration = trajectory.duration
    if not duration > 0.0:
        return ()
    exact = isinstance(trajectory, PiecewisePolynomial)
    begin, wide, sizes, largest = _of_polynomial(trajectory, order) if exact else _of_any(trajectory, order)
    if not ends:
        begin, wide, sizes = begin[1:-1], wide[1:-1], sizes[1:-1]
    if not len(sizes):
        return ()
    largest = np.maximum(largest, np.abs(sizes).max(axis=0))
    u = np.abs(trajectory.at(begin).u).max(axis=0)
    threshold = tolerance * (np.maximum(largest, 1.0) if order == 0 else largest)
    noise = CONSTRUCTED * np.maximum(u, u.max(initial=0.0)) / np.power(wide, order)[:, None]
    found = np.argwhere(np.abs(sizes) > np.maximum(threshold, noise))
    return tuple(Jump(order, float(begin[k]), int(i), float(sizes[k, i])) for k, i in found)


def _of_polynomial(motion: PiecewisePolynomial, order: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Times of the knots, the longer piece beside each, the jumps there, and the largest value of the derivative."""
    knots = motion.knots
    after, before = motion.derivative(knots[:-1], order), motion.derivative(knots[1:], order, within=knots[:-1])
    rests = [after[:1], before[-1:]] if order == 0 else [0.0 * after[:1], 0.0 * before[-1:]]
    sizes = np.concatenate([after, rests[1]]) - np.concatenate([rests[0], before])
    gaps = np.diff(knots)
    within = motion.derivative((knots[:-1, None] + gaps[:, None] * INSIDE).ravel(), order)
    largest = np.abs(np.concatenate([after, before, within])).max(axis=0)
    return knots, np.maximum(np.insert(gaps, 0, gaps[0]), np.append(gaps, gaps[-1])), sizes, largest


def _of_any(trajectory: Trajectory, order: int) -> tuple[Floats, Floats, Floats, Floats]:
    """The same, by values beside the places at two distances."""
    least = CLOSEST * trajectory.duration
    begin, end = _clusters(_places(trajectory, order), least)
    gaps = begin[1:] - end[:-1]
    left, right = np.insert(gaps, 0, gaps[:1]), np.append(gaps, gaps[-1:])
    if not len(gaps):
        return begin[:0], begin[:0], np.zeros((0, trajectory.n)), np.zeros(trajectory.n)
    h = np.maximum(NEAR * np.minimum(left, right), least)
    once, twice = (
        derivative(trajectory, end + k * h, order) - derivative(trajectory, begin - k * h, order) for k in (1.0, 2.0)
    )
    samples = derivative(trajectory, np.linspace(0.0, trajectory.duration, 257), order)
    return begin, np.maximum(left, right), 2.0 * once - twice, np.abs(samples).max(axis=0)


def _places(trajectory: Trajectory, order: int) -> Floats:
    """Times at which a derivative may jump: breaks, and where values leap between two neighbouring times."""
    breaks = trajectory.breaks()
    if order == 3 or len(breaks) < 2:
        return breaks
    inner = np.linspace(0.0, trajectory.duration, SCANNED + 1)[1:-1]
    t = np.unique(np.concatenate([breaks, inner]))
    beside = NEAR * np.diff(t) * np.isin(t[:-1], breaks), NEAR * np.diff(t) * np.isin(t[1:], breaks)
    return np.unique(np.concatenate([breaks, _leaps(trajectory, t[:-1] + beside[0], t[1:] - beside[1], order)]))


def _leaps(trajectory: Trajectory, low: Floats, high: Floats, order: int) -> Floats:
    """Times in the intervals from `low` to `high` at which a derivative changes as its own derivative does not say.

    |f(b) - f(a) - (b - a) (f'(a) + 4 f'(m) + f'(b))/6| shrinks with the interval unless f jumps in it.
    """
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        halves = [_residual(trajectory, a, b, order) for a, b in ((low, middle), (middle, high))]
        largest = max(1.0 if order == 0 else 0.0, *(half[1] for half in halves))
        first = halves[0][0] >= halves[1][0]
        suspect = np.maximum(halves[0][0], halves[1][0]) > 0.5 * JUMP * largest
        low, high = np.where(first, low, middle)[suspect], np.where(first, middle, high)[suspect]
        if not len(low):
            return low
    return (low + high) / 2


def _residual(trajectory: Trajectory, a: Floats, b: Floats, order: int) -> tuple[Floats, float]:
    """(k,) the largest of all coordinates over each interval; and the largest value of the derivative."""
    f = [derivative(trajectory, x, order) for x in (a, b)]
    slopes = [derivative(trajectory, x, order + 1) for x in (a, (a + b) / 2, b)]
    rise = (b - a)[:, None] * (slopes[0] + 4.0 * slopes[1] + slopes[2]) / 6.0
    return np.abs(f[1] - f[0] - rise).max(axis=1, initial=0.0), float(np.abs(f[0]).max(initial=0.0))


def _clusters(t: Floats, least: float) -> tuple[Floats, Floats]:
    """First and last time of each group of times that are as good as one."""
    split = np.flatnonzero(np.diff(t) > 8.0 * least) + 1
    return t[np.insert(split, 0, 0)], t[np.append(split, len(t)) - 1]
