"""Geometry of MJCF bodies: what is seen, what collides, and the matter that may give mass.

Primitives full of matter or with matter on their surface only: volumes, areas, principal moments.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import pi

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, frozen
from mafsil.errors import MafsilError
from mafsil.model.faults import BAD_SIZE, NOT_KEPT, UNKNOWN_ASSET, WRONG_COUNT
from mafsil.model.link import Box, Capsule, Cylinder, Geometry, Inertial, Shape, Sphere, moved_inertial
from mafsil.model.mjcf.mesh_asset import MeshAssets
from mafsil.model.mjcf.settings import Settings, choice, read_pose
from mafsil.model.placement import frame_along
from mafsil.model.reading import Reading
from mafsil.model.urdf.shape import looking_at_a_shape
from mafsil.model.xml_tree import Element

THOMSEN = 1.6075
"""Exponent of Thomsen's formula for the surface of an ellipsoid."""
_SKIN = 1e-6
"""Thickness of the skin by which the shell of an ellipsoid is approximated, as MuJoCo does [m]."""
KINDS = ("plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "sdf")
_SIZES = {"sphere": 1, "capsule": 2, "ellipsoid": 3, "cylinder": 2, "box": 3}
_FROM_TO = ("capsule", "cylinder", "ellipsoid", "box")
_WATER = 1000.0
_NOTHING = 1e-14
"""Mass [kg] up to which a geometry counts as weightless, as in MuJoCo."""
HIGHEST_VISIBLE_GROUP = 2


@dataclass(frozen=True, slots=True)
class Library:
    """What the parts of one model refer to: settings, meshes, materials."""

    settings: Settings
    meshes: MeshAssets
    materials: dict[str, Element] = field(default_factory=dict[str, Element])


@dataclass(frozen=True, eq=False, slots=True)
class Matter:
    """What fills a geometry.

    Attributes:
        T: (4, 4) its pose in the body.
        mass: [kg], or None where the density gives it.
        density: [kg/m^3], or [kg/m^2] of a shell.
        kind, size: of a primitive.
        mesh: name of the mesh, or empty.
        shell: only the surface weighs.
        library: where the mesh is found.
    """

    T: PoseMatrix
    mass: float | None
    density: float
    kind: str
    size: tuple[float, ...]
    mesh: str
    shell: bool
    library: Library

    def inertial(self, reading: Reading) -> Inertial | None:
        """Mass properties in the body's frame, or None for no mass.

        Raises:
            MafsilError: the mesh gives none.
        """
        if self.mass == 0.0 or (self.mass is None and self.density == 0.0):
            return None
        if self.mesh:
            whole = self.library.meshes.mass(reading, self.mesh)
            mass = self.density * whole.volume if self.mass is None else self.mass
            body = Inertial(mass, whole.com, frozen(whole.inertia * (mass / whole.volume)))
        else:
            mass = self.density * volume(self.kind, self.size, self.shell) if self.mass is None else self.mass
            body = Inertial(mass, inertia=frozen(np.diag(moments(self.kind, self.size, mass, self.shell))))
        return moved_inertial(body, self.T) if mass > _NOTHING else None


@dataclass(frozen=True, slots=True)
class Geom:
    """One geometry of a body.

    Attributes:
        shape: for pictures and collisions, or None for what has no bounded shape here.
        seen, collides: what the shape is for.
        matter: what may give mass, or None.
    """

    shape: Shape | None
    seen: bool
    collides: bool
    matter: Matter | None

    def in_frame(self, T: PoseMatrix) -> Geom:
        """The same geometry in the frame in which its own has the pose T."""
        shape = None if self.shape is None else replace(self.shape, T_lg=frozen(T @ self.shape.T_lg))
        matter = None if self.matter is None else replace(self.matter, T=frozen(T @ self.matter.T))
        return replace(self, shape=shape, matter=matter)


def read_geom(reading: Reading, element: Element, library: Library) -> Geom | None:
    """A geometry whose default class is already filled in; None after an error."""
    kind = choice(reading, element, "type", KINDS, "sphere")
    group = reading.number(element, "group", 0.0) or 0.0
    collides = any((reading.number(element, key, 1.0) or 0.0) != 0.0 for key in ("contype", "conaffinity"))
    if kind in ("plane", "hfield"):
        return Geom(None, seen=True, collides=True, matter=None)
    T = read_pose(reading, element, library.settings)
    mesh = _mesh_name(reading, element, library, needed=kind in ("mesh", "sdf"))
    if mesh is None:
        return None
    size: tuple[float, ...] | None = ()
    geometry: Geometry | None = None
    T_shape = T
    if kind in ("mesh", "sdf"):
        found = library.meshes.shape(reading, mesh)
        if found is not None:
            geometry, T_shape = found[0], frozen(T @ found[1])
    else:
        size, T = _fit(reading, element, kind, mesh, T, library) if mesh else _read_size(reading, element, kind, T)
        mesh = ""
        geometry, T_shape = None if size is None else _geometry(kind, size), T
    if size is None:
        return None
    matter = _read_matter(reading, element, kind, size, mesh, T, library)
    low, high = library.settings.groups
    shape = None
    if geometry is not None:
        shape = Shape(geometry, T_shape, element.get("name"), _colour(reading, element, library))
    seen = group <= HIGHEST_VISIBLE_GROUP or not collides
    return Geom(shape, seen, collides, matter if low <= group <= high else None)


def _mesh_name(reading: Reading, element: Element, library: Library, *, needed: bool) -> str | None:
    """The mesh of a geometry, empty for none; None after an error."""
    if not needed and "mesh" not in element.attributes:
        return ""
    name = reading.reference(element, "mesh")
    if name and name not in library.meshes.elements:
        reading.report(UNKNOWN_ASSET, element, "mesh", kind="mesh", name=name)
        return None
    return name or None


def _fit(
    reading: Reading, element: Element, kind: str, mesh: str, T: PoseMatrix, library: Library
) -> tuple[tuple[float, ...] | None, PoseMatrix]:
    """Size and pose of a primitive that stands for a mesh; None where the mesh cannot be read."""
    try:
        whole = library.meshes.mass(reading, mesh)
    except MafsilError as error:
        reading.report(NOT_KEPT, element, "mesh", element="geom", what=f"{mesh}: {error}")
        return None, T
    middle, half = whole.bounds() if library.settings.fit_box else (np.zeros(3), whole.box)
    x, y, z = (float(length) for length in half)
    boxed = library.settings.fit_box
    wide = max(x, y) if boxed else (x + y) / 2
    sizes = {
        "sphere": (max(x, y, z) if boxed else (x + y + z) / 3,),
        "capsule": (wide, z - wide if boxed else max(0.0, z - wide / 2)),
        "cylinder": (wide, z),
    }
    factor = reading.number(element, "fitscale", 1.0) or 1.0
    T_gm = whole.frame.copy()
    T_gm[:3, 3] += T_gm[:3, :3] @ middle
    return tuple(length * factor for length in sizes.get(kind, (x, y, z))), frozen(T @ T_gm)


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
        needed = 1
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


def along_line(ends: Floats) -> Floats:
    """The pose (4, 4) halfway between two points (6,), the z axis from the second to the first."""
    start, end = ends[:3], ends[3:]
    T, span = np.eye(4), float(np.linalg.norm(start - end))
    T[:3, 3] = (start + end) / 2
    if span > 0.0:
        T[:3, :3] = frame_along((start - end) / span)
    return T


def _between(kind: str, size: tuple[float, ...], ends: Floats) -> tuple[tuple[float, ...], PoseMatrix]:
    """Size and pose of a geometry whose z axis joins two points."""
    half = float(np.linalg.norm(ends[:3] - ends[3:])) / 2
    sizes = (size[0], size[0], half) if kind in ("ellipsoid", "box") else (size[0], half)
    return sizes, frozen(along_line(ends))


def _read_matter(
    reading: Reading, element: Element, kind: str, size: tuple[float, ...], mesh: str, T: PoseMatrix, library: Library
) -> Matter:
    """What fills a geometry; a number that is wrong is reported and weighs nothing."""
    shell = choice(reading, element, "shellinertia", ("true", "false"), "false") == "true"
    mass = (reading.number(element, "mass") or 0.0) if "mass" in element.attributes else None
    density = reading.number(element, "density", _WATER) or 0.0
    for attribute, value in (("mass", mass), ("density", density)):
        if value is not None and value < 0.0:
            reading.report(BAD_SIZE, element, attribute, element="geom", attribute=attribute, value=value)
    return Matter(T, None if mass is None else max(mass, 0.0), max(density, 0.0), kind, size, mesh, shell, library)


def _colour(reading: Reading, element: Element, library: Library) -> tuple[float, float, float, float] | None:
    holder = element
    if "rgba" not in element.attributes and "material" in element.attributes:
        material = library.materials.get(element.get("material"))
        if material is None:
            reading.report(UNKNOWN_ASSET, element, "material", kind="material", name=element.get("material"))
            return None
        holder = material
    with looking_at_a_shape(reading):
        rgba = reading.vector(holder, "rgba", 4, ()) if "rgba" in holder.attributes else None
    if not rgba:
        return None
    r, g, b, a = (min(max(value, 0.0), 1.0) for value in rgba)
    return r, g, b, a


def volume(kind: str, size: tuple[float, ...], shell: bool) -> float:
    """Volume [m^3], or area [m^2] of a shell, of a geometry of MJCF sizes (radii and half lengths)."""
    match kind, size:
        case "sphere", (r,):
            return 4 * pi * r * r if shell else 4 / 3 * pi * r**3
        case "capsule", (r, h):
            return 4 * pi * r * (r + h) if shell else pi * r * r * 2 * h + 4 / 3 * pi * r**3
        case "cylinder", (r, h):
            return 2 * pi * r * (r + 2 * h) if shell else pi * r * r * 2 * h
        case "ellipsoid", (a, b, c):
            if shell:
                mean = ((a * b) ** THOMSEN + (b * c) ** THOMSEN + (c * a) ** THOMSEN) / 3
                return 4 * pi * mean ** (1 / THOMSEN)
            return 4 / 3 * pi * a * b * c
        case _:
            a, b, c = size
            return 8 * (a * b + b * c + c * a) if shell else 8 * a * b * c


def moments(kind: str, size: tuple[float, ...], mass: float, shell: bool) -> Floats:
    """(3,) principal moments of a homogeneous geometry about its centre [kg m^2]."""
    return _shell(kind, size, mass) if shell else mass * _solid(kind, size)


def _solid(kind: str, size: tuple[float, ...]) -> Floats:
    """(3,) principal moments of unit mass [m^2]."""
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


def _shell(kind: str, size: tuple[float, ...], mass: float) -> Floats:
    """(3,) principal moments of a surface of even thickness."""
    match kind, size:
        case "sphere", (r,):
            return np.full(3, 2 / 3 * mass * r * r)
        case "capsule", (r, h):
            ball = mass * r / (r + h)
            tube = mass - ball
            across = tube * (r * r / 2 + h * h / 3) + ball * (2 / 3 * r * r + h * h + h * r)
            return np.array([across, across, tube * r * r + ball * 2 / 3 * r * r])
        case "cylinder", (r, h):
            disk = mass * r / (2 * r + 4 * h)
            tube = mass - 2 * disk
            across = tube * (r * r / 2 + h * h / 3) + 2 * disk * (r * r / 4 + h * h)
            return np.array([across, across, tube * r * r + disk * r * r])
        case "ellipsoid", (a, b, c):
            grown = (a + _SKIN, b + _SKIN, c + _SKIN)
            inner, outer = volume(kind, size, shell=False), volume(kind, grown, shell=False)
            density = mass / (outer - inner)
            return density * (outer * _solid(kind, grown) - inner * _solid(kind, size))
        case _:
            return _box_shell(size, mass)


def _box_shell(size: tuple[float, ...], mass: float) -> Floats:
    """Six plates: each about its own middle, moved to the middle of the box."""
    half = np.array(size)
    areas = 4 * np.array([half[1] * half[2], half[0] * half[2], half[0] * half[1]])
    second = np.zeros(3)
    for axis in range(3):
        plate = mass * areas[axis] / (2 * areas.sum())
        spread = half**2 / 3
        spread[axis] = half[axis] ** 2
        second += 2 * plate * spread
    return second.sum() - second
