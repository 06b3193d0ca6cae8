"""The `origin` element of URDF: a pose as xyz and rpy, from 1.1 on as xyz and a quaternion."""

from __future__ import annotations

from mafsil.arrays import PoseMatrix, frozen
from mafsil.model.faults import QUATERNION_NORMALISED, TWO_ROTATIONS, ZERO_QUATERNION
from mafsil.model.numbers import written
from mafsil.model.placement import pose_from_xyz_quaternion, pose_from_xyz_rpy, quaternion_length
from mafsil.model.reading import Reading
from mafsil.model.tolerances import UNIT_QUATERNION
from mafsil.model.xml_tree import Element

_ZERO = (0.0, 0.0, 0.0)
_QUATERNION = "quat_xyzw"


def read_origin(reading: Reading, element: Element) -> PoseMatrix:
    """The pose (4, 4) in an `origin` child; identity if there is none or after an error.

    A quaternion is there in versions that have one alone: the vocabulary takes it out of others.
    """
    origin = reading.one(element, "origin")
    if origin is None:
        return frozen(pose_from_xyz_rpy(_ZERO, _ZERO))
    xyz = reading.vector(origin, "xyz", 3, _ZERO) or _ZERO
    if _QUATERNION not in origin.attributes:
        return frozen(pose_from_xyz_rpy(xyz, reading.vector(origin, "rpy", 3, _ZERO) or _ZERO))
    if "rpy" in origin.attributes:
        reading.report(TWO_ROTATIONS, origin, _QUATERNION, None, element=origin.tag)
    xyzw = reading.vector(origin, _QUATERNION, 4)
    return frozen(pose_from_xyz_quaternion(xyz, _judge(reading, origin, xyzw)))


def _judge(reading: Reading, origin: Element, xyzw: tuple[float, ...] | None) -> tuple[float, ...]:
    """A quaternion that has a length; one far from 1 is reported."""
    if xyzw is None:
        return (0.0, 0.0, 0.0, 1.0)
    length = quaternion_length(xyzw)
    if length == 0.0:
        reading.report(ZERO_QUATERNION, origin, _QUATERNION, None, element=origin.tag)
        return (0.0, 0.0, 0.0, 1.0)
    if abs(length - 1.0) > UNIT_QUATERNION:
        repair = reading.set_attribute(origin, _QUATERNION, " ".join(written(part / length) for part in xyzw))
        reading.report(QUATERNION_NORMALISED, origin, _QUATERNION, repair, length=f"{length:.6g}")
    return xyzw
