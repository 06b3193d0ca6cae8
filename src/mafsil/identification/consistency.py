"""Physically consistent bodies: the parameters of all links near those of before, as far as the data let them.

A body's pseudo-inertia [[S, h], [h', m]], S the integral of x x' dm, is positive definite exactly if a distribution of
mass has it. Written as L A A' L' with L the Cholesky factor of before and A upper triangular with exponentials on its
diagonal, it is so for every x; x = 0 is the body of before and |x| a distance that does not depend on units.

Reference: Wensing, Kim & Slotine, IEEE RA-L 3, 2018; Rucker & Wensing, Smooth parameterization of rigid-body inertia,
IEEE RA-L 7, 2022.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.identification.tolerances import LEAST_SHARE
from mafsil.solvers.least_squares import levenberg_marquardt

Indices: TypeAlias = NDArray[np.int64]
"""Indices of parameters."""
_UPPER = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))


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
