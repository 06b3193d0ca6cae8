"""Simple shapes for robots without geometry, made from their kinematics, so that every robot can be drawn."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from mafsil.arrays import PoseMatrix, Vector3, frozen
from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import Link
from mafsil.model.mechanism import Mechanism
from mafsil.model.placement import frame_along
from mafsil.model.shape import Box, Capsule, Cylinder, Geometry, Shape, Sphere

THICKNESS = 0.03
"""Radius of the bones as a fraction of the robot's longest chain."""
_LINK_COLOUR = (0.62, 0.66, 0.70, 1.0)
_JOINT_COLOUR = (0.95, 0.55, 0.15, 1.0)
_TIP_COLOUR = (0.20, 0.45, 0.75, 1.0)


def with_skeleton(mechanism: Mechanism, radius: float | None = None) -> Mechanism:
    """The same mechanism, where links without visuals got simple ones.

    A capsule leads from a link's own joint to each joint that it carries and to the tip; a cylinder along the axis
    marks a revolute or helical joint, a box and a rod reaching back a prismatic one, a ball the tip. Links that have
    visuals keep them.

    Args:
        mechanism: any robot.
        radius: of the capsules [m]; THICKNESS times the length of the longest chain by default.
    """
    ends = _ends(mechanism)
    size = THICKNESS * _length(mechanism) if radius is None else radius
    own = {joint.child: joint for joint in mechanism.joints}
    links = tuple(
        link
        if link.visuals
        else replace(link, visuals=_shapes(link, own.get(link.name), ends[link.name], mechanism, size))
        for link in mechanism.links
    )
    return replace(mechanism, links=links)


def _ends(mechanism: Mechanism) -> dict[str, list[Vector3]]:
    """For each link the points in its frame where it carries joints or the tip."""
    ends: dict[str, list[Vector3]] = {link.name: [] for link in mechanism.links}
    for joint in (*mechanism.joints, *mechanism.loops):
        ends[joint.parent].append(joint.T_pj[:3, 3])
    ends[mechanism.tip].append(mechanism.T_lt[:3, 3])
    return ends


def _length(mechanism: Mechanism) -> float:
    """Length of the longest chain from frame to frame, the tip included; 1 if all frames coincide [m]."""
    along = {mechanism.links[0].name: 0.0}
    for joint in mechanism.joints:
        along[joint.child] = along[joint.parent] + float(np.linalg.norm(joint.T_pj[:3, 3]))
    along[mechanism.tip] += float(np.linalg.norm(mechanism.T_lt[:3, 3]))
    return max(along.values()) or 1.0


def _shapes(
    link: Link, own: Joint | None, points: list[Vector3], mechanism: Mechanism, radius: float
) -> tuple[Shape, ...]:
    """Joint mark, bones, tip mark."""
    shapes = [Shape(*_mark(own, radius), name="joint", colour=_JOINT_COLOUR)] if own and own.moves else []
    if own is not None and own.kind is JointKind.PRISMATIC:
        shapes.append(_rod(own, radius))
    for point in points:
        bend = _bend(own, point)
        shapes += [_bone(start, end, radius) for start, end in pairwise(bend) if np.linalg.norm(end - start) > 1e-9]
    if link.name == mechanism.tip:
        shapes.append(Shape(Sphere(1.2 * radius), mechanism.T_lt, name="tip", colour=_TIP_COLOUR))
    return tuple(shapes)


def _bend(own: Joint | None, point: Vector3) -> list[Vector3]:
    """Corners of the bone: along the joint's axis first, then across, as real links are built."""
    axis = np.array([0.0, 0.0, 1.0]) if own is None or not own.moves else own.axis
    return [np.zeros(3), axis * (axis @ point), np.asarray(point)]


def _bone(start: Vector3, end: Vector3, radius: float) -> Shape:
    length = float(np.linalg.norm(end - start))
    return Shape(
        Capsule(radius, length), _placed((start + end) / 2, (end - start) / length), name="bone", colour=_LINK_COLOUR
    )


def _rod(joint: Joint, radius: float) -> Shape:
    """What a sliding link leaves behind in the link before: as long as its travel forward, half a metre if unknown."""
    travel = joint.limits.upper if np.isfinite(joint.limits.upper) else 0.5
    length = max(float(travel), 4.0 * radius)
    place = _placed(-joint.axis * length / 2, joint.axis)
    return Shape(Cylinder(0.6 * radius, length), place, name="rod", colour=_LINK_COLOUR)


def _mark(joint: Joint, radius: float) -> tuple[Geometry, PoseMatrix]:
    """Cylinder around the axis of a turning joint, box along a sliding one."""
    pose = _placed(np.zeros(3), joint.axis)
    if joint.kind is JointKind.PRISMATIC:
        return Box((2.6 * radius, 2.6 * radius, 4.0 * radius)), pose
    return Cylinder(1.6 * radius, 4.0 * radius), pose


def _placed(centre: Vector3, direction: Vector3) -> PoseMatrix:
    T = np.eye(4)
    T[:3, :3] = frame_along(direction)
    T[:3, 3] = centre
    return frozen(T)
