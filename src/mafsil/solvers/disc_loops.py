"""Discs of wrenches, and how far a set of them reaches in a direction (its support function), compiled.

Disc i of D (k, parts, m) is {a + c E_1 + s E_2 + t g : c^2 + s^2 <= 1, |t| <= 1} with a = D[i, 0], E = D[i, 1:3],
g = D[i, 3]; parts is 1 (points), 3 or 4. A round friction cone with unit push is one; the set is the hull of all.

Along u a disc reaches a . u + hypot(E_1 . u, E_2 . u) + |g . u|, at c = E_1 . u / hypot, s = E_2 . u / hypot, t = +-1.
The hull reaches as far as the furthest disc; a sum as far as those that reach beyond the origin, together.

The wrenches of contacts become discs in coordinates that suit them (`contact_discs`).
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled

Dimension: TypeAlias = tuple[int, ...]
"""m zeros: the length of a tuple is known when a loop is compiled, so that loops over the m rows unroll."""


@compiled
def dot(a: Floats, b: Floats) -> float:
    """Sum of products."""
    total = 0.0
    for c in range(len(a)):
        total += a[c] * b[c]
    return total


@compiled
def support(D: Floats, together: bool, u: Floats, w: Floats) -> float:
    """h(u) = max u . w over the set.

    1. The height of each disc: that of its centre and how much further it reaches.
    2. Where discs are summed, those with a positive height count, each with its furthest point.
    3. Else the highest disc gives the height and the point.

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
        height = 0.0  # 1
        for c in range(m):
            height += D[i, 0, c] * u[c]
        if parts > 1:
            height += swing(D[i], u)
        if together and height > 0.0:  # 2
            total += height
            reach(D[i], u, w)
        if height > best:  # 3
            best, where = height, i
    if together:
        return total
    reach(D[where], u, w)
    return best


@compiled
def swing(disc: Floats, u: Floats) -> float:
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
def reach(disc: Floats, u: Floats, w: Floats) -> None:
    """Add the disc's furthest point to w.

    1. The centre.
    2. Along u the disc's axes x, y and torsion t.
    3. The point of the ellipse that is furthest along u, and the end of the torsion on its side.
    """
    m = len(u)
    for c in range(m):  # 1
        w[c] += disc[0, c]
    if len(disc) == 1:
        return
    x, y, t = 0.0, 0.0, 0.0  # 2
    for c in range(m):
        x += disc[1, c] * u[c]
        y += disc[2, c] * u[c]
        if len(disc) > 3:
            t += disc[3, c] * u[c]
    size = np.sqrt(x * x + y * y)  # 3
    for c in range(m):
        if size > 0.0:
            w[c] += (x * disc[1, c] + y * disc[2, c]) / size
        if len(disc) > 3:
            w[c] += disc[3, c] if t >= 0.0 else -disc[3, c]


@compiled
def conditioning(points: Floats, T: Floats) -> None:
    """Wrenches about the origin to wrenches about the middle of the points, moments divided by their spread.

    Args:
        points: (k, d).
        T: (m, m) out.
    """
    k, d = points.shape
    middle, spread = np.zeros(d), 0.0
    for i in range(k):
        for c in range(d):
            middle[c] += points[i, c] / k
    for i in range(k):
        square = 0.0
        for c in range(d):
            square += (points[i, c] - middle[c]) ** 2
        spread = max(spread, np.sqrt(square))
    about(middle, spread if spread > 0.0 else 1.0, T)


@compiled
def about(origin: Floats, length: float, T: Floats) -> None:
    """Wrenches about the origin of the frame to wrenches about another point, moments divided by a length.

    Args:
        origin: (d,) the point.
        length: the divisor.
        T: (m, m) out.
    """
    d, m = len(origin), len(T)
    for i in range(m):
        for j in range(m):
            T[i, j] = 0.0
        T[i, i] = 1.0 if i >= m - d else 1.0 / length
    if d == 2:
        T[0, 1], T[0, 2] = origin[1] / length, -origin[0] / length
        return
    x, y, z = origin[0] / length, origin[1] / length, origin[2] / length
    T[0, 4], T[0, 5] = z, -y
    T[1, 3], T[1, 5] = -z, x
    T[2, 3], T[2, 4] = y, -x


@compiled
def transformed_wrench(r: Floats, f: Floats, couple: Floats, T: Floats, w: Floats) -> None:
    """W = T (r x f + couple, f); the plane has no couple.

    1. The wrench (moment, force) of the force at the point, with the couple.
    2. Its product with T.
    """
    m, d = len(w), len(r)
    raw = np.empty(m)  # 1
    if d == 2:
        raw[0] = r[0] * f[1] - r[1] * f[0]
    else:
        for a in range(3):
            b, c = (a + 1) % 3, (a + 2) % 3
            raw[a] = r[b] * f[c] - r[c] * f[b] + couple[a]
    for c in range(d):
        raw[m - d + c] = f[c]
    for i in range(m):  # 2
        w[i] = 0.0
        for j in range(m):
            w[i] += T[i, j] * raw[j]


@compiled
def contact_discs(points: Floats, normals: Floats, coefficients: Floats, T: Floats, D: Floats) -> None:
    """The discs of contacts with unit push.

    1. Friction directions a, b of length mu in the tangent plane: in space, a is square to the normal and to the axis
       that is furthest from it, and b = n x a.
    2. Wrenches of the unit push, of both friction directions, and of the torsional couple along the normal.

    Args:
        points, normals: (k, d) contact points and unit normals into the body.
        coefficients: (k, 2) of friction and of torsional friction [m].
        T: (m, m) applied to the wrenches.
        D: (k, 4, m) out.
    """
    d = points.shape[1]
    zero = np.zeros(d)
    for i in range(len(points)):
        n, mu, gamma = normals[i], coefficients[i, 0], coefficients[i, 1]
        a, b = np.zeros(d), np.zeros(d)  # 1
        if d == 2:
            a[0], a[1] = -mu * n[1], mu * n[0]
        elif mu > 0.0:
            least = int(np.argmin(np.abs(n)))
            p, q = (least + 1) % 3, (least + 2) % 3
            length = np.sqrt(n[p] * n[p] + n[q] * n[q])
            a[p], a[q] = -mu * n[q] / length, mu * n[p] / length
            for c in range(3):
                b[c] = n[(c + 1) % 3] * a[(c + 2) % 3] - n[(c + 2) % 3] * a[(c + 1) % 3]
        transformed_wrench(points[i], n, zero, T, D[i, 0])  # 2
        transformed_wrench(points[i], a, zero, T, D[i, 1])
        transformed_wrench(points[i], b, zero, T, D[i, 2])
        transformed_wrench(points[i], zero, gamma * n, T, D[i, 3])


@compiled
def rim_columns(D: Floats, edges: int, W: Floats) -> None:
    """Points on the rims of discs, torsion to and fro in turn.

    Args:
        D: (k, 4, m).
        edges: points of each.
        W: (m, most) out, the first k edges columns.
    """
    u = np.empty(D.shape[2])
    for i in range(len(D)):
        for e in range(edges):
            angle = 2.0 * np.pi * e / edges
            for c in range(len(u)):
                u[c] = D[i, 0, c] + np.cos(angle) * D[i, 1, c] + np.sin(angle) * D[i, 2, c]
                u[c] += D[i, 3, c] if e % 2 else -D[i, 3, c]
                W[c, i * edges + e] = u[c]
