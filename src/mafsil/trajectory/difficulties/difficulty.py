"""The three difficulties of Cartesian paths as data: places out of reach, high joint rates, changes of branch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from mafsil.arrays import JointVector
from mafsil.ik import SolutionSet
from mafsil.messages import say
from mafsil.messages.quantities import quantity
from mafsil.performance.singularities.axis_cases import SingularityCause

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
