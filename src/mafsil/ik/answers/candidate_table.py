"""What the compiled closed form says of its rows, by name, and what it decides about a pose.

Candidates for the solutions of a pose, and where they come from.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector
from mafsil.ik.answers.branch import UNNAMED


class Decision(IntEnum):
    """What the rows of a closed form decide about a pose; positive numbers are the rows of a clear list, as bits.

    The same numbers stand in `mafsil.mechanics.closed_form.decision`.
    """

    REPEATED = -1
    """The solutions are exact and isolated, but rows may repeat each other."""
    MEETING = -2
    """The solutions are exact, but two branches meet in one of them, or joints of its wrist are free."""
    CAREFUL = -3
    """Rows have to be refined before anything can be said."""
    NONE = -4
    """There is no solution."""
    NO_POSE = -5
    """The matrix is no pose."""


RESIDUAL, CODE, EXCESS = 0, 1, 3
"""Columns of a `ParametricTable`, for the one pose whose call would feel the table's making."""


class ParametricTable(NamedTuple):
    """What is known of the branches of a closed form with given values of its redundant joints.

    Attributes:
        residual: (*batch, rows) error of forward kinematics, distance [m] or angle [rad], the larger.
        code: (*batch, rows) branch as a number, see `mafsil.mechanics.closed_form.table`.
        margin: (*batch, rows) smallest branch margin: zero where two branches meet.
        excess: (*batch, rows) by how much a coordinate is beyond its limits [rad | m].
    """

    residual: Floats
    code: Floats
    margin: Floats
    excess: Floats

    @classmethod
    def of(cls, columns: Floats) -> Self:
        """Views of the kernel's (*batch, rows, 4)."""
        # Of one pose the transpose is the same, and ten times quicker.
        return cls._make(columns.T if columns.ndim == 2 else np.moveaxis(columns, -1, 0))


class ParametricSummary(NamedTuple):
    """What is known of a pose from the branches at given values of the redundant joints.

    Attributes:
        defect: (*batch,) how far the matrix is from a pose.
        doubtful: (*batch,) one if a branch needs refinement.
        folded: (*batch,) one if rounding may have moved a branch far off where two pairs of roots merge.
        excess: (*batch,) the least excess over the limits of a solution [rad | m].
    """

    defect: Floats
    doubtful: Floats
    folded: Floats
    excess: Floats

    @classmethod
    def of(cls, columns: Floats) -> Self:
        """Views of the kernel's (*batch, 4)."""
        return cls._make(np.moveaxis(columns, -1, 0))


class CandidateTable(NamedTuple):
    """What is known of the rows of a closed form.

    Attributes:
        residual: (*batch, rows) error of forward kinematics, distance [m] or angle [rad], the larger.
        subproblem_residual: (*batch, rows) residual of the worst subproblem, zero where all are solved [m | rad].
        free: (*batch, rows) sum of 2^i over the free coordinates.
        code: (*batch, rows) branch as a number, see `mafsil.mechanics.closed_form.table`.
        margin: (*batch, rows) smallest branch margin of the branch: zero where two branches meet.
        excess: (*batch, rows) by how much a coordinate is beyond its limits, negative within [rad | m].
    """

    residual: Floats
    subproblem_residual: Floats
    free: Floats
    code: Floats
    margin: Floats
    excess: Floats

    @classmethod
    def of(cls, columns: Floats) -> Self:
        """Views of the kernel's (*batch, rows, 6)."""
        return cls._make(columns.T if columns.ndim == 2 else np.moveaxis(columns, -1, 0))

    def at(self, index: object) -> Self:
        """Those of some poses."""
        columns: list[Any] = [column[index] for column in self]  # pyright: ignore[reportArgumentType, reportCallIssue]
        return self._make(columns)


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
