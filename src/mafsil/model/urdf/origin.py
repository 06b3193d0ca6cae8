"""The `origin` element of URDF: a pose as xyz and rpy."""

from __future__ import annotations

from mafsil.arrays import PoseMatrix, frozen
from mafsil.model.placement import pose_from_xyz_rpy
from mafsil.model.reading import Reading
from mafsil.model.xml_tree import Element

_ZERO = (0.0, 0.0, 0.0)


def read_origin(reading: Reading, element: Element) -> PoseMatrix:
    """The pose (4, 4) in an `origin` child; identity if there is none or after an error."""
    origin = reading.one(element, "origin")
    xyz = rpy = None
    if origin is not None:
        xyz = reading.vector(origin, "xyz", 3, _ZERO)
        rpy = reading.vector(origin, "rpy", 3, _ZERO)
    return frozen(pose_from_xyz_rpy(xyz or _ZERO, rpy or _ZERO))
