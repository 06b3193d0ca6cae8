"""Which bodies of an arm are checked against each other, and why the others are not.

What collides of an arm: a body for each link that has a shape, and for what is fixed to its tip.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import combinations
from pathlib import Path

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, Vector3, cross
from mafsil.collision.scene import Obstacle
from mafsil.collision.shapes import Cone, ConvexHull, Geometry
from mafsil.errors import InputError
from mafsil.model import JointKind, Mechanism, mesh
from mafsil.model.link import OUTLINE, Capsule, Cylinder, Mesh, Shape, Sphere
from mafsil.model.mesh.surface import keep_hull_corners

ON_AXIS = 1e-9
"""Distance from an axis, as share of a radius, and angle to it, below which a shape lies on it."""
SAME_PLACE = 1e-6
"""Distance within which the axes of two hinges make one joint [m]."""


class SkipReason(Enum):
    """Why a pair is not checked."""

    RIGID = "rigid"
    ADJACENT = "adjacent"
    LISTED = "listed"
    REST = "rest"
    ALWAYS = "always"
    OFTEN = "often"
    UNSEEN = "unseen"


@dataclass(frozen=True, slots=True)
class SkippedPair:
    """Two bodies that are not checked against each other.

    Attributes:
        first, second: their names.
        reason: no joint moves between them; they are neighbours at one joint; listed in a file or by the caller; they
            meet where the robot is known to be free; they
            met in (nearly) all sampled configurations; they met in many, and at the zero configuration or across
            hinges at one point with empty links between; they met in none.
    """

    first: str
    second: str
    reason: SkipReason

    def __str__(self) -> str:
        return f"{self.first} - {self.second}"


def skipped_by_structure(
    mechanism: Mechanism, bodies: tuple[Body, ...], listed: Mapping[frozenset[str], str]
) -> dict[tuple[int, int], SkipReason]:
    """Pairs of bodies that need no check, by their indices: rigid, neighbours, listed.

    Args:
        mechanism: the arm.
        bodies: of it.
        listed: pairs of names of bodies, or of links, which then stand for all that they carry.
    """
    group = rigid_groups(mechanism)
    index = {link.name: i for i, link in enumerate(mechanism.links)}
    neighbours = {
        frozenset((group[index[joint.parent]], group[index[joint.child]]))
        for joint in (*mechanism.joints, *mechanism.loops)
        if joint.moves
    }
    found = dict[tuple[int, int], SkipReason]()
    for (a, first), (b, second) in combinations(enumerate(bodies), 2):
        names = frozenset((first.name, second.name))
        links = frozenset((mechanism.links[first.link].name, mechanism.links[second.link].name))
        if group[first.link] == group[second.link]:
            found[a, b] = SkipReason.RIGID
        elif frozenset((group[first.link], group[second.link])) in neighbours:
            found[a, b] = SkipReason.ADJACENT
        elif names in listed or links in listed:
            found[a, b] = SkipReason.LISTED
    return found


def rigid_groups(mechanism: Mechanism) -> tuple[int, ...]:
    """For each link the first link that it is rigidly joined to."""
    group = [0]
    for k, (joint, parent) in enumerate(zip(mechanism.joints, mechanism.parents, strict=True)):
        group.append(k + 1 if joint.moves else group[parent])
    return tuple(group)


def joined_by_hinges(mechanism: Mechanism, bodies: tuple[Body, ...]) -> set[tuple[int, int]]:
    """Pairs of bodies, by their indices, that several hinges at one point join, with empty links between.

    That is how descriptions write universal and ball joints.

    Args:
        mechanism: the arm.
        bodies: of it.
    """
    group = rigid_groups(mechanism)
    filled = {group[body.link] for body in bodies}
    places = [np.eye(4)]
    above = dict[int, tuple[int, bool, bool]]()
    for k, (joint, parent) in enumerate(zip(mechanism.joints, mechanism.parents, strict=True)):
        T = places[parent] @ joint.T_pj
        places.append(np.eye(4) if joint.moves else T)
        if joint.moves:
            at_its_joint = bool(np.linalg.norm(T[:3, 3]) <= SAME_PLACE)
            above[k + 1] = (group[parent], joint.kind is JointKind.REVOLUTE, at_its_joint)
    found = set[frozenset[int]]()
    for first, (parent, hinge, at_its_joint) in above.items():
        while hinge and at_its_joint and parent not in filled and parent in above and above[parent][1]:
            parent, hinge, at_its_joint = above[parent]
            found.add(frozenset((first, parent)))
    groups = [group[body.link] for body in bodies]
    pairs = combinations(range(len(bodies)), 2)
    return {(a, b) for a, b in pairs if frozenset((groups[a], groups[b])) in found}


def named_pairs(pairs: Iterable[tuple[str, str]], known: Sequence[str]) -> dict[frozenset[str], str]:
    """Pairs of names as a caller gives them.

    Args:
        pairs: of names.
        known: names of bodies and links.

    Raises:
        InputError: something else than two names, or one that nothing of the arm has.
    """
    found = dict[frozenset[str], str]()
    for pair in pairs:
        if isinstance(pair, str) or len(pair) != 2:
            raise InputError("collision.skip_pair", got=pair)
        for name in pair:
            if name not in known:
                raise InputError("collision.skip_name", name=name, known=", ".join(known))
        found[frozenset(pair)] = ""
    return found


def still_shapes(mechanism: Mechanism, bodies: tuple[Body, ...]) -> tuple[tuple[bool, ...], ...]:
    """For each body, which of its shapes fill the same space whatever the joints do.

    These are shapes that no joint moves, and round ones that the first joint turns about their own axis.

    Args:
        mechanism: the arm.
        bodies: of it.
    """
    group = rigid_groups(mechanism)

    def is_still(link: int, geometry: Geometry, T: PoseMatrix) -> bool:
        if group[link] == 0:
            return True
        joint = mechanism.joints[link - 1] if group[link] == link else None
        turned = joint is not None and group[mechanism.parents[link - 1]] == 0 and joint.kind is JointKind.REVOLUTE
        return joint is not None and turned and _is_round_about(joint.axis, geometry, T)

    return tuple(tuple(is_still(body.link, geometry, T) for geometry, T in body.shapes) for body in bodies)


def _is_round_about(axis: Vector3, geometry: Geometry, T: PoseMatrix) -> bool:
    """Whether a turn about an axis through the origin leaves a geometry where it is."""
    if not isinstance(geometry, Sphere | Cylinder | Capsule | Cone):
        return False
    size = geometry.radius
    centred = bool(np.linalg.norm(np.cross(axis, T[:3, 3])) <= ON_AXIS * size)
    return centred and (isinstance(geometry, Sphere) or bool(np.linalg.norm(np.cross(axis, T[:3, 2])) <= ON_AXIS))


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


def mesh_files(mechanism: Mechanism, attached: Iterable[Obstacle] = ()) -> tuple[Path, ...]:
    """The files that `bodies_of` may read."""
    shapes = [shape.geometry for link in mechanism.links for shape in (*link.visuals, *link.collisions)]
    found = (each for each in (*shapes, *(item.geometry for item in attached)) if isinstance(each, Mesh))
    return tuple(dict.fromkeys(each.path for each in found if each.path is not None))


def _own(shapes: tuple[Shape, ...], radius: float | None) -> tuple[Shape, ...]:
    """The shapes of a link; a radius replaces those of the library, which only follow an outline."""
    return shapes if radius is None else tuple(shape for shape in shapes if shape.name != OUTLINE)


def _body(name: str, link: int, shapes: tuple[Shape, ...]) -> Body:
    meshes = tuple(shape.geometry for shape in shapes if isinstance(shape.geometry, Mesh))
    return Body(name, link, tuple((_hull(shape.geometry), shape.T_lg) for shape in shapes), meshes)


def _hull(geometry: Geometry) -> Geometry:
    """A mesh file as the convex hull of its vertices; anything else as it is."""
    if not isinstance(geometry, Mesh):
        return geometry
    hull = ConvexHull(mesh_vertices(geometry))
    keep_hull_corners(hull.points)
    return hull


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
    x = cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x /= np.linalg.norm(x)
    T = np.eye(4)
    T[:3, :3] = np.column_stack([x, cross(z, x), z])
    T[:3, 3] = end / 2
    return T
