"""What the shapes of a link say about its matter: where it can be, how much room it has, how far it reaches."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from mafsil.arrays import Floats, Vector3
from mafsil.errors import FileError, ModelError
from mafsil.model.link import Link
from mafsil.model.mass_properties import surface as solid_of
from mafsil.model.mechanism import Mechanism
from mafsil.model.mesh import Surface, read
from mafsil.model.mesh.primitives import triangles
from mafsil.model.shape import Box, Capsule, Cylinder, Mesh, Shape, Sphere

DIRECTIONS = 300
"""Planes that bound the hull."""
SMALLEST = 0.03
"""Shapes smaller than this [m] mark a place, such as a sensor's or a tool's; they are not the body itself."""
MOST_BYTES = 40 << 20
"""A larger mesh file is not opened."""


@dataclass(frozen=True, eq=False, slots=True)
class Solid:
    """The shapes of one link, in its frame.

    Attributes:
        points: (k, 3) corners [m].
        volume: of the solids, or None where a surface is open [m^3].
        meshes: whether any shape is a mesh.
    """

    points: Floats
    volume: float | None
    meshes: bool

    @property
    def room(self) -> float:
        """Volume of the smaller of two boxes around everything [m^3]: no matter fills more."""
        centred = self.points - self.points.mean(axis=0)
        _, _, axes = np.linalg.svd(centred, full_matrices=False)
        return float(min(np.prod(np.ptp(self.points, axis=0)), np.prod(np.ptp(centred @ axes.T, axis=0))))

    @property
    def size(self) -> float:
        """Diagonal of the box around everything [m]."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0)))

    def outside(self, point: Vector3) -> float:
        """How far a point lies outside the hull at least [m]; 0 inside."""
        support = (self.points @ _PLANES.T).max(axis=0)
        return max(0.0, float((_PLANES @ point - support).max()))

    def reach_from(self, point: Vector3) -> float:
        """Largest distance of any matter from a point [m]."""
        return float(np.linalg.norm(self.points - point, axis=1).max())

    @property
    def gyration(self) -> float:
        """Trace of the inertia per mass that matter spread evenly over the box would have [m^2]."""
        return float((np.ptp(self.points, axis=0) ** 2).sum() / 6)


def solids(mechanism: Mechanism) -> dict[str, Solid]:
    """The room of every link that has mass properties and shapes, by its name.

    What collides and what is drawn count together, and so do links fixed to it that have no mass properties of their
    own: many files give the mass of a group to its first link. Marks of a few centimetres are no room.

    Args:
        mechanism: any.
    """
    found: dict[str, list[tuple[Link, Floats]]] = {}
    holder: dict[str, tuple[str, Floats]] = {}
    by_name = {link.name: link for link in mechanism.links}
    joints = {joint.child: joint for joint in mechanism.joints}
    for link in mechanism.links:
        joint = joints.get(link.name)
        own = link.inertial is not None or joint is None or joint.moves
        head, T = (link.name, np.eye(4)) if own or joint is None else holder[joint.parent]
        T = T if own or joint is None else T @ joint.T_pj
        holder[link.name] = (head, T)
        found.setdefault(head, []).append((link, T))
    rooms = {name: _room(parts) for name, parts in found.items() if by_name[name].inertial is not None}
    return {name: room for name, room in rooms.items() if room is not None and room.size > SMALLEST}


def _room(parts: list[tuple[Link, Floats]]) -> Solid | None:
    """All shapes of a rigid group, in the frame of its first link; None if some of what is drawn is not known."""
    points: list[Floats] = []
    volumes: list[float | None] = []
    meshes = False
    for link, T in parts:
        groups = [[_placed(shape) for shape in shapes] for shapes in (link.collisions, link.visuals)]
        if any(surface is None for surface in (groups[1] if link.visuals else groups[0])):
            return None
        for shapes, group in zip((link.collisions, link.visuals), groups, strict=True):
            known = [(shape, surface) for shape, surface in zip(shapes, group, strict=True) if surface is not None]
            points += [surface.vertices[np.unique(surface.faces)] @ T[:3, :3].T + T[:3, 3] for _, surface in known]
            meshes = meshes or any(isinstance(shape.geometry, Mesh) for shape, _ in known)
            if known and len(known) == len(shapes):
                each = [_volume(shape, surface) for shape, surface in known]
                volumes.append(None if None in each else sum(volume for volume in each if volume is not None))
    if not points:
        return None
    all_points = np.concatenate(points)
    if len(all_points) < 4 or not np.abs(all_points).max() < 1e9:
        return None
    solid = [volume for volume in volumes if volume is not None]
    return Solid(all_points, min(solid) if solid and len(parts) == 1 else None, meshes)


def _placed(shape: Shape) -> Surface | None:
    """Triangles of a shape in the frame of its link."""
    surface = _read(shape.geometry) if isinstance(shape.geometry, Mesh) else triangles(shape.geometry)
    if surface is None or not len(surface.faces):
        return None
    T = np.asarray(shape.T_lg)
    return Surface(surface.vertices @ T[:3, :3].T + T[:3, 3], surface.faces)


@lru_cache(maxsize=16)
def _read(mesh: Mesh) -> Surface | None:
    try:
        if mesh.path is None or mesh.path.stat().st_size > MOST_BYTES:
            return None
        return read(mesh.path).scaled(mesh.scale)
    except (FileError, OSError):
        return None


def _volume(shape: Shape, surface: Surface) -> float | None:
    match shape.geometry:
        case Box(size=size):
            return float(np.prod(size))
        case Sphere(radius=radius):
            return 4 / 3 * np.pi * radius**3
        case Cylinder(radius=radius, length=length):
            return np.pi * radius**2 * length
        case Capsule(radius=radius, length=length):
            return np.pi * radius**2 * (length + 4 / 3 * radius)
        case Mesh():
            try:
                return solid_of(surface.vertices, surface.faces, density=1.0).mass
            except ModelError:
                return None


def _even_directions(count: int) -> Floats:
    """(count, 3) unit vectors spread evenly over the sphere, and the six axes."""
    k = np.arange(count) + 0.5
    z, turn = 1 - 2 * k / count, np.pi * (1 + 5**0.5) * k
    r = np.sqrt(1 - z * z)
    return np.concatenate([np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1), np.eye(3), -np.eye(3)])


_PLANES = _even_directions(DIRECTIONS)
