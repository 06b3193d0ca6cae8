"""The largest ball about the origin inside a convex set that is known by its support function, compiled.

A simplex grows inside the set: its facet nearest to the origin bounds the radius from below, the support function in
that facet's direction from above, and the support point is the next corner. Only what lies near the answer is built.
Corners are moved by about 1e-9 of their size, so no m + 1 of them share a hyperplane.

A set is the hull of discs, D (k, parts, m): disc i is {a + c E_1 + s E_2 + t g : c^2 + s^2 <= 1, |t| <= 1} with
a = D[i, 0], E = D[i, 1:3], g = D[i, 3]; parts is 1 (points), 3 or 4. Together, the discs (and 0) are summed instead.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.solvers.loops import compiled

JOGGLE = 1e-9
VISIBLE = 1e-13
FLATNESS = 1e-10
MOST = 4096
"""Corners at most: a ridge of m - 2 corners packs into one integer."""
TABLE = 1 << 14
MET, FULL, FLAT, BROKEN = 0, 1, 2, 3
"""How `inscribed` ended: bounds met; room or corners spent; set of lower dimension; rounding spoilt the polytope."""


@compiled
def support(D: Floats, together: bool, u: Floats, w: Floats) -> float:
    """h(u) = max u . w over the set.

    Args:
        D: discs.
        together: sum them.
        u: (m,) direction.
        w: (m,) out, a point that reaches it.
    """
    k, parts, m = D.shape
    best, where = -np.inf, 0
    w[:] = 0.0
    total = 0.0
    for i in range(k):
        height = 0.0
        for c in range(m):
            height += D[i, 0, c] * u[c]
        if parts > 1:
            height += _swing(D[i], u)
        if together and height > 0.0:
            total += height
            _add(D[i], u, w)
        if height > best:
            best, where = height, i
    if together:
        return total
    _add(D[where], u, w)
    return best


@compiled
def _swing(disc: Floats, u: Floats) -> float:
    """How much further than its centre a disc reaches."""
    x, y, t = 0.0, 0.0, 0.0
    for c in range(len(u)):
        x += disc[1, c] * u[c]
        y += disc[2, c] * u[c]
    if len(disc) > 3:
        for c in range(len(u)):
            t += disc[3, c] * u[c]
    return np.sqrt(x * x + y * y) + abs(t)


@compiled
def _add(disc: Floats, u: Floats, w: Floats) -> None:
    """Add the disc's furthest point to w."""
    m = len(u)
    for c in range(m):
        w[c] += disc[0, c]
    if len(disc) == 1:
        return
    x, y, t = 0.0, 0.0, 0.0
    for c in range(m):
        x += disc[1, c] * u[c]
        y += disc[2, c] * u[c]
        if len(disc) > 3:
            t += disc[3, c] * u[c]
    size = np.sqrt(x * x + y * y)
    for c in range(m):
        if size > 0.0:
            w[c] += (x * disc[1, c] + y * disc[2, c]) / size
        if len(disc) > 3:
            w[c] += disc[3, c] if t >= 0.0 else -disc[3, c]


@compiled
def null_vector(A: Floats, n: Floats) -> None:
    """Unit vector n with A n = 0 for A (m - 1, m), by elimination with complete pivoting; A is destroyed."""
    rows, m = A.shape
    order = np.arange(m)
    for r in range(rows):
        pr, pc, big = r, r, -1.0
        for i in range(r, rows):
            for j in range(r, m):
                if abs(A[i, j]) > big:
                    pr, pc, big = i, j, abs(A[i, j])
        if not big > 0.0:
            A[r, r] = 1e-300
        for j in range(m):
            A[r, j], A[pr, j] = A[pr, j], A[r, j]
        for i in range(rows):
            A[i, r], A[i, pc] = A[i, pc], A[i, r]
        order[r], order[pc] = order[pc], order[r]
        for i in range(r + 1, rows):
            f = A[i, r] / A[r, r]
            for j in range(r, m):
                A[i, j] -= f * A[r, j]
    x = np.empty(m)
    x[m - 1] = 1.0
    for r in range(rows - 1, -1, -1):
        s = 0.0
        for j in range(r + 1, m):
            s += A[r, j] * x[j]
        x[r] = -s / A[r, r]
    square = 0.0
    for j in range(m):
        square += x[j] * x[j]
    for j in range(m):
        n[order[j]] = x[j] / np.sqrt(square)


class Polytope(NamedTuple):
    """Simplicial facets; the arrays are larger than what is in use.

    Attributes:
        points: (most, m) corners in the order they came.
        corners: (room, m) corners of each facet, ascending.
        beside: (room, m) the facet across from each of its corners.
        normals, offsets: (room, m), (room,) unit outward normal n and d, n . x <= d inside; d is infinite once hidden.
        seen: (room,) the last turn in which a new corner saw the facet.
        inside: (m,) a point inside.
        A: (m - 1, m) room for elimination.
    """

    points: Floats
    corners: NDArray[np.int64]
    beside: NDArray[np.int64]
    normals: Floats
    offsets: Floats
    seen: NDArray[np.int64]
    inside: Floats
    A: Floats


class Ridges(NamedTuple):
    """Hash table that pairs the ridges of new facets: ridge, facet and which of its corners is missing, turn."""

    key: NDArray[np.int64]
    facet: NDArray[np.int64]
    skipped: NDArray[np.int64]
    turn: NDArray[np.int64]


@compiled
def dot(a: Floats, b: Floats) -> float:
    """Sum of products."""
    total = 0.0
    for c in range(len(a)):
        total += a[c] * b[c]
    return total


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
        u[c] /= max(length, 1e-300)
    return length


@compiled
def first_simplex(D: Floats, together: bool, size: float, points: Floats) -> bool:
    """Corners, m + 1, of the set that span the space: each the furthest from the flat through those before it."""
    m = points.shape[1]
    u, w, basis = np.zeros(m), np.empty(m), np.empty((m, m))
    u[0] = 1.0
    support(D, together, u, points[0])
    for k in range(1, m + 1):
        best = 0.0
        for turn in range(2 * m):
            for c in range(m):
                u[c] = 0.0
            u[turn // 2] = 1.0 if turn % 2 else -1.0
            if away(u, basis, k - 1) < 1e-6:
                continue
            support(D, together, u, w)
            reach = dot(u, w) - dot(u, points[0])
            if reach > best:
                best = reach
                points[k] = w
        if best < FLATNESS * size:
            return False
        for c in range(m):
            basis[k - 1, c] = points[k, c] - points[0, c]
        away(basis[k - 1], basis, k - 1)
    return True


@compiled
def move(w: Floats, length: float, state: int) -> int:
    """Move a corner by up to a length in a reproducible random direction; the generator's next state."""
    for c in range(len(w)):
        state = (state * 1103515245 + 12345) % 2147483648
        w[c] += length * (state / 1073741824.0 - 1.0)
    return state


@compiled
def lay(P: Polytope, f: int) -> None:
    """Hyperplane of a facet through its corners."""
    m = P.points.shape[1]
    last = P.corners[f, m - 1]
    for i in range(m - 1):
        for c in range(m):
            P.A[i, c] = P.points[P.corners[f, i], c] - P.points[last, c]
    n = P.normals[f]
    null_vector(P.A, n)
    d = dot(n, P.points[last])
    if dot(n, P.inside) > d:
        for c in range(m):
            n[c] = -n[c]
        d = -d
    P.offsets[f] = d


@compiled
def begin(P: Polytope) -> int:
    """Facets of the simplex of the first m + 1 points; how many."""
    m = P.points.shape[1]
    for i in range(m + 1):
        for c in range(m):
            P.inside[c] += P.points[i, c] / (m + 1)
    for f in range(m + 1):
        for i in range(m):
            P.corners[f, i] = P.beside[f, i] = i if i < f else i + 1
        lay(P, f)
    return m + 1


@compiled
def see(P: Polytope, w: Floats, f: int, turn: int, dust: float, found: NDArray[np.int64]) -> int:
    """Facets that a point beyond facet f sees, into `found`; how many."""
    count, done = 1, 0
    found[0] = f
    P.seen[f] = turn
    while done < count:
        g = found[done]
        done += 1
        for j in range(P.points.shape[1]):
            h = P.beside[g, j]
            if P.seen[h] != turn and dot(P.normals[h], w) - P.offsets[h] > dust:
                P.seen[h] = turn
                found[count] = h
                count += 1
    return count


@compiled
def cover(P: Polytope, g: int, j: int, new: int, corner: int) -> None:
    """New facet through a corner and the ridge of hidden facet g across from its corner j."""
    m = P.points.shape[1]
    h, k = P.beside[g, j], 0
    for i in range(m):
        if i != j:
            P.corners[new, k] = P.corners[g, i]
            k += 1
    P.corners[new, m - 1] = corner
    P.beside[new, m - 1] = h
    for i in range(m):
        if P.beside[h, i] == g:
            P.beside[h, i] = new
    lay(P, new)


@compiled
def pair(P: Polytope, R: Ridges, new: int, turn: int) -> int:
    """Join a new facet to the other new ones along ridges; change of the number of open ridges, or a large number."""
    m, opened = P.points.shape[1], 0
    for skip in range(m - 1):
        key = 0
        for i in range(m - 1):
            if i != skip:
                key = key * MOST + P.corners[new, i]
        at = (key * 2654435761 >> 7) % len(R.key)
        while R.turn[at] == turn and R.key[at] != key:
            at = (at + 1) % len(R.key)
        if R.turn[at] != turn:
            R.turn[at], R.key[at], R.facet[at], R.skipped[at] = turn, key, new, skip
            opened += 1
        elif R.facet[at] < 0:
            return len(R.key)
        else:
            other = R.facet[at]
            P.beside[new, skip], P.beside[other, R.skipped[at]] = other, new
            R.facet[at] = -1
            opened -= 1
    return opened


@compiled
def add(P: Polytope, R: Ridges, f: int, corner: int, facets: int, dust: float, found: NDArray[np.int64]) -> int:
    """Add a corner that lies beyond facet f; the number of facets then, or minus how it went wrong."""
    hidden = see(P, P.points[corner], f, corner, dust, found)
    first, opened = facets, 0
    for a in range(hidden):
        for j in range(P.points.shape[1]):
            if P.seen[P.beside[found[a], j]] == corner:
                continue
            if facets >= len(P.offsets) or 2 * (facets - first) * P.points.shape[1] > len(R.key):
                return -FULL
            cover(P, found[a], j, facets, corner)
            opened += pair(P, R, facets, corner)
            facets += 1
    for a in range(hidden):
        P.offsets[found[a]] = np.inf
    return -BROKEN if opened else facets


@compiled
def inscribed(
    D: Floats, together: bool, tolerance: float, most: int, room: int, seed: int, direction: Floats
) -> tuple[int, float, float, int]:
    """The largest ball about the origin.

    Args:
        D: discs.
        together: sum them.
        tolerance: wanted gap of the bounds, relative to the radius.
        most: corners at most, up to MOST.
        room: facets at most.
        seed: of the moves of the corners.
        direction: (m,) out: unit direction in which the set reaches least far.

    Returns:
        How it ended; radius proven to fit (negative if the origin is outside); radius not exceeded; corners.
    """
    m, size = D.shape[2], 0.0
    for i in range(len(D)):
        for j in range(D.shape[1]):
            size = max(size, np.sqrt(dot(D[i, j], D[i, j])))
    P = Polytope(
        np.empty((most, m)), np.empty((room, m), np.int64), np.empty((room, m), np.int64), np.empty((room, m)),
        np.empty(room), np.zeros(room, np.int64), np.zeros(m), np.empty((m - 1, m)),
    )  # fmt: skip
    R = Ridges(
        np.empty(TABLE, np.int64), np.empty(TABLE, np.int64), np.empty(TABLE, np.int64), np.zeros(TABLE, np.int64)
    )
    if not first_simplex(D, together, size, P.points):
        return FLAT, 0.0, 0.0, 0
    state = seed
    for i in range(m + 1):
        state = move(P.points[i], JOGGLE * size, state)
    facets, found, slack = begin(P), np.empty(room, np.int64), 10.0 * JOGGLE * size
    lower, upper = -np.inf, np.inf
    for count in range(m + 1, most):
        f = int(np.argmin(P.offsets[:facets]))
        lower = P.offsets[f]
        reach = support(D, together, P.normals[f], P.points[count])
        if reach < upper:
            upper = reach
            direction[:] = P.normals[f]
        if reach < -slack or upper - lower <= tolerance * upper + slack or reach - lower <= slack:
            return MET, lower, upper, count
        state = move(P.points[count], JOGGLE * size, state)
        facets = add(P, R, f, count, facets, VISIBLE * size, found)
        if facets < 0:
            return -facets, lower, upper, count
    return FULL, lower, upper, most
