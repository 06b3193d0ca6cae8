"""Frames on the TCPs of other robots: poses in them are poses in {s} once it is known where those robots stand.

1. A move in such a frame, and those after it as far as no signal is waited for, are to where the other robot is when
   the first of them begins.
2. When all robots are planned, the other one has to be there until the last of these moves ends; else the job is
   refused, for the pose would be another one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from msgspec import structs

from mafsil.arrays import JointVector, PoseMatrix
from mafsil.geometry import pose
from mafsil.job.language.description import Goal, Grasp, MovingFrame
from mafsil.job.language.frames import pose_of
from mafsil.job.language.part import Pose
from mafsil.job.language.units import pose_matrix
from mafsil.job.planning.neighbours import Neighbour
from mafsil.job.planning.tip_motion import SHORTEST
from mafsil.job.planning.walk import Walk
from mafsil.job.remark import Refused
from mafsil.job.tolerances import ARRIVED
from mafsil.messages.quantities import quantity

Placed = TypeVar("Placed", Goal, Pose)


@dataclass(frozen=True, eq=False, slots=True)
class _Use:
    """A leg to a pose on another robot: the robot, where it stood, and when the leg ends [s]."""

    leg: int
    robot: Neighbour
    q: JointVector
    end: float


class TipFrames:
    """Plans moves in frames on the TCPs of other robots.

    Args:
        walk: where the robot is.
    """

    def __init__(self, walk: Walk) -> None:
        self.walk = walk
        self.frames = {name: frame for name, frame in walk.job.moving.items() if frame.robot}
        self._where: dict[str, JointVector] = {}
        self._frame_of: dict[int, str] = {}
        self._uses: list[_Use] = []

    def settle(self, index: int) -> None:
        """Give the poses of a move and those after it in {s}, up to the next wait."""
        moves = self.walk.job.move
        if not self.frames or index in self._frame_of or self._frame(moves[index].pose) is None:
            return
        self._where.clear()
        changed = list(moves)
        for k in range(index, len(moves)):
            if moves[k].wait or moves[k].fork is not None or moves[k].skip:
                break
            name, goal = self._frame(moves[k].pose), moves[k].pose
            if name is not None and goal is not None:
                self._frame_of[k] = name
                T = self.pose(name)
                via = tuple(_in_space(one, T) if isinstance(one, Pose) else one for one in moves[k].via)
                changed[k] = structs.replace(moves[k], pose=structs.replace(_in_space(goal, T), carrier=None), via=via)
        self.walk.job = structs.replace(self.walk.job, move=tuple(changed))

    def note(self, index: int, last: int) -> None:
        """The legs of moves index .. last are planned."""
        name = next((self._frame_of[k] for k in range(index, last + 1) if k in self._frame_of), None)
        if name is not None:
            robot = self._robot(self.frames[name])
            self._uses.append(_Use(len(self.walk.legs) - 1, robot, self._where[robot.asked.name], self.walk.past))

    def pose(self, name: str) -> PoseMatrix:
        """(4, 4) in {s} of a frame where its robot stands now, as far as it has come."""
        robot, walk = self._robot(self.frames[name]), self.walk
        key, others = robot.asked.name, walk.others()
        if key not in self._where:
            known = others is not None and not robot.stands
            self._where[key] = others.stand(key, walk.motion(), walk.past) if known and others else robot.start
        T = np.asarray(robot.robot.forward_kinematics(self._where[key]))
        return T @ pose_matrix(self.frames[name].pose, degrees=False)

    def miss(self, part: Grasp, tip: PoseMatrix) -> float | None:
        """Distance from the grip to the part of that name on another robot [m]; None where none is said to be there."""
        names = [name for one, _, name in self.walk.job.lying if one.name == part.name and name in self.frames]
        return min((self.walk.riding[name].miss(part, self._in_tip(name, tip)) or 0.0 for name in names), default=None)

    def take(self, part: Grasp, tip: PoseMatrix) -> None:
        """A part on another robot is taken."""
        for name in self.frames:
            self.walk.riding[name].take(part, self._in_tip(name, tip), -1, self.walk.past)

    def require_still(self) -> None:
        """Refuse the job where the other robot is not where a pose on it was taken from."""
        walk = self.walk
        for use in self._uses:
            start = use.end - walk.legs[use.leg].trajectory.duration
            motion = next((one.motion for one in walk.beside if one.neighbour is use.robot), None)
            since = use.end - SHORTEST if walk.legs[use.leg].kind == "joint" else start
            times = np.linspace(since, use.end, 33)
            away = 0.0 if motion is None else float(np.abs(motion.at(times) - use.q).max())
            if away > ARRIVED:
                details = {"robot": use.robot.name, "time": quantity(use.end, "s")}
                raise Refused("job.frame_robot_moves", move=walk.where(walk.legs[use.leg].index), **details)

    def _in_tip(self, name: str, tip: PoseMatrix) -> PoseMatrix:
        """(4, 4) of a tip as it would be if the frame stood where the file has it: on a TCP in {s}."""
        return pose_matrix(self.frames[name].pose, degrees=False) @ pose.inverse(self.pose(name)) @ tip

    def _frame(self, goal: Goal | None) -> str | None:
        return goal.carrier if goal is not None and goal.carrier in self.frames else None

    def _robot(self, frame: MovingFrame) -> Neighbour:
        return next(each for each in self.walk.neighbours if each.asked.name == frame.robot)


def _in_space(given: Placed, T: PoseMatrix) -> Placed:
    """A pose in a frame that stands at T (4, 4), in {s}."""
    own = pose_of(T @ pose_matrix(given, degrees=False))
    free = given.rpy is None and given.quaternion is None
    return structs.replace(given, position=own.position, rpy=None, quaternion=None if free else own.quaternion)
