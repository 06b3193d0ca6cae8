"""Numbers as people write them: lengths in metres, angles in radians, poses as matrices, how near a target has to be.

Files may be in millimetres and degrees; an orientation is roll, pitch, yaw or a quaternion, and poses may be those of
things that tools on the flange hold.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, radians
from typing import Any, TypeVar, cast

import msgspec
import numpy as np

from mafsil.arrays import Floats, PoseMatrix, RotationMatrix, Vector3
from mafsil.geometry import rotation
from mafsil.job.language.description import (
    Bounds,
    Collision,
    Goal,
    Grasp,
    Job,
    Obstacle,
    Part,
    Pose,
    SceneFile,
    Step,
    Tolerance,
    Tool,
    Track,
)
from mafsil.job.language.driving_tables import Normal, VariationTable
from mafsil.job.language.part import PathOutput, keys_of
from mafsil.job.language.statements import JobFile, MovableFrame, Pattern, Placed
from mafsil.job.language.surrounding_tables import Door, Guide, Hole, OtherPlace, PathConstraints, Surface
from mafsil.model import Mechanism
from mafsil.model.tolerances import WRITTEN
from mafsil.robot import Robot

LEVEL = 1e-9
"""Horizontal part of a direction of length one below which it is vertical."""
File = TypeVar("File", JobFile, SceneFile)
MILLIMETRE, DEGREE = 1e-3, pi / 180.0
LENGTHS: dict[type[Part], tuple[str, ...]] = {
    Pose: ("position",),
    Placed: ("position", "look_at"),
    OtherPlace: ("position",),
    MovableFrame: ("velocity",),
    Pattern: ("pitch",),
    Grasp: ("size", "offset", "com"),
    Obstacle: ("box", "sphere", "cylinder", "capsule", "cone", "radius", "size", "base"),
    Collision: ("clearance", "self_clearance"),
    Tolerance: ("position",),
    PathConstraints: ("tolerance",),
    Step: ("blend", "clearance", "tip_speed", "tip_acceleration", "tip_jerk"),
    PathOutput: ("distance",),
    Surface: ("point", "sphere", "cylinder"),
    Hole: ("mouth", "clearance", "depth", "chamfer", "peg"),
    Door: ("hinge",),
    Guide: ("point",),
    Tool: ("com", "size", "centre"),
    Bounds: ("tip_speed", "tip_acceleration", "tip_jerk"),
    Track: ("point",),
    VariationTable: ("bound", "payload_offset"),
}
"""Lengths, also per time, of each table and those derived from it; coordinates of joints are converted elsewhere."""
ANGLES: dict[type[Part], tuple[str, ...]] = {
    Bounds: ("tip_angular_speed",),
    MovableFrame: ("angular_speed",),
    Step: ("tip_angular_speed", "joint_speed", "joint_acceleration", "joint_jerk"),
}
"""Angles per time; those of poses, joints and tolerances are converted where they are used."""


def angle_unit(job: Job) -> float:
    """Of angles in the file [rad]."""
    return DEGREE if job.angles == "degrees" else 1.0


def length_unit(job: Job) -> float:
    """Of coordinates of prismatic joints in the file; other lengths are metres already [m]."""
    return MILLIMETRE if job.lengths == "millimetres" else 1.0


def in_si(file: File, data: dict[str, Any]) -> File:
    """The same file with all lengths in metres and angles in radians; coordinates and poses stay as they are.

    Args:
        file: as it was read.
        data: its tables: only keys that stand there are converted, defaults are in these units already.
    """
    if file.lengths == "millimetres":
        file = _scale(file, data, LENGTHS, MILLIMETRE)
    return _scale(file, data, ANGLES, DEGREE) if file.angles == "degrees" else file


def _scale(value: Any, given: Any, table: dict[type[Part], tuple[str, ...]], unit: float) -> Any:
    """What a table names, in all tables inside a value."""
    if isinstance(value, Part):
        named = {name for kind, names in table.items() if isinstance(value, kind) for name in names}
        fields = keys_of(type(value))
        changed = {
            fields[key]: _in_unit(getattr(value, fields[key]), unit)
            if key in named
            else _scale(getattr(value, fields[key]), inner, table, unit)
            for key, inner in given.items()
        }
        return msgspec.structs.replace(value, **changed)
    if isinstance(value, tuple):
        pairs = zip(cast("tuple[Any, ...]", value), given, strict=True)
        return tuple(_scale(each, inner, table, unit) for each, inner in pairs)
    if isinstance(value, dict):
        return {name: _scale(each, given[name], table, unit) for name, each in cast("dict[str, Any]", value).items()}
    return value


def _in_unit(value: Any, unit: float) -> Any:
    if isinstance(value, tuple):
        return tuple(unit * each for each in cast("tuple[float, ...]", value))
    if isinstance(value, Normal):
        return Normal(mean=unit * value.mean, deviation=unit * value.deviation)
    return unit * value


POSITION, ORIENTATION = 1e-3, radians(0.5)
"""Tolerances where the job names none [m, rad]."""


@dataclass(frozen=True, eq=False, slots=True)
class Tolerances:
    """How near a target has to be reached: position [m], orientation [rad], joints (n,) [rad | m]."""

    position: float
    orientation: float
    joints: Floats


def tolerances(job: Job, robot: Robot, move: int | None = None) -> Tolerances:
    """What is allowed at the end of a move: its own tolerance, else the job's, else the defaults.

    Args:
        job, robot: what is asked; the robot with its tool.
        move: index in the job; None for what the job says in general, as for the start.
    """
    degree = angle_unit(job)
    own, general = None if move is None else job.move[move].tolerance, job.tolerance
    position, orientation, joints = (
        getattr(general, name) if own is None or getattr(own, name) is None else getattr(own, name)
        for name in ("position", "orientation", "joints")
    )
    metres = POSITION if position is None else float(position)
    angle = ORIENTATION if orientation is None else degree * float(orientation)
    revolute = robot.mechanism.angular
    if isinstance(joints, tuple):
        return Tolerances(
            metres, angle, np.array(cast("tuple[float, ...]", joints)) * np.where(revolute, degree, length_unit(job))
        )
    turn = angle if joints is None else degree * float(joints)
    return Tolerances(metres, angle, np.where(revolute, turn, metres))


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
