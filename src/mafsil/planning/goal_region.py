"""Goals that leave room: any pose of the tip within a box, turned by no more than an angle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, as_batch, frozen, real_array, require_finite, whole
from mafsil.errors import InputError
from mafsil.fields import between
from mafsil.geometry import rotation
from mafsil.model.placement import checked_pose

MOST_POSES = 10_000


@dataclass(frozen=True, eq=False, slots=True)
class GoalRegion:
    """A goal region: poses of the tip near a nominal one.

    Attributes:
        T: (4, 4) the pose in the middle, in {s}.
        box: (3,) how far the tip may be from it along each axis of that pose, to both sides [m]; one number for all.
        angle: by how much it may be turned from it, about any axis [rad]; pi for any orientation.
        axis: about which alone it may be turned, in the frame of the pose, such as (0, 0, 1) for a round tool; None for
            any axis.
        count: poses that are tried, that in the middle first.
        seed: of the others.

    Raises:
        InputError: no pose, a negative length or angle, an angle above pi.
    """

    T: PoseMatrix
    box: Floats | float = 0.0
    angle: float = 0.0
    axis: ArrayLike | None = None
    count: int = 64
    seed: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "T", frozen(checked_pose("T", self.T)))
        box = require_finite("box", real_array("box", self.box))
        if box.shape not in ((), (3,)) or (box < 0.0).any():
            raise InputError("planning.region_box", value=self.box)
        object.__setattr__(self, "box", frozen(np.broadcast_to(box, (3,))))
        object.__setattr__(self, "angle", between(0.0, np.pi + 1e-12)("angle", self.angle))
        if self.axis is not None:
            axis = require_finite("axis", real_array("axis", self.axis))
            if axis.shape != (3,) or not axis.any():
                raise InputError("planning.constraint_direction", name="axis")
            object.__setattr__(self, "axis", frozen(axis / np.linalg.norm(axis)))
        whole("count", self.count, 1, MOST_POSES)
        whole("seed", self.seed)

    def poses(self) -> PoseMatrix:
        """(count, 4, 4) the pose in the middle, then others evenly within the region; equal seeds give equal poses."""
        rng = np.random.default_rng(self.seed)
        poses = np.tile(self.T, (self.count, 1, 1))
        places = rng.uniform(-1.0, 1.0, (self.count, 3)) * self.box
        vectors = self._turns(rng)
        places[0], vectors[0] = 0.0, 0.0
        poses[:, :3, 3] += places @ self.T[:3, :3].T
        poses[:, :3, :3] = self.T[:3, :3] @ rotation.exp(vectors)
        return poses

    def contains(self, T: ArrayLike, tolerance: float = 1e-6) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """(*batch,) whether poses (*batch, 4, 4) lie in the region, up to a tolerance [m, rad]."""
        poses = as_batch("T", T, (4, 4), finite=True)
        away = (poses[..., :3, 3] - self.T[:3, 3]) @ self.T[:3, :3]
        turns = rotation.log(np.swapaxes(self.T[:3, :3], -1, -2) @ poses[..., :3, :3])
        if self.axis is not None:
            along = np.asarray(turns @ np.asarray(self.axis))[..., None] * np.asarray(self.axis)
            off = np.linalg.norm(turns - along, axis=-1)
            turned = (off <= tolerance) & (np.linalg.norm(along, axis=-1) <= self.angle + tolerance)
        else:
            turned = np.linalg.norm(turns, axis=-1) <= self.angle + tolerance
        return np.asarray((np.abs(away) <= self.box + tolerance).all(axis=-1) & turned)

    def _turns(self, rng: np.random.Generator) -> Floats:
        """(count, 3) rotation vectors: even over the ball of rotations, or over the angle about the axis."""
        if self.axis is not None:
            return rng.uniform(-self.angle, self.angle, (self.count, 1)) * np.asarray(self.axis)
        ways = rng.standard_normal((self.count, 3))
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        return _angles(rng.random(self.count), self.angle)[:, None] * ways


def _angles(shares: Floats, most: float) -> Floats:
    """Angles of rotations that are even by Haar's measure: (a - sin a) / (A - sin A) = share, by bisection."""
    low, high = np.zeros_like(shares), np.full_like(shares, most)
    for _ in range(60):
        middle = 0.5 * (low + high)
        above = middle - np.sin(middle) > shares * (most - np.sin(most))
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return 0.5 * (low + high)
