"""Where a branch of solutions ends, why, and what flips when the arm has to go on with another.

Intervals of a path and its legs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import JointVector
from mafsil.ik import SolutionSet, inverse_kinematics
from mafsil.trajectory.difficulties.difficulty import BranchChange, BranchEnd, BranchPart, PathInterval
from mafsil.trajectory.difficulties.ladder import INSIDE, Chain, Ladder, shortest
from mafsil.trajectory.difficulties.rates import conditioning, singular_causes
from mafsil.trajectory.paths import TipPath

HALVINGS = 48
"""From the distance of samples to the spacing of floating-point numbers."""
ENDS_SINGULAR = 1e-3
"""Conditioning of the last configuration of a branch below which a singular one ends it: at a fold it falls with the
square root of the distance, and that is rounding after halving."""
APART = 0.5
"""Change of a coordinate [rad | m] within a sample that is no continuation."""


@dataclass(frozen=True, eq=False)
class BranchLimit:
    """Where a branch ends in one direction of a path.

    Attributes:
        sample, row: its last solution within the limits.
        beyond: row of the next sample that continues it beyond the limits; -1 if none does.
    """

    sample: int
    row: int
    beyond: int


def branch_limit(ladder: Ladder, sample: int, row: int, *, forward: bool) -> BranchLimit:
    """Follow the solutions that continue each other as far as they are within the limits.

    Args:
        ladder: all solutions.
        sample, row: where to begin.
        forward: towards s = 1, else towards 0.
    """
    step = 1 if forward else -1
    while 0 <= sample + step < len(ladder.s):
        edges = ladder.continuous(sample) if forward else ladder.continuous(sample - 1).T
        ahead = np.flatnonzero(edges[row])
        if not len(ahead):
            return BranchLimit(sample, row, -1)
        if not ladder.within[sample + step, ahead[0]]:
            return BranchLimit(sample, row, int(ahead[0]))
        sample, row = sample + step, int(ahead[0])
    return BranchLimit(sample, row, -1)


def branch_change(ladder: Ladder, chain: Chain, jump: int) -> BranchChange:
    """What has to change between a sample and the next one of a chain.

    1. How far the branch before goes on, and how far back the branch after begins.
    2. Why the first ends: a joint at its limit, a singular configuration, or neither is found.
    3. What flips: the parts of the branches' names that differ.

    Args:
        ladder: all solutions.
        chain: with a jump after the sample `jump`.
        jump: sample of the ladder.
    """
    robot, i = ladder.robot, jump - chain.begin
    q_before, q_after = chain.q[i], chain.q[i + 1]
    row, new = int(chain.rows[i]), int(chain.rows[i + 1])
    jumps = int(np.abs(q_after - q_before).argmax())
    names = robot.joint_names
    if ladder.continuous(jump)[row, new]:
        # The same branch: only whole turns are lost.
        end = robot.limits.upper if q_before[jumps] > q_after[jumps] else robot.limits.lower
        where = place_of(ladder.path, float(ladder.s[jump]), float(ladder.s[jump + 1]))
        at, limit, near = where.begin, float(end[jumps]), float(conditioning(robot, q_before, ladder.task))
        turn, ends = names[jumps], "limit"
        return BranchChange(where, "turn", turn, q_before, q_after, ends, at, turn, limit, near, ())
    # 1
    last, first = branch_limit(ladder, jump, row, forward=True), branch_limit(ladder, jump + 1, new, forward=False)
    begins_at = limit_place(ladder, first, forward=False)[0] if first.beyond >= 0 else float(ladder.s[first.sample])
    # 2
    ends_at, q_last = fold_place(ladder, last)
    near, joint, limit = float(conditioning(robot, q_last, ladder.task)), "", np.inf
    reason: BranchEnd = "singular" if near < ENDS_SINGULAR else "unknown"
    if last.beyond >= 0:
        ends_at, j, limit = limit_place(ladder, last, forward=True)
        reason, joint = "limit", names[j]
    causes = singular_causes(robot, q_last, ladder.task) if reason == "singular" else ()
    # 3
    part = _part(ladder, (jump, row), (jump + 1, new))
    where = place_of(ladder.path, min(begins_at, ends_at), max(begins_at, ends_at))
    return BranchChange(where, part, names[jumps], q_before, q_after, reason, ends_at, joint, limit, near, causes)


def _part(ladder: Ladder, before: tuple[int, int], after: tuple[int, int]) -> BranchPart:
    """The first of shoulder, elbow and wrist that differs."""
    names = ladder.solutions.branch(*before), ladder.solutions.branch(*after)
    for part in ("shoulder", "elbow", "wrist"):
        if getattr(names[0], part) != getattr(names[1], part):
            return part
    return "other"


def fold_place(ladder: Ladder, end: BranchLimit) -> tuple[float, JointVector]:
    """How far a branch can be continued after its last sample, by halving, and its configuration there.

    Args:
        ladder: all solutions.
        end: of a branch that no solution of the next sample continues.
    """
    a, q_a = float(ladder.s[end.sample]), ladder.q[end.sample, end.row]
    if end.beyond >= 0 or end.sample + 1 >= len(ladder.s):
        return a, q_a
    b = float(ladder.s[end.sample + 1])
    for _ in range(HALVINGS):
        middle = (a + b) / 2
        q = _nearest(ladder, middle, q_a)
        if q is not None and np.abs(q - q_a).max() < APART:
            a, q_a = middle, q
        else:
            b = middle
    return a, q_a


def limit_place(ladder: Ladder, end: BranchLimit, *, forward: bool) -> tuple[float, int, float]:
    """Where a branch reaches a joint limit: s, the joint, and the limit, by halving between samples.

    Args:
        ladder: all solutions.
        end: of a branch that goes on beyond the limits.
        forward: whether s grows towards the limit.
    """
    step = 1 if forward else -1
    limits = ladder.robot.limits
    a, b = float(ladder.s[end.sample]), float(ladder.s[end.sample + step])
    q_a = ladder.q[end.sample, end.row]
    q_b = q_a + shortest(ladder.q[end.sample + step, end.beyond] - q_a, ladder.revolute)
    joint = int(np.maximum(limits.lower - q_b, q_b - limits.upper).argmax())
    limit = float(limits.lower[joint] if q_b[joint] < limits.lower[joint] else limits.upper[joint])
    for _ in range(HALVINGS):
        middle = (a + b) / 2
        q = _nearest(ladder, middle, (q_a + q_b) / 2)
        if q is None:
            break
        if limits.lower[joint] - INSIDE <= q[joint] <= limits.upper[joint] + INSIDE:
            a, q_a = middle, q
        else:
            b, q_b = middle, q
    return (a + b) / 2, joint, limit


def _nearest(ladder: Ladder, s: float, q: JointVector) -> JointVector | None:
    """The solution nearest to a configuration, up to whole turns."""
    found = inverse_kinematics(ladder.robot, ladder.path.poses(s), task=ladder.task)
    if not isinstance(found, SolutionSet) or not len(found):
        return None
    moved = q + shortest(found.q - q, ladder.revolute)
    return moved[int(np.abs(moved - q).max(axis=1).argmin())]


def place_of(path: TipPath, begin: float, end: float) -> PathInterval:
    """An interval with the leg that its middle is on.

    Args:
        path: of the tip.
        begin, end: of s.
    """
    legs = len(path.breaks) - 1
    leg = int(np.clip(np.searchsorted(path.breaks, (begin + end) / 2, side="right"), 1, legs))
    return PathInterval(begin, end, leg, legs)
