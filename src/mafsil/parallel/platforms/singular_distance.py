"""How far a platform is from its nearest singular pose: a length that is proven free, and the nearest that was found.

Reference: Hasofer and Lind, Exact and invariant second-moment code format, 1974, and Rackwitz and Fiessler, 1978, for
the iteration to the nearest zero of a function.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import SingleAnswer, Status
from mafsil.arrays import Booleans, Floats, whole
from mafsil.messages.tables import on_screen
from mafsil.parallel.planar.planar_legs import PlanarThreeRPR
from mafsil.parallel.platforms.pose_space import PoseSpace, pose_space, regular_radius, signed_measure
from mafsil.parallel.platforms.stewart import StewartPlatform
from mafsil.parallel.singular_kinds import SingularKinds
from mafsil.parallel.tolerances import RANK

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
class NearestSingularity(SingleAnswer):
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

    def __repr__(self) -> str:
        return on_screen(self.explain())

    def explain(self, language: str | None = None) -> str:
        """Both lengths, and what they rest on."""
        return self.status.sentence(
            language, distance=self.distance, free=self.free, size=self.size, starts=self.starts,
            converged=self.converged,
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "status": self.status.name.lower(), "free": self.free,
            "distance": self.distance if np.isfinite(self.distance) else None, "x": self.x,
            "starts": self.starts, "converged": self.converged,
        }  # fmt: skip


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
        g2 = np.maximum((g**2).sum(axis=-1, keepdims=True), np.finfo(np.float64).tiny)
        ahead = (((g * xi).sum(axis=-1) - f)[:, None] / g2) * g - xi
        length = np.linalg.norm(ahead, axis=-1, keepdims=True)
        ahead *= np.minimum(1.0, LONGEST * size / np.maximum(length, np.finfo(np.float64).tiny))
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
