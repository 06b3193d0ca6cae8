"""Poses of a platform on extending legs as a space: steps, distances, and a radius within which nothing is singular.

A step has the length of a screw motion in metres: rotations count times the size of the robot.

How far a platform is from its nearest singular pose: a length that is proven free, and the nearest that was found.

Reference: Hasofer and Lind, Exact and invariant second-moment code format, 1974, and Rackwitz and Fiessler, 1978, for
the iteration to the nearest zero of a function.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, as_batch, whole
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import pose, rotation
from mafsil.parallel.legs.leg_lines import line_matrix, unit_vectors
from mafsil.parallel.planar.planar_legs import PlanarThreeRPR, planar_line_matrix
from mafsil.parallel.platforms.stewart import StewartPlatform
from mafsil.parallel.singular_kinds import SingularKinds
from mafsil.parallel.tolerances import RANK
from mafsil.solvers.decompositions import singular_values

BISECTIONS = 40


class PoseSpace(Protocol):
    """What searches need of a platform."""

    @property
    def size(self) -> float:
        """Of the robot [m]."""
        ...

    @property
    def dimension(self) -> int:
        """Of the space, 6 or 3."""
        ...

    def check(self, name: str, x: object) -> Floats:
        """One pose that a user gave."""
        ...

    def integrate(self, x: Floats, step: Floats) -> Floats:
        """Poses x after steps (*batch, dimension) [m]."""
        ...

    def step(self, x: Floats, y: Floats) -> Floats:
        """(*batch, dimension) from x to y [m]; a share of it leads to a pose between them."""
        ...

    def random(self, rng: np.random.Generator, low: Floats, high: Floats) -> Floats:
        """A pose with its place in a box and any orientation."""
        ...

    def place(self, x: Floats) -> Floats:
        """(*batch, 3 | 2) where the platform is [m]."""
        ...

    def lengths(self, x: Floats) -> Floats:
        """(*batch, m) of the legs [m]."""
        ...

    def lines(self, x: Floats) -> Floats:
        """(*batch, m, m) lines of the legs about the middle of the base, moments over the size."""
        ...

    def gains(self) -> tuple[Floats, Floats]:
        """(m,) how far ends b_i move per step, and how much a row of `lines` changes per change of its direction."""
        ...


@dataclass(frozen=True, eq=False)
class SpatialPoses:
    """Poses T (4, 4) of a platform on six legs."""

    robot: StewartPlatform

    @property
    def dimension(self) -> int:
        """Three rotations, three translations."""
        return 6

    @property
    def size(self) -> float:
        """Of the robot [m]."""
        return self.robot.size

    def check(self, name: str, x: object) -> Floats:
        """(4, 4)."""
        return pose.check(np.asarray(x, dtype=np.float64), name)

    def integrate(self, x: Floats, step: Floats) -> Floats:
        """Rotated about axes of {b}, shifted in {s}."""
        R = x[..., :3, :3] @ rotation.exp(step[..., :3] / self.size)
        return pose.from_rotation_translation(R, x[..., :3, 3] + step[..., 3:])

    def step(self, x: Floats, y: Floats) -> Floats:
        """The rotation about one axis, and the straight line."""
        turn = rotation.log(np.swapaxes(x[..., :3, :3], -1, -2) @ y[..., :3, :3])
        return np.concatenate([self.size * turn, y[..., :3, 3] - x[..., :3, 3]], axis=-1)

    def random(self, rng: np.random.Generator, low: Floats, high: Floats) -> Floats:
        """(4, 4)."""
        return pose.from_rotation_translation(rotation.random(rng), rng.uniform(low, high))

    def place(self, x: Floats) -> Floats:
        """Origin of {b}."""
        return x[..., :3, 3]

    def lengths(self, x: Floats) -> Floats:
        """(*batch, 6)."""
        return self.robot.lengths(x)

    def lines(self, x: Floats) -> Floats:
        """(*batch, 6, 6)."""
        arms = self.robot.base - self.robot.base.mean(axis=0)
        return line_matrix(arms, unit_vectors(self.robot.leg_vectors(x))[1]) / np.repeat([self.size, 1.0], 3)

    def gains(self) -> tuple[Floats, Floats]:
        """Of ends and rows."""
        return _gains(self.robot.base, self.robot.platform, self.size)


@dataclass(frozen=True, eq=False)
class PlanarPoseSpace:
    """Poses (x, y, phi) of a planar platform on three legs."""

    robot: PlanarThreeRPR

    @property
    def dimension(self) -> int:
        """Two translations, one rotation."""
        return 3

    @property
    def size(self) -> float:
        """Of the robot [m]."""
        return self.robot.size

    def check(self, name: str, x: object) -> Floats:
        """(3,)."""
        return as_batch(name, x, (3,), finite=True)  # type: ignore[arg-type]

    def integrate(self, x: Floats, step: Floats) -> Floats:
        """Rotated, and shifted in {s}."""
        return x + step / np.array([1.0, 1.0, self.size])

    def step(self, x: Floats, y: Floats) -> Floats:
        """The shorter rotation, and the straight line."""
        found = y - x
        turn = (found[..., 2:] + np.pi) % (2 * np.pi) - np.pi
        return np.concatenate([found[..., :2], self.size * turn], axis=-1)

    def random(self, rng: np.random.Generator, low: Floats, high: Floats) -> Floats:
        """(3,)."""
        return np.append(rng.uniform(low, high), rng.uniform(-np.pi, np.pi))

    def place(self, x: Floats) -> Floats:
        """Origin of {b}."""
        return x[..., :2]

    def lengths(self, x: Floats) -> Floats:
        """(*batch, 3)."""
        return self.robot.lengths(x)

    def lines(self, x: Floats) -> Floats:
        """(*batch, 3, 3)."""
        arms = self.robot.base - self.robot.base.mean(axis=0)
        rows = planar_line_matrix(arms, unit_vectors(self.robot.leg_vectors(x))[1])
        return rows / np.array([self.size, 1.0, 1.0])

    def gains(self) -> tuple[Floats, Floats]:
        """Of ends and rows."""
        return _gains(self.robot.base, self.robot.platform, self.size)


def pose_space(robot: StewartPlatform | PlanarThreeRPR) -> PoseSpace:
    """The space of a robot's poses."""
    return SpatialPoses(robot) if isinstance(robot, StewartPlatform) else PlanarPoseSpace(robot)


def _gains(base: Floats, platform: Floats, size: float) -> tuple[Floats, Floats]:
    ends = np.hypot(1.0, np.linalg.norm(platform, axis=-1) / size)
    rows = np.hypot(1.0, np.linalg.norm(base - base.mean(axis=0), axis=-1) / size)
    return ends, rows


def signed_measure(space: PoseSpace, x: Floats) -> Floats:
    """(*batch,) determinant of the lines: zero where the platform moves with all legs locked."""
    return np.asarray(np.linalg.det(space.lines(x)), dtype=np.float64)


def regular_radius(space: PoseSpace, x: Floats) -> Floats:
    """(*batch,) a length of steps within which no pose is singular: proven, and smaller than the largest such length.

    Each end moves by at most its gain times the step r, so the direction of a leg of length s turns by at most
    asin(gain r / s); a matrix whose change has a Frobenius norm below its least singular value keeps its rank.
    """
    ends, rows = space.gains()
    least, s = singular_values(np.ascontiguousarray(space.lines(x)))[..., -1], space.lengths(x)
    low: Floats = np.zeros(least.shape)
    high: Floats = (s / ends).min(axis=-1)
    for _ in range(BISECTIONS):
        r = (low + high) / 2
        turn: Floats = np.arcsin(np.minimum(ends * r[..., None] / s, 1.0))
        change: Floats = np.linalg.norm(2 * np.sin(turn / 2) * rows, axis=-1)
        safe = change < least
        low, high = np.where(safe, r, low), np.where(safe, high, r)
    return low


RELAXED = (1.0,) * 60 + (0.5,) * 60 + (0.25,) * 60 + (0.1,) * 80
"""Shares of the steps that are taken, one after the other: full ones may go to and fro where the measure bends."""
DIFFERENCE = 1e-6
"""Step of central differences over the size: errors of 1e-10 of the gradient."""
CONVERGED = 1e-9
"""Last change, over the size, below which a start has found its zero."""
LONGEST = 0.2
"""Change of one iteration over the size: the measure is no polynomial of low degree further away."""


class NearestStatus(Status):
    """What is known about the nearest singular pose."""

    FOUND = ("parallel.nearest_found", True)
    HERE = ("parallel.nearest_here", True)
    NOT_FOUND = ("parallel.nearest_not_found", False)


@dataclass(frozen=True, eq=False, repr=False)
class NearestSingularity(Answer, data="free x starts converged"):
    """The singular pose nearest to a pose, of those that were found; true if one was.

    Attributes:
        status: found, or the pose itself is singular, or none was found.
        free: no pose within this length is singular, by a bound on how legs turn: proven [m].
        distance: length of the step to the nearest singular pose found, rotations times the size; infinite if none [m].
        x: that pose, (4, 4) or (3,); None if none.
        kinds: of the singularity there; None if none.
        size: of the robot [m].
        starts, converged: how many searches began, and how many of them ended at a singular pose.
    """

    status: NearestStatus
    free: float
    distance: float
    x: Floats | None
    kinds: SingularKinds | None
    size: float
    starts: int
    converged: int

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return Answer.to_dict(self) | {"distance": self.distance if np.isfinite(self.distance) else None}


def nearest_singularity(
    robot: StewartPlatform | PlanarThreeRPR, x: ArrayLike, *, starts: int = 64, seed: int = 0
) -> NearestSingularity:
    """The singular pose (of the second kind) nearest to a pose.

    1. From each start xi, a random step of up to the size, the zero of the linearised measure f nearest to the pose:
       xi <- (g . xi - f) g / |g|^2, by at most a fifth of the size at a time.
    2. Fixed points are zeros of f at which the step is along the gradient: the pose cannot be nearer in first order.
    3. The shortest of them is the answer. That there is no nearer one is not proven; `free` is.

    Args:
        robot: a platform on six legs, or a planar one on three.
        x: pose T_sb (4, 4), or (x, y, phi).
        starts: how many searches begin.
        seed: of their random steps.

    Raises:
        InputError: x is no pose, a leg has length zero there.
    """
    space = pose_space(robot)
    here, count = space.check("x", x), whole("starts", starts, 1)
    free = float(regular_radius(space, here))
    if not robot.singularity(here):
        return NearestSingularity(NearestStatus.HERE, 0.0, 0.0, here, robot.singularity(here), space.size, 0, 0)
    steps, found = _zeros(space, here, count, np.random.default_rng(seed))
    if not found.any():
        return NearestSingularity(NearestStatus.NOT_FOUND, free, np.inf, None, None, space.size, count, 0)
    lengths = np.where(found, np.linalg.norm(steps, axis=-1), np.inf)
    best = int(lengths.argmin())
    place = space.integrate(here, steps[best])
    return NearestSingularity(
        NearestStatus.FOUND, free, float(lengths[best]), place, robot.singularity(place), space.size, count,
        int(found.sum()),
    )  # fmt: skip


def _zeros(space: PoseSpace, here: Floats, count: int, rng: np.random.Generator) -> tuple[Floats, Booleans]:
    """Steps (count, n) to which the iteration led, and whether (count,) they are singular poses."""
    n, size = space.dimension, space.size
    xi = rng.normal(size=(count, n))
    xi *= size * rng.uniform(0.0, 1.0, (count, 1)) / np.linalg.norm(xi, axis=-1, keepdims=True)
    xi[0] = 0.0
    change = np.full(count, np.inf)
    for share in RELAXED:
        f, g = _measure_and_gradient(space, here, xi)
        g2 = np.maximum((g**2).sum(axis=-1, keepdims=True), LEAST_DIVISOR)
        ahead = (((g * xi).sum(axis=-1) - f)[:, None] / g2) * g - xi
        length = np.linalg.norm(ahead, axis=-1, keepdims=True)
        ahead *= np.minimum(1.0, LONGEST * size / np.maximum(length, LEAST_DIVISOR))
        xi, change = xi + share * ahead, np.linalg.norm(ahead, axis=-1)
        if (change < CONVERGED * size).all():
            break
    s = np.linalg.svd(space.lines(space.integrate(here, xi)), compute_uv=False)
    return xi, (change < CONVERGED * size) & (s[..., -1] < RANK * np.maximum(s[..., 0], 1.0))


def _measure_and_gradient(space: PoseSpace, here: Floats, xi: Floats) -> tuple[Floats, Floats]:
    """Of all steps (count, n), by central differences."""
    h = DIFFERENCE * space.size
    shifts = np.concatenate([np.zeros((1, space.dimension)), h * np.eye(space.dimension), -h * np.eye(space.dimension)])
    f = signed_measure(space, space.integrate(here, xi[:, None, :] + shifts))
    n = space.dimension
    return f[:, 0], (f[:, 1 : n + 1] - f[:, n + 1 :]) / (2 * h)
