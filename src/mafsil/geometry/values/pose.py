"""Pose: the pose T_ab of a frame, or the displacement of a body, as a frozen value."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, cast, overload

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Matrix6, Vector3, Vector6
from mafsil.geometry import pose as functions
from mafsil.geometry.values import labels
from mafsil.geometry.values.labels import Frames
from mafsil.geometry.values.point import METRES, Point, Vector
from mafsil.geometry.values.rotation import Rotation
from mafsil.geometry.values.value import Value, operands


@dataclass(frozen=True, eq=False, repr=False)
class Pose(Value):
    """Element of SE(3), any batch of them.

    Read as T_ab it describes {b} seen from {a}; read as an operator it displaces a body within one frame.

    Attributes:
        array: (*batch, 4, 4) [[R, p], [0, 1]], p in metres.
        frames: (a, b), or None.
    """

    frames: Frames | None = None
    core: ClassVar[int] = 2

    @staticmethod
    def check_array(array: Any) -> Floats:
        """Refuse what is not a pose within `tolerance.ROTATION`."""
        return functions.check(array, "Pose")

    @classmethod
    def identity(cls, frames: Frames | None = None) -> Pose:
        """T_aa = I."""
        return cls(np.eye(4), frames)

    @classmethod
    def of(cls, R: Rotation | ArrayLike, p: ArrayLike, frames: Frames | None = None) -> Pose:
        """From a rotation and an origin (*batch, 3) [m]; letters are taken from the rotation if it has any."""
        if isinstance(R, Rotation):
            return cls(functions.from_rotation_translation(R.array, p), frames or R.frames)
        return cls(functions.from_rotation_translation(R, p), frames)

    @classmethod
    def exp(cls, V: ArrayLike, frames: Frames | None = None) -> Pose:
        """From exponential coordinates (omega, v) (*batch, 6) [rad, m]."""
        return cls(functions.exp(V), frames)

    @classmethod
    def translation(cls, p: ArrayLike, frames: Frames | None = None) -> Pose:
        """From a translation (*batch, 3) [m]."""
        return cls(functions.from_translation(p), frames)

    @classmethod
    def nearest(cls, T: ArrayLike, frames: Frames | None = None) -> Pose:
        """With the rotation nearest to the upper left block of (*batch, 4, 4)."""
        return cls(functions.project(T), frames)

    @property
    def rotation(self) -> Rotation:
        """R_ab."""
        return Rotation(self.array[..., :3, :3], self.frames)

    @property
    def origin(self) -> Vector3:
        """(*batch, 3) p_ab [m]: the origin of {b} in {a}."""
        return self.array[..., :3, 3]

    def log(self) -> Vector6:
        """(*batch, 6) exponential coordinates (omega, v) [rad, m]."""
        return functions.log(self.array)

    def inverse(self) -> Pose:
        """T_ba."""
        return Pose(functions.inverse(self.array), labels.reversed_frames(self.frames))

    def adjoint(self) -> Matrix6:
        """(*batch, 6, 6) Ad(T_ab)."""
        return functions.adjoint(self.array)

    @overload
    def __matmul__(self, other: Pose) -> Pose: ...
    @overload
    def __matmul__(self, other: Point) -> Point: ...
    @overload
    def __matmul__(self, other: Vector) -> Vector: ...
    def __matmul__(self, other: Pose | Point | Vector) -> Pose | Point | Vector:
        """T_ab T_bc = T_ac; a point becomes R x + p, a free vector R x."""
        if isinstance(other, Vector):
            return self.rotation @ other
        if isinstance(other, Point):
            frame = labels.carry_frame("@", self.frames, other.frame)
            moved = functions.act(self.array, other.in_unit("m").array)
            return Point(moved / METRES[other.unit], frame, other.unit)
        if not isinstance(cast(object, other), Pose):
            raise operands("@", self, other)
        return Pose(functions.compose(self.array, other.array), labels.join_frames("@", self.frames, other.frames))

    def displace(self, points: ArrayLike) -> Vector3:
        """(*batch, 3) the operator's reading: points (*batch, 3) [m] moved within one frame."""
        return functions.act(self.array, points)

    def displacement_to(self, other: Pose) -> Pose:
        """T_02 T_01^-1, which carries a body from this pose to another, in the coordinates of {0}."""
        return Pose(functions.displacement(self.array, other.array))

    def interpolate_screw(self, other: Pose, t: ArrayLike) -> Pose:
        """From this pose (t = 0) to another (t = 1) by one screw motion."""
        return Pose(functions.interpolate_screw(self.array, other.array, t), self.frames)

    def interpolate_decoupled(self, other: Pose, t: ArrayLike) -> Pose:
        """From this pose (t = 0) to another (t = 1), origin on the straight line."""
        return Pose(functions.interpolate_decoupled(self.array, other.array, t), self.frames)
