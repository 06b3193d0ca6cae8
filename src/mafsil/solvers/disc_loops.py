"""Discs of wrenches, and how far a set of them reaches in a direction (its support function), compiled.

Disc i of D (k, parts, m) is {a + c E_1 + s E_2 + t g : c^2 + s^2 <= 1, |t| <= 1} with a = D[i, 0], E = D[i, 1:3],
g = D[i, 3]; parts is 1 (points), 3 or 4. A round friction cone with unit push is one; the set is the hull of all.

Along u a disc reaches a . u + hypot(E_1 . u, E_2 . u) + |g . u|, at c = E_1 . u / hypot, s = E_2 . u / hypot, t = +-1.
The hull reaches as far as the furthest disc; a sum as far as those that reach beyond the origin, together.
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
