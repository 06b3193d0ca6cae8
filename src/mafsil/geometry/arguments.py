"""What array functions take: the shape of every argument, and the condition that it must meet, in its annotation.

To a type checker all are ArrayLike: numbers, nested lists, arrays, and what other libraries call a rotation or a pose.
"""

from __future__ import annotations

from typing import Annotated, TypeAlias

from numpy.typing import ArrayLike

from mafsil.arrays import Shape
from mafsil.geometry.membership import Member

ScalarLike: TypeAlias = Annotated[ArrayLike, Shape("*batch")]
Vector2Like: TypeAlias = Annotated[ArrayLike, Shape("*batch", 2)]
Vector3Like: TypeAlias = Annotated[ArrayLike, Shape("*batch", 3)]
Vector6Like: TypeAlias = Annotated[ArrayLike, Shape("*batch", 6)]
QuaternionLike: TypeAlias = Annotated[ArrayLike, Shape("*batch", 4)]
Matrix3Like: TypeAlias = Annotated[ArrayLike, Shape("*batch", 3, 3)]
Matrix4Like: TypeAlias = Annotated[ArrayLike, Shape("*batch", 4, 4)]

AmountLike: TypeAlias = Annotated[ArrayLike, Member("amount")]
AxisLike: TypeAlias = Annotated[ArrayLike, Member("axis")]
AxisTripleLike: TypeAlias = Annotated[ArrayLike, Member("axis_triple")]
DurationLike: TypeAlias = Annotated[ArrayLike, Member("duration")]
ExponentialCoordinatesLike: TypeAlias = Annotated[ArrayLike, Member("exponential_coordinates")]
NonzeroQuaternionLike: TypeAlias = Annotated[ArrayLike, Member("quaternion")]
PartTurnLike: TypeAlias = Annotated[ArrayLike, Member("part_turn")]
PlanarCoordinatesLike: TypeAlias = Annotated[ArrayLike, Member("planar_coordinates")]
PlanarPoseLike: TypeAlias = Annotated[ArrayLike, Member("planar_pose")]
PlanarRotationLike: TypeAlias = Annotated[ArrayLike, Member("planar_rotation")]
PoseLike: TypeAlias = Annotated[ArrayLike, Member("pose")]
RotationLike: TypeAlias = Annotated[ArrayLike, Member("rotation")]
RotationVectorLike: TypeAlias = Annotated[ArrayLike, Member("rotation_vector")]
UnitQuaternionLike: TypeAlias = Annotated[ArrayLike, Member("unit_quaternion")]
UnitScrewLike: TypeAlias = Annotated[ArrayLike, Member("unit_screw")]
