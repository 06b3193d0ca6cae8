"""What a set of solutions asks of the question that it answers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import JointVector, PoseMatrix
from mafsil.ik.answers.candidate_table import CandidateTable
from mafsil.ik.answers.family import SolutionFamily
from mafsil.ik.answers.refusal import Refusal
from mafsil.ik.answers.setting import Setting
from mafsil.ik.result import IKStatus
from mafsil.kernels.lazy import lazy


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
