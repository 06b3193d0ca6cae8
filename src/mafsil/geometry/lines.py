"""Lines of space: distance, angle, and the common normal of two of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Scalar, Truth, Vector3, as_batch
from mafsil.errors import InputError
from mafsil.geometry.tolerances import ROUNDOFF


@dataclass(frozen=True, eq=False)
class CommonNormal:
    """The shortest connection of two lines, normal to both.

    Attributes:
        first, second: (*batch, 3) its ends on the two lines [m].
        direction: (*batch, 3) unit vector from the first line to the second; of lines that meet the normal of their
            plane, d1 x d2; of lines that coincide NaN: every normal will do.
        distance: (*batch) [m].
        angle: (*batch) from d1 to d2 about the direction, in [0, pi] for lines that meet [rad].
        parallel: (*batch) whether there are infinitely many: the one through the first line's point is given.
    """

    first: Vector3
    second: Vector3
    direction: Vector3
    distance: Scalar
    angle: Scalar
    parallel: Truth


def common_normal(
    point_1: ArrayLike, direction_1: ArrayLike, point_2: ArrayLike, direction_2: ArrayLike
) -> CommonNormal:
    """The common normal of two lines; distance and angle are the a and the alpha of a Denavit-Hartenberg link.

    Args:
        point_1, point_2: (*batch, 3) a point of each line [m].
        direction_1, direction_2: (*batch, 3) along them, any lengths but zero.

    Raises:
        InputError: a direction is zero.
    """
    p, r = as_batch("point_1", point_1, (3,)), as_batch("point_2", point_2, (3,))
    d, e = _unit("direction_1", direction_1), _unit("direction_2", direction_2)
    p, r, d, e = np.broadcast_arrays(p, r, d, e)
    across, step = np.cross(d, e), r - p
    sine = np.linalg.norm(across, axis=-1)
    parallel = sine <= ROUNDOFF
    square = np.where(parallel, 1.0, sine**2)[..., None]
    along = cast("Floats", np.sum(np.cross(step, e) * across, axis=-1, keepdims=True)) / square
    back = cast("Floats", np.sum(np.cross(step, d) * across, axis=-1, keepdims=True)) / square
    flat = parallel[..., None]
    first = p + np.where(flat, 0.0, along) * d
    beside = cast("Floats", np.sum(step * d, axis=-1, keepdims=True)) * d
    second = np.where(flat, p + step - beside, r + back * e)
    gap = second - first
    distance = np.linalg.norm(gap, axis=-1)
    size = ROUNDOFF * (np.linalg.norm(step, axis=-1) + np.linalg.norm(p, axis=-1))
    apart = (distance > size)[..., None]
    with np.errstate(invalid="ignore", divide="ignore"):
        normal = np.where(apart, gap / distance[..., None], np.where(flat, np.nan, across / sine[..., None]))
    projected = cast("Floats", np.sum(across * normal, axis=-1))
    signed = np.where(np.isnan(normal[..., 0]), sine, projected)
    angle = np.arctan2(signed, np.sum(d * e, axis=-1))
    return CommonNormal(first, second, normal, np.where(apart[..., 0], distance, 0.0), angle, parallel)


def _unit(name: str, direction: ArrayLike) -> Floats:
    d = as_batch(name, direction, (3,))
    size = np.linalg.norm(d, axis=-1, keepdims=True)
    if np.any(size == 0.0):
        raise InputError("geometry.axis", name=name, value=d[tuple(np.argwhere(size[..., 0] == 0.0)[0])].tolist())
    return d / size
