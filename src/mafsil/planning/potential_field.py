"""Artificial potentials: a point is drawn to the goal and pushed from obstacles; local minima are found and escaped."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import (
    Floats,
    as_batch,
    calculable,
    positive,
    real_array,
    require_finite,
    require_function,
    single,
    whole,
)
from mafsil.collision import Checker
from mafsil.collision.checker import each_distance
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.planning.field_descent import FieldPath, down_the_field
from mafsil.planning.outcome import PlanningStatus

Distance: TypeAlias = Callable[[Floats], tuple[Floats, Floats]]
"""(k, n) points -> (k,) distances to an obstacle, and (k, n) its nearest points."""
ROOM = 0.5
"""Distance beyond its reach in which a field of an arm looks for what is near [m]."""
SHARE = 0.5
"""Of what an arm keeps at its goal, below which things repel it: nothing does at the goal itself."""


class Near(NamedTuple):
    """What is around points, thing by thing.

    Attributes:
        rho: (*batch, m) distances, zero where there is none left [m].
        away: (*batch, m, n) how they grow with the coordinates.
    """

    rho: Floats
    away: Floats


def disc_distance(centre: ArrayLike, radius: float) -> Distance:
    """The distance to a disc or ball.

    Args:
        centre: (n,) [m].
        radius: [m].
    """
    middle, r = calculable("centre", require_finite("centre", real_array("centre", centre))), positive("radius", radius)

    def distance(points: Floats) -> tuple[Floats, Floats]:
        way = points - middle
        size = np.linalg.norm(way, axis=-1)
        nearest = middle + way * (r / np.maximum(size, LEAST_DIVISOR))[..., None]
        return np.maximum(size - r, 0.0), nearest

    return distance


@dataclass(frozen=True, eq=False, slots=True)
class Discs:
    """Distances to obstacles of which each is a function.

    Attributes:
        obstacles: each with its nearest points.
    """

    obstacles: tuple[Distance, ...]

    def __call__(self, points: Floats) -> Near:
        """Of points (*batch, n)."""
        found = [obstacle(points) for obstacle in self.obstacles]
        if not found:
            none = np.zeros((*points.shape[:-1], 0, points.shape[-1]))
            return Near(none[..., 0], none)
        rho, nearest = np.stack([d for d, _ in found], axis=-1), np.stack([place for _, place in found], axis=-2)
        with np.errstate(divide="ignore", invalid="ignore"):
            return Near(rho, (points[..., None, :] - nearest) / rho[..., None])


@dataclass(frozen=True, eq=False, slots=True)
class WholeArm:
    """What each body of an arm keeps from everything around it, and each pair of bodies that is checked.

    Attributes:
        checker: the arm in its scene; its clearances are no room.
        within: how far it looks [m].
        levers: (bodies + pairs,) how far what keeps a distance moves at most where the coordinates change by one.
    """

    checker: Checker
    within: float
    levers: Floats

    @classmethod
    def of(cls, checker: Checker, goal: Floats, within: float) -> WholeArm:
        """Of an arm.

        Args:
            checker: the arm in its scene.
            goal: (n,) to which it goes [rad | m].
            within: how far it looks [m].
        """
        n, limits = checker.robot.n, checker.robot.limits
        bounds = np.where(np.isfinite([limits.lower, limits.upper]), [limits.lower, limits.upper], 0.0)
        largest = np.maximum(np.abs(bounds).max(axis=0), np.abs(goal))
        ways = np.stack([checker.largest_ways(row, largest) for row in np.eye(n)])
        of_bodies, pairs = np.linalg.norm(ways, axis=0), checker.arm.pairs
        both = of_bodies[pairs[:, 0]] + of_bodies[pairs[:, 1]]
        return cls(checker, within, np.maximum(np.concatenate([of_bodies, both]), 1e-9))

    def __call__(self, points: Floats) -> Near:
        """Of configurations (*batch, n)."""
        rho, away = each_distance(self.checker, points, self.within)
        kept, bodies = self.checker.clearances(), len(self.checker.arm.bodies)
        clearances = np.concatenate([np.full(bodies, kept[0]), kept[1:]])
        return Near(np.maximum(np.minimum(rho, self.within) - clearances, 0.0), away)


@dataclass(frozen=True, eq=False, slots=True)
class PotentialField:
    """U = kp |x - goal|^2/2 + sum eta (1/rho - 1/rho_0)^2/2 over obstacles nearer than rho_0.

    Attributes:
        goal: (n,) [m]; of an arm [rad | m].
        near: what is around points.
        kp, eta: how strong attraction and repulsion are.
        reach: rho_0, one for all or one for each thing that is near [m].
        lever: how far what keeps a distance moves at most where x changes by a length of one; likewise.
        lower, upper: (n,) between which x stays.
    """

    goal: Floats
    near: Callable[[Floats], Near]
    kp: float = 1.0
    eta: float = 1.0
    reach: float | Floats = 1.0
    lever: float | Floats = 1.0
    lower: Floats = field(default_factory=lambda: np.array(-np.inf))
    upper: Floats = field(default_factory=lambda: np.array(np.inf))

    @classmethod
    def of_arm(
        cls, checker: Checker, goal: ArrayLike, *, kp: float = 1.0, eta: float = 1e-3, reach: float = 0.1
    ) -> PotentialField:
        """The field of an arm in the space of its configurations: every link is pushed away from what is around.

        Bodies of the arm push each other away too, where the checker checks them. What is nearer than twice its reach
        at the goal repels from half that distance on, so that the goal is a minimum.

        Args:
            checker: the arm in its scene.
            goal: (n,), taken as on a limit that it exceeds by rounding [rad | m].
            kp, eta, reach: as of the field.

        Raises:
            InputError: a wrong shape, a number that is not finite, a strength or reach that is not positive.
        """
        target = checker.robot.limits.snap_to_limits(single("goal", goal, (checker.robot.n,)))
        kp, eta, reach = (positive(name, x) for name, x in (("kp", kp), ("eta", eta), ("reach", reach)))
        arm = WholeArm.of(checker, target, reach + ROOM)
        limits, kept = checker.robot.limits, arm(target).rho
        reaches = np.minimum(reach, np.maximum(SHARE * kept, 1e-9))
        return cls(target, arm, kp, eta, reach=reaches, lever=arm.levers, lower=limits.lower, upper=limits.upper)

    @classmethod
    def of(
        cls, goal: ArrayLike, obstacles: Sequence[Distance], *, kp: float = 1.0, eta: float = 1.0, reach: float = 1.0
    ) -> PotentialField:
        """A field.

        Raises:
            InputError: a number that is not finite, a strength or reach that is not positive.
        """
        target = require_finite("goal", real_array("goal", goal))
        if target.ndim != 1 or not len(target):
            raise InputError("input.shape", name="goal", expected="(n,)", got=target.shape, hint="")
        for k, obstacle in enumerate(obstacles):
            require_function(f"obstacles[{k}]", obstacle, "function of points (k, n)", 1)
        kp, eta, reach = (positive(name, x) for name, x in (("kp", kp), ("eta", eta), ("reach", reach)))
        return cls(target, Discs(tuple(obstacles)), kp, eta, reach)

    def attraction(self, x: ArrayLike) -> Floats:
        """(*batch, n) kp (goal - x)."""
        return self.kp * (self.goal - self._points(x))

    def repulsion(self, x: ArrayLike) -> Floats:
        """(*batch, n) sum of eta (1/rho - 1/rho_0)/rho^2 along the directions away from obstacles; infinite at them."""
        return self._repulsion(self.near(self._points(x)))

    def force(self, x: ArrayLike) -> Floats:
        """(*batch, n) minus the gradient of U."""
        return self.attraction(x) + self.repulsion(x)

    def potential(self, x: ArrayLike) -> Floats:
        """(*batch,) U."""
        points = self._points(x)
        return self._potential(points, self.near(points))

    def _points(self, x: ArrayLike) -> Floats:
        return as_batch("x", x, self.goal.shape)

    def at(self, x: Floats) -> tuple[float, Floats, float]:
        """U, the force (n,), and by how much x (n,) can change before anything could be met."""
        near = self.near(x)
        force = self.attraction(x) + self._repulsion(near)
        return float(self._potential(x, near)), force, float((near.rho / self.lever).min(initial=np.inf))

    def path(self, start: ArrayLike, *, step: float = 0.05, escapes: int = 0, seed: int = 0) -> FieldPath:
        """Down the field from a point: a local method, which sees only what is near.

        A start or goal at which an obstacle has no distance left is blocked.

        1. Along the force, by at most `step` and where that is proved clear; halved until U falls.
        2. Where the force vanishes before the goal there is a local minimum, which is where the path ends,
        3. unless escapes are left: a random walk away from it, and down again. What ends no lower is forgotten, and the
           walks grow longer, and begin farther back.

        Args:
            start: (n,) [m].
            step: longest step [m].
            escapes: how many random walks out of local minima are tried.
            seed: of these.

        Raises:
            InputError: a wrong shape, a number that is not finite.

        Reference: Khatib, Real-time obstacle avoidance for manipulators and mobile robots, IJRR 1986; Barraquand and
            Latombe, Robot motion planning: a distributed representation approach, IJRR 1991.
        """
        x = single("start", start, self.goal.shape).copy()
        numbers = positive("step", step), whole("escapes", escapes), whole("seed", seed)
        return down_the_field(self, x, *numbers)

    def minima(
        self, lower: ArrayLike, upper: ArrayLike, *, starts: int = 50, seed: int = 0, step: float = 0.05
    ) -> Floats:
        """(m, n) local minima other than the goal that descents from random places end in.

        Args:
            lower, upper: (n,) between which they begin [m].
            starts: how many.
            seed: of the places.
            step: longest step of a descent [m].

        Raises:
            InputError: a wrong shape, a number that is not finite.
        """
        low, high = (single(name, x, self.goal.shape) for name, x in (("lower", lower), ("upper", upper)))
        places = np.random.default_rng(seed).uniform(low, high, (whole("starts", starts), len(low)))
        found: list[Floats] = []
        for place in places:
            ended = self.path(place, step=step)
            end = ended.path[-1]
            same = 1e-4 * float(np.linalg.norm(high - low))
            if ended.status is PlanningStatus.LOCAL_MINIMUM and all(np.linalg.norm(end - x) > same for x in found):
                found.append(end)
        return np.array(found).reshape(-1, len(low))

    def _potential(self, points: Floats, near: Near) -> Floats:
        drawn = 0.5 * self.kp * ((points - self.goal) ** 2).sum(axis=-1)
        with np.errstate(divide="ignore"):
            excess = 1.0 / near.rho - 1.0 / np.asarray(self.reach)
        pushed = np.where(near.rho < self.reach, 0.5 * self.eta * excess**2, 0.0)
        return drawn + cast("Floats", pushed.sum(axis=-1))

    def _repulsion(self, near: Near) -> Floats:
        with np.errstate(divide="ignore", invalid="ignore"):
            size = self.eta * (1.0 / near.rho - 1.0 / np.asarray(self.reach)) / near.rho**2
            pushed = np.where((near.rho < self.reach)[..., None], size[..., None] * near.away, 0.0)
            return cast("Floats", np.where(np.isnan(pushed), np.inf, pushed).sum(axis=-2))
