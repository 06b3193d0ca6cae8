"""All dyads of many lists of five poses at once: for studies that vary a task thousands of times."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Booleans, Floats, Integers
from mafsil.mobility.synthesis.five_poses import five_pose_pairs
from mafsil.mobility.synthesis.poses import PoseConditions, checked_poses, in_plane

MOST_DYADS = 4


@dataclass(frozen=True, eq=False, repr=False)
class ManyDyads:
    """Dyads of batches of five poses; the point of one with a slider is infinite, across the line of the slider.

    Attributes:
        fixed: (*batch, 4, 2) fixed pivots [m]; NaN beyond their number, where `there` is false.
        moving: (*batch, 4, 2) moving pivots in the frame of the coupler [m], likewise.
        count: (*batch,) number of real dyads.
        infinite: (*batch,) whether there are infinitely many, or the poses have only two angles (which
            `synthesise_motion` takes), so that none is listed.
    """

    fixed: Floats
    moving: Floats
    count: Integers
    infinite: Booleans

    def __repr__(self) -> str:
        return f"ManyDyads(count={self.count!r}, infinite={self.infinite!r})"

    @property
    def there(self) -> Booleans:
        """(*batch, 4) which places hold a dyad."""
        return np.asarray(np.arange(MOST_DYADS) < self.count[..., None], dtype=np.bool_)


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
    turn = np.exp(-1j * given.poses[..., :1, 2])
    origin = given.poses[..., :1, 0] + 1j * given.poses[..., :1, 1]
    middle, size = given.middle[..., None], given.size[..., None]
    with np.errstate(invalid="ignore"):
        fixed = in_plane(np.asarray(p, dtype=np.float64), middle, size)
        moving = in_plane(np.asarray(q, dtype=np.float64), middle - origin, size, turn)
    return ManyDyads(fixed, moving, pairs.real.sum(axis=-1), pairs.infinite)
