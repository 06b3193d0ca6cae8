"""`mafsil fk`: where the tip, or any link, is."""

from __future__ import annotations

from math import degrees as to_degrees

import numpy as np

from mafsil.arrays import Floats
from mafsil.cli.answer import Answer, Toned
from mafsil.cli.loops import chain_at
from mafsil.cli.state import degrees_remarks, joint_values
from mafsil.cli.table import matrix, number
from mafsil.messages import say
from mafsil.robot import load


def fk(robot: str, q: list[str], frame: str | None, tip: str | None, degrees: bool) -> Answer:
    """Pose of the tip or of a link in {s}.

    Args:
        robot: name or file.
        q: (n) coordinates as typed.
        frame: a link; the tip frame if None.
        tip: another tip link.
        degrees: whether bare angles are degrees.

    Raises:
        MafsilError: no such robot or frame, not one number per joint.
    """
    arm = load(robot, tip=tip)
    values = joint_values("q", q, arm.mechanism, degrees=degrees)
    if arm.mechanism.loops:
        chain_at(arm, values)
    T = np.asarray(arm.forward_kinematics(values) if frame is None else arm.forward_kinematics(values, frame=frame))
    quaternion, rpy = orientation(T[:3, :3])
    outside = _outside(values, arm.limits.lower, arm.limits.upper, arm.joint_names)
    data = {
        "robot": arm.name,
        "frame": frame or arm.mechanism.tip,
        "q": values,
        "pose": T,
        "position": T[:3, 3],
        "quaternion_wxyz": quaternion,
        "rpy": rpy,
        "outside_limits": outside,
    }
    lines = [say("cli.fk_title", robot=arm.name, frame=frame or say("cli.tip_frame", link=arm.mechanism.tip))]
    lines += matrix(T)
    lines.append(say("cli.fk_position", values="  ".join(number(x) for x in T[:3, 3])))
    lines.append(say("cli.fk_quaternion", values="  ".join(number(x) for x in quaternion)))
    turned = [to_degrees(x) for x in rpy] if degrees else rpy
    lines.append(say("cli.fk_rpy", unit="°" if degrees else "rad", values="  ".join(number(float(x)) for x in turned)))
    lines += [Toned(say("cli.outside", joint=item), "warning") for item in outside]
    lines += degrees_remarks(q, arm.mechanism, degrees=degrees)
    return Answer(data, tuple(lines))


def orientation(R: Floats) -> tuple[Floats, Floats]:
    """Quaternion (w, x, y, z) with w >= 0, and roll, pitch, yaw about fixed x, y, z [rad]."""
    from mafsil.geometry import rotation

    quaternion = np.asarray(rotation.to_quaternion(R))
    return (quaternion if quaternion[0] >= 0 else -quaternion), np.asarray(rotation.to_rpy(R))


def _outside(q: Floats, lower: Floats, upper: Floats, names: tuple[str, ...]) -> list[str]:
    return [name for name, x, a, b in zip(names, q, lower, upper, strict=True) if not a <= x <= b]
