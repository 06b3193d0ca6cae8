"""A tree held by loops, as expressions of fixed size: accelerations, forces of the loops, rates that close them.

Which rows of the loops are independent depends on the mechanism, hardly on its state: those that are `chosen` act, the
others follow from them. Whether they do at this state is one number, `doubt`: below one the results hold; otherwise, or
where it is not a number, somebody has to look who can find the rank (`mafsil.parallel`).

1. M = L' D L along the tree; Y = L'^-1 J', so that A = J M^-1 J' = Y' D^-1 Y.
2. A_B of the chosen rows B is factored; with C A_B = A_EB the other rows E are J_E = C J_B.
3. qdd = M^-1 (load + J_B' x), A_B x = -(gamma_B + J_B M^-1 load); the forces f of all rows are the shortest with
   J' f = J_B' x.

Reference: Featherstone, Rigid Body Dynamics Algorithms, ch. 8.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, nan

import mafsil.expression as ex
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.mechanics.body_tree import lump_bodies
from mafsil.mechanics.branch_factor import BranchFactor, Row
from mafsil.mechanics.frame_choice import in_chosen_frames, regroup
from mafsil.mechanics.loop_constraints import loops
from mafsil.mechanics.placement import Expression
from mafsil.mechanics.quantities.forward_dynamics import mass_matrix
from mafsil.mechanics.quantities.inverse_dynamics import inverse_dynamics
from mafsil.mechanics.tolerances import DEPENDENT_ROW, FOLLOWS, LARGEST, WEAK_ROW
from mafsil.model import Mechanism

Column = list[Expression]


class HeldTree:
    """The inertia of a tree and the rows of its loops, factored.

    Args:
        M: (n, n) mass matrix of the tree.
        J: (m, n) rows of the loops.
        chosen: indices of independent rows.

    Attributes:
        doubt: sum of what speaks against the chosen rows at this state: one of them is weak (its remainder beside the
            others is less than `WEAK_ROW` of it) or another row does not follow from them.
    """

    def __init__(self, M: Expression, J: Expression, chosen: Sequence[int]) -> None:
        self.factor = BranchFactor(M)
        self.m, self.n = J.shape
        self.chosen = list(chosen)
        # Rows that are structurally zero ask for nothing.
        self.others = [k for k in range(self.m) if k not in self.chosen and not J[k, :].is_zero()]
        self.J = J
        self._half = {k: self.factor.half_solve(_entries(J[k, :])) for k in (*self.chosen, *self.others)}
        A = [[self._between(self._half[k], self._half[i]) for i in self.chosen] for k in self.chosen]
        self._rows = BranchFactor(ex.blockcat(A)) if A else None
        scale = _total([A[k][k] for k in range(len(A))])
        self.doubt = ex.Expression(0) if self._rows is None else pivot_doubt(self._rows, ex.blockcat(A))
        self._follow: dict[int, Column] = {}
        for k in self.others:
            across = [self._between(self._half[k], self._half[i]) for i in self.chosen]
            self._follow[k] = self._solve(across)
            rest = self._between(self._half[k], self._half[k]) - _product(self._follow[k], across)
            self.doubt = self.doubt + ex.fabs(rest) / (DEPENDENT_ROW * scale + LEAST_DIVISOR)

    def accelerations(self, load: Expression, gamma: Expression) -> tuple[Expression, Column]:
        """qdd (n,), and the forces x of the chosen rows.

        Args:
            load: (n,) efforts less the bias forces.
            gamma: (m,) with J qdd + gamma = 0.
        """
        y = self.factor.half_solve(_entries(load))
        x = self._solve([-(gamma[k] + self._between(self._half[k], y)) for k in self.chosen])
        return self._move(y, x), x

    def closing(self, v: Expression) -> Expression:
        """Rates (n,) that keep the loops closed, the nearest to given ones in kinetic energy.

        Args:
            v: (n,) rates.
        """
        x = self._solve([-_product(_entries(self.J[k, :]), _entries(v)) for k in self.chosen])
        return v + self._move({}, x)

    def forces(self, x: Column) -> Expression:
        """(m,) the shortest forces f of all rows with J' f = J_B' x.

        f_E = (1 + C C')^-1 C x of the rows that follow, f_B = x - C' f_E.

        Args:
            x: forces of the chosen rows.
        """
        force = [ex.Expression(0)] * self.m
        for k, value in zip(self.chosen, x, strict=True):
            force[k] = value
        rows = [self._follow[k] for k in self.others]
        if not rows:
            return ex.vertcat(*force)
        gram = [[_product(a, b) + float(i == j) for j, b in enumerate(rows)] for i, a in enumerate(rows)]
        shared = BranchFactor(ex.blockcat(gram)).solve([_product(row, x) for row in rows])
        for k, value, row in zip(self.others, shared, rows, strict=True):
            force[k] = value
            for place, part in zip(self.chosen, row, strict=True):
                force[place] = force[place] - part * value
        return ex.vertcat(*force)

    def distrust(self, qdd: Expression, gamma: Expression) -> Expression:
        """`doubt` after a solution: also how far the other rows miss it, and whether it is finite.

        Args:
            qdd: (n,) found.
            gamma: (m,) as for `accelerations`.
        """
        doubt, motion = self.doubt, _entries(qdd)
        asked = {k: [*_products(_entries(self.J[k, :]), motion), gamma[k]] for k in (*self.chosen, *self.others)}
        size = _total([ex.fabs(part) for k in asked for part in asked[k]]) if self.others else LEAST_DIVISOR
        for k in self.others:
            doubt = doubt + ex.fabs(_total(asked[k])) / (FOLLOWS * size + LEAST_DIVISOR)
        return doubt + self.finite(qdd)

    def carrying_forces(self, load: Expression) -> Column:
        """Forces x of the chosen rows that carry a load in the sense of least squares: M^-1 (load - J_B' x) is closed.

        Args:
            load: (n,) efforts.
        """
        y = self.factor.half_solve(_entries(load))
        return self._solve([self._between(self._half[k], y) for k in self.chosen])

    @staticmethod
    def finite(x: Expression) -> Expression:
        """Zero, or NaN where an entry is not finite.

        Args:
            x: (k,) numbers.
        """
        return ex.if_else(ex.fabs(_total(_entries(x))) < LARGEST, 0.0, nan)

    def _move(self, y: Row, x: Column) -> Expression:
        """M^-1 (b + J_B' x), with y of b."""
        total = dict(y)
        for k, value in zip(self.chosen, x, strict=True):
            for i, entry in self._half[k].items():
                total[i] = total[i] + entry * value if i in total else entry * value
        return ex.vertcat(*self.factor.complete(total))

    def _between(self, y: Row, z: Row) -> Expression:
        return _total([y[i] * (z[i] * self.factor.inverse_pivots[i]) for i in sorted(y.keys() & z.keys())])

    def _solve(self, b: Column) -> Column:
        return [] if self._rows is None else self._rows.solve(b)


def pivot_doubt(factor: BranchFactor, A: Expression) -> Expression:
    """Sum of what pivots say against a factorisation: of one, pivots as large as the entries; NaN, not definite.

    Args:
        factor: of A.
        A: (k, k) symmetric.
    """
    scale = ex.trace(A)
    return _total([(WEAK_ROW * A[k, k] + DEPENDENT_ROW * scale) * factor.inverse_pivots[k] for k in range(factor.n)])


def forward_function(mechanism: Mechanism, chosen: Sequence[int], driven: Sequence[int]) -> ex.Function:
    """Accelerations under efforts: q, qd (n,), tau (a,) of the driven joints to qdd (n,) and held (m + 2,).

    What is held are the forces of the loops, the number of independent rows, and the largest gap of a loop: infinite
    where one is closed the wrong way round, and not a number where the results do not hold.

    Args:
        mechanism: with loops.
        chosen: independent rows.
        driven: coordinates that the efforts act on, in their order.
    """
    n = mechanism.n
    full = in_chosen_frames(lump_bodies(mechanism))
    short = regroup(full)
    q, qd, tau = ex.symbol("q", n), ex.symbol("qd", n), ex.symbol("tau", len(driven))
    asked = loops(full, mechanism.loops, q, qd)
    held = HeldTree(mass_matrix(short, q), asked.rows, chosen)
    load = spread(tau, driven, n) - inverse_dynamics(short, q, qd, ex.zeros(n, 1))
    qdd, x = held.accelerations(load, asked.bias)
    error = ex.if_else(held.distrust(qdd, asked.bias) < 1, error_of(asked.gap, asked.facing), nan)
    together = ex.vertcat(held.forces(x), ex.Expression(len(chosen)), error)
    return ex.Function("closed_forward_dynamics", [q, qd, tau], ex.cse([qdd, together]))


def error_of(gap: Expression, facing: Expression) -> Expression:
    """The largest gap, infinite where a loop faces the wrong way; NaN stays NaN.

    Args:
        gap: (m,) of `Loops`.
        facing: (loops,) likewise.
    """
    worst, ahead = ex.Expression(0), facing[0]
    for each in gap:
        worst = ex.if_else(ex.fabs(each) <= worst, worst, ex.fabs(each))
    for each in list(facing)[1:]:
        ahead = ex.if_else(ahead <= each, ahead, each)
    return ex.if_else(ahead > 0, worst, inf)


def spread(part: Expression, places: Sequence[int], n: int) -> Expression:
    """(n,) with the entries of a shorter column at its places, zero elsewhere.

    Args:
        part: (a,) entries.
        places: where they stand.
        n: length of the whole.
    """
    whole = ex.zeros(n, 1)
    for value, place in zip(part, places, strict=True):
        whole[place] = value
    return whole


def _entries(x: Expression) -> Column:
    """The entries of a row or a column."""
    return list(x)


def _product(a: Sequence[Expression], b: Sequence[Expression]) -> Expression:
    return _total(_products(a, b))


def _products(a: Sequence[Expression], b: Sequence[Expression]) -> Column:
    return [x * y for x, y in zip(a, b, strict=True) if not x.is_zero() and not y.is_zero()]


def _total(parts: Sequence[Expression]) -> Expression:
    total = ex.Expression(0)
    for part in parts:
        total = total + part
    return total
