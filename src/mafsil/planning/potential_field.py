"""Artificial potentials: a point is drawn to the goal and pushed from obstacles; local minima are found and escaped."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, positive, real_array, require_finite, require_function, single, whole
from mafsil.collision import Checker
from mafsil.errors import InputError
from mafsil.planning.outcome import Plan, PlanningStatus

Distance: TypeAlias = Callable[[Floats], tuple[Floats, Floats]]
"""(k, n) points -> (k,) distances to an obstacle, and (k, n) its nearest points."""
STILL = 1e-10
"""Force, as share of the attraction at the start, below which a point stands still."""
MOST_STEPS = 20_000


def disc(centre: ArrayLike, radius: float) -> Distance:
    """The distance to a disc or ball.

    Args:
        centre: (n,) [m].
        radius: [m].
    """
    middle, r = require_finite("centre", real_array("centre", centre)), positive("radius", radius)

    def distance(points: Floats) -> tuple[Floats, Floats]:
        way = points - middle
        size = np.linalg.norm(way, axis=-1)
        nearest = middle + way * (r / np.maximum(size, 1e-300))[..., None]
        return np.maximum(size - r, 0.0), nearest

    return distance


def whole_arm(checker: Checker) -> tuple[Distance, ...]:
    """The distance of each body of an arm to everything around it: forces on every link, not on the tip alone.

    As a function of the coordinates the distance rises along its gradient; its "nearest point" lies as far back along
    that as the distance is large.

    Args:
        checker: the arm in its scene.
    """

    def of(alone: Checker) -> Distance:
        def distance(points: Floats) -> tuple[Floats, Floats]:
            found = alone.distance(points)
            rho = np.maximum(found.distance, 0.0)
            far = np.isinf(rho)
            back = np.where(far, 0.0, rho)[..., None] * found.gradient
            return rho, points - np.where(far[..., None], 1.0, back)

        return distance

    moving = [b for b, row in enumerate(checker.arm.bodies) if row[3] > row[1]]
    return tuple(of(checker.checking([b], ())) for b in moving)


@dataclass(frozen=True, eq=False, slots=True)
class PotentialField:
    """U = kp |x - goal|^2/2 + sum eta (1/rho - 1/rho_0)^2/2 over obstacles nearer than rho_0.

    Attributes:
        goal: (n,) [m]; of an arm [rad | m].
        obstacles: distances to them.
        kp, eta: how strong attraction and repulsion are.
        reach: rho_0 [m].
        lever: how far anything that keeps a distance moves at most where x changes by a length of one.
    """

    goal: Floats
    obstacles: tuple[Distance, ...]
    kp: float = 1.0
    eta: float = 1.0
    reach: float = 1.0
    lever: float = 1.0

    @classmethod
    def of_arm(
        cls, checker: Checker, goal: ArrayLike, *, kp: float = 1.0, eta: float = 1e-3, reach: float = 0.1
    ) -> PotentialField:
        """The field of an arm in the space of its configurations: every link is pushed away from what is around.

        The arm is not pushed away from itself.

        Args:
            checker: the arm in its scene.
            goal: (n,) [rad | m].
            kp, eta, reach: as of the field.

        Raises:
            InputError: a wrong shape, a number that is not finite, a strength or reach that is not positive.
        """
        n, limits = checker.robot.n, checker.robot.limits
        target = single("goal", goal, (n,))
        bounds = np.where(np.isfinite([limits.lower, limits.upper]), [limits.lower, limits.upper], 0.0)
        largest = np.maximum(np.abs(bounds).max(axis=0), np.abs(target))
        ways = [checker.largest_way(row, largest) for row in np.eye(n)]
        field = cls.of(target, whole_arm(checker), kp=kp, eta=eta, reach=reach)
        return replace(field, lever=max(float(np.linalg.norm(ways)), 1e-9))

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
        numbers = (positive(name, x) for name, x in (("kp", kp), ("eta", eta), ("reach", reach)))
        return cls(target, tuple(obstacles), *numbers)

    def attraction(self, x: ArrayLike) -> Floats:
        """(*batch, n) kp (goal - x)."""
        return self.kp * (self.goal - np.asarray(x, dtype=np.float64))

    def repulsion(self, x: ArrayLike) -> Floats:
        """(*batch, n) sum of eta (1/rho - 1/rho_0)/rho^2 along the directions away from obstacles; infinite at them."""
        points = np.asarray(x, dtype=np.float64)
        total = np.zeros_like(points)
        for obstacle in self.obstacles:
            rho, nearest = obstacle(points)
            with np.errstate(divide="ignore", invalid="ignore"):
                size = self.eta * (1.0 / rho - 1.0 / self.reach) / rho**2
                away = (points - nearest) / rho[..., None]
            pushed = np.where((rho < self.reach)[..., None], size[..., None] * away, 0.0)
            total = total + np.where(np.isnan(pushed), np.inf, pushed)
        return total

    def force(self, x: ArrayLike) -> Floats:
        """(*batch, n) minus the gradient of U."""
        return self.attraction(x) + self.repulsion(x)

    def potential(self, x: ArrayLike) -> Floats:
        """(*batch,) U."""
        points = np.asarray(x, dtype=np.float64)
        total = 0.5 * self.kp * ((points - self.goal) ** 2).sum(axis=-1)
        for obstacle in self.obstacles:
            rho, _ = obstacle(points)
            with np.errstate(divide="ignore"):
                total = total + np.where(rho < self.reach, 0.5 * self.eta * (1.0 / rho - 1.0 / self.reach) ** 2, 0.0)
        return total

    def path(self, start: ArrayLike, *, step: float = 0.05, escapes: int = 0, seed: int = 0) -> Plan:
        """Down the field from a point: a local method, which sees only what is near.

        A start or goal at which an obstacle has no distance left is blocked.

        1. Along the force, by at most `step` and no farther than half way to an obstacle; halved until U falls.
        2. Where the force vanishes before the goal there is a local minimum, which is where the path ends,
        3. unless escapes are left: a random walk away from it, and down again.

        Args:
            start: (n,) [m].
            step: longest step [m].
            escapes: how many local minima are left by a random walk.
            seed: of these.

        Raises:
            InputError: a wrong shape, a number that is not finite.

        Reference: Khatib, Real-time obstacle avoidance for manipulators and mobile robots, IJRR 1986; Barraquand and
            Latombe, Robot motion planning: a distributed representation approach, IJRR 1991.
        """
        begun, rng = perf_counter(), np.random.default_rng(seed)
        x = single("start", start, self.goal.shape).copy()
        rows, size = [x.copy()], max(float(np.linalg.norm(self.attraction(x))), 1e-300)
        left, longest = whole("escapes", escapes), positive("step", step)
        for status, end in ((PlanningStatus.START_BLOCKED, x), (PlanningStatus.GOAL_BLOCKED, self.goal)):
            if not self._clear(end) > 0.0:
                return Plan(status, x[None], "potential_field", 1, 0, 0, perf_counter() - begun)
        looks = 0
        for looks in range(1, MOST_STEPS + 1):
            if np.linalg.norm(self.goal - x) <= 1e-9 * max(1.0, size / self.kp):
                return Plan(
                    PlanningStatus.FOUND, np.stack(rows), "potential_field", looks, 0, len(rows), perf_counter() - begun
                )
            F = self.force(x)
            moved = self._down(x, F, longest)
            # 2.
            if np.linalg.norm(F) <= STILL * size or moved is None:
                if left == 0:
                    break
                # 3.
                left -= 1
                rows += self._wandered(x, rng, longest, whole("escapes", escapes) - left)
                moved = rows[-1]
            x = moved
            rows.append(x.copy())
        status = (
            PlanningStatus.LOCAL_MINIMUM if np.linalg.norm(self.force(x)) <= 1e-3 * size else PlanningStatus.NOT_FOUND
        )
        return Plan(status, np.stack(rows), "potential_field", looks, 0, len(rows), perf_counter() - begun)

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

    def _clear(self, x: Floats) -> float:
        """Distance to the nearest obstacle."""
        return min((float(obstacle(x[None])[0][0]) for obstacle in self.obstacles), default=np.inf)

    def _down(self, x: Floats, F: Floats, longest: float) -> Floats | None:
        """A point farther down along the force; None where none is lower."""
        clear = self._clear(x)
        size = float(np.linalg.norm(F))
        if not np.isfinite(size) or size == 0.0:
            return None
        length = min(longest, clear / (2.0 * self.lever), size / self.kp)
        here = float(self.potential(x))
        while length > 1e-15 * max(1.0, float(np.abs(x).max())):
            new = x + F * (length / size)
            if float(self.potential(new)) < here:
                return new
            length /= 2.0
        return None

    def _wandered(self, x: Floats, rng: np.random.Generator, longest: float, times: int) -> list[Floats]:
        """A random walk of some steps that touches no obstacle; the longer, the more there were before."""
        rows, clear = [x + 0.0], self._clear(x)
        for _ in range(times * int(rng.integers(10, 60))):
            move = rng.normal(size=len(x)) * longest * 2.0 / max(self.lever, 1.0)
            # Within the ball that is clear about it nothing is met on the way.
            if float(np.linalg.norm(move)) * self.lever < clear:
                rows.append(rows[-1] + move)
                clear = self._clear(rows[-1])
        return rows[1:] or rows
