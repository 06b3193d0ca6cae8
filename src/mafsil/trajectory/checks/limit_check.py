"""Holding a trajectory against limits: which joint exceeds what, when, and by how much."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mafsil.answer import Answer
from mafsil.arrays import Floats, not_negative
from mafsil.messages import say
from mafsil.model.limits import MEASURED
from mafsil.trajectory.checks.requirements import jumps
from mafsil.trajectory.motion import LimitStatus, Trajectory, derivative
from mafsil.trajectory.motion_limits import Limits, MotionLimits, motion_limits
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.tolerances import GIVEN

SAMPLES_PER_PIECE, LEAST_PER_PIECE = 128, 16
"""Times in a piece that is no polynomial: less in motions of many pieces, which are the simpler."""
PLATEAU = 1e-9
"""Share of the largest value by which neighbours differ at least where a peak is looked for between them."""
HIGH = 0.99
"""Share of the largest value from which on an extreme is looked at closely."""
ROUNDS = 3
"""Of looking closely."""
MOST_SAMPLES = 8192
"""In all pieces, where there are not too many of them."""

JUMPING = ("position", "velocity", "acceleration")
"""Derivatives of which a finite limit of a higher one asks that they are continuous."""

QUANTITIES = (("lower", "upper"), ("velocity", "velocity"), ("acceleration", "acceleration"), ("jerk", "jerk"))
"""What the lower and upper bounds of each derivative are called."""


@dataclass(frozen=True, slots=True)
class Violation:
    """One limit that a trajectory exceeds, at the time where it does so most.

    Attributes:
        joint: name, or index if there are no names.
        quantity: `lower`, `upper`, `velocity`, `acceleration` or `jerk`.
        time: [s].
        value: the coordinate's value or derivative there.
        limit: what was allowed in that direction: negative for a velocity that is too negative.
        jump: of the derivative below, where it is not continuous; then the value is infinite. Else zero.
        jumping: what jumps: `position`, `velocity` or `acceleration`; else nothing.
    """

    joint: str
    quantity: str
    time: float
    value: float
    limit: float
    jump: float = 0.0
    jumping: str = ""

    def quantity_name(self, language: str | None = None) -> str:
        """The quantity in words."""
        return say(f"trajectory.{self.quantity}", language=language)

    def explain(self, language: str | None = None) -> str:
        """The violation as a sentence."""
        quantity = self.quantity_name(language)
        details = {"joint": self.joint, "time": self.time, "value": self.value, "limit": self.limit}
        if self.jumping:
            what = say(f"trajectory.{'upper' if self.jumping == 'position' else self.jumping}", language=language)
            return say(
                "trajectory.jump_exceeds", language=language, quantity=quantity, jumping=what, jump=self.jump, **details
            )
        return say("trajectory.exceeded", language=language, quantity=quantity, **details)


@dataclass(frozen=True, slots=True, repr=False)
class LimitCheck(Answer, data="violations unchecked", entries="violations"):
    """True if the trajectory keeps every limit; iterable over the violations.

    Attributes:
        violations: one for each limit that is exceeded, at its worst.
        unchecked: what no limit was given of, such as the jerk.
    """

    violations: tuple[Violation, ...]
    unchecked: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return not self.violations

    @property
    def status(self) -> LimitStatus:
        """Whether every limit is kept."""
        return LimitStatus.EXCEEDED if self.violations else LimitStatus.KEPT

    def explain(self, language: str | None = None) -> str:
        """One line per violation, or a sentence that there is none; and what was not checked for lack of a limit."""
        if not self.violations:
            return self.status.sentence(language) + not_checked(self.unchecked, language)
        return "\n".join(violation.explain(language) for violation in self.violations)


def not_checked(quantities: tuple[str, ...], language: str | None = None) -> str:
    """The end of a sentence about limits: what none was given of; nothing if all were.

    Args:
        quantities: their names.
        language: of the words.
    """
    if not quantities:
        return ""
    words = (say(f"trajectory.{'upper' if each == 'position' else each}", language=language) for each in quantities)
    return say("trajectory.not_checked", language=language, quantities=", ".join(words))


def check(
    trajectory: Trajectory,
    limits: Limits,
    names: tuple[str, ...] = (),
    *,
    tolerance: float = GIVEN,
    ends: bool = True,
) -> LimitCheck:
    """Hold a trajectory against the limits of its joints.

    Piecewise polynomials are checked at the exact extremes; others are sampled between their breaks and refined
    around the largest samples. A finite limit of derivative k asks that all below it are continuous: a jump of the
    velocity exceeds every finite limit of acceleration and of jerk.

    Args:
        trajectory: of n coordinates, without batch dimensions.
        limits: of a robot, or bounds of n coordinates; infinite ones are not checked, those of effort neither.
        names: (n,) of the joints, for the sentences.
        tolerance: excess that is still allowed, relative to max(1, limit); of positions at least `MEASURED` [rad | m].
        ends: whether jumps from rest at the start and into rest at the end count; False for a part of a longer motion.

    Raises:
        InputError: limits of another number of coordinates.
    """
    tolerance = not_negative("tolerance", tolerance)
    labels = names or tuple(str(i) for i in range(trajectory.n))
    bounds = motion_limits(limits, trajectory.n)
    derivatives = (bounds.position, bounds.velocity, bounds.acceleration, bounds.jerk)
    found: list[tuple[float, Violation]] = [(abs(v.jump), v) for v in jumps_over(trajectory, bounds, labels, ends=ends)]
    jumped = {(violation.joint, violation.quantity) for _, violation in found}
    for order, sides in enumerate(derivatives):
        if not np.isfinite(sides).any():
            continue
        moments, values = extremes(trajectory, order)
        for sign, bound in ((-1.0, sides[0]), (1.0, sides[1])):
            at = (sign * values).argmax(axis=0)
            reached = np.take_along_axis(values, at[None], axis=0)[0]
            excess = sign * (reached - bound)
            size = np.maximum(1.0, np.where(np.isfinite(bound), np.abs(bound), 0.0))
            allowed = np.maximum(tolerance * size, MEASURED) if order == 0 else tolerance * size
            for joint in np.flatnonzero(excess > allowed):
                quantity = QUANTITIES[order][int(sign > 0)]
                place = (float(moments[at[joint]]), float(reached[joint]), float(bound[joint]))
                if (labels[joint], quantity) not in jumped:
                    found.append((float(excess[joint]), Violation(labels[joint], quantity, *place)))
    return LimitCheck(worst_of_each(found), bounds.unbounded)


def jumps_over(
    trajectory: Trajectory, bounds: MotionLimits, labels: tuple[str, ...], *, ends: bool = True
) -> list[Violation]:
    """Jumps that no finite limit of a higher derivative allows: of each joint the lowest that jumps.

    Args:
        trajectory: of n coordinates.
        bounds: of them.
        labels: (n,) names of the joints.
        ends: whether start and end count, before and after which it rests.
    """
    derivatives = (bounds.velocity, bounds.acceleration, bounds.jerk)
    finite = np.array([np.isfinite(sides).any(axis=0) for sides in derivatives])
    found: list[Violation] = []
    done = np.zeros(bounds.n, dtype=bool)
    for order, jumping in enumerate(JUMPING):
        if not (finite[order:].any(axis=0) & ~done).any():
            continue
        leaps = [leap for leap in jumps(trajectory, order, ends=ends) if not done[leap.coordinate]]
        for leap in leaps:
            joint, side = leap.coordinate, int(leap.size > 0.0)
            done[joint] = True
            for k in np.flatnonzero(finite[order:, joint]) + order:
                limit, value = float(derivatives[k][side, joint]), math.copysign(np.inf, leap.size)
                place = (labels[joint], QUANTITIES[k + 1][0], leap.time, value, limit)
                found.append(Violation(*place, jump=leap.size, jumping=jumping))
    return found


def worst_of_each(found: list[tuple[float, Violation]]) -> tuple[Violation, ...]:
    """One violation for each joint and quantity: a limit that is exceeded in both directions is named once."""
    worst: dict[tuple[str, str], tuple[float, Violation]] = {}
    for excess, violation in found:
        key = (violation.joint, violation.quantity)
        if key not in worst or excess > worst[key][0]:
            worst[key] = (excess, violation)
    return tuple(violation for _, violation in worst.values())


def extremes(trajectory: Trajectory, order: int) -> tuple[Floats, Floats]:
    """Times (k,) [s] among which every coordinate's derivative takes its extremes, and its values (k, n) there.

    Piecewise polynomials have roots for that. Of others:

    1. Times between breaks, evenly spaced, are looked at.
    2. Around the largest and the smallest, and at the vertex of every high extreme, are more times.
    3. 2 is repeated.

    Args:
        trajectory: of n coordinates.
        order: of the derivative, 0 to 3.
    """
    breaks = trajectory.breaks()
    # Values jump at breaks: the moment just before belongs to the piece that ends there.
    sides = np.concatenate([breaks, np.nextafter(breaks[1:], 0.0)])
    if isinstance(trajectory, PiecewisePolynomial):
        moments = np.unique(np.concatenate([sides, trajectory.stationary_times(order)]))
        return moments, derivative(trajectory, moments, order)
    # 1.
    samples = max(MOST_SAMPLES // max(len(breaks) - 1, 1), LEAST_PER_PIECE)
    moments = np.unique(np.concatenate([sides, _within(breaks, min(samples, SAMPLES_PER_PIECE))]))
    values = derivative(trajectory, moments, order)
    # 3.
    for _ in range(ROUNDS):
        # 2.
        peaks = np.unique([values.argmax(axis=0), values.argmin(axis=0)])
        last = len(moments) - 1
        near = [_between(float(moments[max(k - 1, 0)]), float(moments[min(k + 1, last)])) for k in peaks]
        added = np.setdiff1d(np.concatenate([*near, _vertices(moments, values)]), moments)
        places = np.searchsorted(moments, added)
        values = np.insert(values, places, derivative(trajectory, added, order), axis=0)
        moments = np.insert(moments, places, added)
    return moments, values


def _vertices(t: Floats, values: Floats) -> Floats:
    """Vertices of parabolas through each three neighbours among which a high extreme lies, of any coordinate.

    Motions near their limits have many extremes that are nearly equal: the largest sample need not be next to the
    largest of them.

    Args:
        t: (k,) times, increasing.
        values: (k, n).
    """
    if len(t) < 3:
        return t[:0]
    before, here, after = values[:-2], values[1:-1], values[2:]
    most, least = values.max(axis=0), values.min(axis=0)
    high = (here >= most - (1.0 - HIGH) * np.abs(most)) | (here <= least + (1.0 - HIGH) * np.abs(least))
    # Next to a break, which is there twice, no parabola says where the peak is: places are added beside it.
    steps = np.diff(t)
    beside = np.flatnonzero(
        high.any(axis=1) & (np.minimum(steps[:-1], steps[1:]) < 1e-6 * np.maximum(steps[:-1], steps[1:]))
    )
    wide = np.where(steps[beside] > steps[beside + 1], beside, beside + 1)
    added = (t[wide, None] + np.array([0.05, 0.2, 0.5, 0.8, 0.95]) * steps[wide, None]).ravel()
    # Noise on a plateau has no vertices: a parabola is at most that much higher than its middle.
    turns = (here - before) * (after - here) <= 0.0
    swing = np.maximum(np.abs(here - before), np.abs(after - here))
    row, column = np.nonzero(high & turns & (swing > PLATEAU * np.maximum(np.abs(most), np.abs(least))))
    h, g = t[row + 1] - t[row], t[row + 2] - t[row + 1]
    rise, fall = here[row, column] - before[row, column], after[row, column] - here[row, column]
    bend = fall / g - rise / h
    slope = (rise / h * g + fall / g * h) / (h + g)
    flat = bend == 0.0
    shift = np.where(flat, 0.0, -0.5 * slope * (h + g) / np.where(flat, 1.0, bend))
    return np.concatenate([added, np.clip(t[row + 1] + shift, t[row], t[row + 2])])


def _within(breaks: Floats, samples: int) -> Floats:
    """Evenly spaced times in every piece."""
    return (breaks[:-1, None] + np.arange(samples) / samples * np.diff(breaks)[:, None]).ravel()


def _between(begin: float, end: float) -> Floats:
    """Evenly spaced times."""
    return np.linspace(begin, end, SAMPLES_PER_PIECE, endpoint=False)
