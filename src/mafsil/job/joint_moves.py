"""Moves of all joints of a job together, round what stands in their way.

What moves of a job keep, as constraints of the planner and in words.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.collision import ContactPair
from mafsil.job.constraint_table import PathConstraints
from mafsil.job.description import QUICKEST, Bounds
from mafsil.job.equipment import Equipment
from mafsil.job.fitting import coordinates
from mafsil.job.joint_motion import STILL, JointMove, joint_motion, motion_on_path
from mafsil.job.language.units import angle_unit
from mafsil.job.planned_remarks import decided_by
from mafsil.job.remark import Refused, Remark
from mafsil.job.surroundings import WayRound
from mafsil.job.timing import Timing
from mafsil.job.walk import Walk
from mafsil.model import JointLimits
from mafsil.planning import FixedOrientation, InPlane, OnLine, Upright
from mafsil.planning.path_constraints import Constraint
from mafsil.trajectory import Trajectory

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
