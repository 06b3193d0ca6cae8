"""Which configuration a pose of a job is taken in, so that the lines after it run."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import JointVector, PoseMatrix
from mafsil.job.description import TIP_PATHS, BranchChoice, Goal
from mafsil.job.planned_remarks import SLOW
from mafsil.job.remark import Refused
from mafsil.job.tip_moves import TipMoves
from mafsil.job.tolerance import tolerances
from mafsil.job.walk import Walk

MOST_CONFIGURATIONS = 8
"""Other configurations of which the lines that follow are tried."""
MOST_FORKS = 3
"""Forks one after the other of which both ways are looked at."""


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
                move = moves[k]
                planned = self.tip_moves.line(first, k, q)
                if isinstance(planned, Refused) or self.walk.meets(first, k, planned.trajectory):
                    return np.inf
                worst = max(worst, planned.factor)
                q = planned.trajectory.at(planned.trajectory.duration).u
            k += 1 + move.skip
        return worst
