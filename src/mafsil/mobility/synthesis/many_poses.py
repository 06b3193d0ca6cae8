"""All dyads of many lists of five poses at once: for studies that vary a task thousands of times."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Booleans, Floats, Integers
from mafsil.mobility.synthesis.five_poses import five_pose_pairs
from mafsil.mobility.synthesis.poses import PoseConditions, as_points, checked_poses
from mafsil.mobility.synthesis.tolerances import AT_INFINITY

MOST_DYADS = 4


@dataclass(frozen=True, eq=False)
class ManyDyads:
    """Dyads of batches of five poses; those with a slider hold NaN where their point is at infinity.

    Attributes:
        fixed: (*batch, 4, 2) fixed pivots [m]; NaN beyond `count`.
        moving: (*batch, 4, 2) moving pivots in the frame of the coupler [m]; NaN beyond `count`.
        count: (*batch,) number of real dyads.
        infinite: (*batch,) whether there are infinitely many, or the poses have only two angles (which
            `synthesise_motion` takes), so that none is listed.
    """

    fixed: Floats
    moving: Floats
    count: Integers
    infinite: Booleans


def five_pose_dyads(poses: ArrayLike) -> ManyDyads:
    """All dyads of five poses each.

    Args:
        poses: (*batch, 5, 3) poses (x, y, phi) of the coupler [m, rad].

    Raises:
        InputError: not five poses, or two of one list coincide.
    """
    given = PoseConditions.of(checked_poses(poses, 5, 5))
    pairs = five_pose_pairs(given.M)
    first = np.argsort(~pairs.real, axis=-1, kind="stable")[..., :MOST_DYADS]
    p, q = (np.take_along_axis(points, first[..., None], axis=-2) for points in (pairs.p, pairs.q))
    fixed, moving = (_places(given, np.asarray(points, dtype=np.float64)) for points in (p, q))
    turn = np.exp(-1j * given.poses[..., :1, 2])
    origin = given.poses[..., :1, 0] + 1j * given.poses[..., :1, 1]
    return ManyDyads(as_points(fixed), as_points((moving - origin) * turn), pairs.real.sum(axis=-1), pairs.infinite)


def _places(given: PoseConditions, points: Floats) -> np.ndarray[tuple[int, ...], np.dtype[np.complex128]]:
    """(*batch, 4) homogeneous points of size one in the world."""
    with np.errstate(invalid="ignore"):
        third = np.where(np.abs(points[..., 2]) < AT_INFINITY, np.nan, points[..., 2])
        unit = (points[..., 0] + 1j * points[..., 1]) / third
        return given.middle[..., None] + given.size[..., None] * unit
