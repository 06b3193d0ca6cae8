"""What a tip touches besides planes: round surfaces, a hole for a peg, a door, faces of several points, guides.

All have the protocol of `mafsil.control.contact.Environment`: the wrench on the tip, in the tip frame, from pose
and twist.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import (
    Floats,
    PoseMatrix,
    Vector3,
    Vector6,
    not_negative,
    positive,
    real_array,
    require_finite,
    single,
)
from mafsil.control.contact.environment import Environment, SpringDamper, surface_force
from mafsil.errors import InputError
from mafsil.fields import check_fields
from mafsil.geometry import pose, rotation

TINY = 1e-12
"""Distance from a centre or an axis at which there is no direction away from it [m]."""


@dataclass(frozen=True, eq=False, slots=True)
class RoundSurface:
    """A sphere, or with an axis a cylinder, that gives way as spring and damper and never pulls.

    Attributes:
        centre: (3,) of the sphere, or a point on the axis, in {s} [m].
        radius: [m].
        stiffness, damping: k [N/m] and b [N s/m].
        friction: mu, rounded off below `slow`.
        axis: (3,) of the cylinder; None for a sphere.
        hollow: whether the tip is inside and touches the inner side.
        slow: speed of sliding below which friction falls off [m/s].
    """

    centre: Vector3
    radius: float
    stiffness: float
    damping: float = 0.0
    friction: float = 0.0
    axis: Vector3 | None = None
    hollow: bool = False
    slow: float = 1e-3
    _numbers = check_fields(
        radius=positive, stiffness=positive, slow=positive, damping=not_negative, friction=not_negative
    )  # fmt: skip

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", single("centre", self.centre, (3,)))
        if self.axis is not None:
            object.__setattr__(self, "axis", _unit("axis", self.axis))
        self._numbers()

    def normal(self, p: Vector3) -> tuple[Vector3, Floats]:
        """(*batch, 3) out of the surface at points p (*batch, 3) in {s}, and how deep (*batch,) these are in it [m]."""
        return round_normal(p, self.centre, self.radius, self.axis, self.hollow)

    def wrench(self, T: PoseMatrix, V: Vector6) -> Vector6:
        """(*batch, 6) on the tip, in the tip frame [N m, N]."""
        outward, depth = self.normal(T[..., :3, 3])
        force = surface_force(depth, outward, _velocity(T, V), self.stiffness, self.damping, self.friction, self.slow)
        return _in_tip(T, np.zeros_like(force), force)


@dataclass(frozen=True, eq=False, slots=True)
class Hole:
    """A round hole with a chamfer in a face, and a bottom; the tip is the end of the peg's axis.

    Where the tip is in the material it is pushed out the shortest way: up through the face, sideways into the hole, or
    along the chamfer of 45 degrees.

    Attributes:
        mouth: (3,) where the axis comes out of the face, in {s} [m].
        axis: (3,) out of the hole.
        clearance: radius of the hole less that of the peg [m].
        depth: of the hole [m].
        chamfer: width of its edge [m].
        stiffness, damping: [N/m, N s/m].
        friction: mu.
        slow: speed of sliding below which friction falls off [m/s].
    """

    mouth: Vector3
    axis: Vector3
    clearance: float
    depth: float
    chamfer: float = 0.0
    stiffness: float = 1e5
    damping: float = 0.0
    friction: float = 0.0
    slow: float = 1e-3
    _numbers = check_fields(
        clearance=positive, depth=positive, stiffness=positive, slow=positive, chamfer=not_negative,
        damping=not_negative, friction=not_negative,
    )  # fmt: skip

    def __post_init__(self) -> None:
        object.__setattr__(self, "mouth", single("mouth", self.mouth, (3,)))
        object.__setattr__(self, "axis", _unit("axis", self.axis))
        self._numbers()

    def wrench(self, T: PoseMatrix, V: Vector6) -> Vector6:
        """(*batch, 6) on the tip, in the tip frame [N m, N]."""
        p, velocity = T[..., :3, 3] - self.mouth, _velocity(T, V)
        height = p @ self.axis
        aside = p - height[..., None] * self.axis
        off = np.linalg.norm(aside, axis=-1)
        inward = -aside / np.maximum(off, TINY)[..., None]
        slant: Floats = (inward + self.axis) / np.sqrt(2.0)
        depths: list[Floats] = [
            -height,
            off - self.clearance,
            (off - self.clearance - height - self.chamfer) / np.sqrt(2.0),
        ]
        inside = np.min(depths, axis=0)
        shortest = np.argmin(depths, axis=0)[..., None]
        way = np.where(shortest == 0, self.axis, np.where(shortest == 1, inward, slant))
        constants = (self.stiffness, self.damping, self.friction, self.slow)
        force = surface_force(inside, way, velocity, *constants)
        force = force + surface_force(-height - self.depth, np.broadcast_to(self.axis, p.shape), velocity, *constants)
        return _in_tip(T, np.zeros_like(force), force)


@dataclass(frozen=True, eq=False, slots=True)
class Door:
    """A door whose handle the tip holds: it turns about its hinge, and everything else gives way as spring and damper.

    One freedom is left of six. The door has no mass: what turns it works against the hinge's friction and closer.

    Attributes:
        hinge, axis: (3,) a point of the hinge, and its direction, in {s} [m, 1].
        handle: (4, 4) pose of the tip where the door is shut.
        stiffness, damping: of the grip against shifts [N/m, N s/m].
        rotational_stiffness, rotational_damping: of the grip against rotations [N m/rad, N m s/rad].
        friction: of the hinge [N m s/rad].
        closer: spring that shuts the door [N m/rad].
    """

    hinge: Vector3
    axis: Vector3
    handle: PoseMatrix
    stiffness: float
    damping: float = 0.0
    rotational_stiffness: float = 0.0
    rotational_damping: float = 0.0
    friction: float = 0.0
    closer: float = 0.0
    _numbers = check_fields(
        stiffness=positive, damping=not_negative, rotational_stiffness=not_negative, rotational_damping=not_negative,
        friction=not_negative, closer=not_negative,
    )  # fmt: skip

    def __post_init__(self) -> None:
        object.__setattr__(self, "hinge", single("hinge", self.hinge, (3,)))
        object.__setattr__(self, "axis", _unit("axis", self.axis))
        object.__setattr__(self, "handle", pose.check(single("handle", self.handle, (4, 4)), "handle"))
        self._numbers()
        if np.linalg.norm(self._aside(self.handle[:3, 3])) < TINY:
            raise InputError("control.handle_on_hinge")

    def angle(self, T: PoseMatrix) -> Floats:
        """(*batch,) by how much the door is open where the tip is [rad], within half a turn."""
        first, now = self._aside(self.handle[:3, 3]), self._aside(T[..., :3, 3])
        return np.asarray(np.arctan2(np.cross(first, now) @ self.axis, now @ first))

    def handle_pose(self, angle: float) -> PoseMatrix:
        """(4, 4) pose of the handle where the door is open by an angle [rad]."""
        R = rotation.exp(angle * self.axis)
        T = self.handle.copy()
        T[:3, :3], T[:3, 3] = R @ T[:3, :3], self.hinge + R @ (T[:3, 3] - self.hinge)
        return T

    def wrench(self, T: PoseMatrix, V: Vector6) -> Vector6:
        """(*batch, 6) on the tip, in the tip frame [N m, N].

        1. Position along the radius and the axis, and orientation, are held as by springs and dampers.
        2. What is left of the moment about the hinge balances: the grip's and the tip's, friction and closer.
        """
        R, p, velocity = T[..., :3, :3], T[..., :3, 3] - self.hinge, _velocity(T, V)
        spin = (R @ V[..., :3, None])[..., 0]
        aside = self._aside(T[..., :3, 3])
        radius = np.maximum(np.linalg.norm(aside, axis=-1), TINY)
        out = aside / radius[..., None]
        along = np.cross(self.axis, out)
        at_handle = self.handle[:3, 3] - self.hinge
        shifts = (radius - np.linalg.norm(self._aside(self.handle[:3, 3])), (p - at_handle) @ self.axis)
        force = np.zeros_like(p)
        for shift, way in zip(shifts, (out, np.broadcast_to(self.axis, p.shape)), strict=True):
            rate = (velocity * way).sum(axis=-1)
            force = force - (self.stiffness * shift + self.damping * rate)[..., None] * way  # 1
        angle, rate = self.angle(T), (velocity * along).sum(axis=-1) / radius
        of_door = rotation.exp(angle[..., None] * self.axis) @ self.handle[:3, :3]
        twisted = rotation.log(R @ np.swapaxes(of_door, -1, -2))
        moment = -self.rotational_stiffness * twisted - self.rotational_damping * (spin - rate[..., None] * self.axis)
        held = moment @ self.axis + self.friction * rate + self.closer * angle  # 2
        return _in_tip(T, moment, force - (held / radius)[..., None] * along)

    def _aside(self, p: Vector3) -> Vector3:
        """From the hinge's axis to points (*batch, 3)."""
        away = p - self.hinge
        return np.asarray(away - (away @ self.axis)[..., None] * self.axis)


@dataclass(frozen=True, eq=False, slots=True)
class AtPoints:
    """An environment that several points of the tip touch, such as the corners of an eraser or the ends of a peg.

    Attributes:
        environment: what each of them touches.
        points: (m, 3) in the tip frame [m].
    """

    environment: Environment
    points: Floats

    def __post_init__(self) -> None:
        points = require_finite("points", real_array("points", self.points))
        if points.ndim != 2 or points.shape[1] != 3 or not len(points):
            raise InputError("input.shape", name="points", expected="(m, 3)", got=points.shape, hint="")
        object.__setattr__(self, "points", points)

    def wrench(self, T: PoseMatrix, V: Vector6) -> Vector6:
        """(*batch, 6) on the tip, in the tip frame [N m, N]."""
        total: Vector6 = np.zeros((*np.broadcast_shapes(T.shape[:-2], V.shape[:-1]), 6))
        for point in self.points:
            there, moving = T.copy(), V.copy()
            there[..., :3, 3] += T[..., :3, :3] @ point
            moving[..., 3:] += np.cross(V[..., :3], point)
            found = self.environment.wrench(there, moving)
            total[..., :3] += found[..., :3] + np.cross(point, found[..., 3:])
            total[..., 3:] += found[..., 3:]
        return total


def round_normal(
    p: Vector3, centre: Vector3, radius: float, axis: Vector3 | None, hollow: bool
) -> tuple[Vector3, Floats]:
    """(*batch, 3) out of a sphere or a cylinder at points p (*batch, 3), and how deep (*batch,) these are in it [m].

    Args:
        p: in {s} [m].
        centre, radius, axis, hollow: as `RoundSurface`.
    """
    away = _from_middle(p, centre, axis)
    distance = np.linalg.norm(away, axis=-1)
    side = -1.0 if hollow else 1.0
    return side * away / np.maximum(distance, TINY)[..., None], side * (radius - distance)


def round_normal_rate(p: Vector3, velocity: Vector3, centre: Vector3, axis: Vector3 | None, hollow: bool) -> Vector3:
    """(*batch, 3) dn/dt = W v / |r|, r from the centre or the axis; W takes away what lies along n and the axis [1/s].

    Args:
        p, velocity: (*batch, 3) of a point, in {s} [m, m/s].
        centre, axis, hollow: as `RoundSurface`.
    """
    away = _from_middle(p, centre, axis)
    distance = np.maximum(np.linalg.norm(away, axis=-1), TINY)[..., None]
    n = away / distance
    across = velocity - (velocity * n).sum(axis=-1)[..., None] * n
    if axis is not None:
        across = across - (across @ axis)[..., None] * axis
    return np.asarray((-1.0 if hollow else 1.0) * across / distance)


def _from_middle(p: Vector3, centre: Vector3, axis: Vector3 | None) -> Vector3:
    """(*batch, 3) to points from the centre, or from the axis."""
    away = p - centre
    return away if axis is None else np.asarray(away - (away @ axis)[..., None] * axis)


def guiding_line(point: ArrayLike, direction: ArrayLike, stiffness: float, damping: float = 0.0) -> SpringDamper:
    """A guide along which the tip is free, and to which it is drawn back: a virtual ruler.

    Args:
        point, direction: (3,) of the line, in {s} [m, 1].
        stiffness, damping: across it [N/m, N s/m].
    """
    u = _unit("direction", direction)
    return _guide(point, np.eye(3) - np.outer(u, u), stiffness, damping)


def guiding_plane(point: ArrayLike, normal: ArrayLike, stiffness: float, damping: float = 0.0) -> SpringDamper:
    """A guide in which the tip is free, and to which it is drawn back from both sides.

    Args:
        point, normal: (3,) of the plane, in {s} [m, 1].
        stiffness, damping: across it [N/m, N s/m].
    """
    u = _unit("normal", normal)
    return _guide(point, np.outer(u, u), stiffness, damping)


def _guide(point: ArrayLike, across: Floats, stiffness: float, damping: float) -> SpringDamper:
    k, d = single("stiffness", stiffness, ()), single("damping", damping, ())
    return SpringDamper(single("point", point, (3,)), k * across, d * across)


def _velocity(T: PoseMatrix, V: Vector6) -> Vector3:
    """(*batch, 3) of the tip's origin in {s} [m/s]."""
    return np.asarray((T[..., :3, :3] @ V[..., 3:, None])[..., 0])


def _in_tip(T: PoseMatrix, moment: Vector3, force: Vector3) -> Vector6:
    """A moment and a force through the tip's origin, in {s}, as a wrench in the tip frame."""
    R = np.swapaxes(T[..., :3, :3], -1, -2)
    return np.concatenate([(R @ part[..., None])[..., 0] for part in (moment, force)], axis=-1)


def _unit(name: str, value: ArrayLike) -> Vector3:
    vector = single(name, value, (3,))
    length = float(np.linalg.norm(vector))
    if not length > 0.0:
        raise InputError("control.no_normal")
    return vector / length
