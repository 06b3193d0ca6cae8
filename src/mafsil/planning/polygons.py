"""Worlds of polygons in the plane: what is inside, what a segment crosses, distances; exact up to rounding.

Obstacles are open: to slide along an edge or to pass a corner is free. Between obstacles that share an edge, or one and
the border, nothing passes.

The shortest way of a point among polygons: the visibility graph, exact.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from time import perf_counter
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, as_batch, single
from mafsil.errors import InputError
from mafsil.fields import check_fields, vector
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.planning.outcome import Plan, PlanningStatus
from mafsil.planning.search import shortest_way

ON_EDGE = 1e-9
"""Share of the size of the world within which a point is on an edge, not in the obstacle."""
BESIDE = 10.0
"""Edges' thicknesses beside a segment at which one side of it must be free."""


class _Edges(NamedTuple):
    """Edges of polygons, side by side.

    Attributes:
        begin, end: (e, 2) of each [m].
        first: (k,) of each polygon.
        longest: (e,) largest component of an edge of the same polygon [m].
    """

    begin: Floats
    end: Floats
    first: NDArray[np.int64]
    longest: Floats


@dataclass(frozen=True, eq=False)
class PolygonWorld:
    """Simple polygons in a rectangle.

    Attributes:
        lower, upper: (2,) corners of the rectangle [m].
        polygons: (k, 2) corners of each obstacle, counter-clockwise, in the order of their names.
    """

    lower: Floats
    upper: Floats
    polygons: tuple[Floats, ...]
    _corners = check_fields(
        lower=vector(2), upper=vector(2), polygons=lambda _, value: tuple(_counter_clockwise(value))
    )

    def __post_init__(self) -> None:
        self._corners()
        if not (self.lower < self.upper).all():
            k = int(np.argmin(self.lower < self.upper))
            raise InputError("planning.bounds", index=k, lower=float(self.lower[k]), upper=float(self.upper[k]))

    @classmethod
    def of(cls, lower: ArrayLike, upper: ArrayLike, polygons: Sequence[ArrayLike]) -> PolygonWorld:
        """From lists of corners in any sense.

        Raises:
            InputError: a wrong shape, a number that is not finite, a polygon without area, no rectangle.
        """
        return cls(cast("Floats", lower), cast("Floats", upper), cast("tuple[Floats, ...]", polygons))

    @property
    def slack(self) -> float:
        """What counts as an edge [m]."""
        return ON_EDGE * float(np.abs(self.upper - self.lower).max())

    def inside(self, points: ArrayLike) -> NDArray[np.int64]:
        """(k,) the polygon in whose interior each point (k, 2) is; -1 in none."""
        p, edges = np.atleast_2d(as_batch("points", points, (2,), finite=True)), self._edges
        if not self.polygons:
            return np.full(len(p), -1)
        a, b = edges.begin, edges.end
        way = b - a
        # Crossings of the ray to the right decide; points on an edge are outside.
        above = (a[None, :, 1] > p[:, None, 1]) != (b[None, :, 1] > p[:, None, 1])
        rise = np.where(way[:, 1] == 0.0, 1.0, way[:, 1])
        x = a[None, :, 0] + (p[:, None, 1] - a[None, :, 1]) / rise * way[None, :, 0]
        odd = np.add.reduceat((above & (p[:, None, 0] < x)).astype(np.int64), edges.first, axis=1) % 2 == 1
        near = np.minimum.reduceat(distances_to_segments(p, a, b), edges.first, axis=1) <= self.slack
        within = odd & ~near
        return np.where(within.any(axis=1), within.argmax(axis=1), -1)

    @cached_property
    def _edges(self) -> _Edges:
        """The edges of all polygons, one after another."""
        begin = np.concatenate([np.zeros((0, 2)), *self.polygons])
        end = np.concatenate([np.zeros((0, 2)), *(np.roll(corners, -1, axis=0) for corners in self.polygons)])
        counts = [len(corners) for corners in self.polygons]
        first = np.cumsum([0, *counts])[:-1]
        longest = [float(np.abs(np.roll(corners, -1, axis=0) - corners).max()) for corners in self.polygons]
        return _Edges(begin, end, first, np.repeat(longest, counts))

    def free(self, points: ArrayLike) -> NDArray[np.bool_]:
        """(k,) whether points (k, 2) are in no obstacle."""
        return self.inside(points) < 0

    def free_segment(self, start: ArrayLike, end: ArrayLike) -> bool:
        """Whether a segment passes through no obstacle's interior.

        1. It is cut where it meets an edge of an obstacle.
        2. It is free if the middles of its parts are, and of each at least one side.

        Args:
            start, end: (2,).
        """
        a, b = single("start", start, (2,)), single("end", end, (2,))
        # 1.
        way, (corners, ends, _, longest) = b - a, self._edges
        edges = ends - corners
        across = way[0] * edges[:, 1] - way[1] * edges[:, 0]
        meets = np.abs(across) > 1e-14 * longest * max(np.abs(way).max(), LEAST_DIVISOR)
        from_a = corners - a
        divisor = np.where(meets, across, 1.0)
        s = (from_a[:, 0] * edges[:, 1] - from_a[:, 1] * edges[:, 0]) / divisor
        t = (from_a[:, 0] * way[1] - from_a[:, 1] * way[0]) / divisor
        cuts = s[meets & (s > 0.0) & (s < 1.0) & (t >= -1e-12) & (t <= 1.0 + 1e-12)]
        # Corners that lie on the segment, where it runs along an edge.
        along = (from_a @ way) / max(float(way @ way), LEAST_DIVISOR)
        near = np.linalg.norm(from_a - along[:, None] * way, axis=1) <= self.slack
        cuts = np.concatenate([[0.0, 1.0], cuts, along[near & (along > 0.0) & (along < 1.0)]])
        # 2.
        places = np.unique(cuts)
        middles = (places[:-1] + places[1:]) / 2.0
        on_way = a + middles[:, None] * way
        if not self.free(on_way).all():
            return False
        size = float(np.linalg.norm(way))
        aside = np.array([-way[1], way[0]]) * (BESIDE * self.slack / size if size else 0.0)
        sides = [self.free(on_way + shift) & self._within(on_way + shift) for shift in (aside, -aside)]
        # Parts no longer than what is looked at beside them are touched in a point, which may be passed.
        point = np.diff(places) * size <= 4.0 * BESIDE * self.slack
        return bool((sides[0] | sides[1] | point).all())

    def _within(self, points: Floats) -> NDArray[np.bool_]:
        return np.asarray(((points >= self.lower) & (points <= self.upper)).all(axis=1), dtype=np.bool_)

    def distance(self, points: ArrayLike) -> tuple[Floats, Floats, NDArray[np.int64]]:
        """Distance of points (k, 2) to the nearest obstacle, its nearest point (k, 2), and its index; 0 inside."""
        p = np.atleast_2d(as_batch("points", points, (2,), finite=True))
        best, place, which = np.full(len(p), np.inf), np.zeros_like(p), np.full(len(p), -1)
        inside = self.inside(p)
        for index, corners in enumerate(self.polygons):
            nearest = nearest_on_segments(p, corners, np.roll(corners, -1, axis=0))
            away = np.linalg.norm(nearest - p[:, None], axis=2)
            k = away.argmin(axis=1)
            rows = np.arange(len(p))
            size = np.where(inside == index, 0.0, away[rows, k])
            closer = size < best
            best[closer], which[closer] = size[closer], index
            place[closer] = np.where((inside == index)[:, None], p, nearest[rows, k])[closer]
        return best, place, which


def _counter_clockwise(polygons: Sequence[ArrayLike]) -> Iterator[Floats]:
    """(k, 2) corners of each, in this sense."""
    given = cast(object, polygons)
    if not isinstance(given, Iterable) or isinstance(given, Mapping):
        raise InputError("input.kind", name="polygons", expected="list of polygons", got=type(polygons).__name__)
    for k, polygon in enumerate(polygons):
        corners = np.asarray(as_batch(f"polygons[{k}]", polygon, (2,), finite=True))
        area = signed_area(corners) if corners.ndim == 2 and len(corners) > 2 else 0.0
        if area == 0.0:
            raise InputError("planning.no_area", index=k)
        yield corners if area > 0.0 else corners[::-1]


def signed_area(corners: Floats) -> float:
    """Of a polygon (k, 2); positive counter-clockwise."""
    a, b = corners, np.roll(corners, -1, axis=0)
    return float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()) / 2.0


def nearest_on_segments(p: Floats, a: Floats, b: Floats) -> Floats:
    """(k, m, 2) the point of each segment (m) nearest to each point (k)."""
    way = b - a
    share = ((p[:, None] - a[None]) * way[None]).sum(axis=2) / np.maximum((way**2).sum(axis=1), LEAST_DIVISOR)
    return a[None] + np.clip(share, 0.0, 1.0)[..., None] * way[None]


def distances_to_segments(p: Floats, a: Floats, b: Floats) -> Floats:
    """(k, m) distances of points to segments."""
    return np.linalg.norm(nearest_on_segments(p, a, b) - p[:, None], axis=2)


def minkowski_sum(first: ArrayLike, second: ArrayLike) -> Floats:
    """(k, 2) corners of the sum of two convex polygons, counter-clockwise: edges of both in the order of their angles.

    The obstacle that a translating robot A sees as a point is the sum of the obstacle and -A.

    Args:
        first, second: (k, 2) corners of convex polygons, in any sense; a segment or a point is one, too.

    Raises:
        InputError: a wrong shape, a number that is not finite, a polygon that is not convex.

    Reference: de Berg et al., Computational Geometry, sec. 13.3.
    """
    a, b = (_from_lowest(_convex(name, x)) for name, x in (("first", first), ("second", second)))
    found: list[Floats] = []
    i, j = 0, 0
    while i < len(a) or j < len(b):
        found.append(a[i % len(a)] + b[j % len(b)])
        u, v = a[(i + 1) % len(a)] - a[i % len(a)], b[(j + 1) % len(b)] - b[j % len(b)]
        turn = u[0] * v[1] - u[1] * v[0]
        i, j = (
            i + int((turn >= 0.0 and i < len(a)) or j >= len(b)),
            j + int((turn <= 0.0 and j < len(b)) or i >= len(a)),
        )
    return np.array(found)


def _convex(name: str, corners: ArrayLike) -> Floats:
    """Corners (k, 2) of a convex polygon; corners on a side or given twice are left in."""
    array = as_batch(name, corners, (2,), finite=True)
    if array.ndim != 2 or not len(array):
        raise InputError("input.shape", name=name, expected="(k, 2), k > 0", got=array.shape, hint="")
    ways = np.roll(array, -1, axis=0) - array
    ways = ways[np.abs(ways).max(axis=1) > 0.0]
    after = np.roll(ways, -1, axis=0)
    turns = ways[:, 0] * after[:, 1] - ways[:, 1] * after[:, 0]
    sizes = np.linalg.norm(ways, axis=1) * np.linalg.norm(after, axis=1)
    angles = np.arctan2(turns, (ways * after).sum(axis=1))
    # The angles of one turn all the way round; a star turns twice.
    if ((turns > 1e-12 * sizes).any() and (turns < -1e-12 * sizes).any()) or abs(angles.sum()) > 2.5 * np.pi:
        raise InputError("planning.not_convex", name=name)
    return array


def _from_lowest(corners: Floats) -> Floats:
    """Counter-clockwise, the lowest and of these the leftmost corner first."""
    turned = corners if signed_area(corners) > 0.0 else corners[::-1]
    return np.roll(turned, -int(np.lexsort((turned[:, 0], turned[:, 1]))[0]), axis=0)


def visibility_path(world: PolygonWorld, start: ArrayLike, goal: ArrayLike) -> Plan:
    """The shortest way from point to point: it bends only at corners of obstacles.

    1. Corners inside the rectangle and in no other obstacle, with start and goal; edges between those in sight.
    2. The shortest way by A*. If there is none, start and goal are separated: everything was looked at.

    Args:
        world: obstacles.
        start, goal: (2,) [m].

    Raises:
        InputError: a wrong shape, a number that is not finite.

    Reference: Lozano-Perez and Wesley, An algorithm for planning collision-free paths, 1979.
    """
    begun = perf_counter()
    a, b = single("start", start, (2,)), single("goal", goal, (2,))
    for status, point in ((PlanningStatus.START_BLOCKED, a), (PlanningStatus.GOAL_BLOCKED, b)):
        outside = (point < world.lower).any() or (point > world.upper).any()
        if outside or not world.free(point)[0]:
            return Plan(status, a[None], "visibility_graph", 1, 0, 0, perf_counter() - begun)
    # 1.
    corners = np.concatenate([np.zeros((0, 2)), *world.polygons])
    within = ((corners >= world.lower) & (corners <= world.upper)).all(axis=1)
    nodes = (
        np.concatenate([a[None], b[None], corners[within & world.free(corners)]]) if len(corners) else np.stack([a, b])
    )
    edges: list[set[int]] = [set() for _ in nodes]
    for i in range(len(nodes)):
        for j in range(i + 1, len(nodes)):
            if world.free_segment(nodes[i], nodes[j]):
                edges[i].add(j)
                edges[j].add(i)
    # 2.
    way = shortest_way(nodes, edges, 0, {1})
    seconds, looks = perf_counter() - begun, len(nodes) * (len(nodes) - 1) // 2
    if way is None:
        return Plan(PlanningStatus.SEPARATED, a[None], "visibility_graph", len(nodes), looks, len(nodes), seconds)
    return Plan(PlanningStatus.FOUND, nodes[way], "visibility_graph", len(nodes), looks, len(nodes), seconds)
