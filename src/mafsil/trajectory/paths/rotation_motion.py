"""A rotation that changes along a path, with its body rate and the derivative of that: how such curves are composed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mafsil.arrays import Floats, Matrix3, RotationMatrix, Vector3, cross
from mafsil.geometry import rotation

SMALL = 1e-2
"""Squared angle below which derivatives of the right Jacobian's coefficients come from their series."""


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
