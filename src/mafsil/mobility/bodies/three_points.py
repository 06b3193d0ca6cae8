"""Free bodies without angles: three points of the body are its nine coordinates, and their distances are kept.

Six angles and shifts of a free body lock somewhere; the places of three points, at the corners of a triangle, do not:
they hold the body's pose as a surface holds its points, once each and with a tangent plane everywhere.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, frozen
from mafsil.floating_point import LEAST_DIVISOR

SIDES = ((0, 1), (1, 2), (2, 0))
SCALE = 3**0.5
"""A shift of the body moves its nine coordinates by this many times its length."""


def triangle(middle: Floats, size: float) -> Floats:
    """(3, 3) corners of a triangle with equal sides about a point, at a distance [m]."""
    angles = 2 * np.pi / 3 * np.arange(3)
    return frozen(middle + size * np.stack([np.cos(angles), np.sin(angles), np.zeros(3)], axis=-1))


def pose_by_points(corners: Floats, moved: Floats) -> tuple[Floats, Floats]:
    """Displacement (*batch, 4, 4) of a body, and twists (*batch, 6, 9) per rate of the coordinates.

    The first corner is where it should be, the second on the ray towards it, the third in the half-plane.

    Args:
        corners: (3, 3) of the body, where it is drawn [m].
        moved: (*batch, 9) by how much each corner is elsewhere [m].
    """
    x = corners + moved.reshape(*moved.shape[:-1], 3, 3)
    R_0, _, _ = _frame(corners)
    R_1, along, across = _frame(x)
    T = np.zeros((*moved.shape[:-1], 4, 4))
    T[..., :3, :3] = R_1 @ R_0.T
    T[..., :3, 3] = x[..., 0, :] - T[..., :3, :3] @ corners[0]
    T[..., 3, 3] = 1.0
    return T, _twists(x[..., 0, :], R_1, along, across)


def _frame(x: Floats) -> tuple[Floats, Floats, Floats]:
    """Axes (*batch, 3, 3) of a triangle as columns, and (a, h), (l,): its third corner at a e1 + h e2, second at l e1.

    A triangle without area has some axes; its distances are not what they should be, so that it is no solution.
    """
    tiny = LEAST_DIVISOR
    first, second = x[..., 1, :] - x[..., 0, :], x[..., 2, :] - x[..., 0, :]
    length = np.linalg.norm(first, axis=-1, keepdims=True)
    e_1 = first / np.maximum(length, tiny)
    part = np.sum(second * e_1, axis=-1, keepdims=True)
    off = second - part * e_1
    height = np.linalg.norm(off, axis=-1, keepdims=True)
    e_2 = off / np.maximum(height, tiny)
    e_3 = np.asarray(np.cross(e_1, e_2), dtype=np.float64)
    return np.stack([e_1, e_2, e_3], axis=-1), np.concatenate([part, height], axis=-1), length


def _twists(origin: Floats, R: Floats, along: Floats, length: Floats) -> Floats:
    """(*batch, 6, 9) of the triangle's frame, (omega, v) with v of the point that passes the origin of the drawing.

    omega = e1 x d1 / l + e1 (e3 . d2 - a e3 . d1 / l) / h, with d1 and d2 the rates of the second and third corner
    against the first.
    """
    e_1, e_2, e_3 = R[..., 0], R[..., 1], R[..., 2]
    tiny = LEAST_DIVISOR
    part, height = along[..., :1], np.maximum(along[..., 1:], tiny)
    over = 1.0 / np.maximum(length, tiny)
    by_second = e_3[..., :, None] * e_2[..., None, :] - e_2[..., :, None] * e_3[..., None, :]
    spin = e_1[..., :, None] * e_3[..., None, :]
    by_second = (by_second - spin * (part / height)[..., None]) * over[..., None]
    by_third = spin / height[..., None]
    omega = np.concatenate([-by_second - by_third, by_second, by_third], axis=-1)
    shift = np.broadcast_to(np.eye(3, 9), (*omega.shape[:-2], 3, 9))
    return np.concatenate([omega, shift + np.cross(origin[..., :, None], omega, axis=-2)], axis=-2)


def distances(corners: Floats, moved: Floats) -> tuple[Floats, Floats]:
    """By how much the sides of the triangle are too long (*batch, 3) [m], and its rates (*batch, 3, 9).

    Args:
        corners, moved: as for `pose_by_points`.
    """
    x = corners + moved.reshape(*moved.shape[:-1], 3, 3)
    missed, rows = list[Floats](), list[Floats]()
    for a, b in SIDES:
        apart = x[..., a, :] - x[..., b, :]
        far = np.linalg.norm(apart, axis=-1)
        along = apart / np.maximum(far, LEAST_DIVISOR)[..., None]
        row = np.zeros((*moved.shape[:-1], 9))
        row[..., 3 * a : 3 * a + 3], row[..., 3 * b : 3 * b + 3] = along, -along
        missed.append(far - float(np.linalg.norm(corners[a] - corners[b])))
        rows.append(row)
    return np.stack(missed, axis=-1), np.stack(rows, axis=-2)
