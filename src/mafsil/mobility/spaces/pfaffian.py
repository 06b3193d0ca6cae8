"""Velocity constraints A(q) q' = 0 as expressions: rank, admissible velocities, growth vectors, integrability.

Whether the constraints come from equations of configurations is Frobenius' question: the distribution ker A is closed
under brackets [X, Y] = (DY) X - (DX) Y, or it grows until n - m functions of q stay constant. Exactness of a row
(d a_j/d q_k = d a_k/d q_j) answers less, since rows may be multiplied by functions of q.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

import mafsil.expression as ex
from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, real_array, single
from mafsil.errors import InputError
from mafsil.mobility.tolerances import RANK
from mafsil.solvers.decompositions import null_basis, ranks

Rows: TypeAlias = Callable[[Any], Sequence[Sequence[Any]]]
VectorField: TypeAlias = Callable[[Any], Any]
SAMPLES = 8
"""Configurations at which ranks are taken: a rank found at one of them is right; all miss a larger one only if it
vanishes on all of them."""


class Integrability(Status):
    """What the constraints leave of the configurations."""

    HOLONOMIC = ("mobility.holonomic", True)
    PARTLY = ("mobility.partly_holonomic", False)
    NONHOLONOMIC = ("mobility.nonholonomic", False)


@dataclass(frozen=True, eq=False, repr=False)
class IntegrabilityAnswer(Answer, data="growth closed first_integrals contradiction"):
    """Frobenius' test; true if the constraints are those of configurations.

    Attributes:
        n: number of coordinates.
        growth: dimensions of D1 = ker A, D2 = D1 + [D1, D1], ... until it stops.
        closed: whether every row, as it is written, is the gradient of a function.
        contradiction: (row, j, k) with d a_j/d q_k differing most from d a_k/d q_j, or None.
    """

    n: int
    growth: tuple[int, ...]
    closed: bool
    contradiction: tuple[int, int, int] | None

    @property
    def first_integrals(self) -> int:
        """n - m: functions of q that no admissible motion changes."""
        return self.n - self.growth[-1]

    @property
    def status(self) -> Integrability:
        """Holonomic, partly so, or completely nonholonomic."""
        if len(self.growth) == 1:
            return Integrability.HOLONOMIC
        return Integrability.PARTLY if self.first_integrals else Integrability.NONHOLONOMIC

    def explain(self, language: str | None = None) -> str:
        """The finding with growth vector and number of first integrals."""
        return self.status.sentence(
            language, growth=", ".join(map(str, self.growth)), integrals=self.first_integrals, n=self.n
        )


@dataclass(frozen=True, eq=False)
class Pfaffian:
    """Constraints A(q) q' = 0.

    Attributes:
        names: of the n coordinates.
        rows: function of the coordinates that gives the rows of A, written with `mafsil.expression`.
        about: (n,) a configuration where the rows are defined; ranks are taken around it. Zero if None.
    """

    names: tuple[str, ...]
    rows: Rows
    about: tuple[float, ...] | None = None

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return len(self.names)

    @cached_property
    def symbols(self) -> Any:
        """The coordinates as a column of symbols."""
        return ex.symbol("q", self.n)

    @cached_property
    def expression(self) -> Any:
        """(k, n) A as an expression of `symbols`."""
        rows = self.rows(self.symbols)
        if not rows or any(len(row) != self.n for row in rows):
            raise InputError("mobility.pfaffian_rows", expected=self.n, got=[len(row) for row in rows])
        return ex.vertcat(*[ex.horzcat(*[ex.expression(value) for value in row]) for row in rows])

    @cached_property
    def _values(self) -> ex.Function:
        return ex.Function("A", [self.symbols], [self.expression])

    def matrix(self, q: ArrayLike) -> Floats:
        """(k, n) A at coordinates (n,).

        Raises:
            InputError: the rows have no finite value there.
        """
        return _finite(_numbers(self._values(single("q", q, (self.n,)))))

    def rank(self, q: ArrayLike) -> int:
        """Number of independent constraints at coordinates (n,)."""
        return int(ranks(self.matrix(q), RANK))

    def velocities(self, q: ArrayLike) -> Floats:
        """(n, n - rank) orthonormal basis of the admissible velocities at coordinates (n,)."""
        A = self.matrix(q)
        return null_basis(A, int(ranks(A, RANK)))

    def project_velocity(self, q: ArrayLike, qd: ArrayLike) -> Floats:
        """(n,) the admissible velocity nearest to a velocity (n,), by least squares of the coordinates' rates."""
        basis = self.velocities(q)
        return basis @ (basis.T @ single("qd", qd, (self.n,)))

    def residual(self, q: ArrayLike, qd: ArrayLike) -> Floats:
        """(k,) A(q) q': zero for admissible velocities."""
        return self.matrix(q) @ single("qd", qd, (self.n,))

    @cached_property
    def samples(self) -> Floats:
        """(SAMPLES, n) configurations in general position around `about`."""
        middle = np.zeros(self.n) if self.about is None else np.array(self.about)
        found = middle + np.random.default_rng(0).uniform(-0.45, 0.45, (SAMPLES, self.n))
        for q in found:
            self.matrix(q)
        return found

    @cached_property
    def fields(self) -> tuple[Any, ...]:
        """Vector fields (n, 1) that span ker A around the samples: elimination with pivots large at all of them."""
        return _kernel(self.expression, self.symbols, self.samples)

    @cached_property
    def integrability(self) -> IntegrabilityAnswer:
        """Frobenius' test with the growth vector.

        1. Fields X_1 ... X_d that span D1 = ker A, by elimination.
        2. D_(i+1) = D_i + [D1, D_i], ranks at configurations in general position, until the dimension stays or is n.
        3. Exactness of each row, as written.

        Reference: R. M. Murray, Z. Li, S. S. Sastry, A mathematical introduction to robotic manipulation, ch. 7.
        """
        growth, closed = growth_vector(self.fields, self.symbols, self.samples), self._exactness()
        return IntegrabilityAnswer(self.n, growth, closed is None, closed)

    def _exactness(self) -> tuple[int, int, int] | None:
        worst, place = 0.0, None
        for row in range(self.expression.rows):
            D = ex.Function("da", [self.symbols], [ex.jacobian(self.expression[row, :].T, self.symbols)])
            for q in self.samples:
                J = _numbers(D(q))
                apart = np.abs(J - J.T)
                if apart.max() > max(worst, RANK * max(1.0, float(np.abs(J).max()))):
                    worst = float(apart.max())
                    j, k = np.unravel_index(int(apart.argmax()), apart.shape)
                    place = (row, int(j), int(k))
        return place

    def potential(self, row: int, q: ArrayLike, start: ArrayLike | None = None) -> float:
        """The function whose gradient an exact row is: its integral along the line from `start` (`about` if None) to q.

        Raises:
            InputError: the row is not exact; the sentence names the two coordinates whose derivatives differ.
        """
        bad = self._exactness()
        if bad is not None and bad[0] == row:
            raise InputError("mobility.not_exact", row=row, first=self.names[bad[1]], second=self.names[bad[2]])
        base = np.array(self.about or np.zeros(self.n)) if start is None else single("start", start, (self.n,))
        along = single("q", q, (self.n,)) - base
        nodes, weights = np.polynomial.legendre.leggauss(40)
        values = [float(self.matrix(base + (1 + s) / 2 * along)[row] @ along) for s in nodes]
        return float(np.dot(weights, values)) / 2

    def keeps(self, function: Callable[[Any], Any]) -> bool:
        """Whether a function of the coordinates is a first integral: constant along all admissible motions."""
        gradient = ex.jacobian(ex.expression(function(self.symbols)), self.symbols)
        rates = [ex.Function("rate", [self.symbols], [gradient @ field]) for field in self.fields]
        size = ex.Function("size", [self.symbols], [gradient])
        return all(
            abs(_numbers(rate(q)).item()) <= 1e-10 * max(1.0, float(np.abs(_numbers(size(q))).max()))
            for rate in rates
            for q in self.samples
        )


def lie_bracket(X: VectorField, Y: VectorField) -> VectorField:
    """The field [X, Y] = (DY) X - (DX) Y: the direction in which going along X, Y, -X and -Y ends.

    Args:
        X, Y: functions of the coordinates that give n components each, written with `mafsil.expression`; brackets too.

    Returns:
        A function of coordinates: numbers (n,) give numbers (n,), symbols expressions.
    """

    def bracket(q: Any) -> Any:
        if isinstance(q, ex.Expression):
            return _bracket(_column(X(q)), _column(Y(q)), q)
        here = real_array("q", q)
        symbols = ex.symbol("q", here.size)
        return _finite(
            _numbers(ex.Function("bracket", [symbols], [bracket(symbols)])(single("q", here, (here.size,)))).T
        )[0]

    return bracket


def _column(field: Any) -> Any:
    """(n, 1) of the components of a field."""
    return field if isinstance(field, ex.Expression) else ex.vertcat(*[ex.expression(value) for value in field])


def _bracket(X: Any, Y: Any, q: Any) -> Any:
    """(n, 1) [X, Y] = (DY) X - (DX) Y of fields as expressions of q."""
    return ex.jacobian(Y, q) @ X - ex.jacobian(X, q) @ Y


def growth_vector(fields: Sequence[Any], q: Any, samples: Floats) -> tuple[int, ...]:
    """Dimensions of D1, D2 = D1 + [D1, D1], D3 = D2 + [D1, D2], ... at configurations in general position.

    Args:
        fields: (n, 1) expressions of q that span D1.
        q: (n, 1) symbols.
        samples: (k, n) configurations.
    """
    if not fields:
        return (0,)
    n, newest, values = q.rows, list(fields), [_at(field, q, samples) for field in fields]
    growth = [_dimension(values)]
    while growth[-1] < n:
        made: list[Any] = []
        for X in fields:
            for Y in newest:
                Z = _bracket(X, Y, q)
                value = _at(Z, q, samples)
                # What is left where both halves of a bracket cancel has no direction.
                value[np.linalg.norm(value, axis=1) <= RANK * _bracket_size(X, Y, q, samples)] = 0.0
                if _dimension([*values, value]) > _dimension(values):
                    values.append(value)
                    made.append(Z)
        if not made:
            break
        growth.append(_dimension(values))
        newest = made
    return tuple(growth)


def _bracket_size(X: Any, Y: Any, q: Any, samples: Floats) -> Floats:
    """(k,) |DY| |X| + |DX| |Y| at all samples: how large a bracket could be."""
    sizes = [
        np.linalg.norm(_at(ex.vec(ex.jacobian(A, q)), q, samples), axis=1) * np.linalg.norm(_at(B, q, samples), axis=1)
        for A, B in ((Y, X), (X, Y))
    ]
    return sizes[0] + sizes[1]


def _at(field: Any, q: Any, samples: Floats) -> Floats:
    """(k, n) a field at all samples."""
    function = ex.Function("X", [q], [field])
    return np.array([_numbers(function(point)).ravel() for point in samples])


def _dimension(values: Sequence[Floats]) -> int:
    """Largest rank of the fields at any sample."""
    A = np.stack(values, axis=1)
    size = np.linalg.norm(A, axis=2, keepdims=True)
    A = A / np.where(size > 0, size, 1.0)
    return int(ranks(A, RANK).max(initial=0))


def _kernel(A: Any, q: Any, samples: Floats) -> tuple[Any, ...]:
    """Fields that span ker A: Gauss-Jordan elimination, each pivot the entry that is largest where it is smallest."""
    k, n = A.rows, A.columns
    rows = [[A[i, j] for j in range(n)] for i in range(k)]
    pivots: list[int] = []
    for done in range(k):
        sizes = np.zeros((k, n))
        function = ex.Function("rows", [q], [ex.vertcat(*[ex.horzcat(*row) for row in rows])])
        numbers = np.abs([_numbers(function(point)) for point in samples])
        sizes[done:] = numbers.min(axis=0)[done:]
        sizes[:, pivots] = 0.0
        i, j = (int(v) for v in np.unravel_index(int(sizes.argmax()), sizes.shape))
        if sizes[i, j] <= RANK * max(1.0, float(numbers.max())):
            break
        rows[done], rows[i] = rows[i], rows[done]
        pivot = rows[done][j]
        rows[done] = [value / pivot for value in rows[done]]
        for other in range(k):
            if other != done:
                factor = rows[other][j]
                rows[other] = [a - factor * b for a, b in zip(rows[other], rows[done], strict=True)]
        pivots.append(j)
    free = [j for j in range(n) if j not in pivots]
    fields: list[Any] = []
    for j in free:
        column = [ex.expression(0.0)] * n
        column[j] = ex.expression(1.0)
        for row, pivot_column in enumerate(pivots):
            column[pivot_column] = -rows[row][j]
        fields.append(ex.vertcat(*column))
    return tuple(fields)


def _numbers(value: Any) -> Floats:
    """A constant matrix of expressions as an array."""
    return np.array([[float(value[i, j]) for j in range(value.columns)] for i in range(value.rows)])


def _finite(A: Floats) -> Floats:
    if not np.isfinite(A).all():
        raise InputError("mobility.pfaffian_finite", row=int(np.flatnonzero(~np.isfinite(A).all(axis=1))[0]))
    return A
