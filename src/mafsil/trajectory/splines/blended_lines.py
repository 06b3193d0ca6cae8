"""Straight lines joined by blends, as a trajectory; and which leg of which coordinate keeps its blends from fitting.

Shapes of a blend between two straight lines, as rows of one table: parabola and quintic.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from math import factorial
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.trajectory.motion import BlendStatus, Motion, Printed, moving_at, times
from mafsil.trajectory.splines.blend_plan import BlendProblem, Blends, blends, mean_acceleration
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.tolerances import ROUNDING

GRID, ROUNDS = 512, 5
"""A search looks at so many candidates at once, and so often between two of them: to the last digits."""
DECADES = 3
"""Candidates reach from the least one a factor of ten to this power upwards, then farther."""
BlendName: TypeAlias = Literal["parabolic", "quintic"]


class _Place(NamedTuple):
    """Where times lie: their leg (*times), themselves (*times, 1, ..), in a blend, in the one at the leg's end."""

    leg: NDArray[np.intp]
    time: Floats
    blending: NDArray[np.bool_]
    late: NDArray[np.bool_]


@dataclass(frozen=True, eq=False, repr=False)
class BlendedLines(Printed):
    """A polygon over time with a blend at each corner, the first and the last one inside their legs.

    Attributes:
        legs: (m,) times between which a leg is one straight line [s].
        corners: (m, *batch, n) times of the corners [s].
        points: (m, *batch, n) positions of the corners [rad | m].
        slopes: (m + 1, *batch, n) velocities before, between and after the corners; zero at both ends.
        blends: (m, *batch, n) durations of the blends, which lie evenly about their corners [s].
        shape: of all blends.
    """

    legs: Floats
    corners: Floats
    points: Floats
    slopes: Floats
    blends: Floats
    shape: BlendShape

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return float(self.legs[-1])

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return self.points.shape[-1]

    def breaks(self) -> Floats:
        """Starts and ends of all blends, 0 and the duration included [s]."""
        return self._breaks

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration at the times `t` (*times) [s]; at rest outside 0 .. duration."""
        moment = times(t)
        moving = moving_at(moment, self.duration, self.points.ndim - 1)
        u, v, a = self._derivatives(moment, (0, 1, 2))
        return Motion(u, v * moving, a * moving)

    def jerk(self, t: ArrayLike) -> Floats:
        """(*times, *batch, n) third derivative [rad/s^3 | m/s^3]; between parabolas it is zero, jumps apart."""
        moment = times(t)
        return self._derivatives(moment, (3,))[0] * moving_at(moment, self.duration, self.points.ndim - 1)

    def blending(self, t: ArrayLike) -> NDArray[np.bool_]:
        """(*times, *batch, n) whether each coordinate is in a blend; else it is in a straight part or at rest."""
        moment = times(t)
        within = ((moment >= 0.0) & (moment <= self.duration)).reshape(moment.shape + (1,) * (self.points.ndim - 1))
        return self._locate(moment).blending & within

    def to_polynomial(self) -> PiecewisePolynomial:
        """The same motion as one list of polynomials; of a batch all knots together, many for many rows."""
        knots, degree = self.breaks(), max(len(self.shape.coefficients) - 1, 2)
        if len(knots) == 1:
            return PiecewisePolynomial.from_pieces([0.0], self.points[:1, None])
        # What a piece is, its middle says; where it starts, its left end.
        values = self._derivatives(knots[:-1], range(degree + 1), (knots[:-1] + knots[1:]) / 2)
        pieces = np.stack([value / factorial(k) for k, value in enumerate(values)], axis=1)
        return PiecewisePolynomial.from_pieces(np.diff(knots), pieces)

    @cached_property
    def _breaks(self) -> Floats:
        ends = [(self.corners + side * self.blends / 2).ravel() for side in (-1.0, 1.0)]
        return np.unique(np.clip(np.concatenate([[0.0, self.duration], *ends]), 0.0, self.duration))

    def _locate(self, t: Floats) -> _Place:
        """Where each coordinate is at the times (*times)."""
        clamped = np.clip(t, 0.0, self.duration)
        leg = np.clip(np.searchsorted(self.legs, clamped, side="right") - 1, 0, len(self.legs) - 2)
        time = clamped.reshape(clamped.shape + (1,) * (self.points.ndim - 1))
        begin, end = leg, leg + 1
        late = (time >= self.corners[end] - self.blends[end] / 2) & (self.blends[end] > 0.0)
        early = (time < self.corners[begin] + self.blends[begin] / 2) & ~late
        return _Place(leg, time, early | late, late)

    def _derivatives(self, t: Floats, orders: Iterable[int], where: Floats | None = None) -> list[Floats]:
        """Derivatives at the times `t`, taken in the part in which `where` lies (`t` itself if None).

        straight: u = u_k + v (t - c_k);  blend: u = u_k - v b/2 + b (v s + dv g(s)),  s = (t - c_k)/b + 1/2
        """
        place = self._locate(t if where is None else where)
        time = place.time if where is None else t.reshape(place.time.shape)
        leg, late, blending = place.leg, place.late, place.blending
        c, u, b = (np.where(late, each[leg + 1], each[leg]) for each in (self.corners, self.points, self.blends))
        own = self.slopes[leg + 1]
        v = np.where(late | ~blending, own, self.slopes[leg])
        dv = np.where(late, self.slopes[leg + 2], own) - v
        b = np.where(blending, b, 1.0)
        s = np.where(blending, (time - c) / b + 0.5, 0.0)
        found: list[Floats] = []
        for order in orders:
            bend = dv * self.shape.g(s, order) / b ** (order - 1)
            line = (u + v * (time - c), v, 0.0)[min(order, 2)]
            found.append(np.where(blending, line + bend, line))
        return found


@dataclass(frozen=True)
class BlendShape:
    """How the speed changes from v to v + dv in a blend of duration b around a corner at u_k.

    u = u_k - v b/2 + b (v s + dv g(s)),  s from 0 to 1 in the blend.

    Attributes:
        coefficients: of g in ascending powers: g(0) = g'(0) = 0, g(1) = 1/2, g'(1) = 1.

    Raises:
        InputError: g does not lead from one line to the other.
    """

    coefficients: tuple[float, ...]

    def __post_init__(self) -> None:
        ends = [self._at(s, order) for order in (0, 1) for s in (0.0, 1.0)]
        if not np.allclose(ends, [0.0, 0.5, 0.0, 1.0], rtol=0.0, atol=1e-14):
            raise InputError("trajectory.blend_ends", coefficients=self.coefficients)

    def g(self, s: Floats, order: int) -> Floats:
        """A derivative of g by s.

        Args:
            s: share of the blend that has passed.
            order: 0 for g itself.
        """
        value = np.zeros_like(s)
        for c in np.polynomial.polynomial.polyder(np.array(self.coefficients), order)[::-1].tolist():
            value = value * s + c
        return value

    @cached_property
    def peak(self) -> float:
        """Peak acceleration over the mean one, dv/b: largest g''."""
        third = np.polynomial.polynomial.polyder(np.array(self.coefficients), 3)
        bends: NDArray[np.complex128] = np.asarray(np.polynomial.polynomial.polyroots(third), dtype=np.complex128)
        inside = [float(s) for s in bends.real[np.abs(bends.imag) < ROUNDING] if 0.0 < s < 1.0]
        return max(abs(self._at(s, 2)) for s in (0.0, *inside, 1.0))

    @property
    def miss(self) -> float:
        """Distance from the corner to the middle of the blend, as share of dv b."""
        return self._at(0.5, 0)

    def _at(self, s: float, order: int) -> float:
        return float(self.g(np.array(s), order))


BLENDS: dict[BlendName, BlendShape] = {
    "parabolic": BlendShape((0.0, 0.0, 0.5)),
    "quintic": BlendShape((0.0, 0.0, 0.0, 1.0, -0.5)),
}
"""All shapes by name. The quintic has no acceleration at its ends; its coefficient of the fifth power vanishes."""


def blend_shape(name: BlendName) -> BlendShape:
    """The shape of that name.

    Raises:
        InputError: there is none; the sentence lists those that are.
    """
    if name not in BLENDS:
        raise InputError("input.choice", name="blend", value=name, known=", ".join(BLENDS))
    return BLENDS[name]


@dataclass(frozen=True, slots=True)
class InfeasibleLeg:
    """The leg of one row of the batch that lacks most time.

    Attributes:
        row: index into the batch; () without.
        status: TOO_SHORT_TO_BLEND (an end leg cannot be travelled with that acceleration at all) or BLENDS_OVERLAP.
        leg: index; it leads from points[leg] to points[leg + 1].
        coordinate: index.
        duration: of the leg [s].
        acceleration: peak magnitude at the leg's first point (its last one of a last leg) [rad/s^2 | m/s^2].
        straight: duration of its straight part [s], negative; NaN if TOO_SHORT_TO_BLEND.
        duration_needed: of this leg, the others as they are [s]; NaN if none was found.
        acceleration_needed: at the end of the leg in which it rests, so that it can be travelled; NaN if
            BLENDS_OVERLAP.
        least_acceleration: the smallest peak that, used at all points, makes the row feasible: of this coordinate,
            or of all of them where they share their blend times. Found by search.
        stretch: the smallest factor of all durations that makes the whole row feasible. Found by search.
    """

    row: tuple[int, ...]
    status: BlendStatus
    leg: int
    coordinate: int
    duration: float
    acceleration: float
    straight: float
    duration_needed: float
    acceleration_needed: float
    least_acceleration: float
    stretch: float

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {name: getattr(self, name) for name in self.__slots__} | {"status": self.status.name.lower()}

    def explain(self, language: str | None = None) -> str:
        """What is lacking, and what would do."""
        details = {name: getattr(self, name) for name in self.__slots__ if name not in ("row", "status")}
        return self.status.sentence(language, end=self.leg + 1, overlap=-self.straight, **details)


def infeasible_legs(problem: BlendProblem, found: Blends, peak: float) -> tuple[InfeasibleLeg, ...]:
    """One for each row that is not feasible.

    Args:
        problem: with batch.
        found: its blends.
        peak: of the blends' acceleration over its mean.
    """
    bad = ~found.feasible(problem.durations).all(axis=(-1, -2))
    return tuple(
        _infeasible_leg(_row(problem, tuple(int(i) for i in row)), tuple(int(i) for i in row), peak)
        for row in np.argwhere(bad)
    )


def _row(problem: BlendProblem, row: tuple[int, ...]) -> BlendProblem:
    """One row of the batch."""
    return replace(problem, points=problem.points[row], down=problem.down[row], up=problem.up[row])


def _infeasible_leg(problem: BlendProblem, row: tuple[int, ...], peak: float) -> InfeasibleLeg:
    """The worst leg of a single problem.

    1. A leg that has no blend at all, the one that would need most acceleration; else the most negative straight time.
    2. What this leg needs alone.
    3. What acceleration everywhere, or how much more time everywhere, makes the row feasible.
    """
    # 1
    found = blends(problem)
    excess = _radicand_accelerations(problem) / _end_accelerations(problem)
    if excess.max() > 1.0 and np.isnan(found.straight).any():
        leg, coordinate = (int(i) for i in np.unravel_index(int(excess.argmax()), excess.shape))
        status, straight = BlendStatus.TOO_SHORT_TO_BLEND, float("nan")
    else:
        leg, coordinate = (int(i) for i in np.unravel_index(int(np.nanargmin(found.straight)), found.straight.shape))
        status, straight = BlendStatus.BLENDS_OVERLAP, float(found.straight[leg, coordinate])
    h, mine = float(problem.durations[leg]), _end_accelerations(problem)[leg, coordinate]
    # 2
    needed = duration_needed = float("nan")
    if status is BlendStatus.TOO_SHORT_TO_BLEND:
        needed = float(_radicand_accelerations(problem)[leg, coordinate])
        duration_needed = h * float(np.sqrt(needed / mine))
    else:
        duration_needed = h * _least(lambda factor: _with_leg(problem, leg, factor), leg)
    # 3
    alone = problem if problem.together else _coordinate(problem, coordinate)
    base = float(_radicand_accelerations(alone).max()) or 1e-3 * float(mine)
    least = base * _least(lambda factor: _equal(alone, base * factor))
    stretch = float(np.sqrt(_least(lambda factor: _stronger(problem, factor))))
    at_goal = leg == len(problem.durations) - 1 and leg > 0
    own = float(np.minimum(problem.down, problem.up)[leg + at_goal, coordinate]) * peak
    details = (h, own, straight, duration_needed, needed * peak, least * peak, stretch)
    return InfeasibleLeg(row, status, leg, coordinate, *details)


def _radicand_accelerations(problem: BlendProblem) -> Floats:
    """(m - 1, n) mean acceleration below which an end leg cannot be travelled: 2 |D|/d^2, alone 4 |D|/d^2; else 0."""
    way = np.abs(np.diff(problem.points, axis=-2))
    ends = np.zeros(len(problem.durations))
    ends[0] += 2.0
    ends[-1] += 2.0
    moving = way > 0.0
    squared = np.where(moving, problem.durations[:, None] ** 2, 1.0)
    return ends[:, None] * way / np.where(squared > 0.0, squared, np.nan)


def _end_accelerations(problem: BlendProblem) -> Floats:
    """(m - 1, n) what the legs have for that; interior legs any."""
    D = np.diff(problem.points, axis=-2)
    start = np.where(D < 0.0, problem.down[:-1], problem.up[:-1])
    goal = np.where(D > 0.0, problem.down[1:], problem.up[1:])
    if len(D) == 1:
        return mean_acceleration(start, goal)
    found = start.copy()
    found[-1] = goal[-1]
    return found


def _least(candidates: Callable[[Floats], BlendProblem], leg: int | None = None) -> float:
    """The smallest factor >= 1 whose candidate is feasible: the first of a grid, then of a finer one before it; or NaN.

    Args:
        candidates: (k,) factors -> a batch (k) of problems.
        leg: whose blends have to fit; all legs if None.
    """
    low, high = 1.0, 10.0**DECADES
    farther = 2
    for _ in range(ROUNDS + farther):
        grid = np.geomspace(low, high, GRID)
        problem = candidates(grid)
        fits = np.asarray(blends(problem).feasible(problem.durations).all(axis=-1), dtype=np.bool_)
        good = np.asarray(fits.all(axis=-1) if leg is None else fits[:, leg], dtype=np.bool_)
        first = int(good.argmax())
        if good[first]:
            low, high = float(grid[max(first - 1, 0)]), float(grid[first])
        elif farther:
            farther, low, high = farther - 1, high, high * 10.0**DECADES
        else:
            return float("nan")
    return high


def _with_leg(problem: BlendProblem, leg: int, factor: Floats) -> BlendProblem:
    """One leg longer by factors (k,)."""
    durations = np.tile(problem.durations, (len(factor), 1))
    durations[:, leg] *= factor
    return replace(_repeat(problem, len(factor)), durations=durations)


def _stronger(problem: BlendProblem, factor: Floats) -> BlendProblem:
    """All accelerations larger by factors (k,): as much as durations longer by their roots."""
    down, up = (factor[:, None, None] * side for side in (problem.down, problem.up))
    return replace(_repeat(problem, len(factor)), down=down, up=up)


def _equal(problem: BlendProblem, acceleration: Floats) -> BlendProblem:
    """One acceleration (k,) for all points and coordinates."""
    whole = _repeat(problem, len(acceleration))
    side = np.broadcast_to(acceleration[:, None, None], whole.points.shape)
    return replace(whole, down=side, up=side)


def _repeat(problem: BlendProblem, count: int) -> BlendProblem:
    """A batch of the same problem."""
    points, down, up = (np.broadcast_to(x, (count, *x.shape)) for x in (problem.points, problem.down, problem.up))
    return replace(problem, points=points, down=down, up=up)


def _coordinate(problem: BlendProblem, k: int) -> BlendProblem:
    """One coordinate alone."""
    points, down, up = (x[:, k : k + 1] for x in (problem.points, problem.down, problem.up))
    return replace(problem, points=points, down=down, up=up)
