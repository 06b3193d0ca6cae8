"""Ways from one pose of a platform to another without a singular pose between: proven impossible, found, or not found.

Two assembly modes of the same lengths may be joined without a singularity on the way (nonsingular assembly mode
change); where their orientations differ, there is always one between.

References: Innocenti and Parenti-Castelli, Singularity-free evolution from one configuration to another in serial and
fully-parallel manipulators, J. Mech. Design 120, 1998; Kuffner and LaValle, RRT-Connect, ICRA 2000.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, whole
from mafsil.parallel.planar.planar_legs import PlanarThreeRPR
from mafsil.parallel.platforms.pose_space import PoseSpace, pose_space, regular_radius, signed_measure
from mafsil.parallel.platforms.stewart import StewartPlatform

SPACING = 0.02
"""Distance of the places that the search looks at, over the size."""
REACH = 0.25
"""Longest branch of a tree, over the size."""
KEPT = 0.1
"""Share of the smaller measure of both ends that the search keeps everywhere; the proof needs some."""
TRIES = 4000
BALLS = 20_000
"""Regular balls along a path; more, and it is called not proven."""
SHORTCUTS = 60


class ModePathStatus(Status):
    """Whether two poses are joined by regular ones."""

    PROVEN = ("parallel.path_proven", True)
    LOOKED_AT = ("parallel.path_looked_at", True)
    OPPOSITE = ("parallel.path_opposite", False)
    SINGULAR_END = ("parallel.path_singular_end", False)
    NOT_FOUND = ("parallel.path_not_found", False)


@dataclass(frozen=True, eq=False, repr=False)
class ModePath(Answer, data="x lengths least measures places"):
    """A singularity-free path between two poses; true if there is one.

    Attributes:
        status: found and proven free of singularities, found and looked at only, proven impossible because det G has
            opposite signs at the ends, an end is singular itself, or none was found.
        x: (k, 4, 4) or (k, 3) corners, between them a rotation about one axis and a straight line; empty if none.
        lengths: (k, m) of the legs at the corners [m].
        least: smallest |det G| along it, over the smaller one of the ends, of the places that were looked at.
        measures: (2,) det G at both ends, moments over the size.
        places: how many were looked at, or how many regular balls cover the way.
    """

    status: ModePathStatus
    x: Floats
    lengths: Floats
    least: float
    measures: Floats
    places: int

    def explain(self, language: str | None = None) -> str:
        """What was found, and what proves it."""
        return self.status.sentence(
            language, corners=len(self.x), least=self.least, places=self.places, first=float(self.measures[0]),
            second=float(self.measures[1]),
        )  # fmt: skip


def mode_path(
    robot: StewartPlatform | PlanarThreeRPR, x_0: ArrayLike, x_1: ArrayLike, *, tries: int = TRIES, seed: int = 0
) -> ModePath:
    """A path from one pose to another without singularities of the second kind.

    1. det G has opposite signs at the ends: it is zero somewhere on every way, so there is none.
    2. The straight step, then two trees of random poses, grown towards each other through places where det G keeps its
       sign and a share of its size.
    3. Corners are cut where that stays so.
    4. The way is covered by balls of poses that are proven regular (`regular_radius`).

    Args:
        robot: a platform on six legs, or a planar one on three.
        x_0, x_1: poses (4, 4), or (x, y, phi).
        tries: random poses at most.
        seed: of the random poses.

    Raises:
        InputError: what is given is no pose, a leg has length zero there.
    """
    space, most = pose_space(robot), whole("tries", tries, 0)
    ends = np.stack([space.check("x_0", x_0), space.check("x_1", x_1)])
    f = signed_measure(space, ends)
    nothing = (np.zeros((0, *ends.shape[1:])), np.zeros((0, space.dimension)), 0.0, f, 0)
    if not (robot.singularity(ends[0]) and robot.singularity(ends[1])):
        return ModePath(ModePathStatus.SINGULAR_END, *nothing)
    if f[0] * f[1] < 0.0:
        return ModePath(ModePathStatus.OPPOSITE, *nothing)
    search = _Search(space, float(np.sign(f[0]) * KEPT * np.abs(f).min()), np.random.default_rng(seed))
    corners = search.way(ends[0], ends[1], most)
    if corners is None:
        return ModePath(ModePathStatus.NOT_FOUND, *nothing[:4], most)
    looked = np.concatenate([search.along(a, b) for a, b in pairwise(corners)])
    least = float(np.abs(signed_measure(space, looked)).min() / np.abs(f).min())
    balls = count_balls(space, corners)
    status = ModePathStatus.PROVEN if balls else ModePathStatus.LOOKED_AT
    return ModePath(status, corners, space.lengths(corners), least, f, balls or len(looked))


def count_balls(space: PoseSpace, corners: Floats) -> int:
    """How many regular balls cover straight steps between corners; 0 if they are not covered by `BALLS`.

    Args:
        space: of the robot's poses.
        corners: (k, 4, 4) or (k, 3).
    """
    count = 0
    for start, end in pairwise(corners):
        step = space.step(start, end)
        whole_length, gone = float(np.linalg.norm(step)), 0.0
        while gone < whole_length:
            if count == BALLS:
                return 0
            gone += max(float(regular_radius(space, space.integrate(start, step * (gone / whole_length)))), 0.0)
            count += 1
    return max(count, 1)


class _Search:
    """Two trees in a space of poses, through places where the measure keeps beyond a bound.

    Args:
        space: of the robot's poses.
        bound: the measure stays beyond it, on its side of zero.
        rng: where the random poses come from.
    """

    def __init__(self, space: PoseSpace, bound: float, rng: np.random.Generator) -> None:
        self.space, self.bound, self.rng = space, bound, rng

    def along(self, x: Floats, y: Floats) -> Floats:
        """Poses on the straight step, both ends included, `SPACING` apart."""
        step = self.space.step(x, y)
        count = 2 + int(np.linalg.norm(step) / (SPACING * self.space.size))
        return self.space.integrate(x, np.linspace(0.0, 1.0, count)[:, None] * step)

    def free(self, x: Floats, y: Floats) -> bool:
        """Whether the measure keeps beyond the bound along the straight step."""
        poses = self.along(x, y)
        if self.space.lengths(poses).min() < SPACING * self.space.size:
            return False
        f = signed_measure(self.space, poses)
        return bool((f * np.sign(self.bound) > abs(self.bound)).all())

    def way(self, start: Floats, end: Floats, tries: int) -> Floats | None:
        """Corners of a way, or None."""
        if self.free(start, end):
            return np.stack([start, end])
        place = self.space.place(np.stack([start, end]))
        low, high = place.min(axis=0) - self.space.size, place.max(axis=0) + self.space.size
        trees = [_Tree(start), _Tree(end)]
        for k in range(tries):
            growing, other = trees[k % 2], trees[1 - k % 2]
            tip = self._grown(growing, self.space.random(self.rng, low, high), once=True)
            if tip is None:
                continue
            met = self._grown(other, growing.poses[tip], once=False)
            if met is not None and float(np.linalg.norm(self.space.step(other.poses[met], growing.poses[tip]))) == 0.0:
                halves = [growing.back_from(tip), other.back_from(met)]
                first, second = halves if k % 2 == 0 else halves[::-1]
                return self._cut([*first[::-1], *second[1:]])
        return None

    def _grown(self, tree: _Tree, goal: Floats, *, once: bool) -> int | None:
        """Index of the last pose that was added towards a goal; None if nothing was."""
        steps = self.space.step(np.array(tree.poses), goal)
        nearest = int(np.linalg.norm(steps, axis=-1).argmin())
        added = None
        while True:
            here = tree.poses[nearest]
            step = self.space.step(here, goal)
            length = float(np.linalg.norm(step))
            if length == 0.0:
                return nearest
            share = min(1.0, REACH * self.space.size / length)
            ahead = goal if share == 1.0 else self.space.integrate(here, share * step)
            if not self.free(here, ahead):
                return added
            nearest = added = tree.add(ahead, nearest)
            if once or share == 1.0:
                return added

    def _cut(self, corners: list[Floats]) -> Floats:
        for _ in range(SHORTCUTS):
            if len(corners) < 3:
                break
            chosen: list[int] = self.rng.choice(len(corners), 2, replace=False).tolist()
            i, j = sorted(chosen)
            if j - i > 1 and self.free(corners[i], corners[j]):
                corners = corners[: i + 1] + corners[j:]
        return np.stack(corners)


class _Tree:
    """Poses, each reached from an earlier one."""

    def __init__(self, root: Floats) -> None:
        self.poses, self.parents = [root], [-1]

    def add(self, pose: Floats, parent: int) -> int:
        """Index of the new pose."""
        self.poses.append(pose)
        self.parents.append(parent)
        return len(self.poses) - 1

    def back_from(self, index: int) -> list[Floats]:
        """Poses from one back to the root."""
        found = [self.poses[index]]
        while self.parents[index] >= 0:
            index = self.parents[index]
            found.append(self.poses[index])
        return found
