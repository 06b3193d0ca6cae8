"""Shapes of a URDF link: geometry, place (`origin`), colour; and capsules, for which the format has no word.

A pose stands as xyz and rpy, from 1.1 on as xyz and a quaternion. A capsule is written as a shaft and two caps, which
are read back as the capsule that they are.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np

from mafsil.arrays import PoseMatrix, frozen
from mafsil.model.asset_path import Assets, Resolved
from mafsil.model.diagnostics import shown
from mafsil.model.faults import (
    BAD_COLOUR,
    BAD_SIZE,
    MISSING_ELEMENT,
    NO_GEOMETRY,
    PACKAGE_NOT_FOUND,
    PATH_ESCAPES,
    QUATERNION_NORMALISED,
    TWO_ROTATIONS,
    UNKNOWN_GEOMETRY,
    UNKNOWN_MATERIAL,
    ZERO_QUATERNION,
    ZERO_SCALE,
)
from mafsil.model.link import Box, Capsule, Cylinder, Geometry, Mesh, Shape, Sphere
from mafsil.model.placement import pose_from_xyz_quaternion, pose_from_xyz_rpy, quaternion_length, translation
from mafsil.model.reading import Reading, written
from mafsil.model.tolerances import UNIT_QUATERNION, WRITTEN
from mafsil.model.xml_tree import Element

PARTS = ("/shaft", "/cap1", "/cap2")
"""Endings of the names of the three shapes."""
_ZERO = (0.0, 0.0, 0.0)
_QUATERNION = "quat_xyzw"
Colour: TypeAlias = tuple[float, float, float, float]


@dataclass(slots=True)
class Materials:
    """Colours by name, from the robot's own list and from the first use."""

    colours: dict[str, Colour | None] = field(default_factory=dict[str, "Colour | None"])
    missing_packages: set[str] = field(default_factory=set[str])

    @classmethod
    def collect(cls, reading: Reading, robot: Element) -> Materials:
        """All materials of a file that have a name and a colour; the robot's own list comes first."""
        materials = cls()
        inside = [m for link in robot.all("link") for visual in link.all("visual") for m in visual.all("material")]
        for element in (*robot.all("material"), *inside):
            name = element.get("name")
            if name and (name not in materials.colours or materials.colours[name] is None):
                if element.first("color") is not None or element.first("texture") is not None:
                    materials.colours[name] = _plain_colour(element)
        for element in robot.all("material"):
            with looking_at_a_shape(reading):
                _read_colour(reading, element)
        return materials


@contextmanager
def looking_at_a_shape(reading: Reading) -> Generator[None]:
    """While this lasts errors are warnings: nothing that is only seen or touched stops the mechanics."""
    reading.in_shape = True
    try:
        yield
    finally:
        reading.in_shape = False


def read_shapes(reading: Reading, elements: list[Element], materials: Materials, assets: Assets) -> tuple[Shape, ...]:
    """The shapes of all `visual` or `collision` elements of a link; broken ones are left out, which is said."""
    with looking_at_a_shape(reading):
        read = [_read_shape(reading, element, materials, assets) for element in elements]
    return with_capsules(shape for shape in read if shape is not None)


def _read_shape(reading: Reading, element: Element, materials: Materials, assets: Assets) -> Shape | None:
    before = reading.dropped
    T_lg = read_origin(reading, element)
    geometry = _read_geometry(reading, element, materials, assets)
    if reading.dropped > before:
        return None
    colour = _colour_of(reading, element, materials)
    return None if geometry is None else Shape(geometry, T_lg, element.get("name"), colour)


def _read_geometry(reading: Reading, shape: Element, materials: Materials, assets: Assets) -> Geometry | None:
    holder = reading.one(shape, "geometry")
    if holder is None:
        reading.report(MISSING_ELEMENT, shape, None, reading.remove(shape), element="geometry", parent=shape.tag)
        return None
    if not holder.children:
        reading.report(NO_GEOMETRY, holder)
        return None
    element = holder.children[0]
    match element.tag:
        case "box":
            size = _sizes(reading, shape, element, "size", 3)
            return Box((size[0], size[1], size[2])) if size else None
        case "sphere":
            radius = _sizes(reading, shape, element, "radius")
            return Sphere(radius[0]) if radius else None
        case "cylinder" | "capsule":
            radius, length = _sizes(reading, shape, element, "radius"), _sizes(reading, shape, element, "length")
            kind = Cylinder if element.tag == "cylinder" else Capsule
            return kind(radius[0], length[0]) if radius and length else None
        case "mesh":
            return _read_mesh(reading, shape, element, materials, assets)
        case _:
            reading.report(UNKNOWN_GEOMETRY, element, None, reading.remove(shape), kind=element.tag)
            return None


def _sizes(
    reading: Reading, shape: Element, element: Element, attribute: str, count: int = 1
) -> tuple[float, ...] | None:
    """Lengths, which must be positive."""
    values = reading.vector(element, attribute, count)
    if values is not None and min(values) <= 0.0:
        repair = reading.remove(shape)
        reading.report(
            BAD_SIZE, element, attribute, repair, element=element.tag, attribute=attribute, value=min(values)
        )
        return None
    return values


def _read_mesh(reading: Reading, shape: Element, element: Element, materials: Materials, assets: Assets) -> Mesh | None:
    reference = reading.reference(element, "filename")
    scale = reading.vector(element, "scale", 3, (1.0, 1.0, 1.0))
    if scale is not None and 0.0 in scale:
        reading.report(ZERO_SCALE, element, "scale", reading.remove_attribute(element, "scale"))
        return None
    if not reference or scale is None:
        return None
    resolved = assets.resolve(reference)
    _report_asset(reading, shape, element, resolved, materials)
    return Mesh(reference, resolved.path, (scale[0], scale[1], scale[2]))


def _report_asset(reading: Reading, shape: Element, element: Element, resolved: Resolved, materials: Materials) -> None:
    """Say why a mesh has no file; a missing package only once."""
    if resolved.fault is None:
        return
    if resolved.fault is PACKAGE_NOT_FOUND:
        if resolved.package in materials.missing_packages:
            return
        materials.missing_packages.add(resolved.package)
    repair = reading.remove(shape) if resolved.fault is PATH_ESCAPES else None
    if resolved.similar:
        folder = element.get("filename").rpartition("/")[0]
        repair = reading.set_attribute(element, "filename", f"{folder}/{resolved.similar}".removeprefix("/"))
    reference = shown(element.get("filename"))
    reading.report(resolved.fault, element, "filename", repair, reference=reference, package=resolved.package)


def _colour_of(reading: Reading, shape: Element, materials: Materials) -> Colour | None:
    material = reading.one(shape, "material")
    if material is None:
        return None
    if material.first("color") is not None:
        return _read_colour(reading, material)
    name = material.get("name")
    if name not in materials.colours and material.first("texture") is None:
        reading.report(UNKNOWN_MATERIAL, material, None, name=name)
    return materials.colours.get(name)


def _read_colour(reading: Reading, material: Element) -> Colour | None:
    colour = reading.one(material, "color")
    if colour is None:
        return None
    rgba = reading.vector(colour, "rgba", 4)
    if rgba is None:
        return None
    clipped = tuple(min(max(value, 0.0), 1.0) for value in rgba)
    if clipped != rgba:
        reading.report(BAD_COLOUR, colour, "rgba", text=colour.get("rgba"))
    return clipped[0], clipped[1], clipped[2], clipped[3]


def _plain_colour(material: Element) -> Colour | None:
    """The colour of a material without remarks, which are made where it is read for good."""
    colour = material.first("color")
    try:
        values = [min(max(float(word), 0.0), 1.0) for word in colour.get("rgba").split()] if colour else []
    except ValueError:
        return None
    return (values[0], values[1], values[2], values[3]) if len(values) == 4 else None


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


def without_capsules(shapes: Iterable[Shape]) -> Iterator[Shape]:
    """The shapes, each capsule as a cylinder and two balls."""
    for shape in shapes:
        if not isinstance(shape.geometry, Capsule):
            yield shape
            continue
        radius, length = shape.geometry.radius, shape.geometry.length
        solids = (Cylinder(radius, length), Sphere(radius), Sphere(radius))
        for part, solid, z in zip(PARTS, solids, (0.0, length / 2, -length / 2), strict=True):
            yield replace(shape, geometry=solid, T_lg=shape.T_lg @ translation(0, 0, z), name=shape.name + part)


def with_capsules(shapes: Iterable[Shape]) -> tuple[Shape, ...]:
    """The shapes, a shaft with its two caps as the capsule that they were."""
    found: list[Shape] = []
    for shape in shapes:
        found.append(shape)
        capsule = _capsule(found[-3:])
        if capsule is not None:
            found[-3:] = [capsule]
    return tuple(found)


def _capsule(three: list[Shape]) -> Shape | None:
    """The capsule of three shapes that are named and placed as its parts."""
    if len(three) < 3 or not all(shape.name.endswith(part) for shape, part in zip(three, PARTS, strict=True)):
        return None
    shaft, *caps = three
    names = {shape.name.removesuffix(part) for shape, part in zip(three, PARTS, strict=True)}
    if not isinstance(shaft.geometry, Cylinder) or len(names) > 1 or any(cap.colour != shaft.colour for cap in caps):
        return None
    radius, length = shaft.geometry.radius, shaft.geometry.length
    for cap, z in zip(caps, (length / 2, -length / 2), strict=True):
        gap = np.abs((shaft.T_lg @ translation(0, 0, z))[:3, 3] - cap.T_lg[:3, 3]).max()
        if cap.geometry != Sphere(radius) or gap > WRITTEN * (radius + length):
            return None
    return replace(shaft, geometry=Capsule(radius, length), name=names.pop())
