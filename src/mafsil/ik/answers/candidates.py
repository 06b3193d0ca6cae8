"""Candidates for the solutions of a pose, and where they come from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import JointVector
from mafsil.ik.answers.branch import UNNAMED
from mafsil.ik.answers.candidate_table import CandidateTable


@dataclass(frozen=True, eq=False)
class Candidates:
    """Candidates, and where they come from.

    Attributes:
        q: (k, n) coordinates.
        rows: (k,) row of the closed form's table, -1 if found otherwise.
        codes: (k,) branch of each as a number.
        free: (k,) sum of 2^i over the free coordinates.
    """

    q: JointVector
    rows: NDArray[np.int64]
    codes: NDArray[np.int64]
    free: NDArray[np.int64]

    def chosen(self, which: NDArray[np.intp] | list[int], q: JointVector) -> Candidates:
        """Some of them, with new coordinates for all."""
        return Candidates(q[which], self.rows[which], self.codes[which], self.free[which])

    def and_more(self, other: Candidates) -> Candidates:
        """They, and others."""
        return Candidates(
            np.concatenate([self.q, other.q]),
            np.concatenate([self.rows, other.rows]),
            np.concatenate([self.codes, other.codes]),
            np.concatenate([self.free, other.free]),
        )

    @classmethod
    def of(cls, q: JointVector, details: CandidateTable, rows: NDArray[np.int64]) -> Candidates:
        """Rows of the closed form with their details."""
        codes, free = (np.nan_to_num(x).astype(np.int64) for x in (details.code, details.free))
        return cls(q, rows, codes, free)


def without_branch(q: JointVector) -> Candidates:
    """Candidates without a branch."""
    k = len(q)
    return Candidates(q, np.full(k, -1), np.full(k, UNNAMED), np.zeros(k, dtype=np.int64))
