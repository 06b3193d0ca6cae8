"""Velocities of rotations and poses from their derivatives, and back, as expressions."""

from __future__ import annotations

import mafsil.expression as ex
from mafsil.algebra import se3, so3, spatial
from mafsil.algebra.spatial import cross


def angular_space(R: ex.Expression, Rdot: ex.Expression) -> tuple[ex.Expression, ex.Expression]:
    """omega_s (3,) with [omega_s] = Rdot R', and the defect: how far Rdot R' is from skew, over |Rdot|.

    Reference: Lynch & Park, Modern Robotics, prop. 3.9.
    """
    return _skew_part(Rdot @ R.T)


def angular_body(R: ex.Expression, Rdot: ex.Expression) -> tuple[ex.Expression, ex.Expression]:
    """omega_b (3,) with [omega_b] = R' Rdot, and the defect of R' Rdot."""
    return _skew_part(R.T @ Rdot)


def body_twist(T: ex.Expression, Tdot: ex.Expression) -> tuple[ex.Expression, ex.Expression]:
    """V_b (6,) with [V_b] = T^-1 Tdot: (omega_b, R' pdot), and the defect.

    Reference: Lynch & Park, Modern Robotics, eq. 3.72.
    """
    omega, defect = angular_body(se3.rotation(T), se3.rotation(Tdot))
    return ex.vertcat(omega, se3.rotation(T).T @ se3.translation(Tdot)), defect


def space_twist(T: ex.Expression, Tdot: ex.Expression) -> tuple[ex.Expression, ex.Expression]:
    """V_s (6,) with [V_s] = Tdot T^-1: (omega_s, pdot - omega_s x p), and the defect.

    Reference: Lynch & Park, Modern Robotics, eq. 3.74.
    """
    omega, defect = angular_space(se3.rotation(T), se3.rotation(Tdot))
    return ex.vertcat(omega, se3.translation(Tdot) - cross(omega, se3.translation(T))), defect


def pose_rate_of_body_twist(T: ex.Expression, V_b: ex.Expression) -> ex.Expression:
    """(4, 4) Tdot = T [V_b]."""
    return T @ spatial.hat(V_b)


def pose_rate_of_space_twist(T: ex.Expression, V_s: ex.Expression) -> ex.Expression:
    """(4, 4) Tdot = [V_s] T."""
    return spatial.hat(V_s) @ T


def mean_angular_velocity(R_0: ex.Expression, R_1: ex.Expression, duration: ex.Expression) -> ex.Expression:
    """(3,) omega_s = log(R_1 R_0') / duration: the constant angular velocity that turns R_0 into R_1."""
    return so3.log(R_1 @ R_0.T) / duration


def mean_space_twist(T_0: ex.Expression, T_1: ex.Expression, duration: ex.Expression) -> ex.Expression:
    """(6,) V_s = log(T_1 T_0^-1) / duration: the constant twist that carries T_0 into T_1."""
    return se3.space_error(T_0, T_1) / duration


def _skew_part(W: ex.Expression) -> tuple[ex.Expression, ex.Expression]:
    symmetric = (W + W.T) / 2
    size, rest = ex.sqrt(ex.sumsqr(W)), ex.sqrt(ex.sumsqr(symmetric))
    return so3.vee(W), ex.if_else(size > 0, rest / ex.if_else(size > 0, size, 1.0), rest)
