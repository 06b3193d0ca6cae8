"""What a set of solutions asks of the question that it answers, and the continua of solutions that it gets."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import JointVector, PoseMatrix
from mafsil.ik.answers.candidate_table import CandidateTable
from mafsil.ik.answers.refusal import Refusal
from mafsil.ik.answers.setting import Setting
from mafsil.ik.result import IKStatus
from mafsil.kernels.lazy import lazy
from mafsil.messages import say


class PoseQuestion(Protocol):
    """One pose for one arm; attributes as of `mafsil.ik.answers.question.Question`."""

    setting: Setting
    T: PoseMatrix
    q0: JointVector
    others: JointVector

    @property
    def start_q0(self) -> JointVector:
        """(n,) where free and locked joints stand."""
        ...

    @property
    def refuted(self) -> bool:
        """Whether it is proven that there is no solution within the limits."""
        ...

    @property
    def tried(self) -> Mapping[str, int]:
        """How many starts were tried by searches."""
        ...

    @lazy
    def verdict(self) -> IKStatus:
        """The status where there is no solution."""
        ...

    @lazy
    def refusal(self) -> Refusal:
        """Why there is no solution, and the nearest pose."""
        ...

    def proven(self, count: int) -> bool:
        """Whether it is proven otherwise than by the closed form that there are so many solutions and no more."""
        ...

    def list_known(self, details: CandidateTable) -> bool:
        """Whether the closed form proves that there are no other solutions than these."""
        ...

    def free_of(self, q: JointVector, details: CandidateTable) -> NDArray[np.int64]:
        """(k,) sum of 2^i over the coordinates that may be chosen, of exact rows of the closed form."""
        ...

    def families(self, q: JointVector, rows: NDArray[np.int64], free: NDArray[np.int64]) -> Iterator[SolutionFamily]:
        """The continuum through each solution that can move while the pose stays."""
        ...


@dataclass(frozen=True, eq=False)
class SolutionFamily:
    """A continuum of solutions.

    Attributes:
        solution: index of the member in the solution set.
        joint: name of the joint that may be chosen.
        moving: names of the joints that move within the family.
        rates: (n,) their rates along the family at the member, that of `joint` one [rad | m per rad | m].
        joints: names of all joints that may be chosen at this solution, `joint` among them; more than one where
            several families cross.
        within: the intervals of `joint` in which the branch is within the limits; see `intervals`.
        follow: solution (n,) with joints at values, by name; NaN where the family does not go so far.
    """

    solution: int
    joint: str
    moving: tuple[str, ...]
    rates: JointVector
    joints: tuple[str, ...]
    follow: Callable[[Mapping[str, float]], JointVector]
    within: Callable[[], tuple[tuple[float, float], ...]] = tuple

    @property
    def intervals(self) -> tuple[tuple[float, float], ...]:
        """Ends of the intervals of `joint` in which the branch of the member is within the joint limits [rad | m].

        Proven but for gaps of 1e-9; known where the arm has an exact closed form once this joint is locked, else empty.
        """
        return self.within()

    def at(self, value: float, **others: float) -> JointVector:
        """(n,) the member with the joint at a value; NaN where the family does not go so far.

        Args:
            value: of `joint` [rad | m].
            others: values of further joints among `joints`, by name.
        """
        return self.follow({self.joint: value, **others})

    def sample(self, values: JointVector) -> JointVector:
        """(k, n) members at many values of the joint.

        Args:
            values: (k,) [rad | m].
        """
        return np.array([self.at(float(value)) for value in values]).reshape(len(values), len(self.rates))

    def relation(self) -> str:
        """How the joints move together near the member, such as `joint4: +1, joint6: -1`."""
        others = [(name, rate) for name, rate in zip(self.moving, self.rates[self.rates != 0.0], strict=True)]
        return ", ".join(f"{name}: {rate:+.6g}" for name, rate in others)


@dataclass(frozen=True)
class LimitExcess:
    """A joint that a solution needs beyond its limit.

    Attributes:
        joint: its name.
        value: what the solution needs.
        limit: what is allowed.
        excess: their distance.
        unit: of the numbers: `rad` or `m`, or `deg` where an answer in degrees was asked for.
    """

    joint: str
    value: float
    limit: float
    excess: float
    unit: str

    def explain(self, language: str | None = None) -> str:
        """The sentence."""
        return say("ik.limit_excess", language=language, **vars(self))


def number_list(numbers: list[int]) -> str:
    """Increasing numbers, runs of three and more as ranges: 1-4, 6, 7."""
    runs = np.split(np.array(numbers), np.flatnonzero(np.diff(numbers) != 1) + 1)
    return ", ".join(f"{run[0]}-{run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs)
