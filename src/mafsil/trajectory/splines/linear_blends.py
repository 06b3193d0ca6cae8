"""Straight lines with blends through points (LSPB, linear with parabolic blends): planned, or why not.

Durations of legs that nobody gave: from default speeds or limits, raised until every leg holds its blends.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer
from mafsil.arrays import LARGEST, Floats, calculable, frozen, real_array, require_finite
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.trajectory.motion import BlendStatus
from mafsil.trajectory.motion_limits import Limits, MotionLimits, motion_limits
from mafsil.trajectory.splines.blend_plan import (
    BlendProblem,
    Blends,
    blends,
    mean_acceleration,
    with_stops,
    with_through_points,
)
from mafsil.trajectory.splines.blended_lines import (
    BlendedLines,
    BlendName,
    BlendShape,
    InfeasibleLeg,
    blend_shape,
    infeasible_legs,
)
from mafsil.trajectory.splines.cubic_spline import points_and_durations
from mafsil.trajectory.tolerances import ROUNDING

ROUNDS = 60
"""Legs are lengthened so often by what they lack; what then still overlaps is slowed as a whole."""
GROWTH = 0.25
"""By which share of itself the quickest leg grows at once."""
MUCH = (np.inf, 1.0, 0.25)
"""What share of a leg is much to lack: each is tried, and the shortest of the motions taken."""
SLOWER = 1.1
"""How much as a whole."""


@dataclass(frozen=True, eq=False, repr=False)
class BlendPlan(Answer, data="points durations acceleration blend slope straight miss infeasible"):
    """Straight lines with blends; true if every leg of every row of the batch holds its blends.

    Attributes:
        points: (*batch, m, n) corners of the lines, pseudo via points and repeated ones included [rad | m].
        durations: (m - 1,) of the legs [s].
        acceleration: (*batch, m, n) signed peak of each blend [rad/s^2 | m/s^2].
        blend: (*batch, m, n) duration of each blend [s].
        slope: (*batch, m - 1, n) velocity of each straight part [rad/s | m/s].
        straight: (*batch, m - 1, n) duration of each straight part [s]; negative where blends overlap.
        miss: (*batch, m - 2, n) u - u_k at the time of each inner point [rad | m].
        trajectory: the motion; None if a leg does not hold its blends.
        infeasible: of each row that is not feasible, the leg that lacks most.
    """

    points: Floats
    durations: Floats
    acceleration: Floats
    blend: Floats
    slope: Floats
    straight: Floats
    miss: Floats
    trajectory: BlendedLines | None
    infeasible: tuple[InfeasibleLeg, ...]

    def __bool__(self) -> bool:
        return not self.infeasible

    def __len__(self) -> int:
        return len(self.points) if self.points.ndim > 2 else 1

    def __iter__(self) -> Any:
        return iter(self.infeasible)

    @property
    def status(self) -> Any:
        """The status, a member of `BlendStatus`; of a batch an array (*batch,) of them."""
        found = np.full(self.points.shape[:-2], BlendStatus.PLANNED, dtype=np.object_)
        for leg in self.infeasible:
            found[leg.row] = leg.status
        return found if found.ndim else found[()]

    @property
    def via_times(self) -> Floats:
        """(m,) times of the points [s]."""
        return np.concatenate([[0.0], np.cumsum(self.durations)])

    def explain(self, language: str | None = None) -> str:
        """How long it takes, or what each row lacks and how much would do."""
        if self:
            return BlendStatus.PLANNED.sentence(language, duration=float(self.via_times[-1]))
        lines = [leg.explain(language) for leg in self.infeasible]
        if self.points.ndim > 2:
            count = int(np.prod(self.points.shape[:-2]))
            lines.insert(0, say("trajectory.blends_batch", language=language, bad=len(lines), count=count))
        return "\n".join(lines)


def linear_blends(
    points: ArrayLike,
    durations: ArrayLike | None = None,
    *,
    acceleration: ArrayLike | None = None,
    velocity: ArrayLike | None = None,
    limits: Limits | None = None,
    through: Mapping[int, ArrayLike | None] | None = None,
    stops: Mapping[int, float] | None = None,
    delta: float | None = None,
    common_blend: bool = False,
    blend: BlendName = "parabolic",
) -> BlendPlan:
    """Straight lines between points, joined by blends; from rest to rest.

    One blend time for all coordinates keeps several coordinates on one line: A_i = dv_i/t_k with the largest t_k.

    Args:
        points: (*batch, m, n) start, inner points and goal [rad | m]; (m,) is one coordinate. A repeated
            point is a stop.
        durations: (m - 1,) of the legs, one number for all of them; if None from `velocity`, or the velocities of
            `limits`, for the slowest coordinate, raised until every leg holds its blends [s].
        acceleration: magnitude of the blends' peaks, one number, (n,), or (m, n) for each point ((m,) if points are
            (m,)); those of `limits` if None, each direction of its own [rad/s^2 | m/s^2].
        velocity: (n,) or one number, default speeds for `durations`: |D|/velocity; not a limit [rad/s | m/s].
        limits: of the coordinates, or a robot's. They also bound the slopes where durations come from them.
        through: index of an inner point -> (n,) velocity there, or None for the mean of the slopes on both sides: the
            point is passed exactly, between two pseudo via points on a line through it.
        stops: index of an inner point -> rest there [s], 0 for an instant: the point is repeated.
        delta: time from a point of `through` to its pseudo via points; if None the shortest that holds the blends [s].
        common_blend: one blend time at each point for all coordinates.
        blend: `parabolic`, or `quintic` without acceleration at its ends and with a peak of 1.5 times the mean.

    Returns:
        The plan. If a leg does not hold its blends it is false, has no trajectory, and says how much time or
        acceleration is lacking.

    Raises:
        InputError: a wrong shape, a number that is not finite, a duration or an acceleration that is not positive, no
            finite limit where nothing is given.

    Reference: Craig, Introduction to Robotics, sec. 7.3.
    """
    first, legs = points_and_durations(points, 1.0 if durations is None else durations)
    u, flat = np.moveaxis(first, 0, -2), np.ndim(points) == 1
    calculable("points", u[np.abs(u) > LARGEST])
    bounds = None if limits is None else motion_limits(limits, u.shape[-1])
    shape = blend_shape(blend)
    sides = _magnitudes(acceleration, bounds, u, flat)
    problem = BlendProblem(u, legs, sides[0] / shape.peak, sides[1] / shape.peak, common_blend)
    if durations is None:
        problem = default_durations(problem, velocity, bounds)
    if stops:
        problem, through = with_stops(problem, stops, through)
    if through:
        problem = with_through_points(problem, through, delta)
    return _plan(problem, shape)


def _plan(problem: BlendProblem, shape: BlendShape) -> BlendPlan:
    """The answer of a problem."""
    found = blends(problem)
    lacking = infeasible_legs(problem, found, shape.peak)
    change = np.diff(found.slope, axis=-2)
    return BlendPlan(
        frozen(problem.points),
        frozen(problem.durations),
        frozen(found.acceleration * shape.peak),
        frozen(found.blend),
        frozen(found.slope),
        frozen(found.straight),
        frozen(change * found.blend[..., 1:-1, :] * shape.miss),
        None if lacking else _trajectory(problem, found, shape),
        lacking,
    )


def _trajectory(problem: BlendProblem, found: Blends, shape: BlendShape) -> BlendedLines:
    """Corners with their blends; those at the ends lie half a blend inside."""
    first = np.moveaxis(np.array([problem.points, found.blend]), -2, 1)
    legs = np.concatenate([[0.0], np.cumsum(problem.durations)])
    corners = np.broadcast_to(legs.reshape((-1,) + (1,) * (first.ndim - 2)), first.shape[1:]).copy()
    corners[0] += first[1][0] / 2
    corners[-1] -= first[1][-1] / 2
    still = np.zeros((1, *first.shape[2:]))
    slopes = np.concatenate([still, np.moveaxis(found.slope, -2, 0), still])
    return BlendedLines(frozen(legs), frozen(corners), frozen(first[0]), frozen(slopes), frozen(first[1]), shape)


def _magnitudes(
    acceleration: ArrayLike | None, limits: MotionLimits | None, u: Floats, flat: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(*batch, m, n) largest accelerations towards smaller and towards larger speeds, as magnitudes."""
    m, n = u.shape[-2:]
    if acceleration is not None:
        A = calculable("acceleration", require_finite("acceleration", real_array("acceleration", acceleration)))
        A = A[:, None] if flat and A.shape == (m,) else A
        if A.shape not in ((), (n,), (m, n)):
            raise InputError("input.shape", name="acceleration", expected=f"({n},) / ({m}, {n})", got=A.shape, hint="")
        down, up = A, A
    elif limits is not None:
        down, up = -limits.acceleration[0], limits.acceleration[1]
    else:
        raise InputError("trajectory.no_acceleration")
    for side in (down, up):
        wrong = ~((side > 0.0) & np.isfinite(side))
        if wrong.any():
            value = float(np.atleast_1d(side)[np.atleast_1d(wrong)][0])
            raise InputError("trajectory.no_acceleration_of", value=value)
    return np.broadcast_to(down, u.shape), np.broadcast_to(up, u.shape)


def default_durations(problem: BlendProblem, velocity: ArrayLike | None, limits: MotionLimits | None) -> BlendProblem:
    """The problem with durations, those of the slowest coordinate and the slowest row of a batch.

    1. |D|/V, the least time of each leg.
    2. End legs need sqrt(2 |D|/A), a leg from rest to rest 2 sqrt(|D|/A); where V is a limit, |D|/V and half a blend.
    3. Each leg is lengthened by what its blends overlap. A leg without distance lasts as long as they do: a stop.

    Args:
        problem: its durations do not count.
        velocity: (n,) or one number, default speeds [rad/s | m/s].
        limits: of the slopes.

    Raises:
        InputError: neither default speeds nor finite limits of velocity, or one that is not positive.
    """
    n = problem.points.shape[-1]
    if velocity is None and limits is None:
        raise InputError("trajectory.no_velocity")
    speed = _speeds(velocity, n)
    free = _speeds(None, n)
    hard = (free, free) if limits is None else (-limits.velocity[0], limits.velocity[1])
    D: Floats = np.diff(problem.points, axis=-2)
    top: Floats = np.where(D < 0.0, hard[0], hard[1])
    pace = np.minimum(speed, top)
    if not ((pace > 0.0) & np.isfinite(pace))[D != 0.0].all():
        raise InputError("trajectory.no_velocity")
    # 1
    way = np.abs(D)
    least = np.where(way > 0.0, way / np.where(way > 0.0, pace, 1.0), 0.0)
    # 2
    least = np.maximum(least, _with_blends(problem, D, top))
    durations = least.reshape(-1, *least.shape[-2:]).max(axis=(0, -1), initial=0.0)
    return _lengthen(replace(problem, durations=durations))


def _speeds(velocity: ArrayLike | None, n: int) -> Floats:
    """(n,) positive speeds; infinite where none is given."""
    V = real_array("velocity", np.inf if velocity is None else velocity)
    if V.shape not in ((), (n,)):
        raise InputError("input.shape", name="velocity", expected=(n,), got=V.shape, hint="")
    if not (V > 0.0).all():
        raise InputError("input.positive", name="velocity", value=float(V[~(V > 0.0)].flat[0]) if V.ndim else float(V))
    return np.broadcast_to(calculable("velocity", V), (n,))


def _with_blends(problem: BlendProblem, D: Floats, top: Floats) -> Floats:
    """(*batch, m - 1, n) least time of end legs with their blends; 0 of the others."""
    way, legs = np.abs(D), D.shape[-2]
    start = np.where(D < 0.0, problem.down[..., :-1, :], problem.up[..., :-1, :])
    goal = np.where(D > 0.0, problem.down[..., 1:, :], problem.up[..., 1:, :])
    least = np.zeros(D.shape)
    if legs == 1:
        A = mean_acceleration(start, goal)
        cruise = way * A > top**2
        safe = np.where(cruise, top, 1.0)
        return np.where(cruise, way / safe + safe / A, 2.0 * np.sqrt(way / A))
    for k, A in ((0, start), (-1, goal)):
        far, strong, fast = way[..., k, :], A[..., k, :], top[..., k, :]
        cruise = 2.0 * far * strong > fast**2
        safe = np.where(cruise, fast, 1.0)
        least[..., k, :] = np.where(cruise, far / safe + safe / (2.0 * strong), np.sqrt(2.0 * far / strong))
    return least


def _lengthen(problem: BlendProblem) -> BlendProblem:
    """3. Longer legs until nothing overlaps: what they lack, or slower legs where they lack much."""
    as_it_is, _ = found = _without_overlaps(problem, MUCH[0])
    if as_it_is is problem:
        return problem
    return min(found, *(_without_overlaps(problem, much) for much in MUCH[1:]), key=lambda each: each[1])[0]


def _without_overlaps(problem: BlendProblem, much: float) -> tuple[BlendProblem, float]:
    """The problem with longer legs, and how long it takes in all; infinite where something overlaps to the end."""
    total = np.inf
    for attempt in range(10 * ROUNDS):
        found = blends(problem)
        lacking = -found.straight.reshape(-1, *found.straight.shape[-2:]).min(axis=(0, -1))
        if (lacking <= ROUNDING * problem.durations).all():
            total = float(problem.durations.sum())
            break
        longer = SLOWER * problem.durations
        if attempt < ROUNDS:
            longer = problem.durations + _growth(problem, found.slope, lacking, much)
        problem = replace(problem, durations=longer)
    return problem, total


def _growth(problem: BlendProblem, slope: Floats, lacking: Floats, much: float) -> Floats:
    """(m - 1,) what legs grow by: what they lack; where that is much, the quickest of a leg and those beside it grows.

    It is quick legs that make blends long. A leg without distance is measured by those beside it.

    Args:
        problem: the legs.
        slope: (*batch, m - 1, n) of them.
        lacking: (m - 1,) what each leg lacks [s].
        much: from which share of a leg on that is much.
    """
    durations, legs = problem.durations, len(problem.durations)
    pace = np.abs(slope) / np.minimum(problem.up, problem.down)[..., :-1, :]
    quick = pace.reshape(-1, *pace.shape[-2:]).max(axis=(0, -1))
    growth = np.zeros(legs)
    for k in np.flatnonzero(lacking > ROUNDING * durations):
        beside = np.arange(max(k - 1, 0), min(k + 2, legs))
        need, quickest = float(lacking[k]) * (1.0 + ROUNDING), int(beside[quick[beside].argmax()])
        if need <= much * float(durations[k] if quick[k] > 0.0 else durations[beside].max()):
            growth[k] = max(growth[k], need)
        else:
            growth[quickest] = max(growth[quickest], GROWTH * durations[quickest])
    return growth
