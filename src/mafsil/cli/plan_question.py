"""What `mafsil plan` is asked for beside the start: where to go, what room that leaves, and what is kept on the way."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from mafsil.arrays import JointVector, PoseMatrix, single
from mafsil.cli import numerals
from mafsil.cli.numerals import number
from mafsil.cli.state import joint_values
from mafsil.cli.typed_pose import PLACES, typed_pose
from mafsil.errors import InputError
from mafsil.geometry import Pose
from mafsil.model import Mechanism
from mafsil.planning import FixedOrientation, GoalRegion, InPlane, OnLine, Upright

Goal: TypeAlias = JointVector | PoseMatrix | Pose | GoalRegion
Kept: TypeAlias = Upright | FixedOrientation | OnLine | InPlane


def rows_of(words: list[str], length: int) -> list[list[str]]:
    """Words in rows of one length; one row of all of them where that does not divide their number."""
    if not words or len(words) % length:
        return [words]
    return [words[k : k + length] for k in range(0, len(words), length)]


def typed_goal(
    goal: list[str], pose: list[str], box: list[str], angle: str | None, mechanism: Mechanism, *, degrees: bool
) -> Goal:
    """One or several configurations or poses, of which any will do; or a region around one pose.

    Args:
        goal: n words, or k n.
        pose: x y z [m] and perhaps roll pitch yaw, or k times all six.
        box: how far the tip may be from the pose along each of its axes: one number or three [m].
        angle: by how much the tip may be turned from it.
        mechanism: the arm.
        degrees: whether bare angles are degrees.

    Raises:
        InputError: no goal or two; a wrong number of words; room around anything but one pose.
    """
    if bool(goal) == bool(pose):
        raise InputError("cli.plan_one_goal")
    if (box or angle is not None) and not (pose and len(pose) in (3, len(PLACES))):
        raise InputError("cli.plan_region")
    if goal:
        rows = [joint_values("goal", row, mechanism, degrees=degrees) for row in rows_of(goal, mechanism.n)]
        return rows[0] if len(rows) == 1 else np.stack(rows)
    poses = [typed_pose("pose", row, degrees=degrees) for row in rows_of(pose, len(PLACES))]
    if box or angle is not None:
        sizes = [number(f"--box[{k}]", word) for k, word in enumerate(box or ["0"])]
        room = sizes[0] if len(sizes) == 1 else single("box", sizes, (3,))
        turn = 0.0 if angle is None else numerals.angle("--angle", angle, degrees=degrees)
        return GoalRegion(poses[0], box=room, angle=turn)
    # An array of four rows could be four configurations of an arm with four joints.
    return Pose(poses[0]) if len(poses) == 1 else np.stack(poses)


def typed_constraints(
    upright: str | None, orientation: bool, line: list[str], plane: list[str], *, degrees: bool
) -> tuple[Kept, ...]:
    """What the path keeps.

    Args:
        upright: largest angle between the tip's z axis and where it points at the start.
        orientation: whether the tip keeps its orientation.
        line: direction of the line that the tip stays on, in {s}.
        plane: normal of the plane that it stays in.
        degrees: whether bare angles are degrees.

    Raises:
        InputError: no three numbers, a direction of length zero, an angle out of range.
    """
    found = list[Kept]()
    if upright is not None:
        found.append(Upright(numerals.angle("--upright", upright, degrees=degrees)))
    if orientation:
        found.append(FixedOrientation())
    if line:
        found.append(OnLine(single("line", [number("--line", word) for word in line], (3,))))
    if plane:
        found.append(InPlane(single("plane", [number("--plane", word) for word in plane], (3,))))
    return tuple(found)
