"""Orientations through many orientations: squad, and the spline of rotation vectors with continuous acceleration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, RotationMatrix, Vector3
from mafsil.geometry import rotation
from mafsil.trajectory.paths.rotation_motion import (
    RotationMotion,
    exponential,
    inverse,
    logarithm,
    product,
    rotate_rows,
)
from mafsil.trajectory.profiles.polynomial import cubic_coefficients
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial

MOST_ROUNDS, CONVERGED = 100, 1e-14


@dataclass(frozen=True, eq=False)
class Squad:
    """Spherical quadrangle interpolation: continuous rate, given orientations met.

    S(h) = slerp(slerp(R_i, R_i+1, h), slerp(A_i, A_i+1, h), 2 h (1 - h)),
    A_i = R_i exp(-(log(R_i^T R_i+1) + log(R_i^T R_i-1)) / 4)

    Attributes:
        knots: (k + 1,) places from 0 to 1.
        R, A: (k + 1, 3, 3) orientations and inner control orientations.

    Reference: Shoemake, Quaternion calculus and fast animation, 1987. Continuous rates want knots of even spacing.
    """

    knots: Floats
    R: RotationMatrix
    A: RotationMatrix

    @classmethod
    def through(cls, R: RotationMatrix, knots: Floats) -> Squad:
        """Through orientations (k + 1, 3, 3) at places (k + 1,)."""
        A = R.copy()
        back = np.swapaxes(R[1:-1], -1, -2)
        A[1:-1] = R[1:-1] @ rotation.exp(-(rotation.log(back @ R[2:]) + rotation.log(back @ R[:-2])) / 4)
        return cls(knots, R, A)

    @property
    def breaks(self) -> Floats:
        """The knots."""
        return self.knots

    def at(self, s: Floats) -> RotationMotion:
        """Rotation, rate and its derivative."""
        i, h, width = _locate(self.knots, s)
        outer, inner = (_slerp(X[i], X[i + 1], h) for X in (self.R, self.A))
        between = logarithm(product(inverse(outer), inner))
        share, rate, growth = (x[..., None] for x in (2 * h * (1 - h), 2 - 4 * h, np.full_like(h, -4.0)))
        L, L_1, L_2 = between
        step = exponential(share * L, rate * L + share * L_1, growth * L + 2 * rate * L_1 + share * L_2)
        R, w, a = product(outer, step)
        return RotationMotion(R, w / width[..., None], a / width[..., None] ** 2)


@dataclass(frozen=True, eq=False)
class RotationSpline:
    """R = R_i exp([theta_i(s)]) with cubic theta_i: rate and angular acceleration are continuous.

    Attributes:
        R: (k, 3, 3) orientation at the start of every piece.
        theta: (3) rotation vectors over 0 .. 1, zero at the start of every piece [rad].

    Reference: Markley, Optimal interpolation of rotations, as in scipy's RotationSpline; the ends turn at the mean rate
        of the pieces there.
    """

    R: RotationMatrix
    theta: PiecewisePolynomial

    @classmethod
    def through(cls, R: RotationMatrix, knots: Floats) -> RotationSpline:
        """Through orientations (k + 1, 3, 3) at places (k + 1,)."""
        h = np.diff(knots)
        turn = rotation.log(np.swapaxes(R[:-1], -1, -2) @ R[1:])
        w = _continuous_rates(turn, h)
        ends = rotate_rows(rotation.right_jacobian_inverse(turn), w[1:])
        pieces = [cubic_coefficients(np.zeros(3), turn[i], w[i], ends[i], float(h[i])) for i in range(len(h))]
        theta = PiecewisePolynomial.from_pieces(h, pieces)
        return cls(R[:-1], PiecewisePolynomial(knots, theta.coefficients))

    @property
    def breaks(self) -> Floats:
        """The knots."""
        return self.theta.knots

    def at(self, s: Floats) -> RotationMotion:
        """Rotation, rate and its derivative."""
        inside = np.clip(s, 0.0, 1.0)
        i, _, _ = _locate(self.theta.knots, inside)
        R, w, a = exponential(*self.theta.at(inside))
        return RotationMotion(self.R[i] @ R, w, a)


def _continuous_rates(turn: Vector3, h: Floats) -> Vector3:
    """(k + 1, 3) body rates at the knots with which the angular acceleration is continuous.

    At the end of a piece  a = J_r theta'' + J_r' theta',  at the start of the next  a = theta''; both are linear in the
    rates but for J_r' theta', which is brought in round by round.
    """
    k = len(h)
    w = np.concatenate([turn[:1] / h[0], (turn[:-1] / h[:-1, None] + turn[1:] / h[1:, None]) / 2, turn[-1:] / h[-1]])
    if k == 1:
        return w
    J, J_inverse = rotation.right_jacobian(turn), rotation.right_jacobian_inverse(turn)
    M = np.zeros((3 * (k - 1), 3 * (k + 1)))
    fixed = np.zeros((k - 1, 3))
    for i in range(1, k):
        rows = slice(3 * (i - 1), 3 * i)
        before, after = h[i - 1], h[i]
        # J (2 w_i-1 + 4 J^-1 w_i - 6 turn / h) / h + convective = (6 turn / h - 4 w_i - 2 J^-1 w_i+1) / h
        M[rows, 3 * (i - 1) : 3 * i] = 2 * J[i - 1] / before
        M[rows, 3 * i : 3 * (i + 1)] = (4 / before + 4 / after) * np.eye(3)
        M[rows, 3 * (i + 1) : 3 * (i + 2)] = 2 * J_inverse[i] / after
        fixed[i - 1] = 6 * turn[i] / after**2 + 6 * J[i - 1] @ turn[i - 1] / before**2
    inner: Floats = M[:, 3:-3]
    for _ in range(MOST_ROUNDS):
        slope = rotate_rows(J_inverse[:-1], w[1:-1])
        convective = exponential(turn[:-1], slope, np.zeros_like(slope)).a
        right: Floats = (fixed - convective).ravel() - M[:, :3] @ w[0] - M[:, -3:] @ w[-1]
        found: Vector3 = np.linalg.solve(inner, right).astype(np.float64).reshape(-1, 3)
        change = float(np.abs(found - w[1:-1]).max())
        w[1:-1] = found
        if change <= CONVERGED * max(1.0, float(np.abs(found).max())):
            break
    return w


def _locate(knots: Floats, s: Floats) -> tuple[NDArray[np.intp], Floats, Floats]:
    """Index of the piece, share of it that is done, and its width."""
    i = np.clip(np.searchsorted(knots, s, side="right") - 1, 0, len(knots) - 2)
    width = knots[i + 1] - knots[i]
    return i, (s - knots[i]) / width, width


def _slerp(A: RotationMatrix, B: RotationMatrix, h: Floats) -> RotationMotion:
    """A exp(h log(A^T B)) over h."""
    k = rotation.log(np.swapaxes(A, -1, -2) @ B)
    step = exponential(h[..., None] * k, k, np.zeros_like(k))
    return RotationMotion(A @ step.R, step.w, step.a)
