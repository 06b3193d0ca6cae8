"""The largest ball about the origin inside a convex set that is known by its support function, compiled.

An incremental convex hull (beneath and beyond), of which only what lies near the answer is built:

1. `first_simplex`: m + 1 far corners of the set; `begin`: their facets.
2. The facet nearest to the origin bounds the radius from below, the support function in its direction from above.
3. Where the bounds have not met, the support point is the next corner. Corners are moved by about 1e-9 of their size,
   so that no m + 1 of them share a hyperplane (`move`).
4. `see`: the facets that the corner sees, found from neighbour to neighbour.
5. `cover`: a new facet through the corner and each ridge between a facet that it sees and one that it does not.
6. `join`: new facets are paired along the ridges that they share, by a hash table; facets that were seen are hidden.

A set is the hull of discs (see `disc_loops`); together, the discs (and 0) are summed instead.

Reference:
    C. B. Barber, D. P. Dobkin, H. Huhdanpaa, The quickhull algorithm for convex hulls, ACM Trans. Math. Softw. 22(4),
    1996.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.kernels.loops.loop import compiled, reordered
from mafsil.solvers.disc_loops import Dimension, dot, support
from mafsil.solvers.tolerances import FLATNESS, JOGGLE, TURNED, VISIBLE

STEADY = 10.0
"""Heights over a facet, in units of what is barely visible, from which the next facet's direction is sure."""
FAR = 0.05
"""Heights of a corner over the flat of those before, relative to the set, at which no better one is looked for."""
MOST = 4096
"""Corners at most: a ridge of m - 2 corners packs into one integer."""
TABLE = 1 << 14
MIX = 0x1E3779B97F4A7C15
"""Odd factor that spreads keys over the table."""
CONVERGED, FULL, FLAT, BROKEN = 0, 1, 2, 3
"""How `inscribed_ball` ended: bounds met; buffers or vertices spent; set is flat; rounding spoilt the polytope."""


@compiled
def null_vector(dimension: Dimension, A: Floats, n: Floats) -> None:
    """Unit vector n with A n = 0 for A (m - 1, m); A is destroyed.

    1. Elimination with complete pivoting; `order` remembers the columns.
    2. The last unknown is 1; the others follow backwards.
    3. Back in the first order, at length 1.
    """
    m = len(dimension)
    rows = m - 1
    order = np.arange(m)
    for r in range(rows):  # 1
        pr, pc, big = r, r, -1.0
        for i in range(r, rows):
            for j in range(r, m):
                if abs(A[i, j]) > big:
                    pr, pc, big = i, j, abs(A[i, j])
        if not big > 0.0:
            A[r, r] = LEAST_DIVISOR
        for j in range(m):
            A[r, j], A[pr, j] = A[pr, j], A[r, j]
        for i in range(rows):
            A[i, r], A[i, pc] = A[i, pc], A[i, r]
        order[r], order[pc] = order[pc], order[r]
        for i in range(r + 1, rows):
            f = A[i, r] / A[r, r]
            for j in range(r, m):
                A[i, j] -= f * A[r, j]
    x = np.empty(m)  # 2
    x[m - 1] = 1.0
    for r in range(rows - 1, -1, -1):
        s = 0.0
        for j in range(r + 1, m):
            s += A[r, j] * x[j]
        x[r] = -s / A[r, r]
    square = 0.0  # 3
    for j in range(m):
        square += x[j] * x[j]
    for j in range(m):
        n[order[j]] = x[j] / np.sqrt(square)


class Polytope(NamedTuple):
    """Simplicial facets; the arrays are larger than what is in use.

    Attributes:
        points: (most, m) corners in the order they came.
        corners: (size, m) corners of each facet, ascending.
        beside: (size, m) the facet across from each of its corners.
        normals, offsets: (size, m), (size,) unit outward normal n and d, n . x <= d inside; d is infinite once hidden.
        seen: (size,) the last turn in which a new corner saw the facet; minus it if the corner did not.
        inside: (m,) a point inside.
        A: (m - 1, m) buffer of an elimination.
        found: (size,) facets that a new corner sees.
        heights: (size,) of the new corner over the facets that were asked.
        clock: (1,) turns taken since the arrays were made, so that none has to be cleared.
    """

    points: Floats
    corners: NDArray[np.int64]
    beside: NDArray[np.int64]
    normals: Floats
    offsets: Floats
    seen: NDArray[np.int64]
    inside: Floats
    A: Floats
    found: NDArray[np.int64]
    heights: Floats
    clock: NDArray[np.int64]


class Ridges(NamedTuple):
    """Hash table that pairs the ridges of new facets: ridge, facet and which of its corners is missing, turn."""

    key: NDArray[np.int64]
    facet: NDArray[np.int64]
    skipped: NDArray[np.int64]
    turn: NDArray[np.int64]


@compiled
def make_polytope(m: int, most: int, size: int) -> Polytope:
    """Arrays for up to `most` corners and `size` facets in m dimensions; they can be used again and again."""
    return Polytope(
        np.empty((most, m)), np.empty((size, m), np.int64), np.empty((size, m), np.int64), np.empty((size, m)),
        np.empty(size), np.zeros(size, np.int64), np.zeros(m), np.empty((m - 1, m)), np.empty(size, np.int64),
        np.empty(size), np.zeros(1, np.int64),
    )  # fmt: skip


@compiled
def make_ridges() -> Ridges:
    """The table that goes with a polytope; it too can be used again."""
    return Ridges(
        np.empty(TABLE, np.int64), np.empty(TABLE, np.int64), np.empty(TABLE, np.int64), np.zeros(TABLE, np.int64)
    )


@compiled
def away(u: Floats, basis: Floats, count: int) -> float:
    """Make u a unit vector orthogonal to the first rows of an orthonormal basis; its length before, 0 if lost."""
    for _ in range(2):
        for i in range(count):
            s = dot(basis[i], u)
            for c in range(len(u)):
                u[c] -= s * basis[i, c]
    length = np.sqrt(dot(u, u))
    for c in range(len(u)):
        u[c] /= max(length, LEAST_DIVISOR)
    return length


@compiled
def furthest_either_way(D: Floats, together: bool, u: Floats, from_: Floats, w: Floats, best: Floats) -> float:
    """Into `best` the set's point furthest along u or against it; its distance from the plane through a point."""
    m, most = len(u), 0.0
    for _ in range(2):
        support(D, together, u, w)
        height = dot(u, w) - dot(u, from_)
        if height > most:
            most = height
            best[:] = w
        for c in range(m):
            u[c] = -u[c]
    return most


@compiled
def first_simplex(D: Floats, together: bool, size: float, points: Floats) -> bool:
    """Corners, m + 1, of the set that span the space, each far from the flat through those before it.

    1. The axis of which most is left across the flat gives a direction; the set's furthest points along it and against
       it are looked at, and the further one is taken.
    2. Where that is near the flat the other axes are asked too, and the furthest point of all is taken.
    """
    m = points.shape[1]
    u, w, basis, left = np.zeros(m), np.empty(m), np.empty((m, m)), np.ones(m)
    u[0] = 1.0
    support(D, together, u, points[0])
    for k in range(1, m + 1):
        best, first = 0.0, int(np.argmax(left))
        for turn in range(-1, m):  # 1
            axis = first if turn < 0 else turn
            if turn == 0 and best > FAR * size:  # 2
                break
            u[:] = 0.0
            u[axis] = 1.0
            if turn == first or away(u, basis, k - 1) < TURNED:
                continue
            height = furthest_either_way(D, together, u, points[0], w, basis[k - 1])
            if height > best:
                best = height
                points[k] = basis[k - 1]
        if best < FLATNESS * size:
            return False
        for c in range(m):
            basis[k - 1, c] = points[k, c] - points[0, c]
        away(basis[k - 1], basis, k - 1)
        for c in range(m):
            left[c] -= basis[k - 1, c] ** 2
    return True


@compiled
def move(w: Floats, length: float, state: int) -> int:
    """Move a corner by up to a length in a reproducible random direction; the generator's next state."""
    for c in range(len(w)):
        state = (state * 1103515245 + 12345) % 2147483648
        w[c] += length * (state / 1073741824.0 - 1.0)
    return state


@compiled
def lay(dimension: Dimension, P: Polytope, f: int) -> None:
    """Hyperplane of a facet through its corners.

    1. The normal is orthogonal to the edges from the last corner to the others.
    2. It points away from a point inside; the offset is that of the last corner.
    """
    m = len(dimension)
    last = P.corners[f, m - 1]
    for i in range(m - 1):  # 1
        for c in range(m):
            P.A[i, c] = P.points[P.corners[f, i], c] - P.points[last, c]
    n = P.normals[f]
    null_vector(dimension, P.A, n)
    d = dot(n, P.points[last])  # 2
    if dot(n, P.inside) > d:
        for c in range(m):
            n[c] = -n[c]
        d = -d
    P.offsets[f] = d


@compiled
def begin(dimension: Dimension, P: Polytope) -> int:
    """Facets of the simplex of the first m + 1 points; how many."""
    m = len(dimension)
    for i in range(m + 1):
        for c in range(m):
            P.inside[c] = (P.inside[c] if i > 0 else 0.0) + P.points[i, c] / (m + 1)
    for f in range(m + 1):
        for i in range(m):
            P.corners[f, i] = P.beside[f, i] = i if i < f else i + 1
        lay(dimension, P, f)
    return m + 1


@reordered
def see(dimension: Dimension, P: Polytope, corner: int, f: int, turn: int, roundoff: float) -> int:
    """Facets that a corner beyond facet f sees, into `found`; how many.

    1. Height of the corner over the facet beyond which it lies.
    2. From each facet that is seen its neighbours are looked at, each once in a turn: positive heights are seen, the
       others are where the horizon runs.
    """
    found, seen, beside, normals, offsets, heights = P.found, P.seen, P.beside, P.normals, P.offsets, P.heights
    points, count, done = P.points, 1, 0
    found[0], seen[f], heights[f] = f, turn, -offsets[f]  # 1
    for c in range(len(dimension)):
        heights[f] += normals[f, c] * points[corner, c]
    while done < count:  # 2
        g = found[done]
        done += 1
        for j in range(len(dimension)):
            h = beside[g, j]
            if abs(seen[h]) == turn:
                continue
            height = -offsets[h]
            for c in range(len(dimension)):
                height += normals[h, c] * points[corner, c]
            heights[h] = height
            seen[h] = turn if height > roundoff else -turn
            if height > roundoff:
                found[count] = h
                count += 1
    return count


@reordered
def cover(dimension: Dimension, P: Polytope, corner: int, hidden: int, turn: int, facets: int, roundoff: float) -> int:
    """New facets through a corner and each ridge between a facet that it sees and one that it does not; how many then.

    With heights s >= 0 of the corner over facet g and t >= 0 below facet h, the plane s (n_h, d_h) + t (n_g, d_g)
    holds the ridge between them and the corner: no elimination, nothing cancels. If both are roundoff, corners decide.

    1. Across each corner of a seen facet g is a neighbour h; where h is not seen, the ridge between them is on the
       horizon.
    2. The corners of the ridge and the new one make a facet, which becomes the neighbour of h.
    3. Its plane by the heights.
    4. Where these are roundoff, its plane by elimination.
    """
    m, found, seen, beside, corners = len(dimension), P.found, P.seen, P.beside, P.corners
    normals, offsets, heights = P.normals, P.offsets, P.heights
    for a in range(hidden):  # 1
        g = found[a]
        for j in range(m):
            h = beside[g, j]
            if seen[h] == turn:
                continue
            if facets >= len(offsets):
                return -1
            k = 0  # 2
            for i in range(m):
                if i != j:
                    corners[facets, k] = corners[g, i]
                    k += 1
                if beside[h, i] == g:
                    beside[h, i] = facets
            corners[facets, m - 1], beside[facets, m - 1] = corner, h
            s, t, square = heights[g], -heights[h], 0.0  # 3
            for c in range(m):
                normals[facets, c] = s * normals[h, c] + t * normals[g, c]
                square += normals[facets, c] ** 2
            factor = 1.0 / np.sqrt(square)
            for c in range(m):
                normals[facets, c] *= factor
            offsets[facets] = (s * offsets[h] + t * offsets[g]) * factor
            if t < 0.0 or not s + t > STEADY * roundoff:  # 4
                lay(dimension, P, facets)
            facets += 1
    return facets


@compiled
def join(dimension: Dimension, P: Polytope, R: Ridges, first: int, facets: int, turn: int) -> bool:
    """Pair the new facets along the ridges that they share; whether every ridge found its two.

    1. The ridge of a new facet without one of its corners packs into one integer; the new corner, which all share, is
       left out.
    2. Its place in the table: the next that is free in this turn, or holds the same ridge.
    3. A ridge that comes first waits; the second joins both facets; a third means that rounding spoilt the polytope.
    """
    m, corners, beside = len(dimension), P.corners, P.beside
    keys, turns, owner, skipped = R.key, R.turn, R.facet, R.skipped
    opened = 0
    for new in range(first, facets):
        for skip in range(m - 1):
            key = 0  # 1
            for i in range(m - 1):
                if i != skip:
                    key = key * MOST + corners[new, i]
            at = (key * MIX >> 40) & (TABLE - 1)  # 2
            while turns[at] == turn and keys[at] != key:
                at = (at + 1) & (TABLE - 1)
            if turns[at] != turn:  # 3
                turns[at], keys[at], owner[at], skipped[at] = turn, key, new, skip
                opened += 1
            elif owner[at] < 0:
                return False
            else:
                other = owner[at]
                beside[new, skip], beside[other, skipped[at]] = other, new
                owner[at] = -1
                opened -= 1
    return opened == 0


@compiled
def add(dimension: Dimension, P: Polytope, R: Ridges, f: int, corner: int, facets: int, roundoff: float) -> int:
    """Add a corner that lies beyond facet f; the number of facets then, or minus how it went wrong."""
    P.clock[0] += 1
    turn = P.clock[0]
    hidden = see(dimension, P, corner, f, turn, roundoff)  # 4
    grown = cover(dimension, P, corner, hidden, turn, facets, roundoff)  # 5
    if grown < 0 or 2 * (grown - facets) * len(dimension) > TABLE:
        return -FULL
    if not join(dimension, P, R, facets, grown, turn):  # 6
        return -BROKEN
    for a in range(hidden):
        P.offsets[P.found[a]] = np.inf
    return grown


@compiled
def inscribed_ball(
    dimension: Dimension,
    D: Floats,
    together: bool,
    tolerance: float,
    P: Polytope,
    R: Ridges,
    seed: int,
    direction: Floats,
) -> tuple[int, float, float, int]:
    """The largest ball about the origin.

    Args:
        dimension: m zeros (see `disc_loops.Dimension`).
        D: discs.
        together: sum them.
        tolerance: largest gap of the bounds, relative to the radius.
        P, R: buffers, for MOST corners at most.
        seed: of the moves of the corners.
        direction: (m,) out: unit direction in which the set reaches least far.

    Returns:
        How it ended; radius proven to fit (negative if the origin is outside); radius not exceeded; corners.
    """
    m, size = len(dimension), 0.0
    for i in range(len(D)):
        for j in range(D.shape[1]):
            size = max(size, np.sqrt(dot(D[i, j], D[i, j])))
    if not first_simplex(D, together, size, P.points):  # 1
        return FLAT, 0.0, 0.0, 0
    state = seed
    for i in range(m + 1):
        state = move(P.points[i], JOGGLE * size, state)
    facets, slack, most = begin(dimension, P), 10.0 * JOGGLE * size, len(P.points)
    moved = JOGGLE * size * np.sqrt(m)
    lower, upper = -np.inf, np.inf
    for count in range(m + 1, most):
        f = int(np.argmin(P.offsets[:facets]))  # 2
        lay(dimension, P, f)
        lower = P.offsets[f]
        reach = support(D, together, P.normals[f], P.points[count])
        if reach < upper:
            upper = reach
            direction[:] = P.normals[f]
        if reach < -slack or upper - lower <= tolerance * upper + slack or reach - lower <= slack:
            return CONVERGED, lower - moved, upper, count
        state = move(P.points[count], JOGGLE * size, state)  # 3
        facets = add(dimension, P, R, f, count, facets, VISIBLE * size)
        if facets < 0:
            return -facets, lower - moved, upper, count
    return FULL, lower - moved, upper, most
