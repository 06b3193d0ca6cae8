"""Poses of a platform on extending legs as a space: steps, distances, and a radius within which nothing is singular.

A step has the length of a screw motion in metres: rotations count times the size of the robot.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mafsil.arrays import Floats, as_batch
from mafsil.geometry import pose, rotation
from mafsil.parallel.legs.leg_lines import line_matrix, unit_vectors
from mafsil.parallel.planar.planar_legs import PlanarThreeRPR, planar_line_matrix
from mafsil.parallel.platforms.stewart import StewartPlatform
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
