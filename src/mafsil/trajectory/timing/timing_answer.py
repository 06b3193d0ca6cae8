"""The shortest time along a path: the motion, what limits it where, or why there is none.

How the search for the shortest time along a path ended.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, frozen
from mafsil.messages import say
from mafsil.messages.tables import number, table
from mafsil.trajectory.motion_limits import MotionLimits, share_of
from mafsil.trajectory.path import JointPath, PathMotion
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.timing.jerk_timing import JerkTiming, timed_with_jerk
from mafsil.trajectory.timing.sampled_limits import SampledLimit
from mafsil.trajectory.timing.sampled_timing import ALLOWED, MOST_ROUNDS, timed_within
from mafsil.trajectory.timing.timing_problem import Timing, TimingProblem, limits_of_each, solve_timing

LOOKS = (1e-6, 0.5, 1.0 - 1e-6)
"""Shares of an interval at which is looked which limit decides."""


class Binding(NamedTuple):
    """A stretch of time in which one limit decides how fast the path is passed.

    Attributes:
        begin, end: [s].
        joint: index of the joint; -1 for limits of the tip.
        quantity: `velocity`, `acceleration`, `jerk`, `effort`, `tip_speed`, `tip_angular_speed` or `tip_acceleration`.
        share: the largest share of the limit that is used there.
    """

    begin: float
    end: float
    joint: int
    quantity: str
    share: float


class Gain(NamedTuple):
    """The time that a greater limit would save.

    Attributes:
        joint: index of the joint; -1 for limits of the tip.
        quantity: as in `Binding`.
        seconds: saved by one per cent more of the limit, in both directions [s].
    """

    joint: int
    quantity: str
    seconds: float


@dataclass(frozen=True, eq=False, repr=False)
class TimeOptimal(Answer, data="duration excess velocities bindings details"):
    """The shortest time along a path within limits; true if there is one.

    Attributes:
        status: how it ended.
        path: what was timed.
        limits: what was kept.
        timing: grid, squared path velocities and reachable sets.
        details: what the sentence of the status mentions.
        sampled: limits of effort and of the tip that were kept too.
        velocities_at_ends: ds/dt that was asked for at the start and at the end.
        smooth: the motion if the jerk is limited; `timing` is then the one without limits of jerk.
    """

    status: TimingStatus
    path: JointPath
    limits: MotionLimits
    timing: Timing
    details: Mapping[str, object] = field(default_factory=dict[str, object])
    sampled: tuple[SampledLimit, ...] = ()
    velocities_at_ends: tuple[float, float] = (0.0, 0.0)
    smooth: JerkTiming | None = None

    @property
    def duration(self) -> float:
        """[s]; infinite where there is no timing."""
        if not self:
            return np.inf
        return self.smooth.motion.duration if self.smooth else self.timing.duration

    @property
    def excess(self) -> float:
        """The largest excess over any limit at any time, as share of the limit, rounding included."""
        return self.smooth.excess if self.smooth else self.timing.excess

    @property
    def velocities(self) -> Floats:
        """(places, 2) path parameter s and path velocity ds/dt on the grid.

        Between its places (ds/dt)^2 is linear in s; with limited jerk s is a quintic in time.
        """
        if self.smooth:
            s, rate, _ = self.smooth.motion.law.at(self.smooth.motion.law.breaks())
            return np.concatenate([s, rate], axis=1)
        return np.stack([self.timing.s, np.sqrt(np.maximum(self.timing.x, 0.0))], axis=1)

    @property
    def limit_curve(self) -> Floats:
        """(places, 2) s and the largest ds/dt from which the end can still be reached."""
        return np.stack([self.timing.s, np.sqrt(np.maximum(self.timing.high, 0.0))], axis=1)

    @cached_property
    def trajectory(self) -> PathMotion | None:
        """The motion; None where there is none."""
        if self.smooth:
            return self.smooth.motion
        return motion_on(self.path, self.timing) if self else None

    @cached_property
    def bindings(self) -> tuple[Binding, ...]:
        """Which limit decides when, one after the other."""
        return bindings_of(self) if self and self.duration > 0.0 else ()

    def gains(self) -> tuple[Gain, ...]:
        """What one per cent more of each limit that decides somewhere would save, the most first; solved anew for each.

        Differences of two timings on one even grid; those of efforts and of the tip carry the roundoff of repeated
        tightening, about 1e-5 of the duration.
        """
        return gains_of(self) if self.bindings else ()

    def explain(self, language: str | None = None) -> str:
        """The sentence of the status; with a motion, a table of what limits it."""
        lines = [self.status.sentence(language, **self.details)]
        if not self.bindings:
            return "\n".join(lines)
        head = [
            say(f"trajectory.column_{name}", language=language) for name in ("binding", "coordinate", "time", "share")
        ]
        return "\n".join([*lines, *table(head, _rows(self, language), language)])


class TimeOptimalBatch(Answer, data="answers"):
    """The shortest times along many paths; true if each has one; indexed by the path.

    Args:
        count: of paths.
        answer: makes the answer of one of them; asked when it is first looked at.
        durations: (count,) [s]; None to take them from the answers.
    """

    def __init__(self, count: int, answer: Callable[[int], TimeOptimal], durations: Floats | None = None) -> None:
        self._answers: list[TimeOptimal | None] = [None] * count
        self._answer = answer
        self._durations = durations

    def __bool__(self) -> bool:
        return all(self)

    def __len__(self) -> int:
        return len(self._answers)

    def __iter__(self) -> Iterator[TimeOptimal]:
        return (self[k] for k in range(len(self)))

    def __getitem__(self, index: int) -> TimeOptimal:
        known = self._answers[index]
        if known is None:
            known = self._answers[index] = self._answer(index % len(self))
        return known

    @property
    def answers(self) -> tuple[TimeOptimal, ...]:
        """One for each path."""
        return tuple(self)

    @property
    def status(self) -> tuple[TimingStatus, ...]:
        """Of each path."""
        return tuple(answer.status for answer in self.answers)

    @property
    def durations(self) -> Floats:
        """(paths,) [s]; infinite where there is no timing."""
        if self._durations is None:
            self._durations = frozen([answer.duration for answer in self])
        return self._durations

    def explain(self, language: str | None = None) -> str:
        """How many paths have a timing, and the first that has none with its reason."""
        timed = [answer.duration for answer in self.answers if answer]
        shortest, longest = (min(timed), max(timed)) if timed else (np.nan, np.nan)
        details = {"count": len(self), "timed": len(timed), "shortest": shortest, "longest": longest}
        lines = [say("trajectory.timed_batch", language=language, **details)]
        lines += [f"{k}: " + answer.explain(language) for k, answer in enumerate(self.answers) if not answer][:10]
        return "\n".join(lines)


def motion_on(path: JointPath, timing: Timing) -> PathMotion:
    """The motion whose squared path velocity is linear between the places of the grid.

    s = s_i + sqrt(x_i) t + u_i t^2/2  with  u_i = (x_{i+1} - x_i)/(2 h_i),  for  2 h_i/(sqrt(x_i) + sqrt(x_{i+1})).
    """
    if timing.duration == 0.0:
        law = PiecewisePolynomial(frozen([0.0, 0.0]), frozen(np.zeros((1, 1, 1))))
        return PathMotion(path.curve, law)
    h, rate = np.diff(timing.s), np.sqrt(timing.x)
    growth = np.diff(timing.x) / (2.0 * h)
    rows = np.stack([timing.s[:-1], rate[:-1], growth / 2.0], axis=1)[..., None]
    law = PiecewisePolynomial.from_pieces(2.0 * h / (rate[:-1] + rate[1:]), rows)
    return PathMotion(path.curve, law, frozen(timing.s))


def with_jerk(answer: TimeOptimal) -> TimeOptimal:
    """The answer when the jerk is limited, too.

    Args:
        answer: without limits of jerk, true.
    """
    if answer.timing.duration == 0.0:
        return answer
    standing = _without_jerk(answer.path, answer.limits)
    if standing is not None:
        return replace(answer, status=TimingStatus.NO_MOTION, details={"place": 0.0, "joint": standing})
    found = timed_with_jerk(answer.path, answer.limits, answer.sampled)
    if found is None:
        return replace(answer, status=TimingStatus.BLOCKED, details={"place": 0.0})
    pieces = len(found.motion.law.breaks()) - 1
    if found.excess > ALLOWED:
        details = {"excess": found.excess, "rounds": MOST_ROUNDS}
        return replace(answer, status=TimingStatus.EXCEEDED, details=details, smooth=found)
    details = {"duration": found.motion.duration, "intervals": pieces, "excess": found.excess}
    return replace(answer, details=details, smooth=found)


def _without_jerk(path: JointPath, limits: MotionLimits) -> int | None:
    """A joint that moves and whose limit of jerk is zero on one side."""
    moves = (path.curve.coefficients[:, 1:] != 0.0).any(axis=(0, 1))
    still = np.flatnonzero(moves & (limits.jerk == 0.0).any(axis=0))
    return int(still[0]) if len(still) else None


class _States(NamedTuple):
    """A motion along a path seen at one share of every interval.

    Attributes:
        s, square, growth: path parameters, squares of the path velocity, path accelerations.
        jerk: (intervals, n) of the coordinates; None where it is not limited.
    """

    s: Floats
    square: Floats
    growth: Floats
    jerk: Floats | None


def _states(answer: TimeOptimal, share: float) -> _States:
    """The motion at a share of every interval."""
    if answer.smooth:
        motion = answer.smooth.motion
        t = motion.law.breaks()[:-1] + share * np.diff(motion.law.breaks())
        s, rate, growth = (part[:, 0] for part in motion.law.at(t))
        return _States(s, rate**2, growth, motion.jerk(t))
    timing = answer.timing
    h = np.diff(timing.s)
    square = (1.0 - share) * timing.x[:-1] + share * timing.x[1:]
    return _States(timing.s[:-1] + share * h, square, np.diff(timing.x) / (2.0 * h), None)


def shares_of(answer: TimeOptimal) -> tuple[Floats, list[tuple[int, str]], Floats]:
    """Largest shares of all limits (intervals, k), what each column means, and the durations (intervals,) [s]."""
    timing, limits, n = answer.timing, answer.limits, answer.path.n
    if answer.smooth:
        lengths = np.diff(answer.smooth.motion.law.breaks())
    else:
        lengths = 2.0 * np.diff(timing.s) / (np.sqrt(timing.x[:-1]) + np.sqrt(timing.x[1:]))
    quantities = ("velocity", "acceleration", "jerk") if answer.smooth else ("velocity", "acceleration")
    labels = [(j, quantity) for quantity in quantities for j in range(n)]
    labels += [limit.label(k) for limit in answer.sampled for k in range(len(limit.scale()))]
    shares = np.zeros((len(lengths), len(labels)))
    for r in LOOKS:
        now = _states(answer, r)
        here, square, growth = answer.path.at(now.s), now.square, now.growth
        v, a = here.slope * np.sqrt(square)[:, None], here.curvature * square[:, None] + here.slope * growth[:, None]
        columns = [share_of(v, limits.velocity), share_of(a, limits.acceleration)]
        columns += [] if now.jerk is None else [share_of(now.jerk, limits.jerk)]
        columns += [limit.excess(here, square, growth) + 1.0 for limit in answer.sampled]
        shares = np.maximum(shares, np.concatenate(columns, axis=1))
    return shares, labels, lengths


def bindings_of(answer: TimeOptimal) -> tuple[Binding, ...]:
    """Stretches of equal largest share, one after the other."""
    shares, labels, lengths = shares_of(answer)
    which = shares.argmax(axis=1)
    edges = np.concatenate([[0.0], np.cumsum(lengths)])
    starts = np.concatenate([[0], np.flatnonzero(np.diff(which)) + 1, [len(which)]])
    return tuple(
        Binding(float(edges[a]), float(edges[b]), labels[w][0], labels[w][1], float(shares[a:b, w].max()))
        for a, b, w in ((a, b, int(which[a])) for a, b in pairwise(starts))
    )


def gains_of(answer: TimeOptimal) -> tuple[Gain, ...]:
    """As `TimeOptimal.gains` says."""
    decisive = sorted({(binding.joint, binding.quantity) for binding in answer.bindings})
    before = _duration(answer, answer.limits, answer.sampled)
    found = [Gain(*which, before - _duration(answer, *_raise(answer, *which))) for which in decisive]
    return tuple(sorted(found, key=lambda gain: -gain.seconds))


def _duration(answer: TimeOptimal, limits: MotionLimits, sampled: tuple[SampledLimit, ...]) -> float:
    """Of the motion under other limits, on an even grid [s]."""
    if answer.smooth:
        smooth = timed_with_jerk(answer.path, limits, sampled)
        return np.nan if smooth is None else smooth.motion.duration
    start, end = (np.array([v]) for v in answer.velocities_at_ends)
    places = max(len(answer.timing.s) - 1, 1)
    problem = TimingProblem([answer.path], *limits_of_each(limits, 1), start, end, places)
    return (timed_within(problem, sampled) if sampled else solve_timing(problem)[0]).duration


def _raise(answer: TimeOptimal, joint: int, quantity: str) -> tuple[MotionLimits, tuple[SampledLimit, ...]]:
    """Limits of which one is one per cent more."""
    if quantity not in ("velocity", "acceleration", "jerk"):
        return answer.limits, tuple(limit.scale_limit(joint, quantity, 1.01) for limit in answer.sampled)
    more = np.array(getattr(answer.limits, quantity))
    more[:, joint] *= 1.01
    return replace(answer.limits, **{quantity: frozen(more)}), answer.sampled


def _rows(answer: TimeOptimal, language: str | None) -> list[list[str]]:
    """One row for each limit that decides, the one that does so longest first."""
    total: dict[tuple[str, int], float] = {}
    for binding in answer.bindings:
        key = (binding.quantity, binding.joint)
        total[key] = total.get(key, 0.0) + binding.end - binding.begin
    return [
        [
            say(f"trajectory.{quantity}", language=language),
            str(joint) if joint >= 0 else "-",
            f"{number(time)} s",
            f"{100.0 * time / answer.duration:.0f} %",
        ]
        for (quantity, joint), time in sorted(total.items(), key=lambda item: -item[1])
    ]


class TimingStatus(Status):
    """Whether a path has a time law within the limits."""

    TIMED = ("trajectory.timed", True)
    POSITION = ("trajectory.path_outside", False)
    START_VELOCITY = ("trajectory.start_velocity", False)
    END_VELOCITY = ("trajectory.end_velocity", False)
    NO_REST = ("trajectory.no_rest", False)
    NO_MOTION = ("trajectory.no_motion", False)
    BLOCKED = ("trajectory.blocked", False)
    EXCEEDED = ("trajectory.between_places", False)
