"""Where a branch of solutions ends, why, and what flips when the arm has to go on with another.

Intervals of a path and its legs.

Difficulty 2: stretches of a path on which joints would have to be too fast, or the arm is nearly singular.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.ik import SolutionSet, inverse_kinematics
from mafsil.ik.tolerances import NEARLY_SINGULAR
from mafsil.robot import Robot
from mafsil.trajectory.difficulties.difficulty import (
    BranchChange,
    BranchEnd,
    BranchPart,
    FastStretch,
    PathInterval,
    at_limited_rates,
    conditioning,
    distance_from_path,
    singular_causes,
)
from mafsil.trajectory.difficulties.ladder import INSIDE, Chain, Ladder, shortest
from mafsil.trajectory.paths import TipPath
from mafsil.trajectory.paths.pose_path import PathTask

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


CAUSED_BY_SINGULARITY = 0.02
"""Conditioning below which high rates are put down to the singularity nearby."""
RATE = 1e-9
"""Share of a limit by which a rate at it may exceed it."""


@dataclass(frozen=True, eq=False)
class Piece:
    """A motion along a part of a path without jumps, at samples.

    Attributes:
        robot, path, task: what was asked.
        s: (c,) samples.
        q, rates: (c, n) coordinates, and their derivatives by s.
    """

    robot: Robot
    path: TipPath
    task: PathTask
    s: Floats
    q: JointVector
    rates: Floats


def stretches(piece: Piece, duration: float | None) -> Iterator[FastStretch]:
    """Where rates exceed their limits at constant ds/dt; without a duration where the arm is nearly singular.

    Args:
        piece: a motion without jumps.
        duration: of the whole path [s].
    """
    yield from _singular_stretches(piece) if duration is None else _fast_stretches(piece, duration)


def _singular_stretches(piece: Piece) -> Iterator[FastStretch]:
    """Where the arm is nearly singular; not where that is the edge of its reach, which is a difficulty of its own."""
    robot = piece.robot
    ratios = conditioning(robot, piece.q, piece.task)
    excess = NEARLY_SINGULAR / np.maximum(ratios, LEAST_DIVISOR)
    for a, b in _runs(excess > 1.0):
        at_edge = (a == 0 and piece.s[0] > 0.0) or (b == len(piece.s) - 1 and piece.s[-1] < 1.0)
        if at_edge:
            continue
        k = int(a + excess[a : b + 1].argmax())
        j = int(np.abs(piece.rates[k]).argmax())
        where = place_of(piece.path, _crossing(piece.s, excess, a, -1), _crossing(piece.s, excess, b, 1))
        joint, rate = robot.joint_names[j], float(abs(piece.rates[k, j]))
        causes = singular_causes(robot, piece.q[k], piece.task)
        yield FastStretch(where, joint, float(piece.s[k]), rate, np.inf, float(ratios[k]), causes, np.nan)


def _fast_stretches(piece: Piece, duration: float) -> Iterator[FastStretch]:
    """Where joints are faster than their limits, and by how much the tip leaves the path if they are not."""
    robot = piece.robot
    speeds = np.abs(piece.rates) / duration
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.nan_to_num(speeds / robot.limits.velocity, posinf=np.inf)
    excess = shares.max(axis=1)
    runs = list(_runs(excess > 1.0 + RATE))
    if not runs:
        return
    distance = np.nan
    if len(piece.s) > 1:
        slowed = at_limited_rates(robot, piece.s, piece.q, piece.rates, duration)
        distance = float(distance_from_path(robot, piece.path, slowed).max())
    for a, b in runs:
        k = int(a + excess[a : b + 1].argmax())
        j = int(shares[k].argmax())
        near = float(conditioning(robot, piece.q[k], piece.task))
        causes = singular_causes(robot, piece.q[k], piece.task) if near < CAUSED_BY_SINGULARITY else ()
        where = place_of(piece.path, _crossing(piece.s, excess, a, -1), _crossing(piece.s, excess, b, 1))
        limit = float(robot.limits.velocity[j])
        joint, rate = robot.joint_names[j], float(speeds[k, j])
        yield FastStretch(where, joint, float(piece.s[k]), rate, limit, near, causes, distance)


def _runs(over: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """First and last index of every run of True."""
    padded = np.concatenate([[False], over, [False]])
    ends = np.flatnonzero(padded[1:] != padded[:-1])
    yield from zip(ends[::2].tolist(), (ends[1::2] - 1).tolist(), strict=True)


def _crossing(s: Floats, excess: Floats, k: int, step: int) -> float:
    """Where the excess falls to one beside a sample, on the straight line between samples."""
    other = k + step
    if not 0 <= other < len(s):
        return float(s[k])
    share = (excess[k] - 1.0) / (excess[k] - excess[other])
    return float(s[k] + share * (s[other] - s[k]))
