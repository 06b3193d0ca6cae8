"""Configurations of an arm in boxes proved free or full: a path through free ones, or a proof that there is none.

No point of a body moves further than M (`Checker.largest_ways`) while the coordinates go from the middle of a box to
any place in it. If every body is further from everything at the middle than that, the box is free; if one overlaps
something more deeply than that, the box is full. Every other box is mixed, and is divided.
"""

from __future__ import annotations

from itertools import pairwise
from math import hypot
from time import perf_counter
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, Truth
from mafsil.collision import Cone, Cylinder
from mafsil.lazy_module import lazily
from mafsil.planning.search import shortest_way

if TYPE_CHECKING:
    from mafsil.collision import Checker, Scene

sparse, csgraph = lazily("scipy.sparse"), lazily("scipy.sparse.csgraph")
MOST_MOVING = 3
"""Coordinates of which boxes are made: of more there are too many boxes."""
FIRST_BOXES = 64
"""About how many there are before any is divided."""
DEEPEST = 14
"""How often a box is divided at most."""
SURE = 1e-3
"""Share of both sizes by which a depth has to be larger: those of cylinders and cones are upper bounds."""
ROUNDING = 1e-9
"""Of distances [m]."""
LINKS = 64
"""Nearest free boxes to which a straight motion from an end is tried."""
Indices = NDArray[np.int64]


class Cover(NamedTuple):
    """What the boxes say.

    Attributes:
        path: (k, n) through free boxes, each motion proved; None where they lead to no goal.
        separated: whether no path leads to any goal, which full boxes prove.
        boxes: how many were looked at.
    """

    path: JointVector | None
    separated: bool
    boxes: int


class _Boxes(NamedTuple):
    """Boxes that are all as large, by their places on a grid.

    Attributes:
        level: how often they were divided.
        places: (m, k) numbers along each moving coordinate.
    """

    level: int
    places: Indices


class _Space:
    """The moving coordinates of an arm between bounds, and how boxes of them are judged.

    Args:
        checker: the arm.
        lower, upper: (n,) bounds; the same for what is held [rad | m].
    """

    def __init__(self, checker: Checker, lower: JointVector, upper: JointVector) -> None:
        self.checker, self.lower, self.upper = checker, lower, upper
        self.moving = np.flatnonzero(upper > lower)
        self.largest = np.maximum(np.abs(lower), np.abs(upper))
        limits = checker.robot.limits
        endless = np.isinf(limits.lower) & np.isinf(limits.upper)
        turns = np.array([each.screw[:3].any() for each in checker.robot.mechanism.coordinates], np.bool_)
        # Whole turns of a joint without limits: behind its upper bound follows the lower one.
        self.wraps = (endless & turns)[self.moving]
        self.bounded = bool((np.isfinite(limits.lower) & np.isfinite(limits.upper) | turns)[self.moving].all())
        over = (upper - lower)[self.moving]
        size = np.where(self.wraps, 2.0 * np.pi * np.ceil(over / (2.0 * np.pi) - 1e-9), over)
        self.low, self.size = lower[self.moving], size
        bodies = range(len(checker.bodies) if len(checker.scene) else 0)
        self.around = [(b, checker.checking([b], ())) for b in bodies]
        alone = checker.with_scene(())
        pairs: list[list[int]] = checker.arm.pairs.tolist()
        self.pairs = [(a, b, alone.checking((), [k])) for k, (a, b) in enumerate(pairs)]
        ways = np.array([self._ways(np.where(np.arange(len(size)) == k, size, 0.0)).max() for k in range(len(size))])
        shares = np.maximum(ways / max(float(ways.max()), ROUNDING), 1e-3)
        even = float((FIRST_BOXES / np.prod(shares)) ** (1.0 / len(size)))
        self.counts = np.maximum(np.round(even * shares), 1.0).astype(np.int64)
        self.unsure, self.unsure_around = SURE * checker.arm.bodies[:, 7], SURE * _rounded_size(checker.scene)

    def _ways(self, half: Floats) -> Floats:
        change = np.zeros(len(self.lower))
        change[self.moving] = half
        return self.checker.largest_ways(change, self.largest + change) + ROUNDING

    def widths(self, level: int) -> Floats:
        """(k,) edges of boxes of a level [rad | m]."""
        return self.size / (self.counts * 2**level)

    def middles(self, boxes: _Boxes) -> JointVector:
        """(m, n) configurations in the middle of boxes."""
        q = np.repeat(self.lower[None], len(boxes.places), axis=0)
        q[:, self.moving] = self.low + (boxes.places + 0.5) * self.widths(boxes.level)
        return q

    def judge_boxes(self, boxes: _Boxes) -> tuple[Truth, Truth]:
        """(m,), (m,) which boxes are proved free, and which full."""
        M, q = self._ways(self.widths(boxes.level) / 2.0), self.middles(boxes)
        clearance, *clearances = self.checker.clearances().tolist()
        free, full = np.ones(len(q), np.bool_), np.zeros(len(q), np.bool_)
        for b, checker in self.around:
            gap = checker.distance(q, within=clearance + 2.0 * M[b]).distance
            free &= gap > clearance + M[b]
            full |= gap + M[b] + self.unsure[b] + self.unsure_around <= clearance
        for (a, b, checker), kept in zip(self.pairs, clearances, strict=True):
            both = M[a] + M[b]
            gap = checker.distance(q, within=kept + 2.0 * both).distance
            free &= gap > kept + both
            full |= gap + both + self.unsure[a] + self.unsure[b] <= kept
        return free, full


def _rounded_size(scene: Scene) -> float:
    """The largest extent of its cylinders and cones [m]."""
    shapes = [each.geometry for each in scene]
    return max([0.0, *(hypot(each.radius, each.length) for each in shapes if isinstance(each, Cylinder | Cone))])


def cover(
    checker: Checker, bounds: tuple[JointVector, JointVector], q: JointVector, goals: JointVector, most: int,
    seconds: float,
) -> Cover:  # fmt: skip
    """Divide configurations between bounds until free boxes lead from the start to a goal, or full ones lie between.

    1. Boxes are judged; those neither free nor full are divided in all coordinates, all at once.
    2. What cannot be reached from the start through boxes that are not full is forgotten. If that are all goals, they
       are separated: free space is open, so a path passes through the sides of boxes.
    3. Start and goals are joined to free boxes by straight motions that are proved. The shortest way over the middles
       of sides is the path.

    Args:
        checker: the arm.
        bounds: (n,), (n,) of its coordinates; the same for what is held, MOST_MOVING others at most.
        q: (n,) where it begins.
        goals: (g, n), one at least.
        most: boxes that are looked at.
        seconds: after which it gives up.

    Reference: R. Brooks, T. Lozano-Perez, A subdivision algorithm in configuration space for findpath with rotation,
        IJCAI 1983; D. Zhu, J.-C. Latombe, New heuristic algorithms for efficient hierarchical path planning, IEEE T-RA
        1991.
    """
    begun, space = perf_counter(), _Space(checker, *bounds)
    ends = np.concatenate([q[None], goals])
    free, looked_at = list[_Boxes](), 0
    mixed = _Boxes(0, np.indices(tuple(space.counts.tolist())).reshape(len(space.counts), -1).T.astype(np.int64))
    for _ in range(DEEPEST):
        if looked_at + len(mixed.places) > most or perf_counter() - begun > seconds:
            break
        # 1.
        looked_at += len(mixed.places)
        is_free, is_full = space.judge_boxes(mixed)
        free.append(_Boxes(mixed.level, mixed.places[is_free]))
        mixed = _Boxes(mixed.level, mixed.places[~is_free & ~is_full])
        # 2.
        levels = [*free, mixed]
        label = _labels(sum(len(each.places) for each in levels), _neighbours(space, levels)[0])
        here = _holding(space, levels, ends[0])
        there = [_holding(space, levels, goal) for goal in goals]
        reached = np.isin(label, label[here])
        if not any(reached[each].any() for each in there):
            return Cover(None, space.bounded, looked_at)
        kept = np.split(reached, np.cumsum([len(each.places) for each in levels])[:-1])
        *free, mixed = (_Boxes(each.level, each.places[some]) for each, some in zip(levels, kept, strict=True))
        # 3.
        path = _through(space, free, ends)
        if path is not None:
            return Cover(path, False, looked_at)
        halves = np.indices((2,) * len(space.counts)).reshape(len(space.counts), -1).T
        mixed = _Boxes(mixed.level + 1, (2 * mixed.places[:, None] + halves).reshape(-1, len(space.counts)))
    return Cover(None, False, looked_at)


def _neighbours(space: _Space, levels: list[_Boxes]) -> tuple[Indices, Indices]:
    """(p, 2) pairs of boxes that share a side, the smaller or equal one first, and (p, 2) its coordinate and sense.

    A neighbour is as large as a box, or larger and then holds its place divided by a power of two.
    """
    first = np.cumsum([0, *(len(each.places) for each in levels)])
    known = [_numbers(space, each) for each in levels]
    order = [np.argsort(numbers) for numbers in known]
    pairs, sides = [np.zeros((0, 2), np.int64)], [np.zeros((0, 2), np.int64)]
    for i, small in enumerate(levels):
        for axis in range(len(space.counts)):
            for sense in (-1, 1):
                beside = small.places.copy()
                beside[:, axis] += sense
                count = space.counts[axis] * 2**small.level
                if space.wraps[axis]:
                    beside[:, axis] %= count
                inside = np.flatnonzero((beside[:, axis] >= 0) & (beside[:, axis] < count))
                for j, large in enumerate(levels):
                    if large.level > small.level or not len(known[j]):
                        continue
                    parent = _Boxes(large.level, beside[inside] >> (small.level - large.level))
                    numbers, sorted_known = _numbers(space, parent), known[j][order[j]]
                    at = np.minimum(np.searchsorted(sorted_known, numbers), len(sorted_known) - 1)
                    hit = np.flatnonzero(sorted_known[at] == numbers)
                    pairs.append(np.stack([first[i] + inside[hit], first[j] + order[j][at[hit]]], axis=1))
                    sides.append(np.tile([axis, sense], (len(hit), 1)))
    return np.concatenate(pairs), np.concatenate(sides)


def _numbers(space: _Space, boxes: _Boxes) -> Indices:
    """(m,) one number for the place of each box."""
    found = np.zeros(len(boxes.places), np.int64)
    for k, count in enumerate(space.counts.tolist()):
        found = found * (count * 2**boxes.level) + boxes.places[:, k]
    return found


def _labels(count: int, pairs: Indices) -> Indices:
    """(count,) the same number for all that pairs join to each other."""
    joined = sparse.coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return np.asarray(csgraph.connected_components(joined, directed=False)[1], dtype=np.int64)


def _holding(space: _Space, levels: list[_Boxes], q: JointVector) -> Indices:
    """Boxes that hold a configuration, their sides included."""
    found, first = list[Indices](), 0
    away = q[space.moving] - space.low
    for each in levels:
        width = space.widths(each.level)
        off = np.abs(away - (each.places + 0.5) * width)
        off = np.where(space.wraps, np.minimum(off % space.size, space.size - off % space.size), off)
        found.append(first + np.flatnonzero((off <= width * (0.5 + 1e-9)).all(axis=1)))
        first += len(each.places)
    return np.concatenate(found)


def _through(space: _Space, free: list[_Boxes], ends: JointVector) -> JointVector | None:
    """The shortest way through free boxes from the first end to one of the others; None where none leads there."""
    middles = np.concatenate([space.middles(each) for each in free])
    if not len(middles):
        return None
    pairs, sides = _neighbours(space, free)
    width = np.concatenate([np.repeat(space.widths(each.level)[None], len(each.places), axis=0) for each in free])
    axis, rows = sides[:, 0], np.arange(len(pairs))
    doors = middles[pairs[:, 0]].copy()
    doors[rows, space.moving[axis]] += sides[:, 1] * width[pairs[:, 0], axis] / 2.0
    # Over the bound of a joint without limits lies a place that is whole turns away.
    away = np.abs(middles[pairs[:, 1]] - doors)[rows, space.moving[axis]] > width[pairs[:, 1], axis]
    of_pair = {(int(a), int(b)): door for (a, b), door in zip(pairs[~away], doors[~away], strict=True)}
    edges: list[set[int]] = [set() for _ in range(len(middles) + len(ends))]
    for a, b in of_pair:
        edges[a].add(b)
        edges[b].add(a)
    for k, q in enumerate(ends):
        for box in map(int, _seen_from(space, middles, q)):
            edges[len(middles) + k].add(box)
            edges[box].add(len(middles) + k)
    nodes, goals = np.concatenate([middles, ends]), set(range(len(middles) + 1, len(middles) + len(ends)))
    way = shortest_way(nodes, edges, len(middles), goals)
    if way is None:
        return None
    path = [nodes[way[0]]]
    for a, b in pairwise(way):
        door = of_pair.get((a, b), of_pair.get((b, a)))
        path += [nodes[b]] if door is None else [door, nodes[b]]
    found = np.stack(path)
    return found if np.all(space.checker.free_segment(found[:-1], found[1:])) else None


def _seen_from(space: _Space, middles: JointVector, q: JointVector) -> Indices:
    """Free boxes near a configuration to whose middles the straight motion is proved free."""
    near = np.argsort(np.abs(middles - q).max(axis=1), kind="stable")[:LINKS]
    return near[np.asarray(space.checker.free_segment(np.repeat(q[None], len(near), axis=0), middles[near]))]
