"""The rows of a batch as `SolutionBatch` has them, and how answers are written into them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, PoseMatrix
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.problem import FARTHEST
from mafsil.ik.status import CODES, IKStatus


class BatchRows:
    """Solutions of k poses in a table of the same number of rows for each.

    Attributes:
        q: (k, rows, n) coordinates.
        valid, within: (k, rows) which rows are solutions, and within the limits.
        residual: (k, rows) by how much they miss.
        codes: (k, rows) branches as numbers.
        free: (k, rows) sum of 2^i over the coordinates that may be chosen.
        status: (k,) index of the status; at first that of no poses.
    """

    def __init__(self, count: int, rows: int, n: int) -> None:
        shape = (count, rows)
        self.q = np.full((*shape, n), np.nan)
        self.residual: Floats = np.full(shape, np.nan)
        self.valid, self.within = np.zeros(shape, dtype=np.bool_), np.zeros(shape, dtype=np.bool_)
        self.codes, self.free = np.zeros(shape, dtype=np.int16), np.zeros(shape, dtype=np.int32)
        self.status = np.full(count, CODES[IKStatus.NOT_A_POSE], dtype=np.int8)

    def set_status(self, which: NDArray[np.bool_] | NDArray[np.intp], status: IKStatus) -> None:
        """Set the status of some poses."""
        self.status[which] = CODES[status]

    def write(self, i: int, answer: SolutionSet) -> None:
        """A careful answer into the rows of its pose, as far as there are any."""
        k = min(len(answer), self.q.shape[1])
        self.q[i, :k], self.residual[i, :k], self.codes[i, :k] = answer.own[:k], answer.residual[:k], answer.codes[:k]
        self.valid[i, :k], self.within[i, :k], self.free[i, :k] = True, answer.within[:k], answer.own_free[:k]
        self.status[i] = CODES[answer.status]

    @property
    def columns(self) -> tuple[NDArray[Any], ...]:
        """Coordinates, solutions, those within the limits, residuals, codes, free coordinates, statuses."""
        return self.q, self.valid, self.within, self.residual, self.codes, self.free, self.status


def finite_poses(T: PoseMatrix) -> PoseMatrix:
    """Rows with NaN, infinities or numbers that would overflow as zeros, which are no poses either.

    Args:
        T: (k, 4, 4).
    """
    finite = np.asarray((np.abs(T) < FARTHEST).all(axis=(1, 2)), dtype=np.bool_)
    return T if finite.all() else np.where(finite[:, None, None], T, 0.0)
