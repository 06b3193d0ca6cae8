"""The moving bodies of a mechanism, in frames chosen to make its expressions short.

A body is everything that a moving joint carries rigidly: the links behind fixed joints are lumped into it. Its frame
{i} has z along its joint axis. Poses, velocities and joint efforts do not depend on these choices (`frame_choice`,
`regrouping`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mafsil.arrays import Floats
from mafsil.model import Inertial, Joint, JointKind, Mechanism


@dataclass(frozen=True, eq=False, slots=True)
class RigidInertia:
    """Inertia of a rigid body about the origin of its frame {i}.

    Attributes:
        mass: [kg].
        h: (3,) first moment, mass times centre of mass [kg m].
        I: (3, 3) rotational inertia about the origin of {i}, not about the centre of mass [kg m^2].
    """

    mass: float
    h: Floats
    I: Floats

    @staticmethod
    def zero() -> RigidInertia:
        """No inertia at all."""
        return RigidInertia(0.0, np.zeros(3), np.zeros((3, 3)))

    @staticmethod
    def about_com(mass: float, com: Floats, inertia: Floats) -> RigidInertia:
        """From the inertia about the centre of mass (Steiner): I = I_c + m (|c|^2 E - c c')."""
        return RigidInertia(mass, mass * com, inertia + mass * _steiner(com, com))

    def __add__(self, other: RigidInertia) -> RigidInertia:
        return RigidInertia(self.mass + other.mass, self.h + other.h, self.I + other.I)

    def in_frame(self, R: Floats, p: Floats) -> RigidInertia:
        """The same body seen from a frame in which its present frame has the pose (R, p)."""
        h = R @ self.h
        shift = self.mass * _steiner(p, p) + _steiner(p, h) + _steiner(h, p)
        return RigidInertia(self.mass, h + self.mass * p, R @ self.I @ R.T + shift)


@dataclass(frozen=True, eq=False, slots=True)
class Body:
    """A moving body and the joint that carries it.

    The pose of {i} in its parent's frame is (R, p) followed by the joint's screw along z by
    multiplier * x + offset + higher[0] * x^2 + ..., x = q[coordinate].

    Attributes:
        joint: name of the joint.
        parent: index of the parent body; 0 is the fixed base.
        R, p: (3, 3), (3,) pose of the joint frame in the parent's frame.
        kind, pitch: how it moves along or about its z axis.
        coordinate, multiplier, offset, higher: which joint coordinate moves it, and how.
        inertia: in {i}.
        armature: additional inertia seen by the joint [kg m^2 | kg].
    """

    joint: str
    parent: int
    R: Floats
    p: Floats
    kind: JointKind
    pitch: float
    coordinate: int
    multiplier: float
    offset: float
    inertia: RigidInertia
    armature: float
    higher: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class Attachment:
    """Where a named frame sits: on which body, and its pose (R, p) there."""

    body: int
    R: Floats
    p: Floats

    def behind(self, T: Floats) -> Attachment:
        """A frame with pose T (4, 4) in this one."""
        return Attachment(self.body, self.R @ T[:3, :3], self.p + self.R @ T[:3, 3])


@dataclass(frozen=True, eq=False, slots=True)
class LinkBody:
    """A link by itself.

    Attributes:
        parent: index of the link that carries it; -1 for the first.
        com: (3,) centre of mass in the link's frame; the frame's origin for a massless link.
        inertia: about the origin of the link's frame.
    """

    parent: int
    com: Floats
    inertia: RigidInertia


@dataclass(frozen=True, eq=False, slots=True)
class BodyTree:
    """All bodies; `bodies[0]` is the base and has no joint of its own.

    Attributes:
        n: number of joint coordinates.
        R_s0, p_s0: pose of the base body's frame {0} in the space frame {s}.
        bodies: moving bodies at indices 1.. ; parents before children. bodies[0] only holds the base's inertia.
        frames: by link name.
        tip: the tip frame.
        gravity: (3,) in {0}.
        links: every link apart, in the order of `frames`: what lumping made one can be told apart again.
        tip_link: name of the link that the tip frame is on.
        coordinates: (n) names of the joints that own a coordinate; others follow them.
    """

    n: int
    R_s0: Floats
    p_s0: Floats
    bodies: tuple[Body, ...]
    frames: dict[str, Attachment]
    tip: Attachment
    gravity: Floats
    links: tuple[LinkBody, ...] = ()
    tip_link: str = ""
    coordinates: tuple[str, ...] = ()

    @property
    def moving(self) -> tuple[tuple[int, Body], ...]:
        """(index, body) of all bodies but the base, parents first."""
        return tuple(enumerate(self.bodies))[1:]

    @property
    def follows(self) -> bool:
        """Whether some joint mimics another, so that coordinates and joints differ."""
        return any((b.coordinate, b.multiplier) != (i - 1, 1.0) for i, b in self.moving)

    @property
    def depth(self) -> int:
        """Most moving bodies in a row between the base and a leaf."""
        return max((len(self.path(i)) for i, _ in self.moving), default=0)

    def path(self, body: int) -> tuple[int, ...]:
        """Indices of the moving bodies from the base to `body`, both included, the base left out."""
        chain: list[int] = []
        while body > 0:
            chain.append(body)
            body = self.bodies[body].parent
        return tuple(reversed(chain))


def lump_bodies(mechanism: Mechanism) -> BodyTree:
    """The body tree in the frames of the description: {i} is the joint frame, turned so that z is the axis."""
    index = {joint.name: k for k, joint in enumerate(mechanism.coordinates)}
    bodies = [_base(mechanism)]
    frames = {mechanism.links[0].name: Attachment(0, np.eye(3), np.zeros(3))}
    for joint, link in zip(mechanism.joints, mechanism.links[1:], strict=True):
        place = frames[joint.parent].behind(joint.T_pj)
        inertia = _inertia_of(link.inertial)
        if joint.moves:
            turn = rotation_onto(joint.axis)
            bodies.append(_body(joint, place, turn, inertia.in_frame(turn.T, np.zeros(3)), index))
            frames[link.name] = Attachment(len(bodies) - 1, turn.T, np.zeros(3))
        else:
            frames[link.name] = place
            carrier = bodies[place.body]
            bodies[place.body] = replace(carrier, inertia=carrier.inertia + inertia.in_frame(place.R, place.p))
    R_s0 = mechanism.T_sb[:3, :3]
    return BodyTree(
        n=mechanism.n,
        R_s0=R_s0,
        p_s0=mechanism.T_sb[:3, 3],
        bodies=tuple(bodies),
        frames=frames,
        tip=frames[mechanism.tip].behind(mechanism.T_lt),
        gravity=R_s0.T @ mechanism.gravity,
        links=_link_bodies(mechanism),
        tip_link=mechanism.tip,
        coordinates=tuple(index),
    )


def rotation_onto(axis: Floats) -> Floats:
    """(3, 3) a rotation that takes z onto the unit vector `axis`, exact for the axes of a frame."""
    x, y, z = axis
    if z < 0:
        half_turn_about_x = np.diag([1.0, -1.0, -1.0])
        return half_turn_about_x @ rotation_onto(half_turn_about_x @ axis)
    k = 1.0 / (1.0 + z)
    return np.array([[1 - k * x * x, -k * x * y, x], [-k * x * y, 1 - k * y * y, y], [-x, -y, z]])


def _link_bodies(mechanism: Mechanism) -> tuple[LinkBody, ...]:
    number = {link.name: k for k, link in enumerate(mechanism.links)}
    parents = [-1, *(number[joint.parent] for joint in mechanism.joints)]
    return tuple(
        LinkBody(
            parent,
            np.zeros(3) if link.inertial is None else np.array(link.inertial.com),
            _inertia_of(link.inertial),
        )
        for parent, link in zip(parents, mechanism.links, strict=True)
    )


def _base(mechanism: Mechanism) -> Body:
    inertia = _inertia_of(mechanism.links[0].inertial)
    return Body("", -1, np.eye(3), np.zeros(3), JointKind.FIXED, 0.0, -1, 0.0, 0.0, inertia, 0.0)


def _body(joint: Joint, place: Attachment, turn: Floats, inertia: RigidInertia, index: dict[str, int]) -> Body:
    leader = joint.name if joint.mimic is None else joint.mimic.leader
    return Body(
        joint=joint.name,
        parent=place.body,
        R=place.R @ turn,
        p=place.p,
        kind=joint.kind,
        pitch=joint.pitch,
        coordinate=index[leader],
        multiplier=1.0 if joint.mimic is None else joint.mimic.multiplier,
        offset=0.0 if joint.mimic is None else joint.mimic.offset,
        inertia=inertia,
        armature=0.0 if joint.actuator is None else joint.actuator.reflected_inertia,
        higher=() if joint.mimic is None else joint.mimic.higher,
    )


def _inertia_of(inertial: Inertial | None) -> RigidInertia:
    if inertial is None:
        return RigidInertia.zero()
    return RigidInertia.about_com(inertial.mass, inertial.com, inertial.inertia)


def _steiner(a: Floats, b: Floats) -> Floats:
    """(a . b) E - a b'."""
    return np.dot(a, b) * np.eye(3) - np.outer(a, b)
