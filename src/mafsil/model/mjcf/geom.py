"""Geometry of MJCF bodies: what is seen, what collides, and the mass that it gives."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, frozen
from mafsil.model.asset_path import Assets
from mafsil.model.faults import BAD_SIZE, NOT_KEPT, UNKNOWN_ASSET, WRONG_COUNT
from mafsil.model.link import Inertial
from mafsil.model.mjcf.orientation import read_pose
from mafsil.model.mjcf.settings import Settings, choice
from mafsil.model.placement import frame_along, moved_inertial
from mafsil.model.reading import Reading
from mafsil.model.shape import Box, Capsule, Cylinder, Geometry, Mesh, Shape, Sphere
from mafsil.model.xml_tree import Element

KINDS = ("plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "sdf")
_SIZES = {"sphere": 1, "capsule": 2, "ellipsoid": 3, "cylinder": 2, "box": 3}
_FROM_TO = ("capsule", "cylinder", "ellipsoid", "box")
_WATER = 1000.0
HIGHEST_VISIBLE_GROUP = 2


@dataclass(frozen=True, slots=True)
class Geom:
    """One geometry of a body.

    Attributes:
        shape: for pictures and collisions, or None for what has no bounded shape here.
        seen, collides: what the shape is for.
        inertial: mass properties in the body frame, or None for none.
        unknown_mass: the mass would follow from a mesh.
    """

    shape: Shape | None
    seen: bool
    collides: bool
    inertial: Inertial | None
    unknown_mass: bool

    def moved(self, T: PoseMatrix) -> Geom:
        """The same geometry in the frame in which its own has the pose T."""
        shape = None if self.shape is None else replace(self.shape, T_lg=frozen(T @ self.shape.T_lg))
        return replace(self, shape=shape, inertial=self.inertial and moved_inertial(self.inertial, T))


@dataclass(frozen=True, slots=True)
class Library:
    """The assets that geometries refer to."""

    settings: Settings
    assets: Assets
    meshes: dict[str, Element]
    materials: dict[str, Element]


def read_geom(reading: Reading, element: Element, library: Library) -> Geom | None:
    """A geometry whose default class is already filled in; None after an error."""
    kind = choice(reading, element, "type", KINDS, "mesh" if "mesh" in element.attributes else "sphere")
    if kind in ("plane", "hfield", "sdf"):
        return Geom(None, seen=True, collides=True, inertial=None, unknown_mass=False)
    T = read_pose(reading, element, library.settings)
    if kind == "mesh":
        geometry, size = _read_mesh(reading, element, library), None
    else:
        size, T = _read_size(reading, element, kind, T)
        geometry = None if size is None else _geometry(kind, size)
    if geometry is None and size is None:
        return None
    mass = _read_mass(reading, element, kind, size)
    group = reading.number(element, "group", 0.0) or 0.0
    weighs = library.settings.groups[0] <= group <= library.settings.groups[1] and mass != 0.0
    inertial = None
    if weighs and size is not None and mass is not None:
        inertial = moved_inertial(Inertial(mass, inertia=frozen(np.diag(mass * unit_moments(kind, size)))), T)
    collides = any((reading.number(element, key, 1.0) or 0.0) != 0.0 for key in ("contype", "conaffinity"))
    seen = group <= HIGHEST_VISIBLE_GROUP or not collides
    shape = None
    if geometry is not None:
        shape = Shape(geometry, T, element.get("name"), _colour(reading, element, library))
    return Geom(shape, seen, collides, inertial, unknown_mass=weighs and kind == "mesh")


def volume(kind: str, size: tuple[float, ...]) -> float:
    """Volume [m^3] of a geometry of MJCF sizes (radii and half lengths)."""
    match kind, size:
        case "sphere", (r,):
            return 4 / 3 * pi * r**3
        case "capsule", (r, h):
            return pi * r * r * 2 * h + 4 / 3 * pi * r**3
        case "cylinder", (r, h):
            return pi * r * r * 2 * h
        case "ellipsoid", (a, b, c):
            return 4 / 3 * pi * a * b * c
        case _:
            a, b, c = size
            return 8 * a * b * c


def unit_moments(kind: str, size: tuple[float, ...]) -> Floats:
    """(3,) principal moments of a homogeneous geometry of unit mass about its centre [m^2]."""
    match kind, size:
        case "sphere", (r,):
            return np.full(3, 0.4 * r * r)
        case "capsule", (r, h):
            ball = 4 / 3 * r / (4 / 3 * r + 2 * h)
            rod = 1.0 - ball
            across = rod * (r * r / 4 + h * h / 3) + ball * (0.4 * r * r + h * h + 0.75 * r * h)
            return np.array([across, across, rod * r * r / 2 + ball * 0.4 * r * r])
        case "cylinder", (r, h):
            across = r * r / 4 + h * h / 3
            return np.array([across, across, r * r / 2])
        case "ellipsoid", (a, b, c):
            return np.array([b * b + c * c, a * a + c * c, a * a + b * b]) / 5
        case _:
            a, b, c = size
            return np.array([b * b + c * c, a * a + c * c, a * a + b * b]) / 3


def _geometry(kind: str, size: tuple[float, ...]) -> Geometry | None:
    match kind, size:
        case "sphere", (r,):
            return Sphere(r)
        case "capsule", (r, h):
            return Capsule(r, 2 * h)
        case "cylinder", (r, h):
            return Cylinder(r, 2 * h)
        case "box", (a, b, c):
            return Box((2 * a, 2 * b, 2 * c))
        case _:
            return None


def _read_size(
    reading: Reading, element: Element, kind: str, T: PoseMatrix
) -> tuple[tuple[float, ...] | None, PoseMatrix]:
    """Sizes of a primitive, and its pose if `fromto` gives it."""
    needed = _SIZES[kind]
    ends = None
    if kind in _FROM_TO and "fromto" in element.attributes:
        ends = reading.vector(element, "fromto", 6)
        if ends is None:
            return None, T
        needed -= 1
    given = element.get("size").split()
    if len(given) < needed or len(given) > 3:
        reading.report(
            WRONG_COUNT, element, "size", element="geom", attribute="size", expected=needed, got=len(given),
            text=" ".join(given),
        )  # fmt: skip
        return None, T
    size = reading.vector(element, "size", len(given))
    if size is None:
        return None, T
    size = size[:needed]
    if ends is not None:
        size, T = _between(kind, size, np.array(ends))
    if min(size) <= 0.0:
        reading.report(BAD_SIZE, element, "size", element="geom", attribute="size", value=min(size))
        return None, T
    return size, T


def _between(kind: str, size: tuple[float, ...], ends: Floats) -> tuple[tuple[float, ...], PoseMatrix]:
    """Size and pose of a geometry whose z axis joins two points."""
    start, end = ends[:3], ends[3:]
    span = float(np.linalg.norm(start - end))
    T = np.eye(4)
    T[:3, 3] = (start + end) / 2
    if span > 0.0:
        T[:3, :3] = frame_along((start - end) / span)
    return (*size, span / 2), frozen(T)


def _read_mass(reading: Reading, element: Element, kind: str, size: tuple[float, ...] | None) -> float | None:
    """The mass of a geometry: given, or its density times its volume."""
    if element.get("shellinertia") == "true":
        reading.report(NOT_KEPT, element, "shellinertia", element="geom", what="shellinertia")
    if "mass" in element.attributes:
        return reading.number(element, "mass")
    density = reading.number(element, "density", _WATER)
    if density is None or size is None:
        return density
    return density * volume(kind, size)


def _read_mesh(reading: Reading, element: Element, library: Library) -> Mesh | None:
    name = reading.reference(element, "mesh")
    mesh = library.meshes.get(name)
    if mesh is None:
        if name:
            reading.report(UNKNOWN_ASSET, element, "mesh", kind="mesh", name=name)
        return None
    scale = reading.vector(mesh, "scale", 3, (1.0, 1.0, 1.0)) or (1.0, 1.0, 1.0)
    folder = library.settings.mesh_folder.rstrip("/")
    reference = f"{folder}/{mesh.get('file')}" if folder else mesh.get("file")
    resolved = library.assets.resolve(reference)
    if resolved.fault is not None:
        reading.report(resolved.fault, mesh, "file", reference=reference, package=resolved.package)
    return Mesh(reference, resolved.path, (scale[0], scale[1], scale[2]))


def _colour(reading: Reading, element: Element, library: Library) -> tuple[float, float, float, float] | None:
    holder = element
    if "rgba" not in element.attributes and "material" in element.attributes:
        material = library.materials.get(element.get("material"))
        if material is None:
            reading.report(UNKNOWN_ASSET, element, "material", kind="material", name=element.get("material"))
            return None
        holder = material
    rgba = reading.vector(holder, "rgba", 4, ()) if "rgba" in holder.attributes else None
    if not rgba:
        return None
    r, g, b, a = (min(max(value, 0.0), 1.0) for value in rgba)
    return r, g, b, a
