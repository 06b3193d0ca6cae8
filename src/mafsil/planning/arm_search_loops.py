"""RRT-Connect of an arm in a scene, compiled: two forests, edges looked at when they grow and proved when they count.

A proof that a motion is free at every moment can take many states where it passes near something. So an edge is first
given the beginning of a proof; when start and goal are joined, the edges of that path that are not proved yet are, and
one that cannot be is cut off with all that grew from it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.segment_loops import FREE, OPEN, colliding_rows, prove
from mafsil.collision.workshop_loops import Workshop
from mafsil.kernels.loops.entry import Held
from mafsil.kernels.loops.lanes import WIDTH, buffer, get, in_lanes, lanes, part, seen, where
from mafsil.kernels.loops.loop import compiled, inlined
from mafsil.planning.retreat_loops import Limbs, retreats

LOOK = 8
"""Blocks of a proof, of eight intervals each, that an edge is worth while it is not known whether it counts."""
PROOF = 256
"""Blocks that a motion of a path is worth; one that takes more passes something so closely that another is sought."""
LONG, SHORT, AT_FIRST = 0.09, 0.055, 64
"""Longest edges, as shares of the diagonal of the bounds, for so many samples and after: long ones lead out of easy
places in few steps, short ones through narrow ones."""
GOALS_LEFT = 3
"""Goals, nearest first, from which the tools go back."""
JOINED, GROWING, FULL = range(3)
ROOT, CUT = -1, -2
LOOKED_AT, PROVED, STATES_SEEN = range(3)
"""Places in `Forests.seen`: edges looked at, edges proved or tried to be, states."""


class Forests(NamedTuple):
    """What grows from the start (0) and from the goals (1).

    Attributes:
        q: (2, most, n) nodes.
        eights: (2, most / 8, n, 8) the same, eight side by side; infinite where there is none or it is cut off.
        parent: (2, most) index, ROOT, or CUT.
        proved: (2, most) whether the edge to the parent is proved.
        sizes: (3,) nodes of both, points of the path.
        random: (1,) state of the source of samples.
        seen: (3,) counts for the account.
        path: (most + 2, n) out, the path that joins them.
        rows: (9, n) to work in.
        colliding: (1,) bits of eight configurations.
    """

    q: Floats
    eights: Floats
    parent: NDArray[np.int64]
    proved: NDArray[np.bool_]
    sizes: NDArray[np.int64]
    random: NDArray[np.uint64]
    seen: NDArray[np.int64]
    path: Floats
    rows: Floats
    colliding: NDArray[np.int64]


def forests_of(q: Floats, goals: Floats, most: int, random: NDArray[np.uint64], seen: NDArray[np.int64]) -> Forests:
    """The roots, with place for `most` nodes on each side."""
    n, most = len(q), WIDTH * -(-max(most, 2 * len(goals) + 2) // WIDTH)
    rows, parent = np.empty((2, most, n)), np.full((2, most), ROOT)
    rows[0, 0], rows[1, : len(goals)] = q, goals
    count = np.array([1, len(goals), 0])
    proved, path = np.zeros((2, most), np.bool_), np.empty((2 * most, n))
    eights, bits = _side_by_side(rows, count), np.zeros(1, np.int64)
    return Forests(rows, eights, parent, proved, count, random, seen, path, np.empty((WIDTH + 1, n)), bits)


def _side_by_side(rows: Floats, count: NDArray[np.int64]) -> Floats:
    """Nodes (2, most, n), of which the first are there, eight side by side."""
    _, most, n = rows.shape
    found = in_lanes(2 * most // WIDTH * n)[: 2 * most * n].reshape(2, most // WIDTH, n, WIDTH)
    known = np.full(rows.shape, np.inf)
    for side in range(2):
        known[side, : count[side]] = rows[side, : count[side]]
    found[:] = known.reshape(2, most // WIDTH, WIDTH, n).swapaxes(2, 3)
    return found


def double_forests(forests: Forests) -> Forests:
    """The same with place for twice as many nodes."""
    q, parent, proved = (
        np.concatenate([array, np.zeros_like(array)], axis=1) for array in (forests.q, forests.parent, forests.proved)
    )
    eights = _side_by_side(np.where((parent == CUT)[:, :, None], np.inf, q), forests.sizes)
    return forests._replace(
        q=q, eights=eights, parent=parent, proved=proved, path=np.empty((2 * q.shape[1], q.shape[2]))
    )


@compiled
def draw(random: NDArray[np.uint64]) -> float:
    """The next number of [0, 1), by splitmix64."""
    random[0] += np.uint64(0x9E3779B97F4A7C15)
    z = random[0]
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return float(z >> np.uint64(11)) * 2.0**-53


@inlined
def look(shop: Held[Workshop], a: Floats, b: Floats, seen: NDArray[np.int64]) -> int:
    """What the first blocks of a proof say of a motion: FREE, OPEN, or that it is not free."""
    seen[LOOKED_AT] += 1
    code, _, states = prove(shop, a, b, LOOK)
    seen[STATES_SEEN] += states
    return code


@compiled
def looks_free(shop: Held[Workshop], a: Floats, b: Floats, seen: NDArray[np.int64]) -> bool:
    """Whether the first blocks of a proof leave it possible that a motion is free."""
    code = look(shop, a, b, seen)
    return code in (FREE, OPEN)


@compiled
def proves_free(shop: Held[Workshop], a: Floats, b: Floats, seen: NDArray[np.int64]) -> bool:
    """Whether a motion is proved free."""
    seen[PROVED] += 1
    code, _, states = prove(shop, a, b, PROOF)
    seen[STATES_SEEN] += states
    return code == FREE


@inlined
def nearest(forests: Forests, side: int, q: Floats) -> int:
    """The node of one side that is nearest to a configuration and not cut off.

    1. The nearest in each lane, and in which eight it stands.
    2. The nearest of these; of equal ones the first.
    """
    n, found, least = len(q), 0, np.inf
    nodes, best, eight = part(seen(forests.eights), side * forests.eights.shape[1] * n), lanes(np.inf), lanes(0.0)
    for g in range((forests.sizes[side] + WIDTH - 1) // WIDTH):  # 1
        away = lanes(0.0)
        for c in range(n):
            apart_by = nodes[g * n + c] - q[c]
            away = away + apart_by * apart_by
        closer = away < best
        best, eight = where(closer, away, best), where(closer, float(g), eight)
    per_lane = buffer(2)
    per_lane[0], per_lane[1] = best, eight
    for lane in range(WIDTH):  # 2
        away_here, k = get(per_lane, 0, lane), WIDTH * int(get(per_lane, 1, lane)) + lane
        if away_here < least or (away_here == least and k < found):
            least, found = away_here, k
    return found


@compiled
def _towards(a: Floats, b: Floats, step: float, out: Floats) -> bool:
    """Where one step from a towards b ends, in `out`; whether that is b."""
    away = 0.0
    for c in range(len(a)):
        away += (b[c] - a[c]) * (b[c] - a[c])
    share = step / np.sqrt(away) if away > step * step else 1.0
    for c in range(len(a)):
        out[c] = a[c] + share * (b[c] - a[c]) if share < 1.0 else b[c]
    return share == 1.0


@compiled
def place(forests: Forests, side: int, k: int, q: Floats) -> None:
    """Where node k of one side stands; those before it stand already."""
    eight = forests.eights[side, k // WIDTH]
    if k % WIDTH == 0:
        eight[:] = np.inf
    for c in range(len(q)):
        forests.q[side, k, c], eight[c, k % WIDTH] = q[c], q[c]


@inlined
def add(forests: Forests, side: int, q: Floats, parent: int, proved: bool) -> int:
    """A node more, with whether the motion to it is proved; its index."""
    k = forests.sizes[side]
    place(forests, side, k, q)
    forests.parent[side, k], forests.proved[side, k] = parent, proved
    forests.sizes[side] = k + 1
    return k


@compiled
def cut(forests: Forests, side: int, node: int) -> None:
    """A node goes, and all that grew from it: parents stand before their children."""
    parent, nodes = forests.parent[side], forests.eights[side]
    parent[node] = CUT
    nodes[node // WIDTH, 0, node % WIDTH] = np.inf
    for k in range(node + 1, forests.sizes[side]):
        if parent[k] >= 0 and parent[parent[k]] == CUT:
            parent[k] = CUT
            nodes[k // WIDTH, 0, k % WIDTH] = np.inf


@compiled
def way_is_proved(shop: Held[Workshop], forests: Forests, side: int, node: int) -> bool:
    """Whether all edges from a node to its root are proved; the first that cannot be is cut off."""
    while forests.parent[side, node] != ROOT:
        before = forests.parent[side, node]
        if not forests.proved[side, node]:
            if not proves_free(shop, forests.q[side, before], forests.q[side, node], forests.seen):
                cut(forests, side, node)
                return False
            forests.proved[side, node] = True
        node = before
    return True


@compiled
def write_path(forests: Forests, at_start: int, at_goal: int) -> None:
    """The way from the root of the start over a node that both sides have to a goal's root."""
    length, node = 1, at_start
    while forests.parent[0, node] != ROOT:
        node = forests.parent[0, node]
        length += 1
    total, node = length, at_start
    for k in range(length - 1, -1, -1):
        for c in range(forests.path.shape[1]):
            forests.path[k, c] = forests.q[0, node, c]
        node = forests.parent[0, node]
    node = forests.parent[1, at_goal]
    while node != ROOT:
        for c in range(forests.path.shape[1]):
            forests.path[total, c] = forests.q[1, node, c]
        total += 1
        node = forests.parent[1, node]
    forests.sizes[2] = total


@compiled
def grow(
    shop: Held[Workshop], bounds: Floats, near: Floats, limbs: Limbs, left: int, drawn: int, samples: int,
    forests: Forests,
) -> int:  # fmt: skip
    """Both sides grow until a path of proved motions joins start and goal: JOINED, GROWING, or FULL.

    1. The first ends are those of `retreats`, from the nearest goals and from the start, if that is asked.
    2. The others are one step each towards eight samples, from the nearest nodes of the side with fewer. One sample is
       of all that there is, the others lie around start and goal, where paths are sought first.
    3. Eight ends are looked at together, and most of what collides shows there. The motion to an end that is free
       becomes an edge if it looks free.
    4. The other side goes towards the new node, as far as it looks free: step by step, or to an end of step 1 at once.
    5. If it arrives, the edges of the path are proved; one that cannot be is cut off, and growing goes on.

    Args:
        shop: what is free.
        bounds: (2, n) lowest and highest coordinates of the samples.
        near: (2, n) of those around start and goal.
        limbs: whose tools can go back.
        left: goals from which they do so; then they do from the start too.
        drawn: samples before.
        samples: before it comes back.
        forests: the roots stand in them.

    Reference:
        J. Kuffner, S. LaValle, RRT-Connect, ICRA 2000. R. Bohlin, L. Kavraki, Path planning using lazy PRM, ICRA 2000.
    """
    new, further, most = forests.rows, forests.rows[WIDTH], forests.q.shape[1]
    diagonal, places = apart(bounds[0], bounds[1]), left + 1 if left > 0 and len(limbs.parts) > 0 else 0
    for begun in range(drawn - WIDTH * places, drawn + samples, WIDTH):
        ours, step, count = 0 if forests.sizes[0] <= forests.sizes[1] else 1, np.inf, WIDTH
        if begun < 0:  # 1
            place_left = places + begun // WIDTH
            ours = 1 if place_left < places - 1 else 0
            root = forests.q[ours, place_left if ours == 1 else 0]
            if not retreats(limbs, root, bounds, new):
                continue
        else:  # 2
            step, count = diagonal * (LONG if begun < AT_FIRST else SHORT), min(WIDTH, drawn + samples - begun)
            for lane in range(count):
                _sample(bounds if lane == 0 else near, forests.random, further)
                _towards(forests.q[ours, nearest(forests, ours, further)], further, step, new[lane])
        theirs = 1 - ours
        forests.seen[STATES_SEEN] += count
        colliding_rows(shop, new, count, forests.colliding)
        for lane in range(count):  # 3
            if (forests.colliding[0] >> lane) & 1:
                continue
            if max(forests.sizes[0], forests.sizes[1]) + 1 >= most:
                return FULL
            before = nearest(forests, ours, new[lane])
            code = look(shop, forests.q[ours, before], new[lane], forests.seen)
            if code not in (FREE, OPEN):
                continue
            mine = add(forests, ours, new[lane], before, code == FREE)
            other, arrived = _connect(shop, forests, theirs, new[lane], step, further)  # 4
            if not arrived:
                continue
            at_start, at_goal = (mine, other) if ours == 0 else (other, mine)  # 5
            if way_is_proved(shop, forests, 0, at_start) and way_is_proved(shop, forests, 1, at_goal):
                write_path(forests, at_start, at_goal)
                return JOINED
    return GROWING


@compiled
def _sample(bounds: Floats, random: NDArray[np.uint64], out: Floats) -> None:
    for c in range(len(out)):
        out[c] = bounds[0, c] + draw(random) * (bounds[1, c] - bounds[0, c])


@inlined
def _connect(
    shop: Held[Workshop], forests: Forests, side: int, q: Floats, step: float, further: Floats
) -> tuple[int, bool]:  # fmt: skip
    """A side goes towards a configuration as far as it looks free: the last node, and whether it has arrived."""
    other, arrived = nearest(forests, side, q), False
    while not arrived and forests.sizes[side] < forests.q.shape[1]:
        arrived = _towards(forests.q[side, other], q, step, further)
        code = look(shop, forests.q[side, other], further, forests.seen)
        if code not in (FREE, OPEN):
            return other, False
        other = add(forests, side, further, other, code == FREE)
    return other, arrived


@compiled
def apart(a: Floats, b: Floats) -> float:
    """The distance of two configurations [rad | m]."""
    total = 0.0
    for c in range(len(a)):
        total += (a[c] - b[c]) * (a[c] - b[c])
    return np.sqrt(total)
