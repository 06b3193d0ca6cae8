"""Configuration-space obstacles: which configurations of an arm each obstacle forbids, painted on a grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, as_batch, positive, real_array, single, whole
from mafsil.errors import InputError
from mafsil.planning.polygons import PolygonWorld, distances_to_segments
from mafsil.planning.problem import Problem, require_few_cells


@dataclass(frozen=True, eq=False)
class PlanarArm:
    """Links as segments in the plane, of some thickness, that turn at their ends; the whole arm is looked at.

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


def configuration_space(arm: PlanarArm, cells: int = 100) -> tuple[tuple[Floats, ...], NDArray[np.bool_]]:
    """Axes of the grid, and for each obstacle whether the middle of each cell is forbidden by it.

    Args:
        arm: of two or three joints.
        cells: along each angle.

    Returns:
        (n) axes, and bools (obstacles, cells, ..., cells): each obstacle's patch by itself.

    Reference: Lozano-Perez, Spatial planning: a configuration space approach, 1983.
    """
    count, n = whole("cells", cells, least=1), len(arm.lengths)
    require_few_cells(count**n)
    axis: Floats = np.asarray(-np.pi + (np.arange(count) + 0.5) * (2.0 * np.pi / count), dtype=np.float64)
    grid: JointVector = np.asarray(np.stack(np.meshgrid(*[axis] * n, indexing="ij"), axis=-1), dtype=np.float64)
    grid = grid.reshape(-1, n)
    hits = np.concatenate([arm.hits(part) for part in np.array_split(grid, max(len(grid) // 20_000, 1))])
    return (axis,) * n, np.moveaxis(hits.reshape(*(count,) * n, -1), -1, 0)


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
    share = ((c[None] - a[:, None]) * way[:, None]).sum(axis=2) / np.maximum((way**2).sum(axis=1), 1e-300)[:, None]
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
