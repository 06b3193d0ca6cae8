"""The four classic methods for force closure, each on its own, so that they can be compared.

All ask the same: is the origin strictly inside the convex hull of the columns of A (m, n)? One of them reduces A to
[I S] by Gauss and Jordan, every row operation written down, on floats or exactly on fractions: what comes in decides.
The right side is kept as combinations of b, so one elimination serves every external wrench.

How many contacts closure needs at least, for any mix of frictionless, hard and soft ones: the frictional contacts span
V with signs. In the q = m - dim V directions that V leaves open only the frictionless contacts act, each with one
sense: at least q + 1 of them are needed there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import isfinite
from typing import Any, Literal

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, not_negative, real_array, require_finite
from mafsil.errors import InputError
from mafsil.grasp.closure import conditioning
from mafsil.grasp.contact import Contact
from mafsil.grasp.quality import quality_by_facets
from mafsil.grasp.tolerances import OPTIMUM, RANK
from mafsil.solvers.linear_program import minimise
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
    number = Fraction if exact else float
    rows = _rows_of(A, number)
    m, n, one = len(rows), len(rows[0]), number(1)
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


def _rows_of(A: Floats | Sequence[Sequence[Rational]], number: type[Fraction] | type[float]) -> list[list[Any]]:
    """The rows of a matrix in numbers of one kind."""
    given = np.asarray(A, dtype=object)
    if given.ndim != 2 or not given.size:
        raise InputError("input.shape", name="A", expected="(m, n)", got=given.shape, hint="")
    if not all(isfinite(value) for line in A for value in line):
        require_finite("A", real_array("A", np.asarray(A, dtype=np.float64)))
    return [[number(value) for value in row] for row in A]


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


class MethodStatus(Status):
    """The verdict of one method."""

    CLOSED = ("grasp.method_closed", True)
    OPEN = ("grasp.method_open", False)


@dataclass(frozen=True, eq=False, repr=False)
class MethodResult(Answer, data="value evidence"):
    """What one method says; true if the wrenches close.

    Attributes:
        closed: its verdict.
        value: the number whose sign decides: t*, radius, mu*, or the largest sum of A' y.
        evidence: x, y or omega that goes with it, or None.
        reduction: the elimination, if the method makes one.
    """

    closed: bool
    value: float
    evidence: Floats | None = field(default=None)
    reduction: Reduction | None = field(default=None)

    @property
    def status(self) -> MethodStatus:
        """The verdict."""
        return MethodStatus.CLOSED if self.closed else MethodStatus.OPEN


def positive_span(A: Floats) -> MethodResult:
    """Largest t with A x = 0, sum x = 1, x >= t: closed iff t > 0 and rank A = m.

    Args:
        A: (m, n).
    """
    m, n = A.shape
    scaled = _scale(A)
    equal = np.vstack([np.column_stack([scaled, scaled.sum(axis=1)]), np.append(np.ones(n), n)])
    best = minimise(np.append(np.zeros(n), -1.0), equal, np.append(np.zeros(m), 1.0), free=1)
    if best is None:
        return MethodResult(False, -np.inf)
    t = float(best.x[n])
    return MethodResult(t > OPTIMUM and np.linalg.matrix_rank(scaled) == m, t, best.x[:n] + t)


def hull_and_ball(A: Floats) -> MethodResult:
    """Radius of the largest origin-centred ball in the hull of the columns: closed iff positive.

    Args:
        A: (m, n).
    """
    if np.linalg.matrix_rank(_scale(A)) < len(A):
        return MethodResult(False, 0.0)
    quality = quality_by_facets(A)
    return MethodResult(quality.epsilon > OPTIMUM * float(np.abs(A).max()), quality.epsilon, quality.weakest_direction)


def reduction_and_program(A: Floats, *, box: bool = False) -> MethodResult:
    """Gauss-Jordan to [I S]; then min mu with S omega <= mu 1, omega >= 0: closed iff mu* < 0.

    Without a bound on omega the program is unbounded exactly when the answer is yes, so sum omega = 1, or (box)
    0 <= omega <= 1. With n = m + 1 it says: every entry of the one column S is negative.

    Args:
        A: (m, n).
        box: the other normalisation.
    """
    m: int = A.shape[0]
    n: int = A.shape[1]
    reduced = eliminate(A)
    if reduced.rank < m or n == m:
        return MethodResult(False, np.inf, None, reduced)
    S = reduced.S
    k = n - m
    cost = np.append(np.zeros(k), 1.0)
    if box:
        G = np.vstack([np.column_stack([S, -np.ones(m)]), np.eye(k, k + 1)])
        best = minimise(cost, None, None, G, np.append(np.zeros(m), np.ones(k)), free=1)
    else:
        G: Floats = np.column_stack([S, -np.ones(m)])
        best = minimise(cost, np.append(np.ones(k), 0.0)[None], np.ones(1), G, np.zeros(m), free=1)
    assert best is not None, "any omega has its mu"
    return MethodResult(best.value < -OPTIMUM * max(1.0, float(np.abs(S).max())), best.value, best.x[:k], reduced)


def dual(A: Floats) -> MethodResult:
    """Largest sum of A' y with A' y >= 0, |y| <= 1: closed iff 0 and rank A = m; else y is the certificate.

    Args:
        A: (m, n).
    """
    m, n = A.shape
    scaled = _scale(A)
    rows = np.hstack([-scaled.T, scaled.T])
    limits = np.eye(2 * m)
    best = minimise(
        -np.concatenate([scaled.sum(axis=1), -scaled.sum(axis=1)]),
        None, None, np.vstack([rows, limits]), np.append(np.zeros(n), np.ones(2 * m)),
    )  # fmt: skip
    assert best is not None, "y = 0 is a solution"
    y = best.x[:m] - best.x[m:]
    if np.linalg.matrix_rank(scaled) < m:
        return MethodResult(False, 0.0, np.linalg.svd(scaled)[0][:, -1] / _row_sizes(A))
    return MethodResult(-best.value <= OPTIMUM, -best.value, y / _row_sizes(A))


METHODS: Mapping[str, Callable[[Floats], MethodResult]] = {
    "positive_span": positive_span,
    "hull_and_ball": hull_and_ball,
    "reduction": reduction_and_program,
    "dual": dual,
}


def closure_by_all_methods(A: Floats) -> dict[str, MethodResult]:
    """Every method on the same columns.

    Args:
        A: (m, n).
    """
    return {name: method(A) for name, method in METHODS.items()}


def _row_sizes(A: Floats) -> Floats:
    sizes = np.abs(A).max(axis=1, keepdims=False)
    return np.where(sizes > 0, sizes, 1.0)


def _scale(A: Floats) -> Floats:
    rows = A / _row_sizes(A)[:, None]
    sizes = np.linalg.norm(rows, axis=0)
    return rows / np.where(sizes > 0, sizes, 1.0)


@dataclass(frozen=True, eq=False)
class ContactCount:
    """What the models of the contacts can span.

    Attributes:
        rows: m, 3 in the plane and 6 in space.
        frictional: contacts with friction.
        spanned: dim V of their wrenches.
        frictionless: contacts without friction.
        needed: least number of frictionless contacts beside these frictional ones; 0 if V is everything.
        open_directions: (m, q) basis of the wrenches y with y . w = 0 for every frictional contact.
    """

    rows: int
    frictional: int
    spanned: int
    frictionless: int
    needed: int
    open_directions: Floats

    @property
    def enough(self) -> bool:
        """Whether closure is possible at all; if not, no change of places, normals or coefficients helps."""
        return self.frictionless >= self.needed


def count_contacts(contacts: Sequence[Contact]) -> ContactCount:
    """Least numbers of contacts for closure.

    In general position: in the plane 4 frictionless, 1 hard and 2, 2 hard; in space 7, 1 hard and 4, 1 soft and 3, 2
    hard and 2, 3 hard, 1 soft and 1 hard, 2 soft.

    Args:
        contacts: at least one, all in the plane or all in space.
    """
    M = conditioning([c.point for c in contacts])
    m = len(M)
    rough = [M @ c.basis for c in contacts if c.mu > 0 or c.gamma > 0]
    free = sum(c.mu == 0 and c.gamma == 0 for c in contacts)
    rank, basis = 0, np.eye(m)
    if rough:
        U, s, _ = np.linalg.svd(np.hstack(rough), full_matrices=True)
        rank = int((s > RANK * s[0]).sum())
        basis = U[:, rank:]
    return ContactCount(m, len(rough), rank, free, 0 if rank == m else m - rank + 1, M.T @ basis)
