"""A roadmap of an arm, compiled: grows by free configurations, its motions looked at and proved when a way wants them.

Each new node is joined to its ceil(e (1 + 1/n) ln N) nearest ones of the N before it, so that the shortest way through
the roadmap tends to the shortest path there is. A motion is UNKNOWN, LOOKS_FREE, PROVED or BLOCKED.

Reference:
    S. Karaman, E. Frazzoli, Sampling-based algorithms for optimal motion planning, IJRR 30(7), 2011 (PRM*).
    K. Hauser, Lazy collision checking in asymptotically-optimal motion planning, ICRA 2015.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.segment_loops import free_at
from mafsil.collision.workshop_loops import Workshop
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.kernels.loops.entry import Held
from mafsil.kernels.loops.loop import compiled
from mafsil.planning.arm_search_loops import apart, draw, looks_free, proves_free

UNKNOWN, LOOKS_FREE, PROVED, BLOCKED = range(4)
NONE = -1
NEAR = 0.3
"""Standard deviation of samples near a path, at most [rad | m]."""


class Roadmap(NamedTuple):
    """Nodes and the motions between them.

    Attributes:
        q: (most, n) nodes.
        edges: (most_edges, 5) two nodes, the next edge of the first one and of the second one, the state.
        first: (most,) the first edge of each node, NONE where there is none.
        sizes: (2,) nodes, edges.
        random: (1,) state of the source of samples.
        seen: (3,) counts for the account.
    """

    q: Floats
    edges: NDArray[np.int64]
    first: NDArray[np.int64]
    sizes: NDArray[np.int64]
    random: NDArray[np.uint64]
    seen: NDArray[np.int64]


def neighbours(nodes: int, n: int) -> int:
    """Of a node that is added to so many."""
    return int(np.ceil(np.e * (1.0 + 1.0 / max(n, 1)) * np.log(max(nodes, 2))))


@compiled
def _join(roadmap: Roadmap, a: int, b: int) -> None:
    k = roadmap.sizes[1]
    edge = roadmap.edges[k]
    edge[0], edge[1], edge[2], edge[3], edge[4] = a, b, roadmap.first[a], roadmap.first[b], UNKNOWN
    roadmap.first[a] = roadmap.first[b] = k
    roadmap.sizes[1] = k + 1


@compiled
def _add(roadmap: Roadmap, q: Floats, joined: int, away: Floats, order: NDArray[np.int64]) -> int:
    """A node more, joined to its nearest ones; `away` and `order` (joined,) to work in."""
    count, node = 0, roadmap.sizes[0]
    for k in range(node):
        d = 0.0
        for c in range(len(q)):
            d += (roadmap.q[k, c] - q[c]) * (roadmap.q[k, c] - q[c])
        if count == joined and d >= away[count - 1]:
            continue
        at = count if count < joined else joined - 1
        while at > 0 and away[at - 1] > d:
            away[at], order[at] = away[at - 1], order[at - 1]
            at -= 1
        away[at], order[at] = d, k
        count = min(count + 1, joined)
    for c in range(len(q)):
        roadmap.q[node, c] = q[c]
    roadmap.first[node] = NONE
    roadmap.sizes[0] = node + 1
    for k in range(count):
        _join(roadmap, node, order[k])
    return node


@compiled
def add_node(roadmap: Roadmap, q: Floats, joined: int) -> int:
    """A given configuration as a node, joined to its nearest ones; its index."""
    return _add(roadmap, q, joined, np.empty(joined), np.empty(joined, np.int64))


@compiled
def add_path(roadmap: Roadmap, path: Floats, joined: int) -> None:
    """The points of a path of proved motions as nodes, with these motions between them."""
    away, order, before = np.empty(joined), np.empty(joined, np.int64), NONE
    for r in range(len(path)):
        node = _add(roadmap, path[r], joined, away, order)
        if before != NONE:
            _join(roadmap, before, node)
            roadmap.edges[roadmap.sizes[1] - 1, 4] = PROVED
        before = node


@compiled
def _normal(random: NDArray[np.uint64]) -> float:
    """A number of the normal distribution (Box and Muller)."""
    return np.sqrt(-2.0 * np.log(1.0 - draw(random))) * np.cos(2.0 * np.pi * draw(random))


@compiled
def grow_roadmap(
    shop: Held[Workshop], roadmap: Roadmap, lower: Floats, upper: Floats, best: Floats, length: float, tries: int,
    joined: int,
) -> None:  # fmt: skip
    """Add free configurations, of those that a path shorter than `length` can pass.

    1. A sample: of the box of limits; or, in turn, of the ellipsoid whose foci are the ends of the best path, and near
       that path.
    2. If it is within the limits, on a shorter path and free, it is a node.

    Args:
        shop: what is free.
        roadmap: grows; has place for `tries` more nodes.
        lower, upper: (n,) limits.
        best: (k, n) path to beat; empty if there is none.
        length: of it, or infinite.
        tries: samples.
        joined: neighbours of a node.

    Reference: J. Gammell, S. Srinivasa, T. Barfoot, Informed RRT*, IROS 2014; near the path as B. Akgun, M. Stilman,
    Sampling heuristics for optimal motion planning in high dimensions, IROS 2011.
    """
    start, goal = (best[0], best[-1]) if len(best) > 0 else (lower, lower)
    n = len(lower)
    q, x, away, order = np.empty(n), np.empty(n), np.empty(joined), np.empty(joined, np.int64)
    across, apart_by, volume, moving = 0.0, apart(start, goal), 1.0, 0
    for c in range(n):
        moving += 1 if upper[c] > lower[c] else 0
    if length < np.inf:
        across = np.sqrt(max(length * length - apart_by * apart_by, 0.0)) / 2.0
        for c in range(n):
            volume *= 2.0 * across / (upper[c] - lower[c]) if upper[c] > lower[c] else 1.0
    informed = length < np.inf and volume < 1.0
    for t in range(tries):
        norm, along = 0.0, 0.0  # 1
        for c in range(n):
            if not informed:
                q[c] = lower[c] + draw(roadmap.random) * (upper[c] - lower[c])
                continue
            x[c] = _normal(roadmap.random) if upper[c] > lower[c] else 0.0
            norm += x[c] * x[c]
        if len(best) > 1 and t % 2 == 1:
            k, share = int(draw(roadmap.random) * (len(best) - 1)), draw(roadmap.random)
            spread = NEAR * draw(roadmap.random) ** 2
            for c in range(n):
                off = _normal(roadmap.random) if upper[c] > lower[c] else 0.0
                q[c] = best[k, c] + share * (best[k + 1, c] - best[k, c]) + spread * off
        elif informed:
            scale = draw(roadmap.random) ** (1.0 / max(moving, 1)) / np.sqrt(max(norm, LEAST_DIVISOR))
            for c in range(n):
                x[c] *= scale
                along += x[c] * (goal[c] - start[c]) / max(apart_by, LEAST_DIVISOR)
            for c in range(n):
                axis = (goal[c] - start[c]) / max(apart_by, LEAST_DIVISOR)
                q[c] = 0.5 * (start[c] + goal[c]) + across * x[c] + (length / 2.0 - across) * along * axis
        inside = len(best) == 0 or apart(start, q) + apart(q, goal) < length  # 2
        for c in range(n):
            inside = inside and lower[c] <= q[c] <= upper[c]
        if not inside:
            continue
        roadmap.seen[2] += 1
        if free_at(shop, q):
            _add(roadmap, q, joined, away, order)


@compiled
def _push(keys: Floats, nodes: NDArray[np.int64], count: int, key: float, node: int) -> int:
    k = count
    while k > 0 and keys[(k - 1) // 2] > key:
        keys[k], nodes[k] = keys[(k - 1) // 2], nodes[(k - 1) // 2]
        k = (k - 1) // 2
    keys[k], nodes[k] = key, node
    return count + 1


@compiled
def _drop(keys: Floats, nodes: NDArray[np.int64], count: int) -> int:
    """Take the first of a heap away."""
    count -= 1
    key, node, k = keys[count], nodes[count], 0
    while 2 * k + 1 < count:
        child = 2 * k + 1
        if child + 1 < count and keys[child + 1] < keys[child]:
            child += 1
        if keys[child] >= key:
            break
        keys[k], nodes[k] = keys[child], nodes[child]
        k = child
    keys[k], nodes[k] = key, node
    return count


@compiled
def _ahead(roadmap: Roadmap, node: int, goals: NDArray[np.int64]) -> float:
    best = np.inf
    for k in range(len(goals)):
        best = min(best, apart(roadmap.q[node], roadmap.q[goals[k]]))
    return best


@compiled
def _shortest(
    roadmap: Roadmap, start: int, goals: NDArray[np.int64], bound: float, cost: Floats, before: NDArray[np.int64],
    keys: Floats, waiting: NDArray[np.int64], ahead: Floats,
) -> int:  # fmt: skip
    """The goal at the end of the shortest way below a bound by motions that are not blocked (A*); NONE without one.

    1. The node that waits with the least length so far and straight distance ahead.
    2. Its neighbours, if it makes them nearer.

    Args:
        cost: (nodes,) out: lengths from the start.
        before: (nodes,) out: the edge that each was reached by.
        keys, waiting: (2 edges + 1,) a heap.
        ahead: (nodes,) straight distances to the nearest goal, NaN where not asked yet.
    """
    nodes = roadmap.sizes[0]
    for k in range(nodes):
        cost[k], before[k] = np.inf, NONE
    cost[start] = 0.0
    count = _push(keys, waiting, 0, 0.0, start)
    while count > 0:
        key, node = keys[0], waiting[0]  # 1
        count = _drop(keys, waiting, count)
        if node != start and key > cost[node] + ahead[node]:
            continue
        for k in range(len(goals)):
            if goals[k] == node:
                return node
        k = roadmap.first[node]  # 2
        while k != NONE:
            edge = roadmap.edges[k]
            forward = edge[0] == node
            other = edge[1] if forward else edge[0]
            if edge[4] != BLOCKED:
                through = float(cost[node]) + apart(roadmap.q[node], roadmap.q[other])
                if through < cost[other]:
                    if np.isnan(ahead[other]):
                        ahead[other] = _ahead(roadmap, other, goals)
                    if through + ahead[other] < bound:
                        cost[other], before[other] = through, k
                        count = _push(keys, waiting, count, through + float(ahead[other]), other)
            k = edge[2] if forward else edge[3]
    return NONE


@compiled
def _settle(shop: Held[Workshop], roadmap: Roadmap, way: NDArray[np.int64], count: int) -> bool:
    """Whether all motions of a way are proved; those that cannot be are blocked.

    1. All that nobody looked at yet are looked at.
    2. If all look free, they are proved.
    """
    for state in (UNKNOWN, LOOKS_FREE):
        free = True
        for k in range(count):
            edge = roadmap.edges[way[k]]
            if edge[4] != state:
                continue
            a, b = roadmap.q[edge[0]], roadmap.q[edge[1]]
            if state == UNKNOWN:  # 1
                edge[4] = LOOKS_FREE if looks_free(shop, a, b, roadmap.seen) else BLOCKED
            else:  # 2
                edge[4] = PROVED if proves_free(shop, a, b, roadmap.seen) else BLOCKED
            free = free and edge[4] != BLOCKED
        if not free:
            return False
    return True


@compiled
def shortest_proved(
    shop: Held[Workshop], roadmap: Roadmap, start: int, goals: NDArray[np.int64], bound: float, rounds: int
) -> tuple[int, NDArray[np.int64]]:
    """The shortest way below a bound whose motions are all proved: 1 and its nodes; 0: there is none; -1: go on later.

    1. The shortest way by motions that may be free.
    2. Its motions are looked at, then proved; what is blocked is left out the next time.
    """
    nodes, edges = roadmap.sizes[0], roadmap.sizes[1]
    cost, before, ahead = np.empty(nodes), np.empty(nodes, np.int64), np.full(nodes, np.nan)
    keys, waiting, way = np.empty(2 * edges + 2), np.empty(2 * edges + 2, np.int64), np.empty(nodes, np.int64)
    for _ in range(rounds):
        end = _shortest(roadmap, start, goals, bound, cost, before, keys, waiting, ahead)  # 1
        if end == NONE:
            return 0, way[:0].copy()
        count, node = 0, end
        while node != start:
            edge = roadmap.edges[before[node]]
            way[count] = before[node]
            node = edge[0] if edge[1] == node else edge[1]
            count += 1
        if _settle(shop, roadmap, way, count):  # 2
            path, node = np.empty(count + 1, np.int64), end
            for k in range(count, 0, -1):
                path[k] = node
                edge = roadmap.edges[before[node]]
                node = edge[0] if edge[1] == node else edge[1]
            path[0] = start
            return 1, path
    return -1, way[:0].copy()
