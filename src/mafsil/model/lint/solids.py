"""What the shapes of a link say about its matter: where it can be, what volume it has, how far it reaches."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from mafsil.arrays import Floats, Vector3
from mafsil.errors import FileError
from mafsil.model.filled_shape import fill_shape
from mafsil.model.link import OUTLINE, Geometry, Link, Mesh, Shape
from mafsil.model.mechanism import Mechanism
from mafsil.model.mesh import Surface, read
from mafsil.model.mesh.surface import triangles

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
        points: (k, 3) corners of the hulls [m].
        matter: what collides and what is drawn, each a description of the same body; empty where bodies are joined.
        meshes: whether any shape is a mesh.
    """

    points: Floats
    matter: tuple[tuple[Shape, ...], ...]
    meshes: bool

    @property
    def volume(self) -> float | None:
        """Of the solids [m^3]: the smaller of what collides and what is drawn; None where the surfaces are open."""
        volumes = [[_volume(shape.geometry) for shape in shapes] for shapes in self.matter]
        known = [sum(v for v in each if v is not None) for each in volumes if None not in each]
        return min(known, default=None)

    @property
    def box_volume(self) -> float:
        """Volume of the smaller of two boxes around everything [m^3]: no matter fills more."""
        centred = self.points - self.points.mean(axis=0)
        _, _, axes = np.linalg.svd(centred, full_matrices=False)
        across: list[Floats] = [np.ptp(points, axis=0) for points in (self.points, centred @ axes.T)]
        return float(min(np.prod(sides) for sides in across))

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
    """The shapes of every link that has mass properties and shapes, by its name.

    What collides and what is drawn count together, and so do links fixed to it that have no mass properties of their
    own: many files give the mass of a group to its first link. Marks of a few centimetres do not count.

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
    groups = {name: _solid(parts) for name, parts in found.items() if by_name[name].inertial is not None}
    return {name: solid for name, solid in groups.items() if solid is not None and solid.size > SMALLEST}


def _solid(parts: list[tuple[Link, Floats]]) -> Solid | None:
    """All shapes of a rigid group, in the frame of its first link; None if some of what is drawn is not known.

    Outlines of the library's arms say how far a link reaches, not where its matter is: its masses are other tables'.
    """
    points: list[Floats] = []
    matter: list[tuple[Shape, ...]] = []
    for link, T in parts:
        collisions = tuple(shape for shape in link.collisions if shape.name != OUTLINE)
        groups = [[_corners(shape) for shape in shapes] for shapes in (collisions, link.visuals)]
        if any(corners is None for corners in (groups[1] if link.visuals else groups[0])):
            return None
        for shapes, group in zip((collisions, link.visuals), groups, strict=True):
            known = [corners for corners in group if corners is not None]
            points += [corners @ T[:3, :3].T + T[:3, 3] for corners in known]
            if known and len(known) == len(shapes):
                matter.append(shapes)
    all_points = np.concatenate(points or [np.zeros((0, 3))])
    if len(all_points) < 4 or not np.abs(all_points).max() < 1e9:
        return None
    return Solid(all_points, tuple(matter) if len(parts) == 1 else (), any(_has_mesh(link) for link, _ in parts))


def _has_mesh(link: Link) -> bool:
    return any(isinstance(shape.geometry, Mesh) for shape in (*link.collisions, *link.visuals))


def _corners(shape: Shape) -> Floats | None:
    """Corners of a shape's hull in the frame of its link."""
    corners = _hull_of(shape.geometry) if isinstance(shape.geometry, Mesh) else triangles(shape.geometry).vertices
    T = np.asarray(shape.T_lg)
    return None if corners is None else corners @ T[:3, :3].T + T[:3, 3]


def _hull_of(mesh: Mesh) -> Floats | None:
    changed = _change(mesh)
    return None if changed is None else _mesh_hull(mesh, changed)


def _change(mesh: Mesh) -> tuple[int, int] | None:
    """When the file was written and its size, which tell whether it is still the same; None if it is not to be read."""
    try:
        status = None if mesh.path is None else mesh.path.stat()
    except OSError:
        return None
    return None if status is None or status.st_size > MOST_BYTES else (status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=256)
def _mesh_hull(mesh: Mesh, changed: tuple[int, int]) -> Floats | None:
    """Corners of the convex hull; all points where they lie in a plane."""
    from scipy.spatial import ConvexHull, QhullError

    del changed
    surface = _read(mesh)
    if surface is None or not len(surface.faces):
        return None
    used = np.zeros(len(surface.vertices), dtype=bool)
    used[surface.faces.ravel()] = True
    points = surface.vertices[used]
    try:
        return points[ConvexHull(points).vertices]
    except (QhullError, ValueError):
        return points


@lru_cache(maxsize=256)
def _mesh_volume(mesh: Mesh, changed: tuple[int, int]) -> float | None:
    """Of the file as it was when it was changed last."""
    del changed
    return _filled_volume(mesh)


def _read(mesh: Mesh) -> Surface | None:
    try:
        return None if mesh.path is None else read(mesh.path).scale(mesh.scale)
    except FileError:
        return None


def _volume(geometry: Geometry) -> float | None:
    """Of the solid inside; None where it is open or cannot be read."""
    if not isinstance(geometry, Mesh):
        return _filled_volume(geometry)
    changed = _change(geometry)
    return None if changed is None else _mesh_volume(geometry, changed)


def _filled_volume(geometry: Geometry) -> float | None:
    body = fill_shape(geometry)
    return None if body is None else body.mass


def _even_directions(count: int) -> Floats:
    """(count, 3) unit vectors spread evenly over the sphere, and the six axes."""
    k = np.arange(count) + 0.5
    z, longitude = 1 - 2 * k / count, np.pi * (1 + 5**0.5) * k
    r = np.sqrt(1 - z * z)
    return np.concatenate([np.stack([r * np.cos(longitude), r * np.sin(longitude), z], axis=1), np.eye(3), -np.eye(3)])


_PLANES = _even_directions(DIRECTIONS)
