"""The shortest time along a path: the motion, what limits it where, or why there is none."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from mafsil.answer import Answer, SingleAnswer
from mafsil.arrays import Floats, frozen
from mafsil.messages import say
from mafsil.messages.tables import number, table
from mafsil.trajectory.motion_limits import MotionLimits
from mafsil.trajectory.path import JointPath
from mafsil.trajectory.path_motion import PathMotion
from mafsil.trajectory.piecewise import PiecewisePolynomial
from mafsil.trajectory.sampled_limits import SampledLimit
from mafsil.trajectory.sampled_timing import timed_within
from mafsil.trajectory.timing_problem import Timing, TimingProblem, solved
from mafsil.trajectory.timing_status import TimingStatus

LOOKS = (1e-6, 0.5, 1.0 - 1e-6)
"""Shares of an interval at which is looked which limit decides."""


class Binding(NamedTuple):
    """A stretch of time in which one limit decides how fast the path is passed.

    Attributes:
        begin, end: [s].
        joint: index of the joint; -1 for limits of the tip.
        quantity: `velocity`, `acceleration`, `effort`, `tip_speed` or `tip_acceleration`.
        share: the largest share of the limit that is used there.
    """

    begin: float
    end: float
    joint: int
    quantity: str
    share: float


class Gain(NamedTuple):
    """What a greater limit would save.

    Attributes:
        joint: index of the joint; -1 for limits of the tip.
        quantity: as in `Binding`.
        seconds: saved by one per cent more of the limit, in both directions [s].
    """

    joint: int
    quantity: str
    seconds: float


@dataclass(frozen=True, eq=False, repr=False)
class TimeOptimal(SingleAnswer):
    """The shortest time along a path within limits; true if there is one.

    Attributes:
        status: how it ended.
        path: what was timed.
        limits: what was kept.
        timing: grid, squared path velocities and reachable sets.
        details: what the sentence of the status mentions.
        sampled: limits of effort and of the tip that were kept too.
        velocities_at_ends: ds/dt that was asked for at the start and at the end.
    """

    status: TimingStatus
    path: JointPath
    limits: MotionLimits
    timing: Timing
    details: Mapping[str, object] = field(default_factory=dict[str, object])
    sampled: tuple[SampledLimit, ...] = ()
    velocities_at_ends: tuple[float, float] = (0.0, 0.0)

    @property
    def duration(self) -> float:
        """[s]; infinite where there is no timing."""
        return self.timing.duration if self else np.inf

    @property
    def excess(self) -> float:
        """The largest excess over any limit at any time, as share of the limit, rounding included."""
        return self.timing.excess

    @property
    def velocities(self) -> Floats:
        """(places, 2) path parameter s and path velocity ds/dt on the grid; between its places (ds/dt)^2 is linear."""
        return np.stack([self.timing.s, np.sqrt(np.maximum(self.timing.x, 0.0))], axis=1)

    @property
    def limit_curve(self) -> Floats:
        """(places, 2) s and the largest ds/dt from which the end can still be reached."""
        return np.stack([self.timing.s, np.sqrt(np.maximum(self.timing.high, 0.0))], axis=1)

    @cached_property
    def trajectory(self) -> PathMotion | None:
        """The motion; None where there is none."""
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
        first = self.status.sentence(language, **self.details)
        lines = (
            [first]
            if not np.isfinite(self.limits.jerk).any()
            else [first, say("trajectory.jerk_ignored", language=language)]
        )
        if not self.bindings:
            return "\n".join(lines)
        head = [
            say(f"trajectory.column_{name}", language=language) for name in ("binding", "coordinate", "time", "share")
        ]
        return "\n".join([*lines, *table(head, _rows(self, language), language)])

    def to_dict(self) -> dict[str, Any]:
        """Plain data: status, duration, excess, velocities on the grid, bindings, details."""
        return {
            "status": self.status.name,
            "duration": self.duration,
            "excess": self.excess,
            "velocities": self.velocities,
            "bindings": [binding._asdict() for binding in self.bindings],
            "details": dict(self.details),
        }


class TimeOptimalBatch(Answer):
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

    def __repr__(self) -> str:
        return self.explain()

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

    def to_dict(self) -> dict[str, Any]:
        """Plain data of each path."""
        return {"answers": [answer.to_dict() for answer in self.answers]}


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


def shares_of(answer: TimeOptimal) -> tuple[Floats, list[tuple[int, str]], Floats]:
    """Largest shares of all limits (intervals, k), what each column means, and the durations (intervals,) [s]."""
    timing, limits, n = answer.timing, answer.limits, answer.path.n
    h = np.diff(timing.s)
    growth = np.diff(timing.x) / (2.0 * h)
    labels = [(j, quantity) for quantity in ("velocity", "acceleration") for j in range(n)]
    labels += [limit.label(k) for limit in answer.sampled for k in range(len(limit.scale()))]
    shares = np.zeros((len(h), len(labels)))
    for r in LOOKS:
        here = answer.path.at(timing.s[:-1] + r * h)
        square = (1.0 - r) * timing.x[:-1] + r * timing.x[1:]
        v, a = here.slope * np.sqrt(square)[:, None], here.curvature * square[:, None] + here.slope * growth[:, None]
        columns = [_shares(v, limits.velocity), _shares(a, limits.acceleration)]
        columns += [limit.excess(here, square, growth) + 1.0 for limit in answer.sampled]
        shares = np.maximum(shares, np.concatenate(columns, axis=1))
    return shares, labels, 2.0 * h / (np.sqrt(timing.x[:-1]) + np.sqrt(timing.x[1:]))


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
    start, end = (np.array([v]) for v in answer.velocities_at_ends)
    limits, places = answer.limits, max(len(answer.timing.s) - 1, 1)
    given = (limits.velocity, limits.acceleration, answer.sampled)
    decisive = sorted({(binding.joint, binding.quantity) for binding in answer.bindings})
    seconds: list[float] = []
    for velocity, acceleration, sampled in (given, *(_raised(given, joint, quantity) for joint, quantity in decisive)):
        problem = TimingProblem([answer.path], velocity[None], acceleration[None], start, end, places)
        timing = timed_within(problem, sampled) if sampled else solved(problem)[0]
        seconds.append(timing.duration)
    found = [Gain(*which, seconds[0] - less) for which, less in zip(decisive, seconds[1:], strict=True)]
    return tuple(sorted(found, key=lambda gain: -gain.seconds))


def _raised(
    given: tuple[Floats, Floats, tuple[SampledLimit, ...]], joint: int, quantity: str
) -> tuple[Floats, Floats, tuple[SampledLimit, ...]]:
    """Limits of which one is one per cent more."""
    velocity, acceleration, sampled = given[0].copy(), given[1].copy(), given[2]
    if quantity == "velocity":
        velocity[:, joint] *= 1.01
    elif quantity == "acceleration":
        acceleration[:, joint] *= 1.01
    else:
        sampled = tuple(limit.raised(joint, quantity, 1.01) for limit in sampled)
    return velocity, acceleration, sampled


def _shares(value: Floats, bound: Floats) -> Floats:
    """Of the limit in the direction of each value."""
    size: Floats = np.where(value >= 0.0, bound[1:2], -bound[0:1]).astype(np.float64)
    return np.divide(np.abs(value), size, out=np.zeros_like(value), where=size > 0.0)


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
