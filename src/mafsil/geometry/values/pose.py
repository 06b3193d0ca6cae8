"""Pose T_ab, Rotation R_ab, points and free vectors as frozen values with their frames and length unit.

A pose is that of a frame, or the displacement of a body; a rotation is an orientation, or the operator that turns
vectors. A change of frame moves points, but only turns vectors.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, cast, overload

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Matrix6, Quaternion, Scalar, Vector3, Vector6, as_batch, radians
from mafsil.errors import InputError
from mafsil.geometry import euler, quaternion
from mafsil.geometry import pose as pose_functions
from mafsil.geometry import rotation as rotation_functions
from mafsil.geometry.values.value import (
    Frames,
    Linear,
    Value,
    carry_frame,
    common_frame,
    join_frames,
    operands,
    reversed_frames,
)

METRES: dict[str, float] = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3, "in": 0.0254, "ft": 0.3048}
"""Length units in metres."""


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
        return pose_functions.check(array, "Pose")

    @classmethod
    def identity(cls, frames: Frames | None = None) -> Pose:
        """T_aa = I."""
        return cls(np.eye(4), frames)

    @classmethod
    def of(cls, R: Rotation | ArrayLike, p: ArrayLike, frames: Frames | None = None) -> Pose:
        """From a rotation and an origin (*batch, 3) [m]; letters are taken from the rotation if it has any."""
        if isinstance(R, Rotation):
            return cls(pose_functions.from_rotation_translation(R.array, p), frames or R.frames)
        return cls(pose_functions.from_rotation_translation(R, p), frames)

    @classmethod
    def exp(cls, V: ArrayLike, frames: Frames | None = None) -> Pose:
        """From exponential coordinates (omega, v) (*batch, 6) [rad, m]."""
        return cls(pose_functions.exp(V), frames)

    @classmethod
    def translation(cls, p: ArrayLike, frames: Frames | None = None) -> Pose:
        """From a translation (*batch, 3) [m]."""
        return cls(pose_functions.from_translation(p), frames)

    @classmethod
    def nearest(cls, T: ArrayLike, frames: Frames | None = None) -> Pose:
        """With the rotation nearest to the upper left block of (*batch, 4, 4)."""
        return cls(pose_functions.project(T), frames)

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
        return pose_functions.log(self.array)

    def inverse(self) -> Pose:
        """T_ba."""
        return Pose(pose_functions.inverse(self.array), reversed_frames(self.frames))

    def adjoint(self) -> Matrix6:
        """(*batch, 6, 6) Ad(T_ab)."""
        return pose_functions.adjoint(self.array)

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
            frame = carry_frame("@", self.frames, other.frame)
            moved = pose_functions.act(self.array, other.in_unit("m").array)
            return Point(moved / METRES[other.unit], frame, other.unit)
        if not isinstance(cast(object, other), Pose):
            raise operands("@", self, other)
        return Pose(pose_functions.compose(self.array, other.array), join_frames("@", self.frames, other.frames))

    def displace(self, points: ArrayLike) -> Vector3:
        """(*batch, 3) the operator's reading: points (*batch, 3) [m] moved within one frame."""
        return pose_functions.act(self.array, points)

    def displacement_to(self, other: Pose) -> Pose:
        """T_02 T_01^-1, which carries a body from this pose to another, in the coordinates of {0}."""
        return Pose(pose_functions.displacement(self.array, other.array))

    def interpolate_screw(self, other: Pose, t: ArrayLike) -> Pose:
        """From this pose (t = 0) to another (t = 1) by one screw motion."""
        return Pose(pose_functions.interpolate_screw(self.array, other.array, t), self.frames)

    def interpolate_decoupled(self, other: Pose, t: ArrayLike) -> Pose:
        """From this pose (t = 0) to another (t = 1), origin on the straight line."""
        return Pose(pose_functions.interpolate_decoupled(self.array, other.array, t), self.frames)


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
        return rotation_functions.check(array, "Rotation")

    @classmethod
    def identity(cls, frames: Frames | None = None) -> Rotation:
        """R_aa = I."""
        return cls(np.eye(3), frames)

    @classmethod
    def exp(cls, r: ArrayLike, frames: Frames | None = None) -> Rotation:
        """From exponential coordinates omega theta (*batch, 3) [rad]."""
        return cls(rotation_functions.exp(r), frames)

    @classmethod
    def from_axis_angle(
        cls, axis: ArrayLike, angle: ArrayLike, frames: Frames | None = None, *, degrees: bool = False
    ) -> Rotation:
        """About an axis (*batch, 3) by an angle (*batch) [rad, or degrees]."""
        return cls(rotation_functions.from_axis_angle(axis, radians("angle", angle, degrees=degrees)), frames)

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
        return cls(rotation_functions.from_axes(x, y, z), frames)

    @classmethod
    def nearest(cls, M: ArrayLike, frames: Frames | None = None) -> Rotation:
        """The rotation nearest to any matrix (*batch, 3, 3)."""
        return cls(rotation_functions.project(M), frames)

    @classmethod
    def random(cls, seed: int | np.random.Generator, batch: int | tuple[int, ...] = ()) -> Rotation:
        """Uniform over SO(3); the seed is a whole number, or a NumPy generator, which moves on."""
        return cls(rotation_functions.random(seed, batch))

    def log(self) -> Vector3:
        """(*batch, 3) principal exponential coordinates [rad]."""
        return rotation_functions.log(self.array)

    def axis_angle(self) -> tuple[Vector3, Scalar]:
        """Unit axis (*batch, 3) and angle (*batch) in [0, pi] [rad]."""
        return rotation_functions.to_axis_angle(self.array)

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
        return Rotation(rotation_functions.inverse(self.array), reversed_frames(self.frames))

    @overload
    def __matmul__(self, other: Rotation) -> Rotation: ...
    @overload
    def __matmul__(self, other: Vector) -> Vector: ...
    def __matmul__(self, other: Rotation | Vector) -> Rotation | Vector:
        """R_ab R_bc = R_ac, or v_a = R_ab v_b."""
        if isinstance(other, Vector):
            frame = carry_frame("@", self.frames, other.frame)
            return Vector(rotation_functions.apply(self.array, other.array), frame, other.unit)
        if not isinstance(cast(object, other), Rotation):
            raise operands("@", self, other)
        return Rotation(self.array @ other.array, join_frames("@", self.frames, other.frames))

    def then_about_fixed(self, turn: Rotation) -> Rotation:
        """A further turn about axes of the fixed frame multiplies on the left: turn R."""
        return Rotation(turn.array @ self.array, self.frames)

    def then_about_body(self, turn: Rotation) -> Rotation:
        """A further turn about axes of the body multiplies on the right: R turn."""
        return Rotation(self.array @ turn.array, self.frames)

    def turn(self, x: ArrayLike) -> Vector3:
        """(*batch, 3) the operator's reading: vectors (*batch, 3) turned within one frame."""
        return rotation_functions.apply(self.array, x)

    def angle_to(self, other: Rotation) -> Scalar:
        """(*batch) angle [rad] of the shortest turn to another rotation."""
        return rotation_functions.angle_between(self.array, other.array)

    def slerp(self, other: Rotation, t: ArrayLike) -> Rotation:
        """From this rotation (t = 0) to another (t = 1) at constant angular velocity."""
        return Rotation(rotation_functions.slerp(self.array, other.array, t), self.frames)


@dataclass(frozen=True, eq=False, repr=False)
class Vector(Linear):
    """A free vector: a length and a direction, the same wherever it is drawn.

    Attributes:
        array: (*batch, 3) components in the axes of the frame, in the unit.
        frame: letter of the frame, or None.
        unit: length unit.
    """

    unit: str = "m"
    core: ClassVar[int] = 1

    @staticmethod
    def check_array(array: Any) -> Floats:
        """Three numbers each."""
        return as_batch("vector", array, (3,))

    def in_unit(self, unit: str) -> Vector:
        """The same vector with components in another length unit."""
        return replace(self, array=self.array * _factor(self.unit, unit), unit=unit)

    def length(self) -> Scalar:
        """(*batch) length, in the unit."""
        return np.linalg.norm(self.array, axis=-1)

    def dot(self, other: Vector) -> Scalar:
        """(*batch) inner product, in the unit of this vector squared."""
        right = self.match_units("dot", other)
        common_frame("dot", self.frame, right.frame)
        return np.sum(self.array * right.array, axis=-1)

    def match_units(self, sign: str, other: Any) -> Vector:
        """The other vector in the unit of this one."""
        if isinstance(other, Vector):
            return other.in_unit(self.unit)
        raise operands(sign, self, other)

    @overload
    def __add__(self, other: Vector) -> Vector: ...
    @overload
    def __add__(self, other: Point) -> Point: ...
    def __add__(  # pyright: ignore[reportIncompatibleMethodOverride]
        self, other: Vector | Point
    ) -> Vector | Point:
        """Vectors add; a vector carries a point to a point."""
        return other + self if isinstance(other, Point) else super().__add__(cast(Any, other))


@dataclass(frozen=True, eq=False, repr=False)
class Point(Value):
    """A point: the vector to it from the origin of its frame.

    Attributes:
        array: (*batch, 3) coordinates in the unit.
        frame: letter of the frame, or None.
        unit: length unit.
    """

    frame: str | None = None
    unit: str = "m"
    core: ClassVar[int] = 1

    @staticmethod
    def check_array(array: Any) -> Floats:
        """Three numbers each."""
        return as_batch("point", array, (3,))

    def in_unit(self, unit: str) -> Point:
        """The same point with coordinates in another length unit."""
        return replace(self, array=self.array * _factor(self.unit, unit), unit=unit)

    def distance(self, other: Point) -> Scalar:
        """(*batch) distance, in the unit of this point."""
        if not isinstance(cast(object, other), Point):
            raise operands("distance", self, other)
        return (self - other).length()

    def __add__(self, step: Vector) -> Point:
        """The point carried by a free vector; points themselves have no sum."""
        if not isinstance(cast(object, step), Vector):
            raise operands("+", self, step)
        frame = common_frame("+", self.frame, step.frame)
        return Point(self.array + step.in_unit(self.unit).array, frame, self.unit)

    @overload
    def __sub__(self, other: Point) -> Vector: ...
    @overload
    def __sub__(self, other: Vector) -> Point: ...
    def __sub__(self, other: Point | Vector) -> Vector | Point:
        """The vector from another point to this one, or the point carried back by a vector."""
        if not isinstance(cast(object, other), Point | Vector):
            raise operands("-", self, other)
        frame = common_frame("-", self.frame, other.frame)
        kind = Vector if isinstance(other, Point) else Point
        return kind(self.array - other.in_unit(self.unit).array, frame, self.unit)


def _factor(unit: str, target: str) -> float:
    for name in (unit, target):
        if name not in METRES:
            raise InputError("input.choice", name="unit", value=name, known=", ".join(METRES))
    return METRES[unit] / METRES[target]
