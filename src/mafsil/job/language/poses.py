"""Poses as people write them: position and roll, pitch, yaw, or a quaternion; poses that tools on the flange hold."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, RotationMatrix, Vector3
from mafsil.geometry import rotation
from mafsil.job.language.description import Goal, Grasp, Pose, Tool
from mafsil.model import Mechanism
from mafsil.model.tolerances import WRITTEN

LEVEL = 1e-9
"""Horizontal part of a direction of length one below which it is vertical."""


def pose_matrix(pose: Pose, *, degrees: bool, orientation: Floats | None = None) -> PoseMatrix:
    """(4, 4) matrix of a pose.

    Args:
        pose: of the job file.
        degrees: whether its angles are degrees.
        orientation: (3, 3) taken if the pose says nothing about it; identity if None.
    """
    T = np.eye(4)
    T[:3, 3] = pose.position
    if pose.quaternion is not None:
        T[:3, :3] = rotation.from_quaternion(np.array(pose.quaternion) / np.linalg.norm(pose.quaternion))
    elif pose.rpy is not None:
        T[:3, :3] = rotation.from_rpy(np.radians(pose.rpy) if degrees else np.array(pose.rpy))
    elif orientation is not None:
        T[:3, :3] = orientation
    return T


def facing(direction: Vector3) -> RotationMatrix:
    """(3, 3) orientation with z along a direction and x level: a camera that looks along z sees y downwards.

    Args:
        direction: (3,) of any length; straight up or down x is that of the frame.
    """
    z = direction / np.linalg.norm(direction)
    across = np.array([z[1], -z[0], 0.0])
    x = across / np.linalg.norm(across) if np.linalg.norm(across) > LEVEL else np.array([1.0, 0.0, 0.0])
    y = np.cross(z, x)
    y /= np.linalg.norm(y)
    return np.stack([np.cross(y, z), y, z], axis=1)


def goal_matrix(goal: Goal, here: PoseMatrix, *, degrees: bool) -> PoseMatrix:
    """(4, 4) where a goal is.

    Args:
        goal: of the job; a relative one is a displacement along the axes of the tool or of {s}.
        here: (4, 4) pose of the tip when the move begins: its orientation is taken if the goal names none.
        degrees: whether its angles are degrees.
    """
    if goal.relative is None:
        return pose_matrix(goal, degrees=degrees, orientation=here[:3, :3])
    change = pose_matrix(goal, degrees=degrees)
    if goal.relative == "tool":
        return here @ change
    T = np.array(here)
    T[:3, 3] += change[:3, 3]
    T[:3, :3] = change[:3, :3] @ here[:3, :3]
    return T


def with_tool(mechanism: Mechanism, tool: Tool, *, degrees: bool) -> Mechanism:
    """The mechanism with a tool: another tip frame, one more mass; on the flange, or on the link that the tool names.

    Raises:
        ModelError: the tool's link does not exist.
    """
    offset = None if tool.offset is None else pose_matrix(tool.offset, degrees=degrees)
    return mechanism.with_tool(offset, mass=tool.mass, com=tool.com, link=tool.link)


def part_inertia(grasp: Grasp) -> Floats:
    """(3, 3) rotational inertia of a part about its centre of mass [kg m^2]; of an even box if it names none."""
    if grasp.inertia is None:
        a, b, c = (edge**2 for edge in grasp.size)
        return grasp.mass / 12 * np.diag([b + c, a + c, a + b])
    xx, yy, zz, xy, xz, yz = (*grasp.inertia, 0.0, 0.0, 0.0)[:6]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def centre_of_mass(grasp: Grasp) -> Floats:
    """(3,) of a part, in the tip frame [m]."""
    return np.add(grasp.offset, grasp.com)


def is_possible(grasp: Grasp) -> bool:
    """Whether some body has the inertia of a part: three or six numbers, moments that keep the triangle inequality."""
    if grasp.inertia is not None and len(grasp.inertia) not in (3, 6):
        return False
    moments = np.linalg.eigvalsh(part_inertia(grasp))
    return bool(moments[0] >= 0.0 and moments[0] + moments[1] >= moments[2] * (1.0 - WRITTEN))


def box_in_tip(grasp: Grasp) -> PoseMatrix:
    """(4, 4) pose of the box in the tip frame."""
    T = np.eye(4)
    T[:3, 3] = grasp.offset
    return T
