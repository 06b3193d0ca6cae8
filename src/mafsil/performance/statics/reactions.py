"""Equilibrium link by link: the wrench that every joint passes on in an arm at rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, as_batch
from mafsil.errors import InputError
from mafsil.geometry import wrench
from mafsil.model.joint import polynomial
from mafsil.performance.statics.link_loads import LinkLoad
from mafsil.robot import Robot, of_robot


@dataclass(frozen=True, eq=False)
class JointReactions:
    """What each joint of the tree, fixed ones included, passes from its parent link to its child link.

    Attributes:
        joints: names, in the order of `mechanism.joints`.
        about_origin: (*batch, k, 6) wrenches (m, f) on the child, moments about the origin of {s}, axes of {s}.
        at_joint: (*batch, k, 6) the same with moments about the joint frame's origin.
        torque: (*batch, n) their parts along the joint axes: the efforts that hold the arm.
    """

    joints: tuple[str, ...]
    about_origin: Floats
    at_joint: Floats
    torque: JointVector


@of_robot
def joint_reactions(
    robot: Robot, q: ArrayLike, tip_wrench: ArrayLike | None = None, *, loads: Sequence[LinkLoad] = ()
) -> JointReactions:
    """Joint reaction wrenches of a static arm under gravity, loads on its links and a wrench at the tip.

    For every link: reaction of its own joint = reactions it passes on - its weight - its loads (+ what the tip exerts).

    Args:
        robot: the arm.
        q: (*batch, n) joint coordinates [rad | m].
        tip_wrench: (*batch, 6) wrench the tip exerts on the world, in the tip frame [N m, N]; none if None.
        loads: acting on links.
    """
    mechanism = robot.mechanism
    poses = robot.link_poses(q)
    net = [-weight for weight in link_weights(robot, q)]
    for load in loads:
        k = _link_index(mechanism.link_names, load.link)
        net[k] = net[k] - load.about_origin(poses[..., k, :, :])
    if tip_wrench is not None:
        T_ts = np.linalg.inv(robot.forward_kinematics(q))
        tip = mechanism.link_names.index(mechanism.tip)
        net[tip] = net[tip] + wrench.transform(T_ts, tip_wrench)
    for k in reversed(range(len(mechanism.joints))):
        parent = mechanism.parents[k]
        net[parent] = net[parent] + net[k + 1]
    batch = np.broadcast_shapes(*(wrenches.shape for wrenches in net))
    about_origin = np.stack([np.broadcast_to(wrenches, batch) for wrenches in net[1:]], axis=-2)
    points = poses[..., 1:, :3, 3]
    at_joint = about_origin.copy()
    at_joint[..., :3] -= np.cross(points, about_origin[..., 3:])
    return JointReactions(
        tuple(joint.name for joint in mechanism.joints), about_origin, at_joint, _along(robot, q, poses, at_joint)
    )


def _link_index(names: Sequence[str], link: str) -> int:
    if link not in names:
        raise InputError("input.choice", name="link", value=link, known=", ".join(names))
    return list(names).index(link)


@of_robot
def link_weights(robot: Robot, q: ArrayLike) -> list[Floats]:
    """For each link the wrench (*batch, 6) of its weight, moments about the origin of {s}, axes of {s}."""
    mechanism = robot.mechanism
    poses = robot.link_poses(q)
    weights: list[Floats] = []
    for k, link in enumerate(mechanism.links):
        mass, com = (0.0, np.zeros(3)) if link.inertial is None else (link.inertial.mass, link.inertial.com)
        T = poses[..., k, :, :]
        at = T[..., :3, 3] + T[..., :3, :3] @ com
        force = np.broadcast_to(mass * mechanism.gravity, at.shape)
        weights.append(wrench.from_force(np.ascontiguousarray(at), np.ascontiguousarray(force)))
    return weights


@of_robot
def unbalanced_links(robot: Robot, q: ArrayLike, reactions: ArrayLike, tip_wrench: ArrayLike | None = None) -> Floats:
    """(*batch, L - 1, 6) net wrench on every moving link: zero everywhere if the reactions hold the arm.

    The free-body check of given reactions, one sum for each link, all moments about the origin of {s}.

    Args:
        robot: the arm.
        q: (*batch, n) joint coordinates [rad | m].
        reactions: (*batch, k, 6) as `JointReactions.about_origin`.
        tip_wrench: (*batch, 6) wrench the tip exerts on the world, in the tip frame; none if None.
    """
    mechanism = robot.mechanism
    passed = as_batch("reactions", reactions, (len(mechanism.joints), 6))
    net = [passed[..., k, :] + w for k, w in enumerate(link_weights(robot, q)[1:])]
    for k, parent in enumerate(mechanism.parents):
        if parent:
            net[parent - 1] = net[parent - 1] - passed[..., k, :]
    tip = mechanism.link_names.index(mechanism.tip)
    if tip_wrench is not None and tip:
        net[tip - 1] = net[tip - 1] - wrench.transform(np.linalg.inv(robot.forward_kinematics(q)), tip_wrench)
    return np.stack(net, axis=-2)


def _along(robot: Robot, q: ArrayLike, poses: Floats, at_joint: Floats) -> JointVector:
    """Power of each reaction on its joint's screw, summed for joints that follow a coordinate."""
    mechanism = robot.mechanism
    index = {name: i for i, name in enumerate(robot.joint_names)}
    torque = np.zeros((*at_joint.shape[:-2], robot.n))
    for k, joint in enumerate(mechanism.joints):
        if not joint.moves:
            continue
        R = poses[..., k + 1, :3, :3]
        screw = np.concatenate([R @ joint.screw[:3], R @ joint.screw[3:]], axis=-1)
        leader = index[joint.name if joint.mimic is None else joint.mimic.leader]
        factor = 1.0 if joint.mimic is None else polynomial(joint.mimic.curve(1), np.asarray(q)[..., leader])
        torque[..., leader] += factor * (screw * at_joint[..., k, :]).sum(axis=-1)
    return torque
