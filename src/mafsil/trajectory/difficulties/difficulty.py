"""The three difficulties of Cartesian paths as data, and the joint rates along a path that the second is read from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.ik import SolutionSet
from mafsil.messages import say
from mafsil.messages.quantities import quantity
from mafsil.performance import generic_rank, singular_values
from mafsil.performance.singularities.axis_cases import SingularityCause
from mafsil.performance.singularities.ranks import default_task
from mafsil.performance.singularities.singular_configuration import singularity
from mafsil.robot import Robot
from mafsil.trajectory.paths import TipPath
from mafsil.trajectory.paths.pose_path import PathTask

STEPS = 2000
"""Steps in time of an arm whose rates stay within their limits."""
PLACES = 2001
"""Places of the path to which distances are measured."""
AT_ONCE = 256
"""Points that are compared with all places of a way at once, in 12 MB."""
SLACK = 1.01
"""Factor on the conditioning of a configuration at which it counts as singular, to ask for the cause."""
GapReason = Literal["unreachable", "not_found", "beyond_limits"]
BranchPart = Literal["shoulder", "elbow", "wrist", "turn", "other"]
BranchEnd = Literal["limit", "singular", "unknown"]


@dataclass(frozen=True, slots=True)
class PathInterval:
    """An interval of a path.

    Attributes:
        begin, end: of s.
        leg, legs: which smooth part of how many, counted from 1.
    """

    begin: float
    end: float
    leg: int = 1
    legs: int = 1

    def explain(self, language: str | None = None) -> str:
        """The interval in words."""
        words = say("trajectory.place_between", language=language, begin=self.begin, end=self.end)
        leg = say("trajectory.place_leg", language=language, leg=self.leg, legs=self.legs) if self.legs > 1 else ""
        return words + leg


@dataclass(frozen=True, eq=False, slots=True)
class UnreachableStretch:
    """Difficulty 1: between reachable places, or at an end, some that are not.

    Attributes:
        where: open interval of s.
        kind: `unreachable` is proven at every place looked at, `not_found` by no search, `beyond_limits` where every
            solution is beyond the limits.
        answer: what inverse kinematics says of its middle.
        joint, excess: the least excess over the joint limits in its middle [rad | m]; empty otherwise.
    """

    where: PathInterval
    kind: GapReason
    answer: SolutionSet
    joint: str = ""
    excess: float = 0.0

    def explain(self, language: str | None = None) -> str:
        """The interval and the reason."""
        return say(
            f"trajectory.difficulty_{self.kind}",
            language=language,
            place=self.where.explain(language),
            reason=self.answer.explain(language).split("\n")[0],
            joint=self.joint,
            excess=self.excess,
        )


@dataclass(frozen=True, eq=False, slots=True)
class FastStretch:
    """Difficulty 2: joints faster than they can be, or the arm nearly singular.

    Attributes:
        where: interval of s.
        joint: that exceeds its limit most; that changes most where no duration is given.
        at: place of its largest rate among those looked at.
        rate: there [rad/s | m/s]; by s where no duration is given.
        limit: of the rate; infinite where no duration is given.
        conditioning: of the configuration there, smallest over largest singular value.
        causes: which axes are nearly dependent there, if it is nearly singular.
        distance: by how much the tip leaves the path if joints stay within their limits of velocity [m].
    """

    where: PathInterval
    joint: str
    at: float
    rate: float
    limit: float
    conditioning: float
    causes: tuple[SingularityCause, ...]
    distance: float

    def explain(self, language: str | None = None) -> str:
        """Interval, joint, numbers and geometric cause."""
        kind = "fast" if self.limit < float("inf") else "singular"
        sentence = say(
            f"trajectory.difficulty_{kind}",
            language=language,
            place=self.where.explain(language),
            joint=self.joint,
            at=self.at,
            rate=self.rate,
            limit=self.limit,
            conditioning=self.conditioning,
            distance=quantity(self.distance, "m"),
        )
        return sentence + "".join(
            say("trajectory.because", language=language, cause=cause.sentence(language)) for cause in self.causes
        )


@dataclass(frozen=True, eq=False, slots=True)
class BranchChange:
    """Difficulty 3: what comes before and what comes after can be reached, but in different solutions.

    Attributes:
        where: interval of s in which both solutions exist: the change has to be made there.
        part: what of the arm is on the other side afterwards; `turn` where a joint runs out of whole turns.
        joint: that jumps most.
        q_before, q_after: (n,) on both branches at the sample where the least change leads over [rad | m].
        end: why the first branch ends.
        ends_at: where.
        end_joint, limit: the joint that reaches its limit, and the limit.
        conditioning: of the last configuration of the first branch.
        causes: which axes are nearly dependent there, if that ends it.
    """

    where: PathInterval
    part: BranchPart
    joint: str
    q_before: JointVector
    q_after: JointVector
    end: BranchEnd
    ends_at: float
    end_joint: str
    limit: float
    conditioning: float
    causes: tuple[SingularityCause, ...]

    @property
    def jump(self) -> float:
        """Largest change of a coordinate [rad | m]."""
        return float(abs(self.q_after - self.q_before).max())

    def explain(self, language: str | None = None) -> str:
        """Interval, what flips, which joint jumps, and what ends the branch."""
        ends = {"limit": "ends_at_limit", "singular": "ends_singular", "unknown": "ends_unknown"}[self.end]
        reason = say(
            f"trajectory.{ends}",
            language=language,
            place=self.ends_at,
            joint=self.end_joint,
            limit=self.limit,
            conditioning=self.conditioning,
        )
        reason += "".join(
            say("trajectory.because", language=language, cause=cause.sentence(language)) for cause in self.causes
        )
        return say(
            "trajectory.difficulty_branch",
            language=language,
            place=self.where.explain(language),
            change=say(f"trajectory.change_{self.part}", language=language),
            joint=self.joint,
            jump=self.jump,
            reason=reason,
        )


Difficulty = UnreachableStretch | FastStretch | BranchChange


def judged_task(robot: Robot, task: PathTask) -> str | None:
    """The rows by which performance judges a task; None where a path's task is none of them.

    Args:
        robot: any arm.
        task: of a path.
    """
    if task == "axis":
        return None
    own = default_task(robot)
    flat = {"position": ("planar_position",), "pose": ("planar", "schoenflies")}[task]
    return own if own in flat else task


def redundant(robot: Robot, task: PathTask) -> bool:
    """Whether the arm has more joints than what counts needs.

    Args:
        robot: any arm.
        task: of a path.
    """
    rows = judged_task(robot, task)
    return robot.n > (5 if rows is None else generic_rank(robot, task=rows))


def conditioning(robot: Robot, q: JointVector, task: PathTask) -> Floats:
    """(*batch,) smallest over largest singular value of what counts, without units; NaN for the task `axis`.

    Args:
        robot: any arm.
        q: (*batch, n) configurations.
        task: what counts.
    """
    rows = judged_task(robot, task)
    if rows is None:
        return np.full(q.shape[:-1], np.nan)
    values, rank = singular_values(robot, q, task=rows), generic_rank(robot, task=rows)
    return values[..., rank - 1] / values[..., 0]


def singular_causes(robot: Robot, q: JointVector, task: PathTask) -> tuple[SingularityCause, ...]:
    """Which axes become dependent near a configuration, and their geometry.

    Args:
        robot: any arm.
        q: (n,) nearly singular.
        task: what counts.
    """
    rows, near = judged_task(robot, task), float(conditioning(robot, q, task))
    if rows is None or not near < 1.0 / SLACK:
        return ()
    return singularity(robot, q, task=rows, tolerance=max(SLACK * near, 1e-9)).causes


def distance_from_path(robot: Robot, path: TipPath, q: JointVector) -> Floats:
    """(k,) distances of the tip from the way of the path's origin [m].

    Args:
        robot: whose tip.
        path: of the tip.
        q: (k, n) configurations.
    """
    tip = robot.forward_kinematics(q)[:, :3, 3]
    way = path.poses(np.linspace(0.0, 1.0, PLACES))[:, :3, 3]
    near = np.concatenate(
        [
            ((way - some[:, None]) ** 2).sum(axis=-1).argmin(axis=1)
            for some in np.array_split(tip, len(tip) // AT_ONCE + 1)
        ]
    )
    sides = [_to_segments(tip, way[np.maximum(near - 1, 0)], way[near])]
    sides.append(_to_segments(tip, way[near], way[np.minimum(near + 1, len(way) - 1)]))
    return np.minimum(*sides)


def _to_segments(points: Floats, a: Floats, b: Floats) -> Floats:
    """(k,) distances of points from the segments from a to b, (k, 3) each."""
    along, since = b - a, points - a
    share = (since * along).sum(axis=1) / np.maximum((along * along).sum(axis=1), LEAST_DIVISOR)
    return np.linalg.norm(since - np.clip(share, 0.0, 1.0)[:, None] * along, axis=1)


def at_limited_rates(robot: Robot, s: Floats, q: JointVector, rates: Floats, duration: float) -> Floats:
    """(steps, n) configurations of an arm that goes after a joint path at constant ds/dt, no joint beyond its rate.

    Args:
        robot: gives the limits of velocity.
        s: (k,) increasing places.
        q, rates: (k, n) coordinates there, and their derivatives by s.
        duration: of the whole path, s from 0 to 1 [s].
    """
    places: Floats = np.linspace(float(s[0]), float(s[-1]), STEPS + 1)
    aim = _hermite(s, q, rates, places)
    most = robot.limits.velocity * duration * float(places[1] - places[0])
    found = aim.copy()
    for k in range(1, len(places)):
        found[k] = found[k - 1] + np.clip(aim[k] - found[k - 1], -most, most)
    return found


def _hermite(s: Floats, q: JointVector, rates: Floats, at: Floats) -> Floats:
    """Cubics between samples."""
    i = np.clip(np.searchsorted(s, at, side="right") - 1, 0, len(s) - 2)
    h = s[i + 1] - s[i]
    x = ((at - s[i]) / h)[:, None]
    h = h[:, None]
    return (
        (1 + 2 * x) * (1 - x) ** 2 * q[i]
        + x**2 * (3 - 2 * x) * q[i + 1]
        + h * x * (1 - x) * ((1 - x) * rates[i] - x * rates[i + 1])
    )
