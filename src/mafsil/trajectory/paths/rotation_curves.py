"""Orientations through many orientations: squad, and the spline of rotation vectors with continuous acceleration.

A rotation that changes along a path, with its body rate and the derivative of that: how such curves are composed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, Matrix3, RotationMatrix, Vector3, cross
from mafsil.geometry import rotation
from mafsil.trajectory.profiles.polynomial import cubic_coefficients
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial

SMALL = 1e-2
"""Squared angle below which derivatives of the right Jacobian's coefficients come from their series."""
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


class RotationMotion(NamedTuple):
    """R(s) with R' = R [w].

    Attributes:
        R: (*s, 3, 3).
        w: (*s, 3) body rate by s.
        a: (*s, 3) its derivative.
    """

    R: RotationMatrix
    w: Vector3
    a: Vector3


def exponential(K: Vector3, K_1: Vector3, K_2: Vector3) -> RotationMotion:
    """exp([K(s)]) of a rotation vector with its two derivatives: w = J_r K', a = J_r K'' + J_r' K'.

    Args:
        K: (..., 3) rotation vectors [rad] along the curve.
        K_1: (..., 3) dK/ds.
        K_2: (..., 3) d2K/ds2.
    """
    J = rotation.right_jacobian(K)
    return RotationMotion(rotation.exp(K), rotate_rows(J, K_1), rotate_rows(J, K_2) + _carry(K, K_1))


def logarithm(curve: RotationMotion) -> tuple[Vector3, Vector3, Vector3]:
    """The rotation vector of a curve and its two derivatives; the curve stays within less than half a turn."""
    K = rotation.log(curve.R)
    inverse = rotation.right_jacobian_inverse(K)
    K_1 = rotate_rows(inverse, curve.w)
    return K, K_1, rotate_rows(inverse, curve.a - _carry(K, K_1))


def product(A: RotationMotion, B: RotationMotion) -> RotationMotion:
    """A(s) B(s)."""
    back = np.swapaxes(B.R, -1, -2)
    seen = rotate_rows(back, A.w)
    return RotationMotion(A.R @ B.R, seen + B.w, rotate_rows(back, A.a) - cross(B.w, seen) + B.a)


def inverse(A: RotationMotion) -> RotationMotion:
    """The transposed curve."""
    return RotationMotion(np.swapaxes(A.R, -1, -2), -rotate_rows(A.R, A.w), -rotate_rows(A.R, A.a))


def run(curve: RotationMotion, rate: Floats, growth: Floats) -> RotationMotion:
    """The curve over another parameter.

    Args:
        curve: over s, at the places reached.
        rate, growth: (*s,) first and second derivative of s by that parameter.
    """
    once, twice = rate[..., None], growth[..., None]
    return RotationMotion(curve.R, curve.w * once, curve.a * once**2 + curve.w * twice)


def of_matrices(R: Matrix3, R_1: Matrix3, R_2: Matrix3) -> RotationMotion:
    """From a rotation matrix and its two derivatives: [w] = R' R_1, [a] = R' R_2 - [w]^2."""
    back = np.swapaxes(R, -1, -2)
    w = _skew_part(back @ R_1)
    return RotationMotion(R, w, _skew_part(back @ R_2))


def rotate_rows(M: Matrix3, x: Vector3) -> Vector3:
    """M x, row by row."""
    return np.einsum("...ij,...j->...i", M, x)


def _skew_part(M: Matrix3) -> Vector3:
    """The vector of (M - M') / 2."""
    return (
        np.stack([M[..., 2, 1] - M[..., 1, 2], M[..., 0, 2] - M[..., 2, 0], M[..., 1, 0] - M[..., 0, 1]], axis=-1) / 2
    )


def _carry(K: Vector3, K_1: Vector3) -> Vector3:
    """J_r'(K) K', where J_r = 1 - b [K] + c [K]^2 and b, c depend on x = |K|^2."""
    x = (K * K).sum(axis=-1, keepdims=True)
    small = x < SMALL
    safe = np.where(small, 1.0, x)
    angle = np.sqrt(safe)
    b, c = (1.0 - np.cos(angle)) / safe, (angle - np.sin(angle)) / (safe * angle)
    b_slope = np.where(
        small, -1 / 24 + x * (1 / 360 - x * (1 / 13440 - x / 907200)), (np.sin(angle) / angle - 2 * b) / (2 * safe)
    )
    c_slope = np.where(small, -1 / 120 + x * (1 / 2520 - x * (1 / 120960 - x / 9979200)), (b - 3 * c) / (2 * safe))
    c = np.where(small, 1 / 6 - x * (1 / 120 - x * (1 / 5040 - x / 362880)), c)
    growth = 2 * (K * K_1).sum(axis=-1, keepdims=True)
    across = np.cross(K, K_1)
    return growth * (c_slope * np.cross(K, across) - b_slope * across) + c * np.cross(K_1, across)
