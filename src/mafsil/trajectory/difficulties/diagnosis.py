"""Can an arm follow a path of its tip? The three difficulties of Cartesian paths, with their places and causes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, positive, single, whole
from mafsil.errors import InputError
from mafsil.ik import SolutionSet, inverse_kinematics
from mafsil.robot import Robot, of_robot
from mafsil.solvers import Outcome
from mafsil.trajectory.difficulties.branch_changes import Piece, branch_change, place_of, stretches
from mafsil.trajectory.difficulties.difficulty import BranchChange, Difficulty, GapReason, UnreachableStretch, redundant
from mafsil.trajectory.difficulties.ladder import (
    INSIDE,
    Chain,
    Ladder,
    PathReach,
    PathReachStatus,
    best_chain,
    reachability,
    solution_ladder,
)
from mafsil.trajectory.paths import TipPath
from mafsil.trajectory.paths.pose_path import PathTask, path_error
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.timing.path_following import follow

SAMPLES = 201

FINER = 8
"""Into how many parts an interval is divided at whose ends the arm jumps, or its rates differ by half."""

ROUNDS = 2

AT_START = 1e-6
"""Pose error at which a start is still the beginning of the path [rad | m]: six digits of a description."""

COARSE = 1e-4
"""Resolution of the reach of redundant arms: whether a pose has a solution takes milliseconds there."""

STARTS = 8
"""Configurations at the beginning from which a redundant arm is led along the path."""


class PathStatus(Status):
    """Whether an arm can follow a path of its tip."""

    FOLLOWABLE = ("trajectory.path_followable", True)
    HAS_DIFFICULTIES = ("trajectory.path_has_difficulties", False)
    IN_DOUBT = ("trajectory.path_in_doubt", False)


@dataclass(frozen=True, eq=False, repr=False)
class PathDiagnosis(Answer, data="s q rates", entries="difficulties"):
    """True if the path can be followed; iterable over its difficulties, in the order of s.

    Attributes:
        robot, path, task, duration: what was asked.
        q_start: (n,) where the arm had to begin; None if that was free.
        reach: intervals out of reach or beyond the limits.
        s: (k,) samples.
        q: (k, n) the solutions of fewest changes, NaN where there is none within the limits [rad | m].
        rates: (k, n) their derivatives by s, the larger of both sides.
        difficulties: what was found.
        followed: the joint path where nothing interrupts it, or why it could not be followed; None where it is
            interrupted.
    """

    robot: Robot
    path: TipPath
    task: PathTask
    duration: float | None
    q_start: JointVector | None
    reach: PathReach
    s: Floats
    q: JointVector
    rates: Floats
    difficulties: tuple[Difficulty, ...]
    followed: Outcome[PiecewisePolynomial | None] | None

    @property
    def status(self) -> PathStatus:
        """FOLLOWABLE only if the joints were led along the whole path."""
        if self.difficulties:
            return PathStatus.HAS_DIFFICULTIES
        return PathStatus.FOLLOWABLE if self.followed else PathStatus.IN_DOUBT

    def explain(self, language: str | None = None) -> str:
        """The verdict, then a line for each difficulty."""
        followed = self.followed
        reason, residual = ("", 0.0) if followed is None else (followed.explain(language), followed.residual)
        lines = [self.status.sentence(language, reason=reason, residual=residual)]
        return "\n".join([*lines, *(each.explain(language) for each in self.difficulties)])

    def to_dict(self) -> dict[str, Any]:
        """Plain data; arrays are those of the answer."""
        return Answer.to_dict(self) | {
            "difficulties": [
                {
                    "kind": type(each).__name__,
                    "begin": each.where.begin,
                    "end": each.where.end,
                    "text": each.explain("en"),
                }
                for each in self.difficulties
            ]
        }


@of_robot
def diagnose_path(
    robot: Robot,
    path: TipPath,
    *,
    task: PathTask = "pose",
    q_start: ArrayLike | None = None,
    duration: float | None = None,
    samples: int = SAMPLES,
) -> PathDiagnosis:
    """Where and why an arm cannot follow a path of its tip: out of reach, too fast, or on another branch.

    1. Intervals that cannot be reached, or only beyond the joint limits, their ends bisected.
    2. A ladder of all solutions of inverse kinematics at samples, and through it the chain of fewest changes of branch;
       intervals at jumps and where rates grow are divided further.
    3. Each jump is a change of branch: why the branch ends, and what flips.
    4. Joint rates at constant ds/dt = 1/duration against their limits; without a duration, where the arm is nearly
       singular. What lies between samples is not seen.
    5. Where nothing interrupts the chain, the joints are led along the path (`follow`): only that makes it followable.

    Redundant arms have continua of solutions and no ladder: they are led along the path by rates of least norm from
    configurations at its beginning. What is found can be done; where it fails, the verdict is IN_DOUBT.

    Args:
        robot: whose tip is to move.
        path: of the tip.
        task: what of the path counts: `pose`, `axis` or `position`.
        q_start: (n,) configuration in which it begins [rad | m]; any solution if None.
        duration: of the path at constant ds/dt [s]; joint rates are judged only with it.
        samples: of the path at first.

    Raises:
        InputError: q_start is not at the beginning of the path, or beyond the joint limits; a duration that is not
            positive; fewer than two samples.

    Reference: Craig, Introduction to Robotics, sec. 7.5: geometric problems with Cartesian paths.
    """
    if task not in get_args(PathTask):
        raise InputError("input.choice", name="task", value=task, known=", ".join(get_args(PathTask)))
    if whole("samples", samples, 0, 1_000_000) < 2:
        raise InputError("trajectory.few_samples", samples=samples)
    T = None if duration is None else positive("duration", duration)
    start = None if q_start is None else single("q_start", q_start, (robot.n,))
    if start is not None:
        _require_start(robot, path, task, start)
    # 1
    slow = redundant(robot, task)
    reach = (
        reachability(robot, path, task=task, samples=max(samples // 8, 2), resolution=COARSE)
        if slow
        else reachability(robot, path, task=task, samples=2 * samples - 1)
    )
    gaps = [_gap(robot, path, task, reach, ends) for ends in (*reach.unreachable, *reach.beyond_limits)]
    if slow:
        s, q, rates, followed = _lead_along(robot, path, task, start, samples)
        changes = list[BranchChange]()
        pieces = [Piece(robot, path, task, s, q, rates)] if followed else []
    else:
        # 2
        ladder, chains = _chains(robot, path, task, start, samples)
        pieces = [piece for chain in chains for piece in _pieces(ladder, chain)]
        s, q, rates = ladder.s, np.full((len(ladder.s), robot.n), np.nan), np.full((len(ladder.s), robot.n), np.nan)
        for chain in chains:
            part = slice(chain.begin, chain.begin + len(chain.q))
            q[part], rates[part] = chain.q, _larger(ladder, chain)
        # 3
        changes = [branch_change(ladder, chain, jump) for chain in chains for jump in chain.jumps]
        one_branch = not gaps and not changes and len(chains) == 1
        # 5
        followed = follow(robot, path, q[0], task=task) if one_branch else None
    # 4
    fast = [stretch for piece in pieces for stretch in stretches(piece, T)]
    found = sorted([*gaps, *changes, *fast], key=lambda each: each.where.begin)
    return PathDiagnosis(robot, path, task, T, start, reach, s, q, rates, tuple(found), followed)


def _require_start(robot: Robot, path: TipPath, task: PathTask, start: Floats) -> None:
    """The configuration is at the beginning of the path and within the limits."""
    error = float(np.abs(path_error(robot.forward_kinematics(start), path.poses(0.0), task)).max())
    if not error <= AT_START:
        raise InputError("trajectory.not_at_start", error=error)
    beyond = np.maximum(robot.limits.lower - start, start - robot.limits.upper)
    if (beyond > INSIDE).any():
        j = int(beyond.argmax())
        raise InputError("trajectory.start_beyond_limits", joint=robot.joint_names[j], value=float(start[j]))


def _gap(
    robot: Robot, path: TipPath, task: PathTask, reach: PathReach, ends: tuple[float, float]
) -> UnreachableStretch:
    """An interval without solutions, or with none within the limits, and what its middle says."""
    answer = inverse_kinematics(robot, path.poses((ends[0] + ends[1]) / 2), task=task)
    assert isinstance(answer, SolutionSet)
    if ends in reach.unreachable:
        kind: GapReason = "unreachable" if reach.status is PathReachStatus.UNREACHABLE else "not_found"
        return UnreachableStretch(place_of(path, *ends), kind, answer)
    joint, excess = "", 0.0
    if len(answer):
        beyond = np.maximum(np.maximum(robot.limits.lower - answer.q, answer.q - robot.limits.upper), 0.0)
        least = beyond[int(beyond.max(axis=1).argmin())]
        joint, excess = robot.joint_names[int(least.argmax())], float(least.max())
    return UnreachableStretch(place_of(path, *ends), "beyond_limits", answer, joint, excess)


def _chains(
    robot: Robot, path: TipPath, task: PathTask, start: JointVector | None, samples: int
) -> tuple[Ladder, list[Chain]]:
    """The ladder, divided further where chains jump or their rates grow, and a chain for every reachable stretch."""
    s = np.union1d(np.linspace(0.0, 1.0, samples), path.breaks)
    for attempt in range(ROUNDS + 1):
        ladder = solution_ladder(robot, path, task, s, start)
        inside = np.concatenate([[False], ladder.within.any(axis=1), [False]])
        ends = np.flatnonzero(inside[1:] != inside[:-1])
        chains = [
            best_chain(ladder, int(a), int(b), start if a == 0 else None)
            for a, b in zip(ends[::2], ends[1::2], strict=True)
        ]
        chains = [_without_folds(chain, ladder) for chain in chains]
        divided = np.unique(
            np.concatenate([_coarse(ladder, chain) for chain in chains] or [np.zeros(0, dtype=np.intp)])
        )
        if attempt == ROUNDS or not len(divided):
            return ladder, chains
        parts = np.arange(1, FINER) / FINER
        s = np.union1d(s, (s[divided][:, None] + parts * np.diff(s)[divided][:, None]).ravel())
    raise AssertionError


def _without_folds(chain: Chain, ladder: Ladder) -> Chain:
    """A chain without the samples at the edge of reach, where branches merge and no rate exists."""
    first = 1 if chain.begin > 0 else 0
    last = len(chain.q) - (1 if chain.begin + len(chain.q) < len(ladder.s) else 0)
    if last - first < 2:
        return chain
    edges = {chain.begin} if first else set[int]()
    edges |= {chain.begin + last - 1} if last < len(chain.q) else set[int]()
    jumps = tuple(jump for jump in chain.jumps if jump not in edges)
    return Chain(chain.begin + first, chain.rows[first:last], chain.q[first:last], jumps)


def _coarse(ladder: Ladder, chain: Chain) -> NDArray[np.intp]:
    """Intervals of the ladder in which a chain jumps, or at whose ends its fastest joint's rates differ by half."""
    size = np.abs(_larger(ladder, chain)).max(axis=1)
    small, large = np.minimum(size[1:], size[:-1]), np.maximum(size[1:], size[:-1])
    grows = np.flatnonzero((large > 1.5 * small) & (large > np.median(size))) + chain.begin
    return np.union1d(grows, np.array(chain.jumps, dtype=np.intp))


def _larger(ladder: Ladder, chain: Chain) -> Floats:
    """(c, n) rates of a chain by s, on the side where they are larger."""
    sample = np.arange(chain.begin, chain.begin + len(chain.rows))
    before, after = ladder.before[sample, chain.rows], ladder.after[sample, chain.rows]
    return np.where(np.abs(after) >= np.abs(before), after, before)


def _pieces(ladder: Ladder, chain: Chain) -> Iterator[Piece]:
    """The parts of a chain between its jumps."""
    cuts = [0, *(jump + 1 - chain.begin for jump in chain.jumps), len(chain.q)]
    rates = _larger(ladder, chain)
    for a, b in pairwise(cuts):
        s = ladder.s[chain.begin + a : chain.begin + b]
        yield Piece(ladder.robot, ladder.path, ladder.task, s, chain.q[a:b], rates[a:b])


def _lead_along(
    robot: Robot, path: TipPath, task: PathTask, start: JointVector | None, samples: int
) -> tuple[Floats, JointVector, Floats, Outcome[PiecewisePolynomial | None]]:
    """A redundant arm led along the path by rates of least norm: samples, coordinates, rates by s, and how it went."""
    s = np.union1d(np.linspace(0.0, 1.0, samples), path.breaks)
    missing = np.full((len(s), robot.n), np.nan)
    first = inverse_kinematics(robot, path.poses(0.0), task=task)
    assert isinstance(first, SolutionSet)
    starts = first.q[first.within][:STARTS] if start is None else start[None]
    failed: Outcome[PiecewisePolynomial | None] = Outcome(None, first.status)
    for q in starts:
        outcome = follow(robot, path, q, task=task)
        if outcome and outcome.value is not None:
            motion = outcome.value.at(s)
            return s, motion.u, motion.v, outcome
        failed = outcome
    return s, missing, missing, failed
