"""Rotation: an orientation R_ab, or the operator that turns vectors, as a frozen value."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, cast, overload

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Quaternion, Scalar, Vector3, radians
from mafsil.geometry import euler, quaternion
from mafsil.geometry import rotation as functions
from mafsil.geometry.values import labels
from mafsil.geometry.values.labels import Frames
from mafsil.geometry.values.point import Vector
from mafsil.geometry.values.value import Value, operands


@dataclass(frozen=True, eq=False, repr=False)
class Rotation(Value):
    """Element of SO(3), any batch of them.

    Read as R_ab it is the orientation of {b} seen from {a} (columns: axes of {b}); read as an operator it turns vectors
    of one frame. A matrix that is no rotation is refused; `Rotation.nearest` projects on request.

    Attributes:
        array: (*batch, 3, 3).
        frames: (a, b), or None.
    """

    frames: Frames | None = None
    core: ClassVar[int] = 2

    @staticmethod
    def check_array(array: Any) -> Floats:
        """Refuse what is not a rotation within `tolerance.ROTATION`."""
        return functions.check(array, "Rotation")

    @classmethod
    def identity(cls, frames: Frames | None = None) -> Rotation:
        """R_aa = I."""
        return cls(np.eye(3), frames)

    @classmethod
    def exp(cls, r: ArrayLike, frames: Frames | None = None) -> Rotation:
        """From exponential coordinates omega theta (*batch, 3) [rad]."""
        return cls(functions.exp(r), frames)

    @classmethod
    def from_axis_angle(
        cls, axis: ArrayLike, angle: ArrayLike, frames: Frames | None = None, *, degrees: bool = False
    ) -> Rotation:
        """About an axis (*batch, 3) by an angle (*batch) [rad, or degrees]."""
        return cls(functions.from_axis_angle(axis, radians("angle", angle, degrees=degrees)), frames)

    @classmethod
    def from_quaternion(cls, q: ArrayLike, frames: Frames | None = None) -> Rotation:
        """From unit quaternions (w, x, y, z) (*batch, 4)."""
        return cls(quaternion.from_quaternion(q), frames)

    @classmethod
    def from_rpy(cls, rpy: ArrayLike, frames: Frames | None = None, *, degrees: bool = False) -> Rotation:
        """From roll, pitch, yaw (*batch, 3) [rad, or degrees if said] about fixed x, y, z."""
        return cls(euler.from_rpy(radians("rpy", rpy, degrees=degrees)), frames)

    @classmethod
    def from_euler(
        cls, angles: ArrayLike, sequence: str, frames: Frames | None = None, *, degrees: bool = False
    ) -> Rotation:
        """From three angles (*batch, 3) [rad, or degrees] of a sequence such as `ZYX` (body) or `xyz` (fixed)."""
        return cls(euler.from_euler(radians("angles", angles, degrees=degrees), sequence), frames)

    @classmethod
    def from_axes(cls, x: ArrayLike, y: ArrayLike, z: ArrayLike, frames: Frames | None = None) -> Rotation:
        """From the axes of {b} seen from {a}, (*batch, 3) each."""
        return cls(functions.from_axes(x, y, z), frames)

    @classmethod
    def nearest(cls, M: ArrayLike, frames: Frames | None = None) -> Rotation:
        """The rotation nearest to any matrix (*batch, 3, 3)."""
        return cls(functions.project(M), frames)

    @classmethod
    def random(cls, seed: int | np.random.Generator, batch: int | tuple[int, ...] = ()) -> Rotation:
        """Uniform over SO(3); the seed is a whole number, or a NumPy generator, which moves on."""
        return cls(functions.random(seed, batch))

    def log(self) -> Vector3:
        """(*batch, 3) principal exponential coordinates [rad]."""
        return functions.log(self.array)

    def axis_angle(self) -> tuple[Vector3, Scalar]:
        """Unit axis (*batch, 3) and angle (*batch) in [0, pi] [rad]."""
        return functions.to_axis_angle(self.array)

    def quaternion(self) -> Quaternion:
        """(*batch, 4) unit quaternion, w >= 0."""
        return quaternion.to_quaternion(self.array)

    def rpy(self) -> Vector3:
        """(*batch, 3) roll, pitch, yaw [rad]."""
        return euler.to_rpy(self.array)

    def euler(self, sequence: str) -> Vector3:
        """(*batch, 3) principal angles [rad] of a sequence."""
        return euler.to_euler(self.array, sequence)

    def inverse(self) -> Rotation:
        """R_ba."""
        return Rotation(functions.inverse(self.array), labels.reversed_frames(self.frames))

    @overload
    def __matmul__(self, other: Rotation) -> Rotation: ...
    @overload
    def __matmul__(self, other: Vector) -> Vector: ...
    def __matmul__(self, other: Rotation | Vector) -> Rotation | Vector:
        """R_ab R_bc = R_ac, or v_a = R_ab v_b."""
        if isinstance(other, Vector):
            frame = labels.carry_frame("@", self.frames, other.frame)
            return Vector(functions.apply(self.array, other.array), frame, other.unit)
        if not isinstance(cast(object, other), Rotation):
            raise operands("@", self, other)
        return Rotation(self.array @ other.array, labels.join_frames("@", self.frames, other.frames))

    def then_about_fixed(self, turn: Rotation) -> Rotation:
        """A further turn about axes of the fixed frame multiplies on the left: turn R."""
        return Rotation(turn.array @ self.array, self.frames)

    def then_about_body(self, turn: Rotation) -> Rotation:
        """A further turn about axes of the body multiplies on the right: R turn."""
        return Rotation(self.array @ turn.array, self.frames)

    def turn(self, x: ArrayLike) -> Vector3:
        """(*batch, 3) the operator's reading: vectors (*batch, 3) turned within one frame."""
        return functions.apply(self.array, x)

    def angle_to(self, other: Rotation) -> Scalar:
        """(*batch) angle [rad] of the shortest turn to another rotation."""
        return functions.angle_between(self.array, other.array)

    def slerp(self, other: Rotation, t: ArrayLike) -> Rotation:
        """From this rotation (t = 0) to another (t = 1) at constant angular velocity."""
        return Rotation(functions.slerp(self.array, other.array, t), self.frames)
