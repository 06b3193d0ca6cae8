"""Parallel robots as descriptions with loops: what jobs and other commands load."""

from __future__ import annotations

from typing import Any

import numpy as np

from mafsil.errors import FileError, InputError
from mafsil.geometry import pose
from mafsil.model import Limits, Mechanism
from mafsil.model.exponentials import frame_on_screw, kind_of_screw
from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import Link
from mafsil.parallel.cables.cable_robot import CableRobot
from mafsil.parallel.legs.leg_library import delta_legs, rod_legs, spherical_legs, stewart_legs
from mafsil.parallel.legs.leg_mechanism import LegMechanism
from mafsil.parallel.legs.rod_library import OnRods, as_rod_robot
from mafsil.parallel.legs.rod_robot import LegDrive
from mafsil.parallel.platforms.delta import DeltaRobot
from mafsil.parallel.platforms.spherical_platform import SphericalPlatform
from mafsil.parallel.platforms.stewart import StewartPlatform
from mafsil.parallel.robot_file import parse_parallel

STROKE = 0.3
"""How far legs and carriages go either way from where they are drawn, as share of the length of legs or rods."""
SWING = 0.5 * np.pi
"""How far cranks turn either way from where they are drawn [rad]."""


def described(data: dict[str, Any], source: str) -> Mechanism:
    """The mechanism of a parallel robot in plain data, without masses and shapes.

    Args:
        data: as `mafsil.parallel.robot_file` reads it.
        source: name for errors.

    Raises:
        FileError: no parallel robot, or one of cables, of an articulated plate, or of no pose with motors at zero.
    """
    robot = parse_parallel(data, source)
    try:
        if isinstance(robot, CableRobot):
            raise InputError("parallel.not_rigid")
        return mechanism_of_parallel(robot, str(data.get("name", data["kind"])))
    except InputError as fault:
        reason = fault.message()
        raise FileError("parallel.not_described", path=source, given=str(data["kind"]), reason=reason) from None


def mechanism_of_parallel(robot: OnRods | SphericalPlatform | LegMechanism, name: str) -> Mechanism:
    """A parallel robot as a description with loops, without masses and shapes; its tip is the platform.

    Args:
        robot: a platform on six legs is drawn level above its base, as high as the base is wide; robots on rods with
            motors at zero, as `rod_legs` says; legs as they are drawn.
        name: of the robot.

    Raises:
        InputError: motors at zero have no pose; a plate that is articulated.
    """
    match robot:
        case StewartPlatform():
            middle, below = robot.base.mean(axis=0), robot.platform.mean(axis=0)
            height = float(np.linalg.norm(robot.base - middle, axis=1).mean())
            T = pose.from_translation(middle - below + [0.0, 0.0, height])
            way = STROKE * float(robot.inverse_kinematics(T).min())
            return mechanism_of_legs(stewart_legs(robot, T), name, Limits(lower=-way, upper=way))
        case DeltaRobot():
            return mechanism_of_legs(delta_legs(robot, 0.0), name, Limits(lower=-SWING, upper=SWING))
        case LegMechanism():
            return mechanism_of_legs(robot, name, Limits())
        case SphericalPlatform():
            return mechanism_of_legs(spherical_legs(robot), name, Limits(lower=-SWING, upper=SWING))
        case _:
            rods = as_rod_robot(robot)
            way = SWING if rods.drive is LegDrive.CRANK else STROKE * (float(rods.rods.min()) or rods.size)
            return mechanism_of_legs(rod_legs(rods), name, Limits(lower=-way, upper=way))


def mechanism_of_legs(drawn: LegMechanism, name: str, driven: Limits) -> Mechanism:
    """A platform on legs as a tree, whose first leg carries the platform, and loops through the last joints of others.

    Args:
        drawn: the legs, at zero coordinates in one pose of the platform.
        name: of the robot.
        driven: limits of the driven joints.
    """
    links, joints, loops, count = [Link("base")], list[Joint](), list[Joint](), 0
    T_platform = np.eye(4)
    for i, leg in enumerate(drawn.legs, start=1):
        parent, T_parent = "base", np.eye(4)
        for k, S in enumerate(leg.screws, start=1):
            kind, direction, pitch = kind_of_screw(S)
            T = frame_on_screw(S, kind, direction, pitch, T_parent[:3, 3])
            last, moved = k == leg.n, count in drawn.driven
            child = "platform" if last and i == 1 else f"leg {i} link {k}"
            joint = Joint(
                f"leg {i} joint {k}", kind, parent, child, pose.inverse(T_parent) @ T, pitch=pitch,
                limits=driven if moved else Limits(), actuated=moved,
            )  # fmt: skip
            links.append(Link(child))
            if last and i == 1:
                T_platform = T
            if last and i > 1:
                held = Joint(f"foot {i}", JointKind.FIXED, "platform", child, pose.inverse(T_platform) @ T)
                joints, loops = [*joints, held], [*loops, joint]
            else:
                joints.append(joint)
            parent, T_parent, count = child, T, count + 1
    T_lt = pose.inverse(T_platform) @ drawn.legs[0].home
    return Mechanism.assemble(name, links, joints, loops=loops, tip="platform", T_lt=T_lt)
