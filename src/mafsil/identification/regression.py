"""Parameters from long logs: by weighted least squares, and among physically consistent bodies.

Of all rows of a joint one small triangular factor is kept. Consistent are the parameters of all links near those of
before, as far as the data let them: a body's pseudo-inertia [[S, h], [h', m]], S the integral of x x' dm, is positive
definite exactly if a distribution of mass has it. Written as L A A' L' with L the Cholesky factor of before and A upper
triangular with exponentials on its diagonal, it is so for every x; x = 0 is the body of before and |x| a distance that
does not depend on units.

Reference: Wensing, Kim & Slotine, IEEE RA-L 3, 2018; Rucker & Wensing, Smooth parameterization of rigid-body inertia,
IEEE RA-L 7, 2022.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.identification.tolerances import LEAST_NOISE, LEAST_SHARE, NO_EFFORT
from mafsil.solvers.least_squares import levenberg_marquardt

Indices: TypeAlias = NDArray[np.int64]
"""Indices of parameters."""
_UPPER = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
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


def pseudo_inertia(parameters: Floats) -> Floats:
    """(4, 4) of the ten parameters (m, h, Ixx, Iyy, Izz, Ixy, Ixz, Iyz) about the frame's origin."""
    m, hx, hy, hz, xx, yy, zz, xy, xz, yz = parameters
    trace = (xx + yy + zz) / 2
    return np.array(
        [
            [trace - xx, -xy, -xz, hx],
            [-xy, trace - yy, -yz, hy],
            [-xz, -yz, trace - zz, hz],
            [hx, hy, hz, m],
        ]
    )


def parameters_of_pseudo(P: Floats) -> Floats:
    """(..., 10) parameters of pseudo-inertias (..., 4, 4); linear."""
    xx, yy, zz = P[..., 0, 0], P[..., 1, 1], P[..., 2, 2]
    mass, first = P[..., 3, 3, None], P[..., :3, 3]
    moments = np.stack([yy + zz, xx + zz, xx + yy], axis=-1)
    products = -np.stack([P[..., 0, 1], P[..., 0, 2], P[..., 1, 2]], axis=-1)
    return np.concatenate([mass, first, moments, products], axis=-1)


def physically_consistent(parameters: Floats) -> bool:
    """Whether a body can have these ten parameters: its pseudo-inertia is positive definite."""
    return bool(np.linalg.eigvalsh(pseudo_inertia(parameters))[0] > 0.0)


def nearest_consistent(parameters: Floats, length: float) -> Floats:
    """The ten parameters, changed as little as makes them those of a body with some thickness.

    Args:
        parameters: (10,), mass > 0.
        length: [m] of the robot; bodies are kept thicker than LEAST_SHARE times this.
    """
    m, h = parameters[0], parameters[1:4]
    c = h / m
    P = pseudo_inertia(parameters)
    second = P[:3, :3] - m * np.outer(c, c)
    values, axes = np.linalg.eigh(second)
    least = m * (LEAST_SHARE * length) ** 2
    if values[0] >= least:
        return parameters
    P = P.copy()
    P[:3, :3] = (axes * np.maximum(values, least)) @ axes.T + m * np.outer(c, c)
    return parameters_of_pseudo(P)


def ball(mass: float, radius: float, centre: Floats) -> Floats:
    """(10,) parameters of a solid ball."""
    P = np.zeros((4, 4))
    P[:3, :3] = mass * (radius**2 / 5 * np.eye(3) + np.outer(centre, centre))
    P[:3, 3] = P[3, :3] = mass * centre
    P[3, 3] = mass
    return parameters_of_pseudo(P)


@dataclass(frozen=True, eq=False, slots=True)
class BodyParameterisation:
    """All physically consistent bodies, as x (10,) around one of them.

    Attributes:
        factor: (4, 4) Cholesky factor of the pseudo-inertia at x = 0.
    """

    factor: Floats

    @classmethod
    def around(cls, parameters: Floats) -> BodyParameterisation:
        """The parameterisation whose origin is a physically consistent body (10,)."""
        return cls(np.asarray(np.linalg.cholesky(pseudo_inertia(parameters)), dtype=np.float64))

    def at(self, x: Floats) -> tuple[Floats, Floats]:
        """Parameters (10,) of the body at x (10,), and their derivatives (10, 10)."""
        A, dA = np.diag(np.exp(x[:4])), np.zeros((10, 4, 4))
        for k in range(4):
            dA[k, k, k] = A[k, k]
        for k, (i, j) in enumerate(_UPPER, start=4):
            A[i, j] = x[k]
            dA[k, i, j] = 1.0
        left = self.factor @ dA @ A.T @ self.factor.T
        P = self.factor @ A @ A.T @ self.factor.T
        return parameters_of_pseudo(P), parameters_of_pseudo(left + left.transpose(0, 2, 1)).T


@dataclass(frozen=True, eq=False, slots=True)
class Parameterisation:
    """The parameters of a whole robot as x: physically consistent bodies, and plain numbers with a unit of each.

    Attributes:
        bodies: parameterisations by the place of the body's ten numbers among all.
        scale: (P,) unit of the other numbers; 0 for those that are fixed.
        prior: (P,) parameters at x = 0.
        spread: what |x| = 1 of a body counts.
    """

    bodies: dict[int, BodyParameterisation]
    scale: Floats
    prior: Floats
    spread: float

    @property
    def free(self) -> Indices:
        """Indices of the other numbers that are free."""
        return np.flatnonzero(self.scale).astype(np.int64)

    @property
    def size(self) -> int:
        """Length of x."""
        return 10 * len(self.bodies) + len(self.free)

    def at(self, x: Floats) -> tuple[Floats, Floats]:
        """Parameters (P,) at x, and their derivatives (P, size)."""
        value, derivative = self.prior.copy(), np.zeros((len(self.prior), self.size))
        for k, (place, body) in enumerate(self.bodies.items()):
            part = slice(10 * k, 10 * k + 10)
            value[place : place + 10], rates = body.at(self.spread * x[part])
            derivative[place : place + 10, part] = self.spread * rates
        free, rest = self.free, slice(10 * len(self.bodies), None)
        value[free] += self.scale[free] * x[rest]
        derivative[free, np.arange(10 * len(self.bodies), self.size)] = self.scale[free]
        return value, derivative

    def with_fixed(self, places: Indices, values: Floats) -> Parameterisation:
        """The same parameterisation with some of the plain numbers fixed at values."""
        scale, prior = self.scale.copy(), self.prior.copy()
        scale[places], prior[places] = 0.0, values
        return Parameterisation(self.bodies, scale, prior, self.spread)


def most_likely(
    parameterisation: Parameterisation, triangle: Floats, combination: Floats, nonnegative: Indices
) -> Floats:
    """The most likely parameters (P,): physically consistent, close to the prior, and with small residuals.

    minimise |R (K parameters(x), -1)|^2 + |x|^2

    Args:
        parameterisation: where parameters may lie.
        triangle: R (k + 1, k + 1) weighted rows.
        combination: K (k, P) base parameters from all parameters.
        nonnegative: places of numbers that cannot be negative: friction and rotors.
    """
    while True:
        found = _minimum(parameterisation, triangle, combination)
        open_ones: Indices = np.intersect1d(nonnegative, parameterisation.free)
        negative: Indices = open_ones[found[open_ones] < 0.0]
        if not len(negative):
            return found
        parameterisation = parameterisation.with_fixed(negative, np.zeros(len(negative)))


def _minimum(parameterisation: Parameterisation, triangle: Floats, combination: Floats) -> Floats:
    A = triangle[:, :-1] @ combination

    def residual(x: Floats) -> tuple[Floats, Floats]:
        value, derivative = parameterisation.at(x)
        return np.concatenate([A @ value - triangle[:, -1], x]), np.vstack(
            [A @ derivative, np.eye(parameterisation.size)]
        )

    found = levenberg_marquardt(residual, np.zeros(parameterisation.size), tolerance=0.0, iterations=200)
    return parameterisation.at(found.value)[0]
