"""The same arms put elsewhere: several as one robot, on a movable base or a track, by other frames or senses of joints.

Mounted together, each arm stands on its base pose, and its links and joints are named after it. On a movable base,
three translations and a turn about the vertical come before an arm's joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import PoseMatrix, positive
from mafsil.errors import InputError
from mafsil.geometry.pose import from_translation
from mafsil.model.joint import Joint, JointKind
from mafsil.model.limits import Limits
from mafsil.model.link import Link, fixed_array
from mafsil.model.loading import RobotLike, as_mechanism
from mafsil.model.mechanism import Mechanism
from mafsil.model.placement import checked_pose

PLACES = ("x", "y", "z", "yaw")
"""The coordinates of the base, in order [m, m, m, rad]."""
WORLD = "world"
"""The link that carries all bases; its frame is {s}."""


def mounted_together(arms: Sequence[tuple[str, Mechanism, PoseMatrix]]) -> Mechanism:
    """One mechanism of several: a coordinate vector of all their coordinates, arm after arm.

    1. The first link is the space frame; each base hangs on it by a fixed joint.
    2. Link k of an arm is called "arm/link" and stands at 1 + links of the arms before + k; joints likewise.

    Args:
        arms: name, mechanism, and pose (4, 4) of its base link in {s}; the names differ.
    """
    links, joints, loops = [Link(WORLD)], list[Joint](), list[Joint]()
    for name, mechanism, T_sb in arms:
        links += [replace(link, name=_name(name, link.name)) for link in mechanism.links]
        base = _name(name, mechanism.links[0].name)
        joints.append(Joint(_name(name, "mount"), JointKind.FIXED, WORLD, base, T_sb))  # 1
        joints += [_rename(name, joint) for joint in mechanism.joints]  # 2
        loops += [_rename(name, joint) for joint in mechanism.loops]
    first, mechanism, _ = arms[0]
    return Mechanism.assemble(
        " + ".join(name for name, _, _ in arms), links, joints, loops=loops, tip=_name(first, mechanism.tip),
        T_lt=mechanism.T_lt, gravity=mechanism.gravity,
    )  # fmt: skip


def _name(arm: str, name: str) -> str:
    return f"{arm}/{name}"


def _rename(arm: str, joint: Joint) -> Joint:
    mimic = None if joint.mimic is None else replace(joint.mimic, leader=_name(arm, joint.mimic.leader))
    ends = {"parent": _name(arm, joint.parent), "child": _name(arm, joint.child)}
    return replace(joint, name=_name(arm, joint.name), mimic=mimic, **ends)


def on_movable_base(mechanism: Mechanism) -> Mechanism:
    """The mechanism with coordinates (x, y, z, yaw) of its base in {s} before its own.

    Link k of the mechanism becomes link 4 + k; names stay, those of the base are "base pose/x" and so on.

    Args:
        mechanism: any; its own base pose does not count.
    """
    names = [f"base pose/{name}" for name in ("ground", *PLACES[:3])]
    base = mechanism.links[0].name
    axes = np.eye(3)
    sliding = [
        Joint(f"base pose/move {PLACES[k]}", JointKind.PRISMATIC, names[k], names[k + 1], axis=axes[k])
        for k in range(3)
    ]
    yaw_joint = Joint("base pose/turn", JointKind.REVOLUTE, names[3], base, axis=axes[2], wraps=True)
    return Mechanism.assemble(
        mechanism.name, (*(Link(name) for name in names), *mechanism.links), (*sliding, yaw_joint, *mechanism.joints),
        loops=mechanism.loops, tip=mechanism.tip, T_lt=mechanism.T_lt, gravity=mechanism.gravity,
    )  # fmt: skip


def change_frames(robot: RobotLike, *, base: ArrayLike | None = None, tool: ArrayLike | None = None) -> Mechanism:
    """The arm seen from another fixed frame and by another tool frame: T' = P T Q.

    home' = P home Q, S' = Ad(P) S, B' = Ad(Q^-1) B, J_s' = Ad(P) J_s, J_b' = Ad(Q^-1) J_b. Gravity stays the vector it
    is and gets the components of the new fixed frame.

    Args:
        robot: the arm.
        base: (4, 4) pose P of the old {s} in the new one; the identity if None.
        tool: (4, 4) pose Q of the new tip frame in the old one; the identity if None.
    """
    mechanism = as_mechanism(robot, keeps_loops=True)
    P = np.eye(4) if base is None else checked_pose("base", base)
    Q = np.eye(4) if tool is None else checked_pose("tool", tool)
    return replace(mechanism, T_sb=P @ mechanism.T_sb, T_lt=mechanism.T_lt @ Q, gravity=P[:3, :3] @ mechanism.gravity)


def on_track(robot: RobotLike, direction: ArrayLike, limits: Limits, name: str = "track") -> Mechanism:
    """The arm on a linear axis, its first coordinate: the base moves along a direction, and stands as before at zero.

    Args:
        robot: the arm.
        direction: (3,) of the axis in {s}.
        limits: of its coordinate.
        name: of its joint.

    Raises:
        InputError: a direction of no length.
        ModelError: a joint or link has that name already.
    """
    mechanism = as_mechanism(robot, keeps_loops=True)
    axis, rail = fixed_array("direction", direction, (3,)), Link(f"{name}_base")
    length = positive("length of direction", float(np.linalg.norm(axis)))
    axis = mechanism.T_sb[:3, :3].T @ axis / length
    joint = Joint(name, JointKind.PRISMATIC, rail.name, mechanism.links[0].name, mechanism.T_sb, axis, limits=limits)
    return _carried_by(mechanism, (rail,), (joint,))


def on_turntable(
    robot: RobotLike, axis: ArrayLike, point: ArrayLike, limits: Limits, name: str = "turntable"
) -> Mechanism:
    """The arm on a turntable, its first coordinate: the base turns about an axis, and stands as before at zero.

    Args:
        robot: the arm.
        axis, point: (3,) of the turntable in {s}, and a point on it [m].
        limits: of its coordinate.
        name: of its joint.

    Raises:
        InputError: an axis of no length.
        ModelError: a joint or link has that name already.
    """
    mechanism = as_mechanism(robot, keeps_loops=True)
    direction, centre = fixed_array("axis", axis, (3,)), fixed_array("point", point, (3,))
    direction = direction / positive("length of axis", float(np.linalg.norm(direction)))
    base, disc, T = Link(f"{name}_base"), Link(f"{name}_disc"), np.array(mechanism.T_sb)
    T[:3, 3] -= centre
    turn = Joint(name, JointKind.REVOLUTE, base.name, disc.name, from_translation(centre), direction, limits=limits)
    mount = Joint(f"{name}_mount", JointKind.FIXED, disc.name, mechanism.links[0].name, T)
    return _carried_by(mechanism, (base, disc), (turn, mount))


def _carried_by(mechanism: Mechanism, links: tuple[Link, ...], joints: tuple[Joint, ...]) -> Mechanism:
    """The mechanism on links and joints before its own."""
    return Mechanism.assemble(
        mechanism.name, (*links, *mechanism.links), (*joints, *mechanism.joints), loops=mechanism.loops,
        tip=mechanism.tip, T_lt=mechanism.T_lt, gravity=mechanism.gravity,
        provenance=mechanism.provenance,
    )  # fmt: skip


def with_reversed_joint(robot: RobotLike, name: str) -> Mechanism:
    """The arm with one coordinate counted the other way: S_i -> -S_i, q_i -> -q_i, limits exchanged.

    Its rate and effort change their signs too; joints that follow it, or that it follows, stay where they are.
    Friction that differs between the two senses is exchanged with them; speeds, efforts and inertia of the drive are
    magnitudes and stay.

    Args:
        robot: the arm.
        name: of the joint.

    Raises:
        InputError: no joint of that name, or one that does not move.
    """
    mechanism = as_mechanism(robot, keeps_loops=True)
    moving = [joint.name for joint in (*mechanism.joints, *mechanism.loops) if joint.moves]
    if name not in moving:
        raise InputError("input.choice", name="name", value=name, known=", ".join(moving))
    return replace(
        mechanism,
        joints=tuple(_turn(joint, name) for joint in mechanism.joints),
        loops=tuple(_turn(joint, name) for joint in mechanism.loops),
    )


def _turn(joint: Joint, name: str) -> Joint:
    mimic = joint.mimic
    if mimic is not None and mimic.leader == name:
        joint = replace(joint, mimic=mimic.reverse(leader=True))
    if joint.name != name:
        return joint
    limits = replace(joint.limits, lower=-joint.limits.upper, upper=-joint.limits.lower)
    friction = joint.friction
    if friction is not None:
        friction = replace(friction, offset=-friction.offset)
        if friction.coulomb_negative is not None:
            friction = replace(friction, coulomb=friction.coulomb_negative, coulomb_negative=friction.coulomb)
    if mimic is not None:
        mimic = mimic.reverse(leader=False)
    return replace(joint, axis=-joint.axis, limits=limits, friction=friction, mimic=mimic)
