"""Charts of a surface of configurations: points, tangent planes and cells, spread by waves until they cover it.

Points are coordinates over `units`; the angle of a hinge is one modulo 2 pi, so that a turn leads back.

Cells in a plane: convex polygons about the origin, cut by the half-planes nearer to it than to neighbours.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, hypot, pi, sin

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.linkages.loop_closure import are_lengths, close_loops_near, loop_matrix, units
from mafsil.solvers.points_on_circles import PointsOnCircles

Corner = tuple[float, float, int]
"""A corner (x, y) and the owner of the edge from it to the next corner."""
Cell = list[Corner]
NOBODY = -1
"""Owner of edges that no neighbour has cut yet."""
SIDES = 8
Whole = NDArray[np.intp]
TURN = 0.3
"""Turn of the tangent plane [rad] over the radius of a chart."""
MOST_TURN = 0.6
"""Beyond it a step is refused and the radius halved."""
TOO_FAR = 0.35
"""Share of a step that its correction may be."""
REACH = 1.5
"""Steps go this many radii far at most: points end between 1 and 1.5 radii apart."""
CELL = 2.0
"""Radii to the corners of a cell before neighbours cut it."""
ALIGNED = 0.7
"""Least cosine between tangent planes of neighbours on one sheet, which are up to two steps apart."""
OFF_PLANE = 0.45
"""Share of the distance to a neighbour on one sheet by which it may be off the tangent plane."""
SMALLEST = 1 / 64
"""Share of the longest radius below which a chart gives up: the surface is not smooth within it."""
DIFFERENCE = 1e-4
"""Step [rad, sizes] of differences: rounding of tangent planes and the error of the difference are both below 1e-4."""
NEWTON_STEPS = 12
NEAREST = 3
WAYS = 6
"""Steps of a way to a point: each squares what is missed."""
ARRIVED = 1e-6
"""A way that ends so near to a point [rad, sizes] ends there: ten digits after Newton's method."""


@dataclass(eq=False)
class Charts:
    """Charts so far.

    Attributes:
        linkage: whose configurations.
        radius: longest of a chart [rad, sizes].
        points: (n, F) coordinates over `units`.
        bases: (n, F, 2) orthonormal bases of the tangent planes.
        radii: (n,) that each chart has to cover.
        reach: (n,) distance of the farthest corner of each cell.
        cells: polygons in the tangent planes: nearer to this point than to others.
        stuck: charts that gave up.
    """

    linkage: Linkage
    radius: float
    points: Floats
    bases: Floats
    radii: Floats
    reach: Floats
    cells: list[Cell] = field(default_factory=list[list[Corner]])
    stuck: set[int] = field(default_factory=set[int])

    @classmethod
    def first_chart(cls, linkage: Linkage, theta: Floats, radius: float) -> Charts:
        """One chart at a configuration (F,) whose mobility by rank is 2."""
        F = linkage.coordinates
        empty = cls(linkage, radius, np.zeros((0, F)), np.zeros((0, F, 2)), np.zeros(0), np.zeros(0))
        point = wrapped_points(linkage, (theta / units(linkage))[None])
        empty._add(point, tangent_planes(linkage, point))
        return empty

    def spread(self, most: int) -> bool:
        """Add charts until all cells lie within the radii of their charts; whether `most` charts were enough.

        1. Each chart whose cell has a corner outside its radius steps towards it, at most `REACH` radii far.
        2. All steps are closed by Newton's method at once. A step whose correction or turn of the tangent plane is
           large halves the radius of its chart.
        3. Of the new points those are kept that are far enough from each other; cells around them are cut.
        """
        waiting = [0]
        while waiting:
            if len(self.points) >= most:
                return False
            steps = [(k, *self._towards(k)) for k in waiting]
            ids = np.array([k for k, _, _ in steps], dtype=np.intp)
            aims = np.array([(x, y) for _, x, y in steps])
            touched = self._advance(ids, aims)
            waiting = [k for k in sorted({*waiting, *touched}) if self._open(k)]
        return True

    def _open(self, k: int) -> bool:
        return k not in self.stuck and bool(self.reach[k] > self.radii[k] * (1 + 1e-9))

    def _towards(self, k: int) -> tuple[float, float]:
        distance, x, y = farthest(self.cells[k])
        share = min(1.0, REACH * float(self.radii[k]) / distance)
        return share * x, share * y

    def _advance(self, ids: Whole, aims: Floats) -> set[int]:
        """Steps (m, 2) in the planes of charts; indices of the charts whose cells or radii changed."""
        start, bases = self.points[ids], self.bases[ids]
        ahead = start + np.einsum("mfi,mi->mf", bases, aims)
        scale, length = units(self.linkage), np.linalg.norm(aims, axis=1)
        closed = close_loops_near(self.linkage, ahead * scale, steps=NEWTON_STEPS)
        found = closed.theta / scale
        planes = tangent_planes(self.linkage, found)
        turn = np.arccos(np.clip(_least_cosine(bases, planes), 0.0, 1.0))
        good = closed.closed & (np.linalg.norm(found - ahead, axis=1) < TOO_FAR * length) & (turn < MOST_TURN)
        for k in ids[~good].tolist():
            self.radii[k] /= 2
            if self.radii[k] < SMALLEST * self.radius:
                self.stuck.add(k)
        touched = set(ids.tolist())
        fresh = self._apart(found, np.flatnonzero(good), ids)
        return touched | self._add(wrapped_points(self.linkage, found[fresh]), planes[fresh]) if len(fresh) else touched

    def _apart(self, found: Floats, good: Whole, ids: Whole) -> Whole:
        """Of new points those that are a radius of their parents apart from each other."""
        kept: list[int] = []
        for k in good.tolist():
            far = np.linalg.norm(differences(self.linkage, found[k], found[kept]), axis=1)
            if not kept or bool((far > self.radii[ids[k]]).all()):
                kept.append(k)
        return np.array(kept, dtype=np.intp)

    def _add(self, points: Floats, bases: Floats) -> set[int]:
        """New charts, with radii by their curvature; indices of all whose cells changed."""
        first = len(self.points)
        fitting = TURN / np.maximum(curvatures(self.linkage, points, bases), TURN / self.radius)
        self.stuck |= set((first + np.flatnonzero(fitting < SMALLEST * self.radius)).tolist())
        radii = np.maximum(fitting, SMALLEST * self.radius)
        self.points = np.concatenate([self.points, points])
        self.bases = np.concatenate([self.bases, bases])
        self.radii = np.concatenate([self.radii, radii])
        self.reach = np.concatenate([self.reach, CELL * radii])
        self.cells += [open_cell(CELL * radius) for radius in radii.tolist()]
        touched = set(range(first, len(self.points)))
        near = self.tree().within(points, 2 * CELL * self.radius)
        news = np.repeat(np.arange(first, len(self.points)), [len(others) for others in near])
        others = np.array([j for ids in near for j in ids], dtype=np.intp)
        once = (others < news) | ((others >= first) & (others != news))
        return touched | self._cut_pairs(news[once], others[once])

    def _cut_pairs(self, news: Whole, others: Whole) -> set[int]:
        """Cut cells of new charts by neighbours on their sheets, and theirs by them; indices of those that changed.

        Args:
            news: (m,) ascending.
            others: (m,) of charts near each.
        """
        together, u, v, square = self.neighbours(news, others)
        news, others, half = news[together], others[together], square / 2
        touched: set[int] = set()
        away = half / np.maximum(np.linalg.norm(v, axis=1), LEAST_DIVISOR)
        for k in sorted({int(k) for k in news}):
            own = slice(*np.searchsorted(news, (k, k + 1)).tolist())
            before: Cell = self.cells[k]
            after = cut_by(before, u[own], half[own], others[own])
            self.cells[k], self.reach[k] = after, farthest(after)[0]
            for m in (own.start + np.flatnonzero(away[own] < self.reach[others[own]])).tolist():
                j = int(others[m])
                before = self.cells[j]
                after = cut(before, float(v[m, 0]), float(v[m, 1]), float(half[m]), k)
                if after is not before:
                    self.cells[j], self.reach[j] = after, farthest(after)[0]
                    touched.add(j)
        return touched

    def neighbours(self, first: Whole, second: Whole) -> tuple[NDArray[np.bool_], Floats, Floats, Floats]:
        """Of pairs of charts (m,) those on one sheet.

        Returns:
            which they are, and of them the second in the plane of the first, the first in the plane of the second, and
            squared distances.
        """
        d = differences(self.linkage, self.points[first], self.points[second])
        square = np.sum(d**2, axis=1)
        u = np.einsum("mf,mfi->mi", d, self.bases[first])
        v = -np.einsum("mf,mfi->mi", d, self.bases[second])
        off = square - np.minimum(np.sum(u**2, axis=1), np.sum(v**2, axis=1))
        together = off <= OFF_PLANE**2 * square
        together[together] &= _least_cosine(self.bases[first[together]], self.bases[second[together]]) > ALIGNED
        return together, u[together], v[together], square[together]

    def leads_to(self, points: Floats) -> NDArray[np.bool_]:
        """(m,) whether ways along the surface, from the nearest charts, end in points (m, F) of configurations.

        A way goes along the tangent plane to below the point, is closed by Newton's method, and goes on from there.
        """
        ids = self.tree().nearest(points, NEAREST)
        goal = np.repeat(points, ids.shape[1], axis=0)
        here, scale = self.points[ids.reshape(-1)], units(self.linkage)
        first = here.copy()
        for _ in range(WAYS):
            planes = tangent_planes(self.linkage, here)
            ahead = differences(self.linkage, here, goal)
            below = np.einsum("mfi,mgi,mg->mf", planes, planes, ahead)
            here = close_loops_near(self.linkage, (here + below) * scale, steps=NEWTON_STEPS).theta / scale
        gone = np.linalg.norm(differences(self.linkage, first, here), axis=1)
        there = np.linalg.norm(differences(self.linkage, here, goal), axis=1) < ARRIVED
        near = gone < 2 * CELL * self.radii[ids.reshape(-1)]
        return np.asarray((there & near).reshape(ids.shape).any(axis=1))

    def tree(self) -> PointsOnCircles:
        """The points, to be asked for neighbours."""
        return PointsOnCircles(self.points, angular(self.linkage))


def angular(linkage: Linkage) -> NDArray[np.bool_]:
    """(F,) which coordinates are angles that a full turn leads back to: no screws that advance, no translations."""
    w, v = linkage.screws[:3], linkage.screws[3:]
    return ~are_lengths(linkage) & (np.abs(np.sum(w * v, axis=0)) <= 1e-12 * linkage.size)


def wrapped_points(linkage: Linkage, points: Floats) -> Floats:
    """(*batch, F) the same points with angles in [-pi, pi)."""
    return np.where(angular(linkage), np.remainder(points + np.pi, 2 * np.pi) - np.pi, points)


def differences(linkage: Linkage, start: Floats, ends: Floats) -> Floats:
    """(*batch, F) shortest ways from a point to others."""
    return wrapped_points(linkage, ends - start)


def tangent_planes(linkage: Linkage, points: Floats) -> Floats:
    """(*batch, F, 2) orthonormal bases of the planes of possible rates."""
    A = loop_matrix(linkage, points * units(linkage))
    return np.swapaxes(np.linalg.svd(A)[2][..., -2:, :], -1, -2)


def curvatures(linkage: Linkage, points: Floats, planes: Floats) -> Floats:
    """(n,) bound of the turn of the tangent plane per length in any direction [1/rad, 1/sizes], by differences."""
    normal = np.zeros(len(points))
    for k in range(2):
        ahead = tangent_planes(linkage, points + DIFFERENCE * planes[..., k])
        off = ahead - planes @ (np.swapaxes(planes, -1, -2) @ ahead)
        normal += np.sum(off**2, axis=(-2, -1))
    return np.sqrt(normal) / DIFFERENCE


def _least_cosine(first: Floats, second: Floats) -> Floats:
    """(*batch,) cosine of the largest angle between two planes."""
    M = np.swapaxes(first, -1, -2) @ second
    square, determinant = np.sum(M**2, axis=(-2, -1)), np.abs(M[..., 0, 0] * M[..., 1, 1] - M[..., 0, 1] * M[..., 1, 0])
    larger = (
        np.sqrt(np.maximum(square + 2 * determinant, 0.0)) + np.sqrt(np.maximum(square - 2 * determinant, 0.0))
    ) / 2
    return determinant / np.maximum(larger, LEAST_DIVISOR)


def open_cell(radius: float) -> Cell:
    """A regular polygon with corners at a radius, whose edges nobody owns."""
    return [(radius * cos(2 * pi * k / SIDES), radius * sin(2 * pi * k / SIDES), NOBODY) for k in range(SIDES)]


def cut(cell: Cell, a: float, b: float, c: float, owner: int) -> Cell:
    """What is left of a cell where a x + b y <= c; the new edge belongs to the owner."""
    over = [a * x + b * y - c for x, y, _ in cell]
    if max(over, default=0.0) <= 0.0:
        return cell
    kept: Cell = []
    for k, (x, y, own) in enumerate(cell):
        after = (k + 1) % len(cell)
        here, there = over[k], over[after]
        if here <= 0.0:
            kept.append((x, y, own))
        if (here <= 0.0) != (there <= 0.0):
            share = here / (here - there)
            x2, y2, _ = cell[after]
            kept.append((x + share * (x2 - x), y + share * (y2 - y), owner if here <= 0.0 else own))
    return kept


def cut_by(cell: Cell, directions: Floats, limits: Floats, owners: NDArray[np.intp]) -> Cell:
    """What is left of a cell where directions @ (x, y) <= limits, the nearest first: most of them miss what is left.

    Args:
        cell: about the origin.
        directions: (m, 2).
        limits: (m,).
        owners: (m,) of the new edges.
    """
    if not len(owners):
        return cell
    away = limits / np.maximum(np.linalg.norm(directions, axis=1), LEAST_DIVISOR)
    order = np.argsort(away, kind="stable")
    reach = farthest(cell)[0]
    rows = (part[order].tolist() for part in (away, directions, limits, owners))
    for far, (a, b), limit, owner in zip(*rows, strict=True):
        if far >= reach:
            break
        after = cut(cell, a, b, limit, owner)
        if after is not cell:
            cell, reach = after, farthest(after)[0]
    return cell


def farthest(cell: Cell) -> tuple[float, float, float]:
    """(distance, x, y) of the corner farthest from the origin; zeros of an empty cell."""
    return max(((hypot(x, y), x, y) for x, y, _ in cell), default=(0.0, 0.0, 0.0))


def owners(cell: Cell) -> list[int]:
    """Owners of the edges in order around the origin."""
    return [own for _, _, own in cell]
