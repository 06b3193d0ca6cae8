"""The canonical subproblems as array functions: all turns about known axes that bring points where they should be.

Every function returns the closest approach where there is no solution, with the residual, and says where every angle
solves.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, as_batch, single
from mafsil.floating_point import EPS
from mafsil.geometry.membership import Declared
from mafsil.ik.tolerances import SAME_SUBPROBLEM

_distances = Declared("subproblem_quartics.distances", "w:3 r:3 p:3 o:3 distance", "table:2,3")
_two_axes = Declared("subproblem_quartics.two_axes", "w1:3 w2:3 p:3 z:3", "table:2,5")
_heights = Declared("subproblem_quartics.heights", "w:3 h:3 p:3 height", "table:2,3")
_wrist = Declared("subproblem_quartics.wrist", "w4:3 w5:3 w6:3 R:3,3", "table:2,5")
_three_axes = Declared("subproblem_quartics.three_axes", "k1:3 k2:3 k3:3 p0:3 p1:3 p2:3 p3:3", "table:4,5")
_circles = Declared("subproblem_quartics.circles", "A:2,2 B:2,2 b:2", "table:4,4")


class Angles(NamedTuple):
    """The roots of a subproblem, two or four.

    Attributes:
        angles: (*batch, 2) or (*batch, 2, k) angles [rad].
        residual: (*batch, 2) of the closest approach: zero where it is a solution.
        free: (*batch, 2) whether every angle solves.
    """

    angles: Floats
    residual: Floats
    free: NDArray[np.bool_]

    @classmethod
    def of(cls, table: Floats, angles: int | slice) -> Angles:
        """From rows (..., residual, free) of a compiled subproblem.

        Args:
            table: (*batch, roots, columns).
            angles: which columns are the angles.
        """
        *_, residual, free = np.moveaxis(table, -1, 0)
        return cls(table[..., angles], residual, free > 0)

    def solutions(self, tolerance: float = 1e-12) -> Floats:
        """The distinct solutions of one problem, (m,) or (m, k); one representative where every angle solves."""
        rows = [row for row, short in zip(self.angles, self.residual, strict=True) if short <= tolerance]
        kept: list[Floats] = []
        for row in rows:
            if not any(
                np.abs(np.remainder(row - other + np.pi, 2 * np.pi) - np.pi).max() < SAME_SUBPROBLEM for other in kept
            ):
                kept.append(row)
        return np.reshape(kept, (len(kept), *self.angles.shape[1:]))


def distances(w: ArrayLike, r: ArrayLike, p: ArrayLike, distance: ArrayLike, o: ArrayLike = (0.0, 0.0, 0.0)) -> Angles:
    """All q with |exp([S] q) p - o| = distance, S the axis along w through r (subproblem 3).

    Args:
        w: (*batch, 3) unit axis.
        r: (*batch, 3) a point of it [m].
        p, o: (*batch, 3) the point that is turned, and that from which is measured [m].
        distance: (*batch,) [m].
    """
    table = _distances(
        *(as_batch(n, x, (3,)) for n, x in zip("wrpo", (w, r, p, o), strict=True)), as_batch("distance", distance, ())
    )
    return Angles.of(table, 0)


def heights(w: ArrayLike, h: ArrayLike, p: ArrayLike, height: ArrayLike) -> Angles:
    """All q with h . Rot(w, q) p = height (subproblem 4).

    Args:
        w, h: (*batch, 3) unit axis through the origin, and unit direction of heights.
        p: (*batch, 3) [m].
        height: (*batch,) [m].
    """
    table = _heights(
        *(as_batch(n, x, (3,)) for n, x in zip("whp", (w, h, p), strict=True)), as_batch("height", height, ())
    )
    return Angles.of(table, 0)


def two_axes(w1: ArrayLike, w2: ArrayLike, p: ArrayLike, z: ArrayLike) -> Angles:
    """All (q1, q2) with Rot(w1, q1) Rot(w2, q2) p = z for axes through the origin, |p| = |z| (subproblem 2).

    Args:
        w1, w2: (*batch, 3) unit axes, not parallel.
        p, z: (*batch, 3) start and goal [m].
    """
    names = ("w1", "w2", "p", "z")
    table = _two_axes(*(as_batch(n, x, (3,)) for n, x in zip(names, (w1, w2, p, z), strict=True)))
    return Angles.of(table, slice(2))


def wrist_angles(w4: ArrayLike, w5: ArrayLike, w6: ArrayLike, R: ArrayLike) -> Angles:
    """All (q4, q5, q6) with Rot(w4, q4) Rot(w5, q5) Rot(w6, q6) = R, neighbouring axes not parallel.

    Args:
        w4, w5, w6: (*batch, 3) unit axes; orthogonal neighbours reach every rotation.
        R: (*batch, 3, 3).
    """
    names = ("w4", "w5", "w6")
    table = _wrist(*(as_batch(n, x, (3,)) for n, x in zip(names, (w4, w5, w6), strict=True)), as_batch("R", R, (3, 3)))
    return Angles.of(table, slice(3))


def three_axes(
    k1: ArrayLike, k2: ArrayLike, k3: ArrayLike, p0: ArrayLike, p1: ArrayLike, p2: ArrayLike, p3: ArrayLike
) -> Angles:
    """All (q1, q2, q3) with p0 + Rot(k1, q1) p1 = Rot(k2, q2) (p2 + Rot(k3, q3) p3) (subproblem 5).

    Args:
        k1, k2, k3: (*batch, 3) unit axes through the origin; the first two not parallel.
        p0: (*batch, 3) with a part along k1 x k2 [m].
        p1, p2, p3: (*batch, 3) [m].
    """
    names = ("k1", "k2", "k3", "p0", "p1", "p2", "p3")
    table = _three_axes(*(as_batch(n, x, (3,)) for n, x in zip(names, (k1, k2, k3, p0, p1, p2, p3), strict=True)))
    return Angles.of(table, slice(3))


def linked_circles(A: ArrayLike, B: ArrayLike, b: ArrayLike) -> Angles:
    """All (q1, q2) with A (cos q1, sin q1) + B (cos q2, sin q2) = b (subproblem 6).

    Args:
        A: (*batch, 2, 2).
        B: (*batch, 2, 2), not singular.
        b: (*batch, 2).
    """
    table = _circles(as_batch("A", A, (2, 2)), as_batch("B", B, (2, 2)), as_batch("b", b, (2,)))
    return Angles.of(table, slice(2))


def project_off_axis(w: ArrayLike, p: ArrayLike) -> Floats:
    """(*batch, 3) the part of a point or vector normal to an axis through the origin, p - (w . p) w.

    Args:
        w: (*batch, 3) unit axis.
        p: (*batch, 3) [m].
    """
    axis, x = as_batch("w", w, (3,)), as_batch("p", p, (3,))
    return x - (axis * x).sum(axis=-1, keepdims=True) * axis


def signed_angle(w: ArrayLike, a: ArrayLike, b: ArrayLike) -> Floats:
    """(*batch,) the turn about an axis that brings the projection of a onto that of b, in (-pi, pi] [rad].

    atan2(w . (a x b), a . b) of the projections: right in all quadrants, whatever their lengths. Zero where one of them
    vanishes: every angle does there.

    Args:
        w: (*batch, 3) unit axis.
        a, b: (*batch, 3) vectors.
    """
    axis, u, v = as_batch("w", w, (3,)), project_off_axis(w, a), project_off_axis(w, b)
    return np.arctan2((axis * np.cross(u, v)).sum(axis=-1), (u * v).sum(axis=-1))


def strokes(r: ArrayLike, v: ArrayLike, c: float) -> Floats:
    """The increasing q with |r + q v| = |c|: none, one or two; the quadratic of a prismatic third joint.

    q = -(r . v) +- sqrt((r . v)^2 - |r|^2 + c^2); out of reach where |r|^2 - (r . v)^2 > c^2.

    Args:
        r: (3,) the point at q = 0, seen from the place from which is measured [m].
        v: (3,) unit direction of the stroke.
        c: the distance [m].
    """
    point, direction, distance = single("r", r, (3,)), single("v", v, (3,)), float(single("c", c, ()))
    along = float(point @ direction)
    left = along**2 - float(point @ point) + distance**2
    if abs(left) <= 2 * EPS * (along**2 + float(point @ point) + distance**2):
        return np.array([-along])
    return np.array([-along - np.sqrt(left), -along + np.sqrt(left)]) if left > 0.0 else np.zeros(0)
