"""What tables of numbers leave out of a robot: the space that it fills, and mass properties in a short form.

Whoever plans needs shapes. Each arm declares them in one table: for each link what it consists of, tubes and drums
about as thick as the robot, between points in the link's frame. The last piece of an arm is a drum, whose flat end lies
at the flange: a tool's tip at or beyond it may touch something. Textbook arms get invented masses (`with_rods`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import pi
from typing import TypeAlias

import numpy as np

from mafsil.arrays import Vector3, frozen
from mafsil.model.joint import JointKind
from mafsil.model.link import HOUSING, OUTLINE, SHELL, Capsule, Cylinder, Inertial, Shape
from mafsil.model.mechanism import Mechanism
from mafsil.model.placement import frame_along, turned_tensor

Six = tuple[float, float, float, float, float, float]
Three = tuple[float, float, float]
ALUMINIUM = 2700.0
"""[kg/m^3]"""
Point: TypeAlias = Sequence[float]
_EDGE = 0.6
"""How far from its end the round end of a housing is centred, as share of its radius."""
_SAME = 1e-9
"""Distance within which a joint or the tip sits at a link's origin [m]."""


@dataclass(frozen=True, slots=True)
class Tube:
    """Everything within a radius of the segment between two points, in the frame of a link: round at its ends [m]."""

    radius: float
    start: Point
    end: Point

    def shape(self) -> Shape:
        """As a capsule."""
        centre, axis, length = _segment(self.start, self.end)
        return _place(Capsule(self.radius, length), centre, axis)


@dataclass(frozen=True, slots=True)
class Drum:
    """The same with flat ends at the two points [m]."""

    radius: float
    start: Point
    end: Point

    def shape(self) -> Shape:
        """As a cylinder."""
        centre, axis, length = _segment(self.start, self.end)
        return _place(Cylinder(self.radius, length), centre, axis)


def housing(radius: float, start: Point, end: Point) -> Tube:
    """A drum without its edges: a tube whose ends stand out in the middle by less than twice what they lack at the rim.

    Tubes are compared faster than drums are.

    Args:
        radius: of the drum [m].
        start, end: the middles of its flat ends.
    """
    a, b = np.asarray(start, np.float64), np.asarray(end, np.float64)
    length = float(np.linalg.norm(b - a))
    back = min(_EDGE * radius / length, 0.5) * (b - a)
    return Tube(radius, (a + back).tolist(), (b - back).tolist())


Outline: TypeAlias = Mapping[str, Sequence[Tube | Drum]]


def with_outline(mechanism: Mechanism, outline: Outline, source: str) -> Mechanism:
    """The same arm with the shapes of its links, and a note where they come from.

    Args:
        mechanism: an arm.
        outline: pieces by the names of links.
        source: of the numbers.
    """
    links = tuple(
        replace(link, collisions=tuple(piece.shape() for piece in outline.get(link.name, ())))
        for link in mechanism.links
    )
    notes = (*mechanism.provenance.notes, f"collision shapes: {source}")
    return replace(mechanism, links=links, provenance=replace(mechanism.provenance, notes=notes))


def with_slim_tubes(mechanism: Mechanism, radius: float) -> Mechanism:
    """The same serial arm, whose links get tubes from their frame to the next joint or the tip: a book draws lines.

    A link where both coincide has nothing, unless it is the last one and turns: a drum along its axis then ends at the
    tip. What leads across from a sliding joint belongs to the link before, as it makes no difference; a tube that
    only rolls about itself on a sliding link belongs to that one.

    Args:
        mechanism: a serial arm.
        radius: of the tubes [m].
    """
    joints, last = mechanism.joints, mechanism.joints[-1]
    ends = [np.asarray(joint.T_pj[:3, 3]) for joint in joints] + [np.asarray(mechanism.T_lt[:3, 3])]
    ways = [[np.zeros(3), end] for end in ends]
    for k, sliding in enumerate(joints):
        if sliding.kind is not JointKind.PRISMATIC:
            continue
        aside = ends[k + 1] - sliding.axis * (sliding.axis @ ends[k + 1])
        ways[k].append(ends[k] + sliding.T_pj[:3, :3] @ aside)
        ways[k + 1][0] = aside
        if k + 1 < len(joints) and np.linalg.norm(np.cross(joints[k + 1].axis, ends[k + 2])) < _SAME:
            ways[k + 1].append(ends[k + 1] + joints[k + 1].T_pj[:3, :3] @ ends[k + 2])
            ways[k + 2] = []
    outline: dict[str, list[Tube | Drum]] = {}
    for k, (link, way) in enumerate(zip(mechanism.links, ways, strict=True)):
        flat = all(np.linalg.norm(later) < _SAME for later in ends[k + 1 :])
        outline[link.name] = [
            (Drum if flat else Tube)(radius, a.tolist(), b.tolist())
            for a, b in pairwise(way)
            if np.linalg.norm(b - a) > _SAME
        ]
    if not outline[last.child] and last.kind is not JointKind.PRISMATIC:
        outline[last.child] = [Drum(radius, (-2.0 * radius * last.axis).tolist(), (0.0, 0.0, 0.0))]
    return with_outline(mechanism, outline, f"invented slim tubes along the links, radius {radius} m")


def _segment(start: Point, end: Point) -> tuple[Vector3, Vector3, float]:
    """Middle, unit direction and length; a direction along z where the points coincide."""
    a, b = np.asarray(start, np.float64), np.asarray(end, np.float64)
    length = float(np.linalg.norm(b - a))
    return (a + b) / 2.0, (b - a) / length if length else np.array([0.0, 0.0, 1.0]), length


def _place(geometry: Capsule | Cylinder, centre: Vector3, axis: Vector3) -> Shape:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = frame_along(axis), centre
    colour = SHELL if isinstance(geometry, Capsule) else HOUSING
    return Shape(geometry, frozen(T), name=OUTLINE, colour=colour)


def inertial(mass: float, com: Three, moments: Six | Three) -> Inertial:
    """Mass properties from numbers of a table.

    Args:
        mass: [kg].
        com: (3,) centre of mass [m].
        moments: xx, yy, zz, xy, xz, yz (products zero if left out) about the centre of mass [kg m^2].
    """
    xx, yy, zz, xy, xz, yz = (*moments, 0.0, 0.0, 0.0)[:6]
    return Inertial(mass, frozen(com), frozen([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))


def with_rods(mechanism: Mechanism, radius: float = 0.05) -> Mechanism:
    """The same arm with invented masses: every moving link a solid aluminium cylinder along its length.

    The cylinder leads from the link's frame to the next joint or the tip; where these coincide, the link is a ball.

    Args:
        mechanism: a serial arm.
        radius: of the cylinders and balls [m].
    """
    after = [joint.T_pj[:3, 3] for joint in mechanism.joints[1:]] + [mechanism.T_lt[:3, 3]]
    moving = (replace(link, inertial=_rod(end, radius)) for link, end in zip(mechanism.links[1:], after, strict=True))
    note = f"masses invented: solid aluminium cylinders and balls, radius {radius} m"
    provenance = replace(mechanism.provenance, notes=(*mechanism.provenance.notes, note))
    return replace(mechanism, links=(mechanism.links[0], *moving), provenance=provenance)


def _rod(end: Vector3, radius: float) -> Inertial:
    """Solid cylinder from the origin to `end`, or a ball at the origin."""
    length = float(np.linalg.norm(end))
    if length < radius:
        ball = ALUMINIUM * 4 / 3 * pi * radius**3
        return Inertial(ball, frozen(end / 2), frozen(0.4 * ball * radius**2 * np.eye(3)))
    mass = ALUMINIUM * pi * radius**2 * length
    across = mass * (3 * radius**2 + length**2) / 12
    R = frame_along(end / length)
    return Inertial(mass, frozen(end / 2), turned_tensor(np.diag([across, across, mass * radius**2 / 2]), R))
