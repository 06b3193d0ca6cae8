"""Pairs of Runge-Kutta methods: the difference of the two is the error of a step; a polynomial gives the values within.

Coefficients are data that check themselves when they are first asked for: order conditions by rooted trees, of the
weights and of the polynomial at several places within the step.

Order conditions of Runge-Kutta methods of any order: one for each rooted tree.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from itertools import combinations_with_replacement
from typing import TypeAlias

import numpy as np

from mafsil.arrays import Floats, frozen
from mafsil.errors import InputError
from mafsil.solvers.tolerances import ORDER_CONDITION_LONG

Tree: TypeAlias = tuple["Tree", ...]
"""A rooted tree as the sorted tuple of its branches; () is the single node."""


@dataclass(frozen=True, eq=False)
class EmbeddedPair:
    """An explicit Runge-Kutta method with an error estimate and a continuous extension.

    k_i = f(t + c_i h, y + h sum_j a_ij k_j); the last stage of the step proper is f at the new point (FSAL); further
    stages serve the polynomial y(t + theta h) = y + h sum_i k_i sum_d P[i, d] theta^(d+1) alone.

    Attributes:
        name: as the field calls it.
        a: (s, s) all stages, lower triangle.
        steps: number of stages of the step proper, the new point included.
        order: of the result.
        error: (e, steps) rows of differences to lower methods: one row, or the two of Dormand and Prince's 853.
        error_order: of the error estimate: the exponent k with error ~ h^k.
        dense: (s, d) polynomial P.
        dense_order: of the polynomial's global error.

    Raises:
        InputError: an order condition is violated.

    Reference: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, sec. II.4 to II.6.
    """

    name: str
    a: Floats
    steps: int
    order: int
    error: Floats
    error_order: int
    dense: Floats
    dense_order: int
    c: Floats = field(init=False)
    b: Floats = field(init=False)

    def __post_init__(self) -> None:
        s = self.steps
        object.__setattr__(self, "c", frozen(self.a.sum(axis=1)))
        object.__setattr__(self, "b", frozen(self.a[s - 1, : s - 1]))
        self._require("b", self.a[: s - 1, : s - 1], self.b, self.order, 1.0)
        for theta in (0.2, 0.5, 0.9, 1.0):
            weights = self.dense @ theta ** np.arange(1.0, self.dense.shape[1] + 1.0)
            self._require("b(theta)", self.a, weights, self.dense_order, theta)
        ends = self.dense.sum(axis=1)
        ends[: s - 1] -= self.b
        if np.abs(ends).max() > ORDER_CONDITION_LONG * np.abs(self.dense).max():
            raise InputError("solvers.tableau", name=self.name, law="b(1) = b", error=float(np.abs(ends).max()))
        if np.abs(self.error.sum(axis=1)).max() > ORDER_CONDITION_LONG:
            raise InputError("solvers.tableau", name=self.name, law="e 1 = 0", error=float(self.error.sum()))

    def _require(self, law: str, a: Floats, weights: Floats, order: int, theta: float) -> None:
        worst, tree = violation(a, weights, order, theta)
        if worst > ORDER_CONDITION_LONG:
            raise InputError("solvers.tableau", name=self.name, law=f"{law} of {tree}", error=worst)


@cache
def bogacki_shampine() -> EmbeddedPair:
    """Order 3 with an error estimate of order 2: for loose tolerances.

    Reference: Bogacki and Shampine, A 3(2) pair of Runge-Kutta formulas, Appl. Math. Lett. 2, 1989.
    """
    a = _lower([], [1 / 2], [0, 3 / 4], [2 / 9, 1 / 3, 4 / 9])
    hermite = [[1, -4 / 3, 5 / 9], [0, 1, -2 / 3], [0, 4 / 3, -8 / 9], [0, -1, 1]]
    error = frozen([[5 / 72, -1 / 12, -1 / 9, 1 / 8]])
    return EmbeddedPair("Bogacki-Shampine 3(2)", a, 4, 3, error, 3, frozen(hermite), 3)


@cache
def dormand_prince() -> EmbeddedPair:
    """Order 5 with an error estimate of order 4: the usual choice.

    Reference: Dormand and Prince, A family of embedded Runge-Kutta formulae, J. Comp. Appl. Math. 6, 1980; the
    polynomial: Shampine, Some practical Runge-Kutta formulas, Math. Comp. 46, 1986.
    """
    a = _lower(
        [],
        [1 / 5],
        [3 / 40, 9 / 40],
        [44 / 45, -56 / 15, 32 / 9],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656],
        [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    )
    error = frozen([[71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40]])
    dense = [
        [1, -8048581381 / 2820520608, 8663915743 / 2820520608, -12715105075 / 11282082432],
        [0, 0, 0, 0],
        [0, 131558114200 / 32700410799, -68118460800 / 10900136933, 87487479700 / 32700410799],
        [0, -1754552775 / 470086768, 14199869525 / 1410260304, -10690763975 / 1880347072],
        [0, 127303824393 / 49829197408, -318862633887 / 49829197408, 701980252875 / 199316789632],
        [0, -282668133 / 205662961, 2019193451 / 616988883, -1453857185 / 822651844],
        [0, 40617522 / 29380423, -110615467 / 29380423, 69997945 / 29380423],
    ]
    return EmbeddedPair("Dormand-Prince 5(4)", a, 7, 5, error, 5, frozen(dense), 4)


def _lower(*rows: list[float]) -> Floats:
    """A strictly lower triangular matrix from its rows."""
    a = np.zeros((len(rows), len(rows)))
    for i, row in enumerate(rows):
        a[i, : len(row)] = row
    return frozen(a)


@cache
def trees(order: int) -> tuple[Tree, ...]:
    """All rooted trees with that many nodes: 1, 1, 2, 4, 9, 20, 48, 115, ..."""
    return tuple(sorted(_forests(order - 1, order - 1)))


def _forests(nodes: int, largest: int) -> Iterator[Tree]:
    """All multisets of trees with `nodes` nodes together, none larger than `largest`."""
    if nodes == 0:
        yield ()
        return
    for size in range(min(nodes, largest), 0, -1):
        for count in range(1, nodes // size + 1):
            for rest in _forests(nodes - count * size, size - 1):
                for group in combinations_with_replacement(trees(size), count):
                    yield tuple(sorted((*group, *rest)))


@cache
def nodes(tree: Tree) -> int:
    """Number of nodes."""
    return 1 + sum(nodes(branch) for branch in tree)


@cache
def density(tree: Tree) -> int:
    """Gamma(t) = nodes(t) times the densities of the branches."""
    product = nodes(tree)
    for branch in tree:
        product *= density(branch)
    return product


def violation(a: Floats, weights: Floats, order: int, theta: float = 1.0) -> tuple[float, Tree]:
    """Largest |b . Phi(t) - theta^nodes / gamma(t)| over the trees up to an order, and the tree.

    Errors count relative to the sum of |b_i Phi_i|, so that large coefficients are not blamed for their rounding.

    Args:
        a: (s, s) the method's matrix.
        weights: (s,) weights b, or b(theta) of a continuous extension.
        order: up to which the conditions are asked.
        theta: fraction of the step at which the result is taken.

    Reference: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, theorem II.2.13.
    """
    known: dict[Tree, Floats] = {(): np.ones(len(weights))}

    def stages(tree: Tree) -> Floats:
        if tree not in known:
            value = np.ones(len(weights))
            for branch in tree:
                value = value * (a @ stages(branch))
            known[tree] = value
        return known[tree]

    worst, culprit = 0.0, ()
    for count in range(1, order + 1):
        for tree in trees(count):
            terms = weights * stages(tree)
            error = abs(float(terms.sum()) - theta**count / density(tree)) / max(1.0, float(np.abs(terms).sum()))
            if error > worst:
                worst, culprit = error, tree
    return worst, culprit
