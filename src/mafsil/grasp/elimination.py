"""Gauss-Jordan elimination of a grasp matrix to [I S], every row operation written down.

Works on floats or exactly on fractions: what comes in decides. The right side is kept as combinations of b, so one
elimination serves every external wrench.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import isfinite
from typing import Any, Literal

import numpy as np

from mafsil.arrays import Floats, not_negative, real_array, require_finite
from mafsil.errors import InputError
from mafsil.solvers.rational import Rational

Number = float | Fraction


@dataclass(frozen=True)
class RowOperation:
    """One step.

    Attributes:
        kind: `swap` rows, `scale` a row, or `add` a multiple of a row to another.
        row: that changes (from 0).
        other: the other row of a swap or sum.
        factor: of the scaling or of the row that is added.
    """

    kind: Literal["swap", "scale", "add"]
    row: int
    other: int
    factor: Number

    def __str__(self) -> str:
        mine, other = f"R{self.row + 1}", f"R{self.other + 1}"
        if self.kind == "swap":
            return f"{mine} <-> {other}"
        if self.kind == "scale":
            return f"{mine} := {_shown(self.factor)} {mine}"
        sign = "-" if self.factor < 0 else "+"
        return f"{mine} := {mine} {sign} {_shown(abs(self.factor))} {other}"


@dataclass(frozen=True, eq=False)
class Reduction:
    """[A | b] after elimination.

    Attributes:
        rows: reduced rows of A, all columns in their own order.
        right: (m, m) combinations of b that stand on the right side: b becomes `right` b.
        pivots: columns that became the identity.
        free: the other columns, those of S.
        steps: row operations, in order.
        rank: number of pivots.
    """

    rows: list[list[Any]]
    right: list[list[Any]]
    pivots: tuple[int, ...]
    free: tuple[int, ...]
    steps: tuple[RowOperation, ...]

    @property
    def rank(self) -> int:
        """Number of pivots."""
        return len(self.pivots)

    @property
    def S(self) -> Floats:
        """(rank, n - rank) the columns beside the identity."""
        return np.array([[float(row[j]) for j in self.free] for row in self.rows[: self.rank]]).reshape(
            self.rank, len(self.free)
        )

    def right_side(self, b: Floats) -> Floats:
        """(m,) what stands beside the reduced rows for one b."""
        return np.array([[float(v) for v in row] for row in self.right]) @ b

    def lines(self) -> list[str]:
        """The steps and the result as text."""
        head = [str(step) for step in self.steps]
        body = ["  ".join(f"{_shown(v):>9}" for v in row) for row in self.rows]
        return [*head, *body]


def eliminate(A: Floats | Sequence[Sequence[Rational]], *, jordan: bool = True, tolerance: float = 1e-10) -> Reduction:
    """Gauss (upper triangle) or Gauss-Jordan (identity) with the first independent columns as pivots.

    Args:
        A: (m, n) floats (largest pivot of the column), or rows of int and Fraction (exact, first pivot).
        jordan: clear above the pivots and scale them to 1.
        tolerance: for floats: pivots below this share of the largest entry count as zero.
    """
    tolerance = not_negative("tolerance", tolerance)
    exact = not isinstance(A, np.ndarray)
    given = np.asarray(A, dtype=object)
    if given.ndim != 2 or not given.size:
        raise InputError("input.shape", name="A", expected="(m, n)", got=given.shape, hint="")
    if not all(isfinite(value) for line in A for value in line):
        require_finite("A", real_array("A", np.asarray(A, dtype=np.float64)))
    rows: list[list[Any]] = [[Fraction(v) if exact else float(v) for v in row] for row in A]
    m, n = len(rows), len(rows[0])
    one = Fraction(1) if exact else 1.0
    right: list[list[Any]] = [[one * (i == k) for k in range(m)] for i in range(m)]
    limit = 0.0 if exact else tolerance * max(abs(v) for row in rows for v in row)
    steps: list[RowOperation] = []
    pivots: list[int] = []
    for j in range(n):
        top = len(pivots)
        if top == m:
            break
        best = _pivot_row(rows, j, top, limit, exact)
        if best is None:
            continue
        if best != top:
            _apply(rows, right, steps, RowOperation("swap", top, best, one))
        if jordan and rows[top][j] != 1:
            _apply(rows, right, steps, RowOperation("scale", top, top, one / rows[top][j]))
        for i in range(0 if jordan else top + 1, m):
            if i != top and rows[i][j] != 0:
                _apply(rows, right, steps, RowOperation("add", i, top, -rows[i][j] / rows[top][j]))
                rows[i][j] = 0 * one
        pivots.append(j)
    free = tuple(j for j in range(n) if j not in pivots)
    return Reduction(rows, right, tuple(pivots), free, tuple(steps))


def _pivot_row(rows: list[list[Any]], j: int, top: int, limit: float, exact: bool) -> int | None:
    usable = [i for i in range(top, len(rows)) if abs(rows[i][j]) > limit]
    if not usable:
        return None
    return usable[0] if exact else max(usable, key=lambda i: abs(rows[i][j]))


def _apply(rows: list[list[Any]], right: list[list[Any]], steps: list[RowOperation], step: RowOperation) -> None:
    for table in (rows, right):
        if step.kind == "swap":
            table[step.row], table[step.other] = table[step.other], table[step.row]
        elif step.kind == "scale":
            table[step.row] = [step.factor * v for v in table[step.row]]
        else:
            pairs = zip(table[step.row], table[step.other], strict=True)
            table[step.row] = [a + step.factor * b for a, b in pairs]
    steps.append(step)


def _shown(value: Number) -> str:
    return str(value) if isinstance(value, Fraction) else f"{value + 0.0:.6g}"
