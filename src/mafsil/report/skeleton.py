"""A body for a robot that is only numbers: housings at the joints, tubes between them."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from mafsil.arrays import Floats, Vector3
from mafsil.geometry import rotation
from mafsil.model import Box, Capsule, Cylinder, Joint, JointKind, Link, Mechanism, Shape, Sphere
from mafsil.report.content import Body, Solid

Colour: TypeAlias = tuple[float, float, float, float]

SHELL: Colour = (0.90, 0.90, 0.88, 1.0)
HOUSING: Colour = (0.27, 0.31, 0.35, 1.0)
ACCENT: Colour = (0.86, 0.42, 0.14, 1.0)
_TINY = 1e-6
_PLACEHOLDERS = ("joint", "bone", "tip")
"""Names of the shapes that `model.skeleton` gives to robots without geometry: the ones made here fit the page."""


def bodies(mechanism: Mechanism, floor: float) -> tuple[Body, ...]:
    """What to draw of each link, in the order of `mechanism.links`; the base stands on the floor.

    Primitives of the description are drawn as they are; a link without any gets tubes and housings that follow its
    joints. Surfaces in files are not drawn.
    """
    solids = [_primitives(link) for link in mechanism.links]
    if sum(map(bool, solids)) * 2 < len(solids):
        solids = [_grown(mechanism, k) for k in range(len(mechanism.links))]
    else:
        tip = mechanism.link_names.index(mechanism.tip)
        solids[tip] += tuple(
            _tubes(None, mechanism.T_lt[:3, 3], mechanism.T_lt[:3, 2], 0.012 * reach(mechanism), HOUSING)
        )
    solids[0] += stand(mechanism, floor)
    return tuple(Body(link.name, of_link) for link, of_link in zip(mechanism.links, solids, strict=True))


def stand(mechanism: Mechanism, floor: float) -> tuple[Solid, ...]:
    """A column under a base that hangs above the floor."""
    height = float(mechanism.T_sb[2, 3]) - floor
    if height < 0.02 * reach(mechanism):
        return ()
    radius = 1.5 * _radius(mechanism, 0)
    foot = Solid("cylinder", (1.5 * radius, 0.4 * radius), _at(np.array([0.0, 0.0, 0.2 * radius - height])), HOUSING)
    return Solid("cylinder", (radius, height), _at(np.array([0.0, 0.0, -height / 2])), SHELL), foot


def reach(mechanism: Mechanism) -> float:
    """Sum of the distances between joints along the longest way from the base, with strokes of sliding joints [m]."""
    distance = [0.0]
    for joint, parent in zip(mechanism.joints, mechanism.parents, strict=True):
        stroke = 0.0
        if joint.kind is JointKind.PRISMATIC:
            bounds = [abs(b) for b in (joint.limits.lower, joint.limits.upper) if np.isfinite(b)]
            stroke = max(bounds, default=0.0)
        distance.append(distance[parent] + float(np.linalg.norm(joint.T_pj[:3, 3])) + stroke)
    return max(max(distance) + float(np.linalg.norm(mechanism.T_lt[:3, 3])), 0.05)


def _primitives(link: Link) -> tuple[Solid, ...]:
    """The link's own primitives: what is meant to be seen, else what collides."""
    for shapes in (link.visuals, link.collisions):
        if any(shape.name in _PLACEHOLDERS for shape in shapes):
            continue
        solids = tuple(solid for shape in shapes if (solid := _solid(shape)) is not None)
        if solids and len(solids) == len(shapes):
            return solids
    return ()


def _solid(shape: Shape) -> Solid | None:
    pose, colour = _pose(shape.T_lg), shape.colour or SHELL
    match shape.geometry:
        case Box(size=size):
            return Solid("box", size, pose, colour)
        case Sphere(radius=radius):
            return Solid("sphere", (radius,), pose, colour)
        case Cylinder(radius=radius, length=length):
            return Solid("cylinder", (radius, length), pose, colour)
        case Capsule(radius=radius, length=length):
            return Solid("capsule", (radius, length), pose, colour)
        case _:
            return None


def _grown(mechanism: Mechanism, k: int) -> tuple[Solid, ...]:
    """Tubes from link k's own joint to each joint it carries (or to the tip), and a housing at each of them."""
    own = mechanism.joints[k - 1] if k else None
    radius = _radius(mechanism, k)
    solids: list[Solid] = [] if k else [_pedestal(radius)]
    for child, parent in zip(mechanism.joints, mechanism.parents, strict=True):
        if parent != k:
            continue
        solids += _tubes(own, child.T_pj[:3, 3], child.T_pj[:3, :3] @ child.axis, radius)
        solids += _housing(child, radius)
    if mechanism.links[k].name == mechanism.tip:
        solids += _tubes(own, mechanism.T_lt[:3, 3], mechanism.T_lt[:3, 2], radius * 0.6)
        solids.append(Solid("sphere", (radius * 0.62,), _at(np.zeros(3)), ACCENT))
    return tuple(solids)


def _pedestal(radius: float) -> Solid:
    """The foot of the base."""
    return Solid("cylinder", (1.9 * radius, 0.9 * radius), _at(np.array([0.0, 0.0, 0.45 * radius])), HOUSING)


def _radius(mechanism: Mechanism, k: int) -> float:
    """Tubes get thinner from the base to the tip."""
    along = k / max(len(mechanism.links) - 1, 1)
    return reach(mechanism) * (0.046 - 0.021 * along)


def _tubes(own: Joint | None, end: Vector3, axis: Vector3, radius: float, colour: Colour = SHELL) -> list[Solid]:
    """Straight pieces from the link's origin to `end`: first along its own axis, then across, last along `axis`."""
    first = own.axis if own is not None and own.moves else np.array([0.0, 0.0, 1.0])
    legs = [first * (first @ end)]
    rest = end - legs[0]
    last = axis * (axis @ rest)
    legs += [rest - last, last]
    solids: list[Solid] = []
    here = np.zeros(3)
    if own is None:
        here = min(radius, float(np.linalg.norm(legs[0]))) * first
        legs[0] = legs[0] - here
    for leg in legs:
        if np.linalg.norm(leg) > max(_TINY, 0.2 * radius):
            solids.append(_tube(here, here + leg, radius, colour))
        here = here + leg
    return solids


def _tube(start: Vector3, end: Vector3, radius: float, colour: Colour) -> Solid:
    leg = end - start
    length = float(np.linalg.norm(leg))
    return Solid("capsule", (radius, length), _along((start + end) / 2, leg / length), colour)


def _housing(joint: Joint, radius: float) -> list[Solid]:
    """A short drum about a turning axis, a sleeve along a sliding one; nothing at a fixed joint."""
    if not joint.moves:
        return []
    pose = _along(joint.T_pj[:3, 3], joint.T_pj[:3, :3] @ joint.axis)
    if joint.kind is JointKind.PRISMATIC:
        side = 2.3 * radius
        return [Solid("box", (side, side, 2.6 * radius), pose, HOUSING)]
    cap = Solid("cylinder", (1.02 * radius, 2.75 * radius), pose, ACCENT)
    return [Solid("cylinder", (1.28 * radius, 2.35 * radius), pose, HOUSING), cap]


def _along(centre: Vector3, direction: Vector3) -> tuple[float, ...]:
    """Pose of a solid whose z axis points along a direction."""
    w = 1.0 + direction[2]
    if w < 1e-9:
        return (*map(float, centre), 0.0, 1.0, 0.0, 0.0)
    q = np.array([w, -direction[1], direction[0], 0.0])
    return (*map(float, centre), *map(float, q / np.linalg.norm(q)))


def _at(centre: Vector3) -> tuple[float, ...]:
    return (*map(float, centre), 1.0, 0.0, 0.0, 0.0)


def _pose(T: Floats) -> tuple[float, ...]:
    return tuple(float(x) for x in compact(T))


def compact(T: Floats) -> Floats:
    """Position and quaternion (w, x, y, z) of poses.

    Args:
        T: (*batch, 4, 4).

    Returns:
        (*batch, 7).
    """
    return np.concatenate([T[..., :3, 3], rotation.to_quaternion(T[..., :3, :3])], axis=-1)


def extent(mechanism: Mechanism, points: Floats) -> tuple[tuple[float, float, float], float, float]:
    """Middle of the scene, its radius, and the height of the floor.

    Args:
        mechanism: the robot.
        points: (k, 3) that must be seen, in {s} [m].

    Returns:
        (3,) centre, radius and floor [m].
    """
    every = np.vstack([points, mechanism.T_sb[:3, 3]])
    low, high = every.min(axis=0), every.max(axis=0)
    centre = (low + high) / 2
    size = max(float(np.linalg.norm(high - low)) * 0.62, 0.45 * reach(mechanism))
    return (float(centre[0]), float(centre[1]), float(centre[2])), size, float(min(mechanism.T_sb[2, 3], low[2]))
