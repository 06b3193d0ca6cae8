"""What collides of an arm: a body for each link that has a shape, and for what is fixed to its tip."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.collision.scene import Obstacle
from mafsil.collision.shapes import ConvexHull, Geometry
from mafsil.errors import InputError
from mafsil.model import Mechanism, mesh
from mafsil.model.shape import OUTLINE, Capsule, Mesh, Shape


@dataclass(frozen=True, eq=False, slots=True)
class Body:
    """A rigid part of the arm.

    Attributes:
        name: of the link, or of what is fixed to the tip.
        link: index of the link that carries it.
        shapes: geometries with their poses (4, 4) in the link frame; meshes are convex hulls by now.
        meshes: the meshes that became hulls.
    """

    name: str
    link: int
    shapes: tuple[tuple[Geometry, PoseMatrix], ...]
    meshes: tuple[Mesh, ...] = ()


def bodies_of(mechanism: Mechanism, attached: Iterable[Obstacle] = (), radius: float | None = None) -> tuple[Body, ...]:
    """The bodies of an arm, in the order of its links, then what is fixed to the tip.

    1. Links with collision shapes: primitives as they are, a mesh as its convex hull, which holds every vertex.
    2. Where no link has any, what is drawn stands for it.
    3. Links without a shape get capsules from their frame to the joints that they carry, if a radius is given; it
       replaces the shapes of robots of the library, which follow an outline.

    Args:
        mechanism: the arm.
        attached: bodies in the tip frame {t}: a tool, a part.
        radius: of the capsules of links without a shape of their own [m].

    Raises:
        InputError: no link has a shape and there is no radius, a mesh file that is missing, a name used twice.
    """
    drawn = not any(link.collisions for link in mechanism.links)
    shapes = [_own(link.visuals if drawn else link.collisions, radius) for link in mechanism.links]  # 1, 2
    bodies = list[Body]()
    for i, link in enumerate(mechanism.links):
        if shapes[i]:
            bodies.append(_body(link.name, i, shapes[i]))
        elif radius is not None and (capsules := _capsules(mechanism, i, radius)):  # 3
            bodies.append(Body(link.name, i, capsules))
    if not bodies:
        raise InputError("collision.no_shapes", robot=mechanism.name)
    tip = mechanism.link_names.index(mechanism.tip)
    for number, each in enumerate(attached):
        name = each.name or f"attached {number + 1}"
        geometry, T = (_hull(each.geometry), mechanism.T_lt @ each.T_so)
        bodies.append(Body(name, tip, ((geometry, T),)))
    names = [body.name for body in bodies]
    if len(set(names)) < len(names):
        raise InputError("collision.named_twice", name=next(name for name in names if names.count(name) > 1))
    return tuple(bodies)


def _own(shapes: tuple[Shape, ...], radius: float | None) -> tuple[Shape, ...]:
    """The shapes of a link; a radius replaces those of the library, which only follow an outline."""
    return shapes if radius is None else tuple(shape for shape in shapes if shape.name != OUTLINE)


def _body(name: str, link: int, shapes: tuple[Shape, ...]) -> Body:
    meshes = tuple(shape.geometry for shape in shapes if isinstance(shape.geometry, Mesh))
    return Body(name, link, tuple((_hull(shape.geometry), shape.T_lg) for shape in shapes), meshes)


def _hull(geometry: Geometry) -> Geometry:
    """A mesh file as the convex hull of its vertices; anything else as it is."""
    return ConvexHull(mesh_vertices(geometry)) if isinstance(geometry, Mesh) else geometry


def mesh_vertices(shape: Mesh) -> Floats:
    """The corners (k, 3) of a mesh file's triangles.

    Raises:
        InputError: the file was not found when the robot was read.
        FileError: it cannot be read.
    """
    if shape.path is None:
        raise InputError("collision.no_mesh", reference=shape.reference)
    surface = mesh.read(shape.path).scale(shape.scale)
    return surface.vertices[np.unique(surface.faces)]


def _capsules(mechanism: Mechanism, link: int, radius: float) -> tuple[tuple[Geometry, PoseMatrix], ...]:
    """Capsules from a link's frame to the frames of its child joints and, at the tip link, to the tip frame."""
    ends = [j.T_pj[:3, 3] for j, parent in zip(mechanism.joints, mechanism.parents, strict=True) if parent == link]
    if mechanism.link_names[link] == mechanism.tip:
        ends.append(mechanism.T_lt[:3, 3])
    found = list[tuple[Geometry, PoseMatrix]]()
    for end in ends:
        length = float(np.linalg.norm(end))
        if length > 0.0:
            found.append((Capsule(radius, length), _along(end)))
    return tuple(found)


def _along(end: Floats) -> PoseMatrix:
    """(4, 4) pose at the middle of the segment from the origin to a point, z along it."""
    z = end / np.linalg.norm(end)
    x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x /= np.linalg.norm(x)
    T = np.eye(4)
    T[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    T[:3, 3] = end / 2
    return T
