"""Weighted least squares over long logs: one small triangular factor per joint stands for all of its rows."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.identification.tolerances import LEAST_NOISE, LEAST_SHARE, NO_EFFORT

ROUNDS = 4
"""Times the noise of the joints is estimated again with the parameters found."""
GUESSED_NOISE = 0.05
"""Noise as a share of the efforts, while there are fewer rows than parameters."""


@dataclass(frozen=True, eq=False, slots=True)
class RegressorStack:
    """The rows of each joint's equations, rotated into a triangle: |R_j (b, -1)| = |Y_j b - tau_j| for every b.

    Attributes:
        triangles: (n, k + 1, k + 1).
        rows: how many rows each joint has.
    """

    triangles: Floats
    rows: int

    @classmethod
    def of(cls, blocks: Iterable[Floats], n: int, k: int) -> RegressorStack:
        """Take in blocks (rows, n, k + 1) one after the other; memory stays that of a block."""
        triangles, rows = np.zeros((n, k + 1, k + 1)), 0
        for block in blocks:
            rows += len(block)
            for j in range(n):
                triangles[j] = _triangle(np.vstack([triangles[j], block[:, j]]))
        return cls(triangles, rows)

    def residual(self, b: Floats) -> Floats:
        """(n,) root mean square of each joint's residual [N m | N] with the base parameters b (k,)."""
        left = self.triangles @ np.append(b, -1.0)
        return np.sqrt((left**2).sum(axis=1) / max(self.rows, 1))

    def effort(self) -> Floats:
        """(n,) root mean square of each joint's efforts [N m | N]."""
        return np.sqrt((self.triangles[..., -1] ** 2).sum(axis=1) / max(self.rows, 1))

    def own_noise(self) -> Floats:
        """(n,) standard deviation that no parameters whatever could explain, each joint by itself [N m | N]."""
        k = self.triangles.shape[-1] - 1
        if self.rows <= k:
            return GUESSED_NOISE * self.effort()
        return np.abs(self.triangles[:, -1, -1]) / np.sqrt(self.rows - k)

    def size(self) -> Floats:
        """(n, k) root mean square of every column in each joint's rows."""
        return np.sqrt((self.triangles[..., :-1] ** 2).sum(axis=1) / max(self.rows, 1))

    def reduce_columns(self, columns: NDArray[np.int64], known: Floats) -> RegressorStack:
        """The same rows with fewer columns, what is known subtracted from the efforts.

        Args:
            columns: places of the columns that stay.
            known: (k,) base parameters whose efforts are known.
        """
        rest = self.triangles[..., -1] - self.triangles[..., :-1] @ known
        left = np.concatenate([self.triangles[..., columns], rest[..., None]], axis=-1)
        return RegressorStack(np.stack([_triangle(part) for part in left]), self.rows)

    def weighted_triangle(self, noise: Floats) -> Floats:
        """(k + 1, k + 1) the triangle of all joints together, rows divided by the joints' noise (n,)."""
        k = self.triangles.shape[-1]
        return _triangle((self.triangles / noise[:, None, None]).reshape(-1, k))


def _triangle(rows: Floats) -> Floats:
    """(k, k) R with R' R = rows' rows, for at least k rows (N, k)."""
    R: Any = np.linalg.qr(rows, mode="r")
    return np.asarray(R, dtype=np.float64)


@dataclass(frozen=True, eq=False, slots=True)
class Fit:
    """Base parameters that the rows ask for.

    Attributes:
        b: (k,) values; directions that the rows do not identify keep the prior's values.
        covariance: (k, k); what the rows do not identify has the prior's variance.
        noise: (n,) standard deviation of a row of each joint [N m | N].
        triangle: (k + 1, k + 1) the weighted rows.
        strengths: singular values: how many times smaller than the prior's the error of a direction becomes.
        identifiable_count: how many directions the rows identify.
        condition_number: of the weighted columns, each scaled to length one.
    """

    b: Floats
    covariance: Floats
    noise: Floats
    triangle: Floats
    strengths: Floats
    identifiable_count: int
    condition_number: float

    @property
    def standard_errors(self) -> Floats:
        """(k,)."""
        return np.sqrt(np.diag(self.covariance))


def fit_base_parameters(stack: RegressorStack, b0: Floats, spread: Floats) -> Fit:
    """Estimate base parameters and the joints' noise in turn.

    b = b0 + B x; directions x whose error exceeds |x| = 1, that of the prior, keep x = 0.

    Args:
        stack: the rows.
        b0: (k,) of the prior.
        spread: B (k, p), a square root of the prior's covariance.
    """
    k, b = len(b0), b0
    effort = np.maximum(stack.effort(), NO_EFFORT)
    noise = np.maximum(stack.own_noise(), LEAST_NOISE * effort)
    for _ in range(ROUNDS):
        R = stack.weighted_triangle(noise)
        U, S, Vt = np.linalg.svd(R[:, :-1] @ spread, full_matrices=False)
        count = int((S > 1.0).sum())
        target = R[:, -1] - R[:, :-1] @ b0
        b = b0 + spread @ (Vt[:count].T @ ((U.T @ target)[:count] / S[:count]))
        freedom = max(1.0 - count / max(stack.rows * len(noise), 1), LEAST_SHARE)
        noise = np.maximum(stack.residual(b) / np.sqrt(freedom), LEAST_NOISE * effort)
    R = stack.weighted_triangle(noise)
    _, S, Vt = np.linalg.svd(R[:, :-1] @ spread, full_matrices=False)
    count = int((S > 1.0).sum())
    identified = spread @ Vt[:count].T
    root = np.hstack([identified / S[:count], spread - identified @ Vt[:count]])
    columns = np.linalg.norm(R[:, :-1], axis=0)
    condition_number = float(np.linalg.cond(R[:, :-1] / columns)) if columns.all() else np.inf
    return Fit(b, root @ root.T, noise, R, S[:k], count, condition_number)
