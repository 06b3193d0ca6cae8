"""The protocol of all trajectories: position, velocity, acceleration over a duration; printing; statuses of plans."""

from __future__ import annotations

from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Status
from mafsil.arrays import Floats, real_array, require_finite
from mafsil.messages import say
from mafsil.messages.tables import in_notebook, joint_units, number, table


class Motion(NamedTuple):
    """Position, velocity and acceleration of all coordinates at one or many times.

    Attributes:
        u: (*times, *batch, n) position [rad | m | 1].
        v: the same shape, du/dt.
        a: the same shape, d2u/dt2.
    """

    u: Floats
    v: Floats
    a: Floats


@runtime_checkable
class Trajectory(Protocol):
    """A motion of n coordinates over the time 0 .. duration; before and after it rests at its ends."""

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        ...

    @property
    def n(self) -> int:
        """Number of coordinates."""
        ...

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration at the times `t` (*times) [s]; at rest outside 0 .. duration."""
        ...

    def jerk(self, t: ArrayLike) -> Floats:
        """(*times, *batch, n) third derivative at the times `t` [rad/s^3 | m/s^3]."""
        ...

    def breaks(self) -> Floats:
        """(k + 1,) times between which the motion is smooth, 0 and the duration included [s]."""
        ...


@runtime_checkable
@runtime_checkable
class Stretchable(Trajectory, Protocol):
    """A trajectory that can be run slower or faster on the same path."""

    def scale_time(self, factor: float) -> Stretchable:
        """The same path, `factor` times as slow."""
        ...


def derivative(trajectory: Trajectory, t: Floats, order: int) -> Floats:
    """A derivative of a trajectory.

    Args:
        trajectory: of n coordinates.
        t: (k,) times [s].
        order: 0 to 3, position to jerk.

    Returns:
        (k, n) [rad | m] and time derivatives.
    """
    return trajectory.jerk(t) if order == 3 else trajectory.at(t)[order]


def times(t: ArrayLike) -> Floats:
    """Times as a finite float64 array.

    Raises:
        InputError: not real numbers, or a NaN or infinity.
    """
    return require_finite("t", real_array("t", t))


def moving_at(t: Floats, duration: float, trailing: int) -> Floats:
    """Whether a trajectory moves: 1 inside 0 .. duration and 0 outside.

    Args:
        t: (*times) [s].
        duration: of the trajectory [s].
        trailing: number of axes of length one that are appended.
    """
    inside = ((t >= 0.0) & (t <= duration)).astype(np.float64)
    return inside.reshape(t.shape + (1,) * trailing)


SAMPLES = 4001
"""Times at which peaks are looked for: a peak between two of them is missed by less than its fourth digit."""
MOST_BREAKS = 20_000
"""Breaks beyond these are not looked at one by one."""
COLUMNS = ("coordinate", "start", "end", "velocity", "acceleration", "jerk")


def overview(trajectory: Trajectory, names: tuple[str, ...] = (), language: str | None = None) -> str:
    """A sentence and a table: one row for each coordinate, in its own units and seconds.

    Args:
        trajectory: any; of a batch the largest values are shown.
        names: (n,) of the coordinates; their indices if empty.
        language: `en` or `ar`; the current one if None.
    """
    t = _times(trajectory)
    motion = trajectory.at(t)
    start, end = (motion.u[k].reshape(-1, trajectory.n) for k in (0, -1))
    peaks = [_peaks(x, trajectory.n) for x in (motion.v, motion.a, trajectory.jerk(t))]
    labels = names or tuple(str(k) for k in range(trajectory.n))
    rows = [
        [label, *(number(float(x)) for x in row)]
        for label, *row in zip(labels, _largest(start), _largest(end), *peaks, strict=True)
    ]
    details = {"n": trajectory.n, "duration": trajectory.duration, "pieces": max(len(trajectory.breaks()) - 1, 0)}
    if len(start) == 1:
        title = say("trajectory.overview", language=language, **details)
    else:
        title = say("trajectory.overview_batch", language=language, count=len(start), **details)
    head = [say(f"trajectory.column_{name}", language=language) for name in COLUMNS]
    return "\n".join([title, *table(head, rows, language, joint_units(COLUMNS))])


class Printed:
    """A trajectory that shows its overview when it is printed, in notebooks too."""

    __slots__ = ()

    def __repr__(self: Trajectory) -> str:
        return overview(self)

    def _repr_html_(self: Trajectory) -> str:
        return in_notebook(overview(self))


def _times(trajectory: Trajectory) -> Floats:
    """From 0 to the duration; both sides of breaks, where derivatives jump."""
    breaks = trajectory.breaks()[:MOST_BREAKS]
    even = np.linspace(0.0, trajectory.duration, SAMPLES)
    before = np.maximum(np.nextafter(breaks, -1.0), 0.0)
    return np.unique(np.concatenate([even, breaks, before]))


def _peaks(values: Floats, n: int) -> Floats:
    """(n,) largest magnitudes of values (times, *batch, n)."""
    return np.abs(values).reshape(-1, n).max(axis=0, initial=0.0)


def _largest(values: Floats) -> Floats:
    """(n,) of values (batch, n) those of largest magnitude, with their sign."""
    return np.take_along_axis(values, np.abs(values).argmax(axis=0)[None], axis=0)[0] if len(values) else values


class PlanStatus(Status):
    """How planning a trajectory ended."""

    PLANNED = ("trajectory.planned", True)
    FOLLOWED = ("trajectory.followed", True)
    STRETCHED = ("trajectory.stretched", True)
    TOO_SHORT = ("trajectory.too_short", False)
    NOT_FOUND = ("trajectory.not_followed", False)
    ORIENTATION_NOT_FOUND = ("trajectory.orientation_not_followed", False)
    SINGULAR = ("trajectory.singular", False)
    JOINT_LIMIT = ("trajectory.joint_limit", False)
    DEVIATES = ("trajectory.deviates", False)
    RATE_LIMIT = ("trajectory.rate_limit", False)
    VELOCITY_JUMPS = ("trajectory.velocity_jumps", False)


class ComparisonStatus(Status):
    """Whether one of the profiles that are compared keeps all limits."""

    COMPARED = ("trajectory.compared", True)
    TOO_WEAK = ("trajectory.compared_weak", False)
    NONE_KEEPS = ("trajectory.compared_none_keeps", False)


class LimitStatus(Status):
    """Whether a trajectory keeps the limits of its joints."""

    KEPT = ("trajectory.within_limits", True)
    EXCEEDED = ("trajectory.exceeded", False)


class BlendStatus(Status):
    """Whether straight lines hold their blends."""

    PLANNED = ("trajectory.planned", True)
    TOO_SHORT_TO_BLEND = ("trajectory.too_short_to_blend", False)
    BLENDS_OVERLAP = ("trajectory.blends_overlap", False)


class ContinuityStatus(Status):
    """Whether an arm can follow a trajectory as it is."""

    CONTROLLABLE = ("trajectory.controllable", True)
    NOT_CONTROLLABLE = ("trajectory.not_controllable", False)


class ViaRateStatus(Status):
    """How well joint rates at a via point make the tip's velocity."""

    EXACT = ("trajectory.rates_exact", True)
    DAMPED = ("trajectory.rates_damped", False)
    NOT_POSSIBLE = ("trajectory.rates_not_possible", False)


class ProofStatus(Status):
    """Whether a motion is proven to keep its limits."""

    PROVEN = ("trajectory.proven", True)
    EXCEEDED = ("trajectory.exceeded", False)
    IN_DOUBT = ("trajectory.in_doubt", False)


class TickStatus(Status):
    """Whether a generator keeps up with its update rate."""

    ON_TIME = ("trajectory.on_time", True)
    OVERRUN = ("trajectory.overrun", False)


class RequirementStatus(Status):
    """Whether a trajectory does what it must."""

    MET = ("trajectory.met", True)
    NOT_MET = ("trajectory.not_met", False)
