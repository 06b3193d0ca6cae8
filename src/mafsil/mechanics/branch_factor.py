"""A symmetric positive definite matrix factored along its elimination tree: M = L' D L without fill-in.

The mass matrix of a kinematic tree has an entry only where one joint moves the other, and eliminating from the leaves
to the root keeps all other entries zero. Solutions and the inverse use the same pattern, so that their cost follows
the depth of the tree instead of the number of joints.

Reference: Featherstone, Rigid Body Dynamics Algorithms, sec. 6.5 (factorisation); Takahashi, Fagan & Chin, 1973
(entries of the inverse from the factors, without solving for unit vectors).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import nan

import mafsil.expression as ex
from mafsil.mechanics.placement import Expression
from mafsil.mechanics.tolerances import SINGULAR_PIVOT

Row = dict[int, Expression]
"""The structural nonzeros of a row or a column, by index."""


class BranchFactor:
    """L (unit diagonal) and D of a symmetric M (n, n), eliminated from the last row upwards.

    A pivot that is no more than rounding of its diagonal entry makes what depends on it NaN, not a huge number.

    1. Factorisation: row k of L, and the parent of k, the last of the columns in it.
    2. Solution: y = L'^-1 b from the leaves, x = L^-1 D^-1 y from the root. Where y is zero from k up to a
       coordinate p before it, x_k follows from the coordinates up to p alone (`transfer`).
    3. Inverse, by rows from the root: A = D^-1 L'^-1 - (L - E) A, whose first term is diagonal on and below the
       diagonal.

    Attributes:
        n: number of rows.
        rows: of every k, the nonzeros L[k, i] with i < k.
        inverse_pivots: 1 / D[k].
        parent: of every k, the next coordinate towards the root of the elimination tree; -1 for none.
    """

    def __init__(self, M: Expression) -> None:
        self.n = int(M.shape[0])
        self.rows: list[Row] = [{} for _ in range(self.n)]
        self.inverse_pivots: list[Expression] = [ex.Expression(1)] * self.n
        self._factor(M)
        self.parent = [max(row, default=-1) for row in self.rows]
        self._transfers: dict[tuple[int, int], Row] = {}

    def _factor(self, M: Expression) -> None:
        """Step 1."""
        entry = {(i, j): M[i, j] for i in range(self.n) for j in range(i + 1) if not M[i, j].is_zero()}
        for k in reversed(range(self.n)):
            before = [i for i in range(k) if (k, i) in entry]
            inverse = ex.if_else(entry[k, k] > SINGULAR_PIVOT * M[k, k], 1 / entry[k, k], nan)
            self.inverse_pivots[k] = inverse
            for i in before:
                factor = entry[k, i] * inverse
                self.rows[k][i] = factor
                for j in (j for j in before if j <= i):
                    product = factor * entry[k, j]
                    entry[i, j] = entry[i, j] - product if (i, j) in entry else -product

    def solve(self, b: Sequence[Expression]) -> list[Expression]:
        """x (n) with M x = b (n), structural zeros of b used (step 2)."""
        return self.complete(self.half_solve(b))

    def half_solve(self, b: Sequence[Expression]) -> Row:
        """Nonzeros of y = L'^-1 b: then b' M^-1 c is the sum of y_k z_k / D_k, with z of c.

        Args:
            b: (n) one column.
        """
        y = {k: value for k, value in enumerate(b) if not value.is_zero()}
        for k in reversed(range(self.n)):
            if k in y:
                for i, factor in self.rows[k].items():
                    y[i] = y[i] - factor * y[k] if i in y else -(factor * y[k])
        return y

    def complete(self, y: Row) -> list[Expression]:
        """x (n) = L^-1 D^-1 y.

        Args:
            y: from `half_solve`.
        """
        x: list[Expression] = []
        for k in range(self.n):
            if k in y:
                x.append(_less(y[k] * self.inverse_pivots[k], self.rows[k], x))
            else:
                x.append(self._follower(k, set(y), x))
        return x

    def inverse(self) -> list[list[Expression]]:
        """M^-1 by rows, each entry of the lower half computed once (step 3)."""
        A: list[list[Expression]] = []
        for i in range(self.n):
            path = set(self._path(i))
            row: list[Expression] = []
            for j in range(i):
                column = [*(A[a][j] if a >= j else A[j][a] for a in range(i))]
                if j in path:
                    row.append(_less(ex.Expression(0), self.rows[i], column))
                else:
                    row.append(self._follower(i, set(self._path(j)), column))
            row.append(_less(self.inverse_pivots[i], self.rows[i], row))
            A.append(row)
        return [[A[max(i, j)][min(i, j)] for j in range(self.n)] for i in range(self.n)]

    def _follower(self, k: int, driven: set[int], x: Sequence[Expression]) -> Expression:
        """x_k from those of the driven coordinates before it, none of which lies between it and the last of them."""
        p = self.parent[k]
        while p >= 0 and p not in driven:
            p = self.parent[p]
        return _less(ex.Expression(0), self._transfer(k, p), x) if p >= 0 else ex.Expression(0)

    def _transfer(self, k: int, p: int) -> Row:
        """-x_k per coordinate from the root to p, an ancestor of k, where nothing drives the coordinates after p.

        1. For p the parent of k it is row k of L.
        2. Otherwise that for the child of p on the way to k, with the child's own coordinate replaced by its row.
        """
        if (k, p) not in self._transfers:
            if p == self.parent[k]:
                found = dict(self.rows[k])  # 1.
            else:
                between = self.parent[k]  # 2.
                while self.parent[between] != p:
                    between = self.parent[between]
                found = dict(self._transfer(k, between))
                through = found.pop(between, None)
                if through is not None:
                    for i, factor in self.rows[between].items():
                        found[i] = found[i] - through * factor if i in found else -(through * factor)
            self._transfers[k, p] = found
        return self._transfers[k, p]

    def _path(self, k: int) -> list[int]:
        """k and what lies between it and the root."""
        path = [k]
        while self.parent[path[-1]] >= 0:
            path.append(self.parent[path[-1]])
        return path


def _less(start: Expression, row: Row, x: Sequence[Expression]) -> Expression:
    """Start less the sum of row[i] x[i], term by term."""
    for i, factor in row.items():
        if not x[i].is_zero():
            start = start - factor * x[i]
    return start
