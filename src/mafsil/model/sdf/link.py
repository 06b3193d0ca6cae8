"""Links of SDFormat: mass properties and shapes."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeAlias

import numpy as np

from mafsil.arrays import frozen
from mafsil.model.asset_path import Assets
from mafsil.model.faults import BAD_SIZE, MISSING_ELEMENT, SDF_AUTO, SDF_DEFAULT_MASS, UNKNOWN_GEOMETRY
from mafsil.model.filled_shape import fill_shape
from mafsil.model.inertia_check import STAND_IN, inertia_fault, mass_fault
from mafsil.model.link import Box, Capsule, Cylinder, Geometry, Inertial, Link, Mesh, Shape, Sphere, moved_inertial
from mafsil.model.mass_properties import unite_bodies
from mafsil.model.placement import turned_tensor
from mafsil.model.reading import Reading
from mafsil.model.sdf.frames import OWN_NAME, Frames
from mafsil.model.sdf.scope import Part, number, numbers, pose
from mafsil.model.urdf.shape import looking_at_a_shape
from mafsil.model.xml_tree import Element

WATER = 1000.0
"""What fills shapes of no other density [kg/m^3]."""
Placed: TypeAlias = tuple[Element, Shape]
OWN_COLOUR = "mafsil:rgba"
"""Attribute of what collides: its colour."""


def read_link(reading: Reading, part: Part, frames: Frames, assets: Assets) -> Link:
    """A link with its own frame."""
    with looking_at_a_shape(reading):
        visuals = _shapes(reading, part, "visual", frames, assets)
        collisions = _shapes(reading, part, "collision", frames, assets)
    inertial = _inertial(reading, part, frames, collisions)
    return Link(part.name, inertial, tuple(shape for _, shape in visuals), tuple(shape for _, shape in collisions))


def _inertial(reading: Reading, part: Part, frames: Frames, collisions: list[Placed]) -> Inertial | None:
    """Mass properties; what is missing has the default of SDFormat: 1 kg, 1 kg m^2."""
    element = reading.one(part.element, "inertial")
    if element is None:
        reading.report(SDF_DEFAULT_MASS, part.element, None, None, link=part.name)
        return Inertial(1.0, frozen(np.zeros(3)), frozen(np.eye(3)))
    if element.get("auto").strip().lower() in ("true", "1"):
        return _compute(reading, part, element, collisions)
    mass = number(reading, element, "mass", 1.0)
    tensor = reading.one(element, "inertia")
    if tensor is None or element.first("mass") is None:
        reading.report(SDF_DEFAULT_MASS, element, None, None, link=part.name)
    given = tensor or Element("inertia", {}, element.line, element.column, element.start, file=element.file)
    xx, yy, zz = (number(reading, given, tag, 1.0) for tag in ("ixx", "iyy", "izz"))
    xy, xz, yz = (number(reading, given, tag, 0.0) for tag in ("ixy", "ixz", "iyz"))
    moments = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if 0.0 < mass <= STAND_IN:
        if np.abs(moments).max() <= STAND_IN:
            return None
        mass = 0.0
    if fault := mass_fault(mass, moments):
        reading.report(fault, element, None, None, link=part.name, mass=mass)
    if fault := inertia_fault(mass, moments):
        principal = ", ".join(f"{value:.4g}" for value in np.linalg.eigvalsh(moments))
        reading.report(fault, element, None, None, link=part.name, moments=principal)
    holder = element.first("pose")
    T = pose(reading, holder)
    if holder is not None and (relative := holder.get("relative_to")):
        T = frames.between(reading, part.name, part.full(relative), holder) @ T
    return Inertial(mass, frozen(T[:3, 3]), turned_tensor(moments, T[:3, :3]))


def _compute(reading: Reading, part: Part, inertial: Element, collisions: list[Placed]) -> Inertial | None:
    """What fills the shapes that collide evenly, of their own density, the link's or that of water.

    A mass that is given scales all of it. Where a shape is not known, the link has none.
    """
    usual, read = number(reading, inertial, "density", WATER), {id(element): shape for element, shape in collisions}
    bodies: list[Inertial] = []
    for element in part.element.all("collision") or [part.element]:
        shape, density = read.get(id(element)), number(reading, element, "density", usual)
        body = None if shape is None or density <= 0.0 else fill_shape(shape.geometry, density)
        if shape is None or body is None:
            reading.report(SDF_AUTO, element, None, None, link=part.name)
            return None
        bodies.append(moved_inertial(body, shape.T_lg))
    whole = unite_bodies(*bodies)
    if whole is None or inertial.first("mass") is None:
        return whole
    mass = number(reading, inertial, "mass", whole.mass)
    if fault := mass_fault(mass, whole.inertia):
        reading.report(fault, inertial, None, None, link=part.name, mass=mass)
        return None
    return replace(whole, mass=mass, inertia=frozen(whole.inertia * (mass / whole.mass)))


def _shapes(reading: Reading, part: Part, tag: str, frames: Frames, assets: Assets) -> list[Placed]:
    found: list[Placed] = []
    for element in part.element.all(tag):
        before = reading.dropped
        holder = element.first("pose")
        T = pose(reading, holder)
        if holder is not None and (relative := holder.get("relative_to")):
            T = frames.between(reading, part.name, part.full(relative), holder) @ T
        geometry = _geometry(reading, element, assets)
        if geometry is not None and reading.dropped == before:
            name = element.get(OWN_NAME, element.get("name"))
            found.append((element, Shape(geometry, frozen(T), name, _colour(reading, element))))
    return found


def _geometry(reading: Reading, shape: Element, assets: Assets) -> Geometry | None:
    holder = shape.first("geometry")
    if holder is None or not holder.children:
        reading.report(MISSING_ELEMENT, shape, None, None, element="geometry", parent=shape.tag)
        return None
    element = holder.children[0]
    match element.tag:
        case "box":
            x, y, z = _sizes(reading, element, numbers(reading, element.first("size"), 3, (1.0, 1.0, 1.0)))
            return Box((x, y, z))
        case "sphere":
            (radius,) = _sizes(reading, element, (number(reading, element, "radius", 1.0),))
            return Sphere(radius)
        case "cylinder" | "capsule":
            size = (number(reading, element, "radius", 0.5), number(reading, element, "length", 1.0))
            radius, length = _sizes(reading, element, size)
            return (Cylinder if element.tag == "cylinder" else Capsule)(radius, length)
        case "mesh":
            return _mesh(reading, element, assets)
        case _:
            reading.report(UNKNOWN_GEOMETRY, element, None, None, kind=element.tag)
            return None


def _sizes(reading: Reading, element: Element, values: tuple[float, ...]) -> tuple[float, ...]:
    """Lengths, which must be positive."""
    if min(values) <= 0.0:
        details = {"element": element.tag, "attribute": element.tag, "value": min(values)}
        reading.report(BAD_SIZE, element, None, None, **details)
    return values


def _mesh(reading: Reading, element: Element, assets: Assets) -> Mesh:
    uri = element.first("uri")
    reference = "" if uri is None else uri.text
    x, y, z = numbers(reading, element.first("scale"), 3, (1.0, 1.0, 1.0))
    resolved = assets.resolve(reference)
    if resolved.fault is not None:
        reading.report(resolved.fault, element, None, None, reference=reference, package=resolved.package)
        reading.dropped -= resolved.fault.severity.value == "E"
    return Mesh(reference, resolved.path, (x, y, z))


def _colour(reading: Reading, shape: Element) -> tuple[float, float, float, float] | None:
    if OWN_COLOUR in shape.attributes:
        own = reading.vector(shape, OWN_COLOUR, 4)
        return None if own is None else (own[0], own[1], own[2], own[3])
    material = shape.first("material")
    diffuse = None if material is None else material.first("diffuse")
    if diffuse is None:
        return None
    words = diffuse.text.split()
    r, g, b, *a = numbers(reading, diffuse, 3 if len(words) == 3 else 4, (1.0, 1.0, 1.0, 1.0))
    red, green, blue, alpha = (min(max(value, 0.0), 1.0) for value in (r, g, b, *(a or [1.0])))
    return red, green, blue, alpha
