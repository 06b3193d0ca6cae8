"""Configuration-space obstacles: which configurations of an arm each obstacle forbids, painted on a grid."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, as_batch, positive, real_array, single, whole
from mafsil.collision import Checker
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.planning.polygons import PolygonWorld, distances_to_segments
from mafsil.planning.problem import Problem, require_few_cells

MOST_PAINTED = 3
"""Coordinates of a picture."""


@dataclass(frozen=True, eq=False)
class PlanarArm:
    """A planar arm of thick segments with revolute joints; the whole arm is checked.

    Attributes:
        lengths: (n,) of the links [m].
        world: obstacles.
        thickness: radius of the links [m].
        base: (2,) of the first joint [m].
    """

    lengths: Floats
    world: PolygonWorld
    thickness: float = 0.0
    base: tuple[float, float] = (0.0, 0.0)

    def joints(self, q: ArrayLike) -> Floats:
        """(k, n + 1, 2) places of the joints and of the tip, q (k, n) relative angles [rad]."""
        angles = np.cumsum(np.atleast_2d(as_batch("q", q, self.lengths.shape)), axis=1)
        steps = self.lengths[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        start = np.broadcast_to(np.asarray(self.base), (len(angles), 1, 2))
        return np.concatenate([start, start + np.cumsum(steps, axis=1)], axis=1)

    def hits(self, q: ArrayLike) -> NDArray[np.bool_]:
        """(k, obstacles) which obstacles each configuration (k, n) meets with any link."""
        places = self.joints(q)
        found = np.zeros((len(places), len(self.world.polygons)), dtype=np.bool_)
        for index, corners in enumerate(self.world.polygons):
            alone = PolygonWorld(self.world.lower, self.world.upper, (corners,))
            for link in range(len(self.lengths)):
                a, b = places[:, link], places[:, link + 1]
                inside = ~alone.free(a) | ~alone.free(b)
                near = _segments_apart(a, b, corners) < max(self.thickness, self.world.slack)
                found[:, index] |= inside | near
        return found

    def free(self, q: ArrayLike) -> NDArray[np.bool_]:
        """(k,) whether configurations (k, n) meet no obstacle."""
        return np.asarray(~self.hits(q).any(axis=1), dtype=np.bool_)

    def problem(self, *, resolution: float = 0.01) -> Problem:
        """The planning problem of this arm, every angle from -pi to pi.

        Args:
            resolution: largest change of an angle between two places that are looked at [rad].
        """
        n = len(self.lengths)
        return Problem(np.full(n, -np.pi), np.full(n, np.pi), self.free, resolution=resolution)


def configuration_space_obstacles(
    arm: PlanarArm | Checker, cells: int = 100, *, joints: Iterable[str] | None = None, at: ArrayLike | None = None
) -> tuple[tuple[Floats, ...], NDArray[np.bool_]]:
    """Axes of the grid, and for each obstacle whether the middle of each cell is forbidden by it.

    Args:
        arm: among polygons, or any arm in its scene.
        cells: along each coordinate.
        joints: of an arm in its scene, names of one to three coordinates; all if None. They go from limit to limit, or
            half a turn to both sides of zero.
        at: (n,) where the other coordinates are; the zero configuration if None [rad | m].

    Returns:
        (k) axes, and bools (patches, cells, ..., cells): each obstacle's patch by itself, in the order of the scene;
        the last patch of an arm in its scene is what it forbids itself.

    Raises:
        InputError: no such joint, none or more than three, one that slides without limits, a wrong shape.

    Reference: Lozano-Perez, Spatial planning: a configuration space approach, 1983.
    """
    count = whole("cells", cells, least=1)
    if isinstance(arm, PlanarArm):
        columns, rest = np.arange(len(arm.lengths)), np.zeros(len(arm.lengths))
        lower, upper = rest - np.pi, rest + np.pi
    else:
        columns, lower, upper = _paint(arm, joints)
        rest = arm.zero if at is None else single("at", at, (arm.robot.n,))
    require_few_cells(count ** len(columns))
    places = (np.arange(count) + 0.5) / count
    axes = tuple(lower[k] + places * (upper[k] - lower[k]) for k in range(len(columns)))
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(columns))
    parts: list[NDArray[np.bool_]] = []
    for some in np.array_split(grid, max(len(grid) // 20_000, 1)):
        q = np.repeat(rest[None], len(some), axis=0)
        q[:, columns] = some
        parts.append(arm.hits(np.asarray(q)))
    hits = np.concatenate(parts)
    return axes, np.moveaxis(hits.reshape(*(count,) * len(columns), -1), -1, 0)


def _paint(arm: Checker, joints: Iterable[str] | None) -> tuple[NDArray[np.int64], Floats, Floats]:
    """Columns of the coordinates that are painted, and from where to where they go."""
    known = arm.robot.mechanism.coordinates
    names = [each.name for each in known]
    asked = names if joints is None else list(joints)
    for name in asked:
        if name not in names:
            raise InputError("input.choice", name="joints", value=name, known=", ".join(names))
    if not 1 <= len(set(asked)) == len(asked) <= MOST_PAINTED:
        raise InputError("planning.painted", count=len(asked), most=MOST_PAINTED, known=", ".join(names))
    columns = np.array([names.index(name) for name in asked], np.int64)
    turns = np.array([known[names.index(name)].screw[:3].any() for name in asked], np.bool_)
    lower, upper = arm.robot.limits.lower[columns], arm.robot.limits.upper[columns]
    lower = np.where(np.isinf(lower) & turns, -np.pi, lower)
    upper = np.where(np.isinf(upper) & turns, np.pi, upper)
    for name, low, high in zip(asked, lower, upper, strict=True):
        if not np.isfinite([low, high]).all():
            raise InputError("planning.slides_without_end", joint=name)
    return columns, lower, upper


def planar_arm(
    lengths: ArrayLike, world: PolygonWorld, *, thickness: float = 0.0, base: ArrayLike = (0.0, 0.0)
) -> PlanarArm:
    """An arm among polygons.

    Args:
        lengths: (n,) of the links [m].
        world: obstacles.
        thickness: radius of the links [m].
        base: (2,) of the first joint [m].

    Raises:
        InputError: a wrong shape, a length that is not positive, a thickness below zero.
    """
    rows = np.atleast_1d(real_array("lengths", lengths))
    if rows.ndim != 1 or not len(rows):
        raise InputError("input.shape", name="lengths", expected="(n,)", got=rows.shape, hint="")
    for k, length in enumerate(rows.tolist()):
        positive(f"lengths[{k}]", length)
    radius = 0.0 if thickness == 0.0 else positive("thickness", thickness)
    x, y = single("base", base, (2,)).tolist()
    return PlanarArm(rows, world, radius, (x, y))


def _segments_apart(a: Floats, b: Floats, corners: Floats) -> Floats:
    """(k,) distance of segments a-b (k, 2) each to the edges of a polygon; zero where they cross."""
    c, d = corners, np.roll(corners, -1, axis=0)
    ends = np.minimum(distances_to_segments(a, c, d).min(axis=1), distances_to_segments(b, c, d).min(axis=1))
    way = b - a
    share = ((c[None] - a[:, None]) * way[:, None]).sum(axis=2) / np.maximum((way**2).sum(axis=1), LEAST_DIVISOR)[
        :, None
    ]
    foot = a[:, None] + np.clip(share, 0.0, 1.0)[..., None] * way[:, None]
    best = np.minimum(ends, np.linalg.norm(foot - c[None], axis=2).min(axis=1))
    edge = (d - c)[None]
    cross = way[:, None, 0] * edge[..., 1] - way[:, None, 1] * edge[..., 0]
    between = c[None] - a[:, None]
    safe = np.where(cross == 0.0, 1.0, cross)
    s = (between[..., 0] * edge[..., 1] - between[..., 1] * edge[..., 0]) / safe
    t = (between[..., 0] * way[:, None, 1] - between[..., 1] * way[:, None, 0]) / safe
    meets = (cross != 0.0) & (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0)
    return np.where(meets.any(axis=1), 0.0, best)
