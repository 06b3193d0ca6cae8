"""Moves of a mechanism with loops: to joints or poses, with closed loops all the way."""

from __future__ import annotations

from mafsil.arrays import JointVector, PoseMatrix
from mafsil.job.closed_moves import ClosedMoves
from mafsil.job.configurations import MOST_CONFIGURATIONS
from mafsil.job.description import Goal, Move, Task
from mafsil.job.fitting import coordinates
from mafsil.job.joint_moves import JointMoves
from mafsil.job.remark import Refused
from mafsil.job.surroundings import WayRound
from mafsil.job.tolerance import tolerances
from mafsil.job.walk import Walk
from mafsil.trajectory import Trajectory


class ClosedSteps:
    """Plans moves of a mechanism with loops.

    Args:
        walk: where the robot is.
        ways: finds ways round obstacles.
    """

    def __init__(self, walk: Walk, ways: JointMoves) -> None:
        self.walk, self.ways, self.loops = walk, ways, ClosedMoves(walk.robot)

    def go(self, index: int, name: str, move: Move) -> None:
        """One move, to a pose or to joints."""
        if move.pose is not None:
            return self.reach_closed(index, name, move.pose)
        self.walk.goals.forget()
        goal = coordinates(self.walk.job, self.walk.robot, move.joints or ())
        trajectory, way = self.closed_motion(index, goal)
        return self.walk.append(index, name, "joint", trajectory, way=way)

    def reach_closed(self, index: int, name: str, goal: Goal) -> None:
        """To a pose with closed loops: of its configurations the nearest to which there is a motion."""
        target = self.walk.target(goal, self.walk.q)
        known = self.walk.goals.taken(target, goal.task)
        found = [known] if known is not None else self.closed_configurations(index, goal.task, target, self.walk.q)
        refusals: list[Refused] = []
        for q in found[: MOST_CONFIGURATIONS + 1]:
            try:
                trajectory, way = self.closed_motion(index, q)
                self.loops.require_at(trajectory, q, self.walk.where(index))
                self.walk.require_free(index, "joint", trajectory, self.walk.clearance(index, index))
            except Refused as no:
                refusals.append(no)
                continue
            self.walk.append(index, name, "joint", trajectory, None, target, goal.task, way=way)
            return self.walk.note_arrival(index, goal, target)
        raise refusals[0]

    def closed_configurations(self, index: int, task: Task, target: PoseMatrix, near: JointVector) -> list[JointVector]:
        """Configurations with closed loops for a pose, those that meet nothing first, then the nearest."""
        allowed = tolerances(self.walk.job, self.walk.robot, None if index < 0 else index)
        found = self.loops.at_pose(self.walk.robot, target, task, near, allowed, self.walk.where(index))
        around = self.walk.surroundings
        return found if around is None else sorted(found, key=lambda q: not self.walk.is_free(q, index))

    def closed_motion(self, index: int, goal: JointVector) -> tuple[Trajectory, WayRound | None]:
        """The driven joints of a mechanism with loops to a goal, through the points on the way, or round obstacles."""
        move, where = self.walk.job.move[index], self.walk.where(index)
        limits = self.walk.scaled_limits(move)
        ways = [coordinates(self.walk.job, self.walk.robot, via) for via in move.via if isinstance(via, tuple)]
        straight = self.loops.motion(self.walk.q, [*ways, goal], self.walk.with_profile(move), limits, where)
        around = self.walk.surroundings
        if around is None or not (move.constraints is not None or self.ways.goes_round(index)):
            return straight, None
        end, hit = straight.at(straight.duration).u, None
        if move.constraints is None:
            kept, parts = self.walk.clearance(index, index), self.walk.parts_in_the_way(index, end)
            hit = around.first_hit(straight, self.walk.load, kept, parts)
            if hit is None:
                return straight, None
        way = self.ways.way_round(index, end, None if hit is None else hit.contact)
        if way is None:
            return straight, None
        return self.loops.along(self.walk.q, way.plan.joint_path(), move, limits, where), way
