"""Linear differential equations xdot = A x with constant A: the exponential of a matrix by several methods.

`exponential` is the accurate one (scaling and squaring). Series, similarity and the characteristic polynomial are the
methods of the textbook; each says how far it carries.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial, inf
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, real_array, whole
from mafsil.errors import InputError
from mafsil.floating_point import EPS
from mafsil.geometry.tolerances import ROUNDOFF


@dataclass(frozen=True)
class SeriesSum:
    """A truncated exponential series.

    Attributes:
        value: (n, n) sum of the terms.
        terms: how many were summed.
        rest: largest norm that the rest of the series can have; infinite as long as the terms still grow.
        rounding: largest norm of what rounding has done to the sum.
    """

    value: Floats
    terms: int
    rest: float
    rounding: float

    @property
    def bound(self) -> float:
        """Largest distance (spectral norm) of the value from e^(At): rest and rounding together."""
        return self.rest + self.rounding


def exponential(A: ArrayLike, t: float = 1.0) -> Floats:
    """(*batch, n, n) e^(At) of (*batch, n, n).

    Reference: Al-Mohy & Higham, A new scaling and squaring algorithm, SIAM J. Matrix Anal. Appl. 31, 2009 (SciPy).
    """
    return np.asarray(_scipy_expm(_square(A) * t), dtype=np.float64)


def solution(A: ArrayLike, x0: ArrayLike, t: float) -> Floats:
    """(n,) x(t) = e^(At) x0 of xdot = A x."""
    return exponential(A, t) @ real_array("x0", x0)


def series(
    A: ArrayLike, t: float = 1.0, tolerance: float = 1e-15, most: int = 200, *, terms: int | None = None
) -> SeriesSum:
    """Sum of (At)^k / k!: until the rest is below the tolerance, or a given number of terms.

    With a = |At| and n terms summed, n + 1 > a, the rest is at most a^n / n! / (1 - a / (n + 1)). The terms grow to
    e^a before they fall, and every one is rounded: where a is large and e^(At) small, as for A = (-30), rounding
    leaves nothing of the sum. `rounding` says so; `exponential` has no such trouble.

    Args:
        A: (n, n).
        t: time.
        tolerance: largest norm of the rest, absolute.
        most: largest number of terms.
        terms: how many terms are summed, whatever the rest; as many as the tolerance needs if None.

    Raises:
        InputError: `most` terms do not reach the tolerance.
    """
    step = _square(A) * t
    size = float(np.linalg.norm(step, 2))
    count = most if terms is None else whole("terms", terms, 1)
    unit = EPS / 2
    given = 0.0 if t == 1.0 else unit * float(np.linalg.norm(step))
    total, term, rest = np.zeros_like(step), np.eye(len(step)), inf
    wrong_term, rounding = 0.0, 0.0
    for n in range(1, count + 1):
        total = total + term
        rounding += wrong_term + unit * float(np.linalg.norm(total))
        wrong_term = _rounding_of_next(term, step, wrong_term, given, n)
        term = term @ step / n
        rest = _rest(size, n)
        if terms is None and rest <= tolerance:
            return SeriesSum(total, n, rest, rounding)
    if terms is None:
        raise InputError("geometry.convergence", name="A", terms=most, bound=rest, tolerance=tolerance)
    return SeriesSum(total, count, rest, rounding)


def _rounding_of_next(term: Floats, step: Floats, wrong: float, given: float, n: int) -> float:
    """Bound of the error of term @ step / n where term is wrong by `wrong` and step by `given` (Frobenius norms).

    An inner product of m numbers is wrong by at most m units of the product of absolute values; the division adds one.
    """
    unit = EPS / 2
    size, factor = float(np.linalg.norm(term)), float(np.linalg.norm(step))
    rounded = 1.01 * (len(step) + 1) * unit
    return (wrong * (factor + given) + size * given + rounded * size * factor) / n


def by_similarity(A: ArrayLike, t: float = 1.0) -> tuple[Floats, float]:
    """P e^(Dt) P^-1 with A = P D P^-1, and the condition number of P, by which rounding is multiplied.

    A condition number beyond 1e12 says that A has too few eigenvectors: use `exponential`.

    Args:
        A: (n, n).
        t: time.
    """
    values, vectors = np.linalg.eig(_square(A))
    grown = (vectors * np.exp(values * t)) @ np.linalg.pinv(vectors)
    return np.asarray(grown.real, dtype=np.float64), float(np.linalg.cond(vectors))


def characteristic_polynomial(A: ArrayLike) -> Floats:
    """(n + 1,) coefficients of det(s I - A), highest power first.

    Reference: Gantmacher, The Theory of Matrices, sec. 4.5 (Faddeev-LeVerrier).
    """
    matrix = _square(A)
    n = len(matrix)
    coefficients, M = [1.0], np.zeros_like(matrix)
    for k in range(1, n + 1):
        M = matrix @ M + coefficients[-1] * np.eye(n)
        coefficients.append(float(-np.trace(matrix @ M) / k))
    return np.array(coefficients)


def polynomial_of(coefficients: ArrayLike, A: ArrayLike) -> Floats:
    """(n, n) p(A), coefficients highest power first; zero for the characteristic polynomial (Cayley-Hamilton)."""
    matrix = _square(A)
    value = np.zeros_like(matrix)
    for coefficient in real_array("coefficients", coefficients):
        value = value @ matrix + coefficient * np.eye(len(matrix))
    return value


def by_characteristic_polynomial(A: ArrayLike, t: float = 1.0) -> Floats:
    """e^(At) as a polynomial of degree n - 1 in A, which is what Cayley-Hamilton leaves of the series (Putzer).

    e^(At) = sum over k of r_k(t) (A - s_1) ... (A - s_k), rdot_k = s_(k+1) r_k + r_(k-1), s the eigenvalues

    Args:
        A: (n, n).
        t: time.

    Reference: Putzer, Avoiding the Jordan canonical form, Amer. Math. Monthly 73, 1966.
    """
    matrix = _square(A).astype(complex)
    n = len(matrix)
    values = np.linalg.eigvals(matrix)
    chain = np.diag(values) + np.diag(np.ones(n - 1), -1)
    weights = _complex_exponential(chain * t)[:, 0]
    total, product = np.zeros_like(matrix), np.eye(n, dtype=complex)
    for weight, value in zip(weights, values, strict=True):
        total = total + weight * product
        product = product @ (matrix - value * np.eye(n))
    return np.real(total).astype(np.float64)


def commute(A: ArrayLike, B: ArrayLike, tolerance: float = ROUNDOFF) -> bool:
    """Whether AB = BA within the tolerance, relative to their norms: then e^A e^B = e^(A + B)."""
    a, b = _square(A), _square(B)
    return bool(np.linalg.norm(a @ b - b @ a) <= tolerance * (1 + np.linalg.norm(a) * np.linalg.norm(b)))


def _complex_exponential(M: NDArray[Any]) -> NDArray[Any]:
    return np.asarray(_scipy_expm(M))


def _scipy_expm(M: NDArray[Any]) -> NDArray[Any]:
    """SciPy's matrix exponential, loaded when it is called for."""
    from scipy import linalg

    return linalg.expm(M)


def _rest(size: float, n: int) -> float:
    """Bound of the sum of size^k / k! over k >= n."""
    return inf if n + 1 <= size or n > 170 else size**n / factorial(n) / (1 - size / (n + 1))


def _square(A: ArrayLike) -> Floats:
    array = real_array("A", A)
    if array.ndim < 2 or array.shape[-1] != array.shape[-2]:
        raise InputError("input.shape", name="A", expected="(*batch, n, n)", got=array.shape, hint="")
    return array
