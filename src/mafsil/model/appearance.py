"""What to draw of a robot: its own shapes where they are found, thinned out to a budget, else tubes and housings.

A robot that is only numbers gets a body by `with_skeleton`: housings at the joints, tubes between them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeAlias

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, Vector3, frozen
from mafsil.errors import FileError
from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import (
    ACCENT,
    HOUSING,
    OUTLINE,
    SHELL,
    Box,
    Capsule,
    Colour,
    Cylinder,
    Geometry,
    Link,
    Mesh,
    Shape,
    Sphere,
)
from mafsil.model.loading import of_any_mechanism
from mafsil.model.mechanism import Mechanism
from mafsil.model.mesh import Surface, read
from mafsil.model.mesh.decimation import decimate
from mafsil.model.placement import frame_along

THICK, THIN = 0.046, 0.025
"""Radius of the tubes at the base and at the last link, as fractions of the reach."""
SLIMMER = 0.35
"""By how much of their thickness tubes get thinner with every loop: many legs stand where one arm would."""
SHORTEST = 0.2
"""Tubes shorter than this many radii are left out: they would not show."""
_Z = np.array([0.0, 0.0, 1.0])
_ORIGIN = frozen(np.zeros(3))
_TINY = 1e-6
MOST_TRIANGLES = 60_000
MOST_BYTES = 256 << 20
"""Mesh files of one robot beyond this size in all are not opened."""
FEWEST_TRIANGLES = 60
"""A surface is not thinned out below this."""
_SHARE = 0.7
"""Each surface gets its triangles in proportion to this power of what it has: small ones keep more of theirs."""
Drawable: TypeAlias = Box | Cylinder | Capsule | Sphere | Surface


@dataclass(frozen=True, eq=False, slots=True)
class Piece:
    """Something to draw in the frame of its link.

    Attributes:
        geometry: a primitive centred on its frame, or triangles.
        T_lg: (4, 4) pose of its frame in the link's.
        colour: red, green, blue, opacity in 0..1; the triangles' own colours go before it.
    """

    geometry: Drawable
    T_lg: PoseMatrix
    colour: Colour = SHELL


Pieces: TypeAlias = tuple[Piece, ...]


def pieces(mechanism: Mechanism, most_triangles: int = MOST_TRIANGLES) -> tuple[Pieces, ...]:
    """What to draw of each link, in the order of `mechanism.links`.

    The shapes of the description: what is meant to be seen, else what collides. If less than half of the moving parts
    have any that can be drawn, all links get the tubes and housings of `with_skeleton` instead; those of robots of the
    library the outline that they collide with.

    Args:
        mechanism: any robot.
        most_triangles: of all surfaces in files together; beyond it they are simplified.
    """
    files = _Files(most_triangles)
    of_outline = outline(mechanism)
    if of_outline is not None and not _shown_enough(
        mechanism, [tuple(files.of_shapes(link.visuals)) for link in mechanism.links]
    ):
        own = [primitives(link.visuals) for link in of_outline.links]
        own[mechanism.link_names.index(mechanism.tip)] += primitives(tip_tubes(mechanism))
        return tuple(own)
    own = [files.of_link(link) for link in mechanism.links]
    if not _shown_enough(mechanism, own):
        bare = replace(mechanism, links=tuple(replace(link, visuals=()) for link in mechanism.links))
        return tuple(primitives(link.visuals) for link in with_skeleton(bare).links)
    own = list(files.within_budget(own))
    own[mechanism.link_names.index(mechanism.tip)] += primitives(tip_tubes(mechanism))
    return tuple(own)


def part_of(mechanism: Mechanism) -> tuple[int, ...]:
    """For each link the first link of the rigid part that it belongs to; links joined by fixed joints are one part."""
    heads = [0]
    for k, (joint, parent) in enumerate(zip(mechanism.joints, mechanism.parents, strict=True), start=1):
        heads.append(k if joint.moves else heads[parent])
    return tuple(heads)


def corners(piece: Piece) -> Floats:
    """(8, 3) corners of a box around a piece, in the frame of its link [m]."""
    match piece.geometry:
        case Box(size=size):
            half = np.array(size) / 2
        case Sphere(radius=radius):
            half = np.full(3, radius)
        case Cylinder(radius=radius, length=length):
            half = np.array([radius, radius, length / 2])
        case Capsule(radius=radius, length=length):
            half = np.array([radius, radius, length / 2 + radius])
        case Surface(vertices=vertices, faces=faces):
            used = vertices[faces.reshape(-1)]
            low, high = used.min(axis=0), used.max(axis=0)
            return _box(low, high) @ piece.T_lg[:3, :3].T + piece.T_lg[:3, 3]
    return _box(-half, half) @ piece.T_lg[:3, :3].T + piece.T_lg[:3, 3]


def _box(low: Floats, high: Floats) -> Floats:
    picks = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, -1).T
    return np.where(picks == 0, low, high)


def _shown_enough(mechanism: Mechanism, own: list[Pieces]) -> bool:
    heads = part_of(mechanism)
    moving = set(heads) - {0}
    shown = {heads[k] for k, of_link in enumerate(own) if of_link} & moving
    return bool(moving) and 2 * len(shown) >= len(moving)


def primitives(shapes: tuple[Shape, ...]) -> Pieces:
    """Those of the shapes that are no files."""
    return tuple(
        Piece(shape.geometry, shape.T_lg, shape.colour or SHELL)
        for shape in shapes
        if not isinstance(shape.geometry, Mesh)
    )


@dataclass(slots=True)
class _Files:
    """Reads each mesh file once and keeps no more triangles of it than may be drawn in all."""

    most: int
    bytes_left: int = MOST_BYTES
    surfaces: dict[tuple[Path, tuple[float, float, float]], Surface | None] = field(
        default_factory=dict[tuple[Path, tuple[float, float, float]], Surface | None]
    )

    def of_link(self, link: Link) -> Pieces:
        """The first of visuals and collision shapes that can be drawn whole, else what there is of the visuals."""
        found = [tuple(self.of_shapes(shapes)) for shapes in (link.visuals, link.collisions)]
        for given, drawn in zip((link.visuals, link.collisions), found, strict=True):
            if given and len(drawn) == len(given):
                return drawn
        return found[0] or found[1]

    def of_shapes(self, shapes: tuple[Shape, ...]) -> Iterator[Piece]:
        for shape in shapes:
            if isinstance(shape.geometry, Mesh):
                surface = self.surface(shape.geometry)
                if surface is not None:
                    yield Piece(surface, shape.T_lg, shape.colour or SHELL)
            else:
                yield Piece(shape.geometry, shape.T_lg, shape.colour or SHELL)

    def surface(self, mesh: Mesh) -> Surface | None:
        """Its triangles; None if the file is not found, not readable or empty."""
        if mesh.path is None:
            return None
        key = (mesh.path, mesh.scale)
        if key not in self.surfaces:
            self.surfaces[key] = self._read(mesh.path, mesh.scale)
        return self.surfaces[key]

    def _read(self, path: Path, scale: tuple[float, float, float]) -> Surface | None:
        try:
            self.bytes_left -= path.stat().st_size
            whole = read(path) if self.bytes_left >= 0 else None
        except (FileError, OSError):
            return None
        if whole is None or not len(whole.faces) or not np.abs(whole.vertices[whole.faces]).max() < 1e6:
            return None
        return decimate(whole.scale(scale), self.most)

    def within_budget(self, own: list[Pieces]) -> Iterator[Pieces]:
        """The same pieces with surfaces thinned out so that all together keep to the budget."""
        drawn = [p.geometry for of_link in own for p in of_link if isinstance(p.geometry, Surface)]
        counts = np.array([len(surface.faces) for surface in drawn])
        if counts.sum() <= self.most:
            yield from own
            return
        weights = counts**_SHARE
        allowed = [max(FEWEST_TRIANGLES, int(share)) for share in self.most * weights / weights.sum()]
        fewer = {id(s): s if len(s.faces) <= a else decimate(s, a) for s, a in zip(drawn, allowed, strict=True)}
        for of_link in own:
            yield tuple(
                replace(p, geometry=fewer[id(p.geometry)]) if isinstance(p.geometry, Surface) else p for p in of_link
            )


@of_any_mechanism
def with_skeleton(mechanism: Mechanism) -> Mechanism:
    """The same mechanism, where links without visuals got simple ones.

    Tubes lead from a link's own joint to each joint that it carries, those that close loops among them, and to the tip,
    along the axes and across; a drum marks a revolute joint, a sleeve and a rod reaching back a prismatic one, a ball a
    spherical one and the last link. Links that have visuals keep them.

    Args:
        mechanism: any robot.
    """
    size = reach(mechanism)
    links = tuple(
        link if link.visuals else replace(link, visuals=_grown(mechanism, k, size))
        for k, link in enumerate(mechanism.links)
    )
    return replace(mechanism, links=links)


def with_shapes(mechanism: Mechanism) -> Mechanism:
    """The mechanism with something to collide: its collision shapes, else what it shows, else tubes along its links.

    Args:
        mechanism: any arm.
    """
    return mechanism if any(link.collisions for link in mechanism.links) else with_skeleton(mechanism)


def outline(mechanism: Mechanism) -> Mechanism | None:
    """The same mechanism, where what is seen of links is the outline that they collide with, and marks of the joints.

    None if no link has an outline. The marks are hidden in the links of makers' arms, and show on slim tubes.

    Args:
        mechanism: any robot.
    """
    outlines = [tuple(one for one in link.collisions if one.name == OUTLINE) for link in mechanism.links]
    radii = [one.geometry.radius for own in outlines for one in own if isinstance(one.geometry, Capsule | Cylinder)]
    if not radii:
        return None
    links = list(mechanism.links)
    for k, (link, own) in enumerate(zip(mechanism.links, outlines, strict=True)):
        carried = [joint for joint, parent in zip(mechanism.joints, mechanism.parents, strict=True) if parent == k]
        marks = [drum for joint in carried for drum in _housing(joint, min(radii))]
        links[k] = replace(link, visuals=(*own, *marks, *_pin(own, min(radii))))
    return replace(mechanism, links=tuple(links))


def _pin(outline: tuple[Shape, ...], radius: float) -> list[Shape]:
    """What leads from a link's own joint to its outline, where that begins away from the joint."""
    nearest, gap = np.zeros(3), np.inf
    for shape in outline:
        if isinstance(shape.geometry, Capsule | Cylinder):
            axis, length = shape.T_lg[:3, 2], shape.geometry.length
            begin = shape.T_lg[:3, 3] - length / 2.0 * axis
            foot = begin + np.clip(-begin @ axis, 0.0, length) * axis
            if np.linalg.norm(foot) - shape.geometry.radius < gap:
                nearest, gap = foot, float(np.linalg.norm(foot)) - shape.geometry.radius
    if not SHORTEST * radius < gap < np.inf:
        return []
    length = float(np.linalg.norm(nearest))
    return [_shape("bone", Capsule(radius, length), nearest / 2.0, nearest / length, SHELL)]


def reach(mechanism: Mechanism) -> float:
    """Sum of the distances between joints along the longest way from the base, with strokes of prismatic joints [m]."""
    distance = [0.0]
    for joint, parent in zip(mechanism.joints, mechanism.parents, strict=True):
        step = float(np.linalg.norm(joint.T_pj[:3, 3]))
        distance.append(distance[parent] + step + (stroke(joint) if joint.kind is JointKind.PRISMATIC else 0.0))
    return max(max(distance) + float(np.linalg.norm(mechanism.T_lt[:3, 3])), 0.05)


def stroke(joint: Joint) -> float:
    """How far a prismatic joint goes from zero; 0 if it has no bounds [m]."""
    return max((abs(x) for x in (joint.limits.lower, joint.limits.upper) if np.isfinite(x)), default=0.0)


def tip_tubes(mechanism: Mechanism) -> tuple[Shape, ...]:
    """What leads from the tip's link to a tip frame away from it: a tool that has no shape of its own."""
    T = mechanism.T_lt
    return tuple(_tubes(None, T[:3, 3], T[:3, 2], 0.012 * reach(mechanism), HOUSING, flat=True))


def stand(mechanism: Mechanism, top: float, floor: float) -> tuple[Shape, ...]:
    """A column from the floor to a base that hangs above it, in {s}; nothing if the base is near the floor.

    Args:
        mechanism: stands above its origin.
        top: height of the base's lowest point [m].
        floor: height of the floor [m].
    """
    size, height = reach(mechanism), top - floor
    if height < 0.05 * size:
        return ()
    radius, at = 1.5 * THICK * size, mechanism.T_sb[:3, 3] * (1.0, 1.0, 0.0)
    column = _shape("stand", Cylinder(radius, height), at + (floor + height / 2) * _Z, _Z, SHELL)
    return column, _shape("foot", Cylinder(1.5 * radius, 0.4 * radius), at + (floor + 0.2 * radius) * _Z, _Z, HOUSING)


def _grown(mechanism: Mechanism, k: int, size: float) -> tuple[Shape, ...]:
    """Tubes from link k's own joint to each joint it carries (or to the tip), and a housing at each of them."""
    own = mechanism.joints[k - 1] if k else None
    size = size / (1.0 + SLIMMER * len(mechanism.loops))
    radius = size * (THICK - (THICK - THIN) * k / max(len(mechanism.links) - 1, 1))
    foot = _shape("foot", Cylinder(1.9 * radius, 0.9 * radius), 0.45 * radius * _Z, _Z, HOUSING)
    shapes: list[Shape] = [foot] if own is None else [] if mechanism.loops else _rod(own, radius)
    begin = _begin(own) if mechanism.loops else _ORIGIN
    for joint in (*mechanism.joints, *mechanism.loops):
        if joint.parent != mechanism.links[k].name:
            continue
        shapes += _tubes(own, joint.T_pj[:3, 3], joint.T_pj[:3, :3] @ joint.axis, radius, SHELL, begin=begin)
        shapes += _housing(joint, radius)
    if any(loop.child == mechanism.links[k].name for loop in mechanism.loops):
        shapes.append(_shape("pin", Sphere(radius), np.zeros(3), _Z, HOUSING))
    if mechanism.links[k].name == mechanism.tip:
        shapes += _tubes(own, mechanism.T_lt[:3, 3], mechanism.T_lt[:3, 2], 0.6 * radius, SHELL, flat=True)
        shapes.append(_knob(mechanism.T_lt, 0.62 * radius))
    return tuple(shapes)


def _knob(T_lt: PoseMatrix, radius: float) -> Shape:
    """A ball at the last link's origin; where the tip is nearer than its radius, a drum that ends at the tip.

    Nothing reaches beyond the plane of the tip, so that it can touch something.
    """
    if np.linalg.norm(T_lt[:3, 3]) >= radius:
        return _shape("tip", Sphere(radius), np.zeros(3), _Z, ACCENT)
    return _shape("tip", Cylinder(radius, radius), T_lt[:3, 3] - radius / 2.0 * T_lt[:3, 2], T_lt[:3, 2], ACCENT)


def _begin(own: Joint | None) -> Vector3:
    """Where a leg begins that slides out of another: never behind the joint that the other turns about."""
    if own is None or own.kind is not JointKind.PRISMATIC or not np.isfinite(own.limits.lower):
        return _ORIGIN
    return max(0.0, -own.limits.lower) * own.axis


def _rod(own: Joint, radius: float) -> list[Shape]:
    """What a prismatic link leaves behind in the link before: as long as its travel, so that the two stay connected."""
    if own.kind is not JointKind.PRISMATIC:
        return []
    length = max(own.limits.upper, 0.0) if np.isfinite(own.limits.upper) else 0.5
    if length < SHORTEST * radius:
        return []
    return [_shape("rod", Cylinder(0.6 * radius, length), -own.axis * length / 2, own.axis, SHELL)]


def _tubes(
    own: Joint | None,
    end: Vector3,
    axis: Vector3,
    radius: float,
    colour: Colour,
    *,
    begin: Vector3 = _ORIGIN,
    flat: bool = False,
) -> list[Shape]:
    """Straight pieces from the link's origin to `end`: first along its own axis, then across, last along `axis`.

    Or from `begin` on its axis, if the first piece gets so far.

    Round at their ends, or the last one flat.
    """
    first = own.axis if own is not None and own.moves else _Z
    legs = [first * (first @ end)]
    rest = end - legs[0]
    last = axis * (axis @ rest)
    shapes: list[Shape] = []
    here = begin if begin @ begin < begin @ legs[0] else _ORIGIN
    for leg in (legs[0] - here, rest - last, last):
        length = float(np.linalg.norm(leg))
        if length > max(_TINY, SHORTEST * radius):
            shapes.append(_shape("bone", Capsule(radius, length), here + leg / 2, leg / length, colour))
        here = here + leg
    if flat and shapes:
        bone = shapes[-1]
        assert isinstance(bone.geometry, Capsule)
        shapes[-1] = replace(bone, geometry=Cylinder(radius, bone.geometry.length))
    return shapes


def _housing(joint: Joint, radius: float) -> list[Shape]:
    """A short drum about an axis, a sleeve along a prismatic one, a ball about a point; nothing at a fixed joint."""
    if not joint.moves:
        return []
    centre, axis = joint.T_pj[:3, 3], joint.T_pj[:3, :3] @ joint.axis
    if joint.kind is JointKind.PRISMATIC:
        side = 2.3 * radius
        return [_shape("joint", Box((side, side, 2.6 * radius)), centre, axis, HOUSING)]
    if joint.kind is JointKind.SPHERICAL:
        return [_shape("joint", Sphere(1.4 * radius), centre, axis, HOUSING)]
    drum = _shape("joint", Cylinder(1.28 * radius, 2.35 * radius), centre, axis, HOUSING)
    return [drum, _shape("cap", Cylinder(1.02 * radius, 2.75 * radius), centre, axis, ACCENT)]


def _shape(name: str, geometry: Geometry, centre: Vector3, direction: Vector3, colour: Colour) -> Shape:
    return Shape(geometry, _place(centre, direction), name=name, colour=colour)


def _place(centre: Vector3, direction: Vector3) -> PoseMatrix:
    """Pose of a shape whose z axis points along a unit direction."""
    T = np.eye(4)
    T[:3, :3] = frame_along(direction / np.linalg.norm(direction))
    T[:3, 3] = centre
    return frozen(T)
