"""Paths with fewer stops and more clearance: smoothed by gradients of distances (CHOMP), corners rounded, proved."""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.planning.kept_planning import Kept
from mafsil.planning.problem import length_of
from mafsil.trajectory import JointPath
from mafsil.trajectory.splines import PiecewisePolynomial

if TYPE_CHECKING:
    from mafsil.collision import Checker


CHORDS = 8
"""Straight pieces by which a rounded corner is proved free."""
HALVINGS = 6
"""How often a corner is rounded more tightly before it stays sharp."""
STEEPER = 3.0
"""Factor of the weight of the clearance where the least cost is not proved free."""
HEAVIEST = 1e4
"""How much heavier the clearance gets at most."""
CLEARANCE_WEIGHT = 10.0
"""Of the crowding, times 1 + length^2 of the path that is given."""
CLEARANCE = 0.03
"""Of searches that descend from straight lines [m]."""
POINTS = 30
"""Of their paths."""
ATTEMPT = 100
"""Steps from one line before another is tried."""
LEAST_STEP = 1e-4
"""Step below which a descent is at its end."""
QUIET = 1e-5
"""Share of the cost by which a step must lower it to go on."""


@dataclass(frozen=True)
class PathCost:
    """What a path costs, measured at points evenly along it.

    Attributes:
        length: [rad | m].
        bending: integral of the squared second derivative by the share of the path, [(rad | m)^2].
        crowding: mean over the points of the hinge (e - d)^2 / (2 e), e the clearance that is enough; beyond contact
            linear [m].
        total: length^2 / 2 + smoothness bending + weight crowding, the weight 10 (1 + length^2 of the path given).
    """

    length: float
    bending: float
    crowding: float
    total: float


@dataclass(frozen=True, eq=False)
class Descent:
    """How an optimisation ended.

    Attributes:
        path: (k, n) of the least cost that was proved free; the one given where none was.
        before, after: what they cost.
        iterations: descents that were made.
        free: whether `path` is proved free.
    """

    path: JointVector
    before: PathCost
    after: PathCost
    iterations: int
    free: bool


@dataclass(frozen=True, eq=False)
class _Terms:
    """The cost of points (k, n) between two ends, with its derivatives."""

    checker: Checker
    enough_clearance: float
    smoothness: float
    moving: Floats

    def at(self, points: Floats, weight: float) -> tuple[PathCost, Floats]:
        """The cost, and its derivatives (k, n) by all points, zero at the ends.

        1. k sum |x_(i+1) - x_i|^2 / 2, which is length^2 / 2 of points evenly apart.
        2. smoothness k^3 sum |x_(i+1) - 2 x_i + x_(i-1)|^2 / 2.
        3. weight times the mean of the hinge of the distance d_i.
        """
        k = len(points) - 1
        first, second = np.diff(points, axis=0), np.diff(points, 2, axis=0)
        gradient = np.zeros_like(points)
        # 1.
        energy = 0.5 * k * float((first**2).sum())
        gradient[1:-1] -= k * second
        # 2.
        bending = 0.5 * k**3 * float((second**2).sum())
        share = self.smoothness * k**3
        gradient[:-2] += share * second
        gradient[1:-1] -= 2.0 * share * second
        gradient[2:] += share * second
        # 3.
        near = self.checker.distance(points, within=self.enough_clearance)
        d, within = np.minimum(np.asarray(near.distance), self.enough_clearance), self.enough_clearance
        hinge = np.where(d < 0.0, within / 2.0 - d, (within - d) ** 2 / (2.0 * within))
        slope = np.where(d < 0.0, -1.0, -(within - d) / within) * np.isfinite(np.asarray(near.distance))
        gradient += (weight / len(points)) * slope[:, None] * np.nan_to_num(np.asarray(near.gradient))
        gradient[0] = gradient[-1] = 0.0
        crowding = float(hinge.mean())
        total = energy + self.smoothness * bending + weight * crowding
        return PathCost(length_of(points), bending, crowding, total), gradient * self.moving


def evenly(path: JointVector, count: int) -> JointVector:
    """(count, n) points evenly along a path (k, n)."""
    places = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    s: Floats = np.linspace(0.0, float(places[-1]), count)
    columns: list[Floats] = [np.interp(s, places, path[:, c]) for c in range(path.shape[1])]
    return np.stack(columns, axis=1)


def descend(
    checker: Checker, path: JointVector, bounds: tuple[Floats, Floats], enough_clearance: float, smoothness: float,
    points: int, iterations: int, seconds: float,
) -> Descent:  # fmt: skip
    """The path between the same ends, its cost made lower by gradient steps; the best that is proved free.

    1. Points evenly along the path.
    2. A step against the gradient in the metric of squared differences, so that all points move at once; half of it
       until the cost is lower, within the limits. Once the points are proved free, motion by motion, so is each step:
       the gradient of no state would bring a motion back that has gone through something thin.
    3. The cheapest that is proved free stays.
    4. Where steps end and nothing is proved, clearance weighs more.

    Args:
        checker: the arm in its scene.
        path: (k, n); free or not.
        bounds: (n,) limits; equal ones do not move.
        enough_clearance: distance from which on obstacles do not matter [m].
        smoothness: weight of bending.
        points: of the path between its ends.
        iterations, seconds: after which the best is given.

    Reference:
        N. Ratliff, M. Zucker, J. A. Bagnell, S. Srinivasa, CHOMP, ICRA 2009; M. Zucker et al., IJRR 32(9), 2013.
    """
    lower, upper = bounds
    terms = _Terms(checker, enough_clearance, smoothness, (upper > lower).astype(np.float64))
    # 1.
    now = evenly(path, points + 2)
    base = weight = CLEARANCE_WEIGHT * (1.0 + length_of(now) ** 2)
    (cost, gradient), best = terms.at(now, weight), path
    before = least = cost
    proved, kept_free = bool(checker.free_segment(path[:-1], path[1:]).all()), _prove(checker, now)
    metric, step, deadline, made = _inverse(points, smoothness), 0.5, perf_counter() + seconds, 0
    while made < iterations and perf_counter() < deadline:
        made += 1
        # 2.
        way, lowered, quiet = metric @ gradient[1:-1], False, True
        while step > LEAST_STEP and not lowered:
            tried = now.copy()
            tried[1:-1] = np.clip(now[1:-1] - step * way, lower, upper)
            next_cost, next_gradient = terms.at(tried, weight)
            lowered = next_cost.total < cost.total and (not kept_free or _prove(checker, tried))
            if lowered:
                quiet = next_cost.total > cost.total * (1.0 - QUIET)
                now, cost, gradient, step = tried, next_cost, next_gradient, min(1.0, 1.5 * step)
            else:
                step /= 2.0
        # 3.
        plain = replace(cost, total=cost.total + (base - weight) * cost.crowding)
        if lowered and (not proved or plain.total < least.total) and (kept_free or _prove(checker, now)):
            best, least, proved, kept_free = now, plain, True, True
        # 4.
        if quiet:
            if best is now or weight > HEAVIEST * base:
                break
            weight, step = STEEPER * weight, 0.5
            cost, gradient = terms.at(now, weight)
    return Descent(best, before, least, made, proved)


def _prove(checker: Checker, points: Floats) -> bool:
    return bool(checker.free(points).all()) and bool(checker.free_segment(points[:-1], points[1:]).all())


def _inverse(points: int, smoothness: float) -> Floats:
    """(points, points) inverse of the second derivative of the first two terms of the cost."""
    k = points + 1
    first = np.diff(np.eye(points + 2), axis=0)[:, 1:-1]
    second = np.diff(np.eye(points + 2), 2, axis=0)[:, 1:-1]
    return np.asarray(np.linalg.inv(k * first.T @ first + smoothness * k**3 * second.T @ second), dtype=np.float64)


def optimise_from_straight(
    checker: Checker, bounds: tuple[Floats, Floats], q: JointVector, goals: JointVector, seed: int, seconds: float,
    steps: int,
) -> tuple[JointVector | None, int]:  # fmt: skip
    """The first path that descending leads to, and how many steps that took; None if the budget ends before.

    1. From the straight line to each goal, the nearest first.
    2. Then over a random configuration, to each goal in turn.

    Args:
        checker: the arm in its scene.
        bounds: (n,) limits.
        q: (n,) start.
        goals: (k, n).
        seed: of the random configurations.
        seconds, steps: the budget.
    """
    rng, (lower, upper) = np.random.default_rng(seed), bounds
    order = np.argsort(np.linalg.norm(goals - q, axis=1), kind="stable")
    deadline, made, attempt = perf_counter() + seconds, 0, 0
    while made < steps and (left := deadline - perf_counter()) > 0.0:
        goal = goals[order[attempt % len(goals)]]
        over = [] if attempt < len(goals) else [lower + rng.random(len(q)) * (upper - lower)]
        path = np.stack([q, *over, goal])
        if np.array_equal(q, goal):
            return path, made
        found = descend(checker, path, bounds, CLEARANCE, 0.0, POINTS, min(ATTEMPT, steps - made), left)
        made += found.iterations
        if found.free:
            return found.path, made
        attempt += 1
    return None, made


def round_corners(checker: Checker, path: JointVector, share: float = 0.5, kept: Kept | None = None) -> JointPath:
    """A path of proved straight motions with its corners rounded; what is rounded is proved free, too.

    1. A corner c between directions d and e becomes, from c - r d to c + r e, the quintic whose control points lie
       on both legs, three on each: direction and curvature are continuous.
    2. Chords of it are proved with a clearance that is larger by how far the arm can move between chord and curve:
       a curve leaves its chord by at most h^2 / 8 times its second derivative, and that is largest at a control point.
    3. A corner that cannot be proved is rounded half as much; after six times it stays, and motions stop there.

    Args:
        checker: the arm in its scene.
        path: (k, n) points; the motions between them are proved.
        share: of the shorter leg that a corner may take, below 1/2 both corners of a leg find their place [0, 0.5].
        kept: what the curve must keep, too.
    """
    points = np.asarray(path, dtype=np.float64)
    ways = np.linalg.norm(np.diff(points, axis=0), axis=1)
    points = points[np.concatenate([[True], ways > 0.0])]
    if len(points) < 3:
        return JointPath.through(points, "lines")
    ways = np.linalg.norm(np.diff(points, axis=0), axis=1)
    directions = np.diff(points, axis=0) / ways[:, None]
    radii = np.zeros(len(points))
    for k in range(1, len(points) - 1):
        radius = share * min(ways[k - 1], ways[k])
        for _ in range(HALVINGS):
            if _is_free(checker, _corner(points[k], directions[k - 1], directions[k], radius), kept):
                radii[k] = radius
                break
            radius /= 2.0
    return JointPath(_join(points, directions, ways, radii))


def _corner(c: Floats, d: Floats, e: Floats, radius: float) -> Floats:
    """(6, n) control points of the quintic over 2 radius whose ends are straight, with unit speed."""
    step = 0.4 * radius
    before = [c - radius * d + j * step * d for j in range(3)]
    after = [c + radius * e - j * step * e for j in (2, 1, 0)]
    return np.stack([*before, *after])


def _is_free(checker: Checker, control: Floats, kept: Kept | None) -> bool:
    """Whether a curve of control points (6, n) over 0..1 is proved free, and to keep what is to be kept."""
    # Second derivatives of a quintic: 20 times second differences of the control points, which bound them.
    second = 20.0 * np.abs(np.diff(control, 2, axis=0)).max(axis=0)
    apart = second / (8.0 * CHORDS**2)
    extra = 2.0 * checker.largest_way(apart, np.abs(control).max(axis=0))
    places = _bernstein(np.linspace(0.0, 1.0, CHORDS + 1)) @ control
    if kept is not None and not kept.on_curve(checker, places, apart):
        return False
    return bool(checker.free_segment(places[:-1], places[1:], extra=extra).all())


def _bernstein(t: Floats) -> Floats:
    """(k, 6) Bernstein polynomials of degree 5."""
    binomial = np.array([1.0, 5.0, 10.0, 10.0, 5.0, 1.0])
    j = np.arange(6)
    return binomial * t[:, None] ** j * (1.0 - t[:, None]) ** (5 - j)


def _join(points: Floats, directions: Floats, ways: Floats, radii: Floats) -> PiecewisePolynomial:
    """Lines and rounded corners with the length of the legs as path parameter; degree 5."""
    lengths: list[float] = []
    rows: list[Floats] = []
    for k, (d, way) in enumerate(zip(directions, ways, strict=True)):
        straight = way - radii[k] - radii[k + 1]
        if straight > 1e-12 * way:
            line = np.zeros((6, points.shape[1]))
            line[0], line[1] = points[k] + radii[k] * d, d
            rows.append(line)
            lengths.append(straight)
        if k + 1 < len(directions) and radii[k + 1] > 0.0:
            radius = float(radii[k + 1])
            control = _corner(points[k + 1], d, directions[k + 1], radius)
            rows.append(_powers(control) / ((2.0 * radius) ** np.arange(6))[:, None])
            lengths.append(2.0 * radius)
    return PiecewisePolynomial.from_pieces(np.array(lengths), np.stack(rows))


def _powers(control: Floats) -> Floats:
    """(6, n) coefficients of powers of t of a quintic over 0..1: forward differences times binomials."""
    binomial = (1.0, 5.0, 10.0, 10.0, 5.0, 1.0)
    return np.stack([binomial[k] * np.diff(control, k, axis=0)[0] for k in range(6)])
