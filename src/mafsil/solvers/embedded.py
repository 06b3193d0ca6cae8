"""Pairs of Runge-Kutta methods: the difference of the two is the error of a step; a polynomial gives the values within.

Coefficients are data that check themselves when they are first asked for: order conditions by rooted trees, of the
weights and of the polynomial at several places within the step.

Order conditions of Runge-Kutta methods of any order: one for each rooted tree.

The adaptive methods by the names that users type.

Dormand and Prince's method of order 8 with error estimates of orders 5 and 3 and a polynomial of order 7, as data.

Reference: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, sec. II.5, II.6 and the authors' code.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cache
from itertools import combinations_with_replacement
from typing import TypeAlias

import numpy as np
from numpy.polynomial import polynomial

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


Row = dict[int, float]
"""Entries that are not zero, by column."""
# fmt: off
MATRIX: tuple[Row, ...] = (
    {},
    {0: 0.05260015195876773},
    {0: 0.0197250569845379, 1: 0.0591751709536137},
    {0: 0.02958758547680685, 2: 0.08876275643042054},
    {0: 0.2413651341592667, 2: -0.8845494793282861, 3: 0.924834003261792},
    {0: 0.037037037037037035, 3: 0.17082860872947386, 4: 0.12546768756682242},
    {0: 0.037109375, 3: 0.17025221101954405, 4: 0.06021653898045596, 5: -0.017578125},
    {
        0: 0.03709200011850479, 3: 0.17038392571223998, 4: 0.10726203044637328, 5: -0.015319437748624402,
        6: 0.008273789163814023,
    },
    {
        0: 0.6241109587160757, 3: -3.3608926294469414, 4: -0.868219346841726, 5: 27.59209969944671,
        6: 20.154067550477894, 7: -43.48988418106996,
    },
    {
        0: 0.47766253643826434, 3: -2.4881146199716677, 4: -0.590290826836843, 5: 21.230051448181193,
        6: 15.279233632882423, 7: -33.28821096898486, 8: -0.020331201708508627,
    },
    {
        0: -0.9371424300859873, 3: 5.186372428844064, 4: 1.0914373489967295, 5: -8.149787010746927,
        6: -18.52006565999696, 7: 22.739487099350505, 8: 2.4936055526796523, 9: -3.0467644718982196,
    },
    {
        0: 2.273310147516538, 3: -10.53449546673725, 4: -2.0008720582248625, 5: -17.9589318631188,
        6: 27.94888452941996, 7: -2.8589982771350235, 8: -8.87285693353063, 9: 12.360567175794303,
        10: 0.6433927460157636,
    },
    {
        0: 0.054293734116568765, 5: 4.450312892752409, 6: 1.8915178993145003, 7: -5.801203960010585,
        8: 0.3111643669578199, 9: -0.1521609496625161, 10: 0.20136540080403034, 11: 0.04471061572777259,
    },
    {
        0: 0.056167502283047954, 6: 0.25350021021662483, 7: -0.2462390374708025, 8: -0.12419142326381637,
        9: 0.15329179827876568, 10: 0.00820105229563469, 11: 0.007567897660545699, 12: -0.008298,
    },
    {
        0: 0.03183464816350214, 5: 0.028300909672366776, 6: 0.053541988307438566, 7: -0.05492374857139099,
        10: -0.00010834732869724932, 11: 0.0003825710908356584, 12: -0.00034046500868740456,
        13: 0.1413124436746325,
    },
    {
        0: -0.42889630158379194, 5: -4.697621415361164, 6: 7.683421196062599, 7: 4.06898981839711,
        8: 0.3567271874552811, 12: -0.0013990241651590145, 13: 2.9475147891527724, 14: -9.15095847217987,
    },
)
ERRORS: tuple[Row, Row] = (
    {
        0: 0.01312004499419488, 5: -1.2251564463762044, 6: -0.4957589496572502, 7: 1.6643771824549864,
        8: -0.35032884874997366, 9: 0.3341791187130175, 10: 0.08192320648511571, 11: -0.022355307863886294,
    },
    {
        0: -0.18980075407240762, 5: 4.450312892752409, 6: 1.8915178993145003, 7: -5.801203960010585,
        8: -0.4226823213237919, 9: -0.1521609496625161, 10: 0.20136540080403034, 11: 0.02265179219836082,
    },
)
DENSE: tuple[Row, ...] = (
    {
        0: -8.428938276109013, 5: 0.5667149535193777, 6: -3.0689499459498917, 7: 2.38466765651207,
        8: 2.117034582445028, 9: -0.871391583777973, 10: 2.2404374302607883, 11: 0.6315787787694688,
        12: -0.08899033645133331, 13: 18.148505520854727, 14: -9.194632392478356, 15: -4.436036387594894,
    },
    {
        0: 10.427508642579134, 5: 242.28349177525817, 6: 165.20045171727028, 7: -374.5467547226902,
        8: -22.113666853125306, 9: 7.733432668472264, 10: -30.674084731089398, 11: -9.332130526430229,
        12: 15.697238121770845, 13: -31.139403219565178, 14: -9.35292435884448, 15: 35.81684148639408,
    },
    {
        0: 19.985053242002433, 5: -387.0373087493518, 6: -189.17813819516758, 7: 527.8081592054236,
        8: -11.57390253995963, 9: 6.8812326946963, 10: -1.0006050966910838, 11: 0.7777137798053443,
        12: -2.778205752353508, 13: -60.19669523126412, 14: 84.32040550667716, 15: 11.99229113618279,
    },
    {
        0: -25.69393346270375, 5: -154.18974869023643, 6: -231.5293791760455, 7: 357.6391179106141,
        8: 93.40532418362432, 9: -37.45832313645163, 10: 104.0996495089623, 11: 29.8402934266605,
        12: -43.53345659001114, 13: 96.32455395918828, 14: -39.17726167561544, 15: -149.72683625798564,
    },
)
@cache
def dormand_prince_853() -> EmbeddedPair:
    """Order 8: for tight tolerances and smooth motions."""
    return EmbeddedPair("Dormand-Prince 8(5,3)", _fill(MATRIX, 16), 13, 8, _fill(ERRORS, 13), 8, _polynomial(), 7)


def _fill(rows: tuple[Row, ...], columns: int) -> Floats:
    matrix = np.zeros((len(rows), columns))
    for i, row in enumerate(rows):
        for j, value in row.items():
            matrix[i, j] = value
    return frozen(matrix)


def _polynomial() -> Floats:
    """P (16, 7) from the nested form y0 + x (F0 + (1 - x) (F1 + x (F2 + ...))), F linear in the stages."""
    change, first, last = _fill(MATRIX, 16)[12], np.eye(16)[0], np.eye(16)[12]
    nested = [change, first - change, 2.0 * change - first - last, *_fill(DENSE, 16)]
    total, factor = np.zeros((16, 8)), np.ones(1)
    for level, weights in enumerate(nested):
        factor = polynomial.polymul(factor, [0.0, 1.0] if level % 2 == 0 else [1.0, -1.0])
        total[:, : len(factor)] += np.outer(weights, factor)
    return frozen(total[:, 1:])


PAIRS: dict[str, Callable[[], EmbeddedPair]] = {
    "bs23": bogacki_shampine,
    "dp45": dormand_prince,
    "dop853": dormand_prince_853,
}
"""Made, and checked, when they are first asked for."""
def pair(name: str) -> EmbeddedPair:
    """The pair of that name.

    Raises:
        InputError: there is none; the sentence lists the names.
    """
    if name not in PAIRS:
        raise InputError("input.choice", name="method", value=name, known=", ".join(PAIRS))
    return PAIRS[name]()
