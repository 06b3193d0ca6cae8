"""Can an arm follow a path of its tip? The three difficulties of Cartesian paths, with their places and causes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, positive, single
from mafsil.errors import InputError
from mafsil.ik import SolutionSet, inverse_kinematics
from mafsil.ik.tolerances import NEARLY_SINGULAR
from mafsil.messages.tables import on_screen
from mafsil.robot import Robot, of_robot
from mafsil.solvers import Outcome
from mafsil.trajectory.difficulties.branch_changes import branch_change
from mafsil.trajectory.difficulties.difficulty import Difficulty, FastStretch, GapReason, UnreachableStretch
from mafsil.trajectory.difficulties.ladder import Chain, Ladder, best_chain, solution_ladder
from mafsil.trajectory.difficulties.places import place_of
from mafsil.trajectory.difficulties.rates import at_limited_rates, conditioning, distance_from_path, singular_causes
from mafsil.trajectory.difficulties.reachability import PathReach, PathReachStatus, reachability
from mafsil.trajectory.path_following import follow
from mafsil.trajectory.path_task import PathTask, path_error
from mafsil.trajectory.paths import TipPath
from mafsil.trajectory.piecewise import PiecewisePolynomial

SAMPLES = 201

FINER = 8
"""Into how many parts an interval is divided at whose ends the arm jumps, or its rates differ by half."""

ROUNDS = 2

AT_START = 1e-6
"""Pose error at which a start is still the beginning of the path [rad | m]: six digits of a description."""

CAUSED_BY_SINGULARITY = 0.02
"""Conditioning below which high rates are put down to the singularity nearby."""

RATE = 1e-9
"""Share of a limit by which a rate at it may exceed it."""


class PathStatus(Status):
    """Whether an arm can follow a path of its tip."""

    FOLLOWABLE = ("trajectory.path_followable", True)
    HAS_DIFFICULTIES = ("trajectory.path_has_difficulties", False)
    IN_DOUBT = ("trajectory.path_in_doubt", False)


@dataclass(frozen=True, eq=False, repr=False)
class PathDiagnosis(Answer):
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

    def __bool__(self) -> bool:
        return self.status.succeeded

    def __len__(self) -> int:
        return len(self.difficulties)

    def __iter__(self) -> Iterator[Difficulty]:
        return iter(self.difficulties)

    def __repr__(self) -> str:
        return on_screen(self.explain())

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
        return {
            "status": self.status.name,
            "difficulties": [
                {
                    "kind": type(each).__name__,
                    "begin": each.where.begin,
                    "end": each.where.end,
                    "text": each.explain("en"),
                }
                for each in self.difficulties
            ],
            "s": self.s,
            "q": self.q,
            "rates": self.rates,
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

    Redundant arms are looked at with their locked joint where inverse kinematics has it: what is found can be done,
    but other motions may be better.

    Args:
        robot: whose tip is to move.
        path: of the tip.
        task: what of the path counts: `pose`, `axis` or `position`.
        q_start: (n,) configuration in which it begins [rad | m]; any solution if None.
        duration: of the path at constant ds/dt [s]; joint rates are judged only with it.
        samples: of the path at first.

    Raises:
        InputError: q_start is not at the beginning of the path, a duration that is not positive, too few samples.

    Reference: Craig, Introduction to Robotics, sec. 7.5: geometric problems with Cartesian paths.
    """
    T = None if duration is None else positive("duration", duration)
    start = None if q_start is None else single("q_start", q_start, (robot.n,))
    if start is not None:
        error = float(np.abs(path_error(robot.forward_kinematics(start), path.poses(0.0), task)).max())
        if not error <= AT_START:
            raise InputError("trajectory.not_at_start", error=error)
    # 1
    reach = reachability(robot, path, task=task, samples=2 * samples - 1)
    gaps = [_gap(robot, path, task, reach, ends) for ends in (*reach.unreachable, *reach.beyond_limits)]
    # 2
    ladder, chains = _chains(robot, path, task, start, samples)
    q, rates = np.full((len(ladder.s), robot.n), np.nan), np.full((len(ladder.s), robot.n), np.nan)
    for chain in chains:
        part = slice(chain.begin, chain.begin + len(chain.q))
        q[part], rates[part] = chain.q, _larger(ladder, chain)
    # 3
    changes = [branch_change(ladder, chain, jump) for chain in chains for jump in chain.jumps]
    # 4
    fast = [stretch for chain in chains for stretch in _fast(ladder, chain, T)]
    # 5
    followed = None
    if not gaps and not changes and len(chains) == 1:
        followed = follow(robot, path, q[0], task=task)
    found = sorted([*gaps, *changes, *fast], key=lambda each: each.where.begin)
    return PathDiagnosis(robot, path, task, T, start, reach, ladder.s, q, rates, tuple(found), followed)


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
        ladder = solution_ladder(robot, path, task, s)
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


def _fast(ladder: Ladder, chain: Chain, duration: float | None) -> Iterator[FastStretch]:
    """Stretches of every piece between jumps with rates beyond their limits, or nearly singular without a duration."""
    cuts = [0, *(jump + 1 - chain.begin for jump in chain.jumps), len(chain.q)]
    rates = _larger(ladder, chain)
    for a, b in pairwise(cuts):
        s = ladder.s[chain.begin + a : chain.begin + b]
        piece = Piece(ladder, s, chain.q[a:b], rates[a:b])
        yield from _singular_stretches(piece) if duration is None else _fast_stretches(piece, duration)


@dataclass(frozen=True, eq=False)
class Piece:
    """Samples of a chain between two jumps: places (c,), coordinates and rates by s (c, n)."""

    ladder: Ladder
    s: Floats
    q: JointVector
    rates: Floats


def _singular_stretches(piece: Piece) -> Iterator[FastStretch]:
    """Where the arm is nearly singular; not where that is the edge of its reach, which is a difficulty of its own."""
    ladder, robot = piece.ladder, piece.ladder.robot
    ratios = conditioning(robot, piece.q, ladder.task)
    excess = NEARLY_SINGULAR / np.maximum(ratios, 1e-300)
    for a, b in _runs(excess > 1.0):
        at_edge = (a == 0 and piece.s[0] > 0.0) or (b == len(piece.s) - 1 and piece.s[-1] < 1.0)
        if at_edge:
            continue
        k = int(a + excess[a : b + 1].argmax())
        j = int(np.abs(piece.rates[k]).argmax())
        where = place_of(ladder.path, _crossing(piece.s, excess, a, -1), _crossing(piece.s, excess, b, 1))
        joint, rate = robot.joint_names[j], float(abs(piece.rates[k, j]))
        causes = singular_causes(robot, piece.q[k], ladder.task)
        yield FastStretch(where, joint, float(piece.s[k]), rate, np.inf, float(ratios[k]), causes, np.nan)


def _fast_stretches(piece: Piece, duration: float) -> Iterator[FastStretch]:
    """Where joints are faster than their limits, and by how much the tip leaves the path if they are not."""
    ladder, robot = piece.ladder, piece.ladder.robot
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
        distance = float(distance_from_path(robot, ladder.path, slowed).max())
    for a, b in runs:
        k = int(a + excess[a : b + 1].argmax())
        j = int(shares[k].argmax())
        near = float(conditioning(robot, piece.q[k], ladder.task))
        causes = singular_causes(robot, piece.q[k], ladder.task) if near < CAUSED_BY_SINGULARITY else ()
        where = place_of(ladder.path, _crossing(piece.s, excess, a, -1), _crossing(piece.s, excess, b, 1))
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
