"""Moves of all joints of a job together, round what stands in their way: free, keeping something, or with closed loops.

What is to be kept is a constraint of the planner. Where a pose has several configurations, that one is taken in which
the lines after it run. The same questions can be put to planners alone, without the job around them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.collision import ContactPair
from mafsil.errors import JobError
from mafsil.job.language.description import QUICKEST, TIP_PATHS, Bounds, BranchChoice, Goal, Move, Task
from mafsil.job.language.surrounding_tables import PathConstraints
from mafsil.job.language.units import angle_unit, tolerances
from mafsil.job.planning.closed_moves import ClosedMoves
from mafsil.job.planning.equipment import Equipment
from mafsil.job.planning.fitting import coordinates
from mafsil.job.planning.joint_motion import STILL, JointMove, joint_motion, motion_on_path
from mafsil.job.planning.plan import Plan, Timing
from mafsil.job.planning.planned_remarks import SLOW, decided_by
from mafsil.job.planning.surroundings import WayRound
from mafsil.job.planning.tip_moves import TipMoves
from mafsil.job.planning.walk import Walk
from mafsil.job.remark import Refused, Remark
from mafsil.model import JointLimits
from mafsil.planning import FixedOrientation, InPlane, OnLine, Query, Upright
from mafsil.planning.path_constraints import Constraint
from mafsil.trajectory import Trajectory

MOST_CONFIGURATIONS = 8
"""Other configurations of which the lines that follow are tried."""
MOST_FORKS = 3
"""Forks one after the other of which both ways are looked at."""
OtherGoals: TypeAlias = Callable[[], tuple[JointVector, ...]]
"""Configurations (n,) where a planned move may end as well, worked out where they are needed."""
FEW_NODES = 2_000
"""Of the search for a way to one configuration, before others of the same pose may end it as well."""
WIDTH = 1e-3
"""Of lines and planes, where the job names none [m]."""


class JointMoves:
    """Plans moves of the joints.

    Args:
        walk: where the robot is.
    """

    def __init__(self, walk: Walk) -> None:
        self.walk = walk

    def joint_motion(
        self, index: int, goal: JointVector, others: OtherGoals = tuple
    ) -> tuple[Trajectory, Timing, WayRound | None]:
        """All joints together to a goal, through points on the way or round what stands in it; what limits that.

        Args:
            index: of the move.
            goal: (n,) where it ends.
            others: gives (n,) each, where it may end as well if it is planned.
        """
        move, robot, where = self.walk.job.move[index], self.walk.robot, self.walk.where(index)
        way = self.way_round(index, goal, None, others)
        around = None if way is None else way.plan.joint_path()
        ways = [coordinates(self.walk.job, robot, via) for via in move.via if isinstance(via, tuple)]
        points, timed = [self.walk.q, *ways, goal], self.walk.with_profile(move)

        def within(limits: JointLimits) -> JointMove:
            if around is not None:
                return motion_on_path(robot, around, move, limits, where)
            return joint_motion(robot, points, timed, limits, where)

        limits = self.walk.scaled_limits(move)
        planned = within(limits)
        if move.profile is not None or around is not None:
            self.walk.remarks += decided_by(robot, planned.binding, where)

        def again(limits: JointLimits, bounds: Bounds) -> float:
            return within(limits).trajectory.duration

        return planned.trajectory, Timing(limits, self.walk.job.limits, None, again), way

    def goes_round(self, index: int) -> bool:
        """Whether a move may leave the straight way of its joints for one round obstacles."""
        move = self.walk.job.move[index]
        return not move.via and move.profile in (None, *QUICKEST) and self.walk.avoids(index)

    def way_round(
        self, index: int, goal: JointVector, met: ContactPair | None = None, others: OtherGoals = tuple
    ) -> WayRound | None:
        """A way round obstacles; None where the move does not ask for one, or where the straight way is free.

        Args:
            index: of the move.
            goal: (n,) where it ends.
            met: what the way without it meets, where that is no straight way of the joints.
            others: gives (n,) each, where it may end as well if it is planned.
        """
        walk = self.walk
        move, around, where = walk.job.move[index], walk.surroundings, walk.where(index)
        if around is None or not (self.goes_round(index) or move.constraints is not None):
            return None
        clearance, parts = walk.clearance(index, index), walk.parts_in_the_way(index, goal)
        constraints: tuple[Constraint, ...] = ()
        if move.constraints is not None:
            if np.abs(goal - walk.q).max(initial=0.0) < STILL:
                return None
            constraints = constraints_of(move.constraints, walk.load.equipment, angle_unit(walk.job))

        def search(goals: Floats, nodes: int | None = None) -> WayRound | None:
            asked = walk.q, goals, walk.load, clearance, move.planner, met, parts, constraints
            return around.way_round(*asked, nodes=nodes)

        found = search(np.stack([goal, *others()])) if constraints else search(goal, FEW_NODES)
        if found is None:
            return None
        if not found.plan and not constraints:
            again = search(np.stack([goal, *others()]))
            assert again is not None
            found = replace(again, contact=found.contact)
        if not found.plan:
            if constraints:
                raise Refused("job.no_constrained_path", move=where, reason=found.plan)
            raise Refused("job.no_way_round", move=where, reason=found.plan, **found.bodies())
        walk.remarks.append(
            Remark("good", "job.went_round", {"move": where} | found.details())
            if not constraints
            else Remark("good", "job.constrained_path", {"move": where, "kept": found.keeps} | found.details())
        )
        return found


def constraints_of(constraints: PathConstraints, equipment: Equipment, unit: float) -> tuple[Constraint, ...]:
    """Constraints of the tip of the tool that is mounted, in the tip frame of the first one.

    Args:
        constraints: of the move.
        equipment: the tool.
        unit: of angles [rad].
    """
    T = np.asarray(equipment.T_of_first)
    at, width = T[:3, 3], WIDTH if constraints.tolerance is None else constraints.tolerance
    found: list[Constraint] = []
    if constraints.upright is not None:
        found.append(Upright(unit * constraints.upright, axis=T[:3, 2]))
    if constraints.orientation:
        found.append(
            FixedOrientation() if constraints.angle is None else FixedOrientation(tolerance=unit * constraints.angle)
        )
    if constraints.line is not None:
        found.append(OnLine(constraints.line, tolerance=width, at=at))
    if constraints.plane is not None:
        found.append(InPlane(constraints.plane, tolerance=width, at=at))
    return tuple(found)


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


class Configurations:
    """Chooses configurations for poses.

    Args:
        walk: where the robot is.
        tip_moves: plans the lines after a pose.
    """

    def __init__(self, walk: Walk, tip_moves: TipMoves) -> None:
        self.walk, self.tip_moves = walk, tip_moves

    def configuration(self, index: int, goal: Goal, target: PoseMatrix) -> JointVector:
        """Where the joints go for a pose: as before for the same pose, nearby, or so that the lines after it run.

        1. The configuration in which the pose was taken before.
        2. The configuration near the present one, if the move to it meets nothing, or may go round it, and the lines
           that follow from there are possible and not slowed.
        3. Of other configurations, the nearest that is better in that; the best one if none is good.
        """
        if goal.branch is not None:
            return self.on_branch(index, goal.branch, target)
        known = self.walk.goals.taken(target, goal.task)
        if known is not None:
            return known
        allowed = tolerances(self.walk.job, self.walk.robot, None if index < 0 else index)
        nearest = self.walk.goals.configuration(target, goal.task, self.walk.q, allowed, self.walk.where(index))
        best, least = nearest, self.trouble(index, nearest)
        if least <= SLOW:
            return nearest
        for other in self.walk.goals.others(target, goal.task, self.walk.q)[:MOST_CONFIGURATIONS]:
            trouble = self.trouble(index, other)
            if trouble < least:
                best, least = other, trouble
            if least <= SLOW:
                break
        return best

    def others(self, index: int, goal: Goal, target: PoseMatrix) -> tuple[JointVector, ...]:
        """Where a planned move may end as well: not every configuration is reached that way."""
        if goal.branch is not None or self.walk.goals.taken(target, goal.task) is not None:
            return ()
        found = self.walk.goals.others(target, goal.task, self.walk.q)
        if self.walk.job.move[index].constraints is not None:
            return tuple(q for q in found if self.walk.is_free(q, index))
        return tuple(q for q in found[:MOST_CONFIGURATIONS] if self.trouble(index, q) <= SLOW)

    def on_branch(self, index: int, branch: BranchChoice, target: PoseMatrix) -> JointVector:
        """The nearest configuration of a branch that is free, if one of them is."""
        found = self.walk.goals.on_branch(target, branch, self.walk.q, self.walk.where(index))
        free = [q for q in found if self.walk.is_free(q, index)]
        return (free or found)[0]

    def trouble(self, index: int, q: JointVector) -> float:
        """How many times longer than the tip's bounds ask for the worst line after a move takes; inf if impossible."""
        if not self.walk.is_free(q, index) or self.walk.is_blocked(index, q):
            return np.inf
        skip = self.walk.job.move[index].skip if index >= 0 else 0
        return self._worst(index + 1 + skip, q, MOST_FORKS)

    def _worst(self, k: int, q: JointVector, forks: int) -> float:
        """Of the lines from move k on, on each way that the job may go; from a change of tools on other poses count."""
        moves, worst = self.walk.job.move, 1.0
        while k < len(moves):
            move = moves[k]
            if move.fork is not None and forks > 0:
                ways = (k + 1, k + 1 + move.fork.skip)
                return max(worst, *(self._worst(way, q, forks - 1) for way in ways))
            of_tip = move.path in TIP_PATHS and move.pose is not None and not move.carried
            if move.fork is not None or not (move.stays or of_tip):
                break
            if not move.stays:
                first, k = k, self.tip_moves.last(k)
                if any(each.path not in TIP_PATHS for each in moves[first : k + 1]):
                    break
                move = moves[k]
                planned = self.tip_moves.line(first, k, q)
                if isinstance(planned, Refused) or self.walk.meets(first, k, planned.trajectory):
                    return np.inf
                worst = max(worst, planned.factor)
                q = planned.trajectory.at(planned.trajectory.duration).u
            k += 1 + move.skip
        return worst


def queries_of(plan: Plan) -> tuple[Query, ...]:
    """Each move of the joints, from where it begins to where it ends, with what the tool carries then.

    Args:
        plan: of the job.

    Raises:
        JobError: there are no such moves, or nothing stands around the arm.
    """
    found: list[Query] = []
    for leg in plan.legs if plan.surroundings is not None else ():
        q = leg.trajectory.at(np.array([0.0, leg.trajectory.duration])).u
        if leg.kind == "joint" and np.abs(q[1] - q[0]).max() > STILL:
            assert plan.surroundings is not None
            checker = plan.surroundings.checker(leg.load, leg.clearance, leg.parts)
            found.append(Query(leg.name or str(leg.index + 1), checker, q[0], q[1]))
    if not found:
        raise JobError("job.no_free_moves")
    return tuple(found)
