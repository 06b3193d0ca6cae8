"""The group of rigid motions SE(3): compose, inverse, exp, log, adjoint and Jacobians, as expressions.

Velocities of rotations and poses from their derivatives, and back, as expressions.
"""

from __future__ import annotations

import mafsil.expression as ex
from mafsil.algebra import quaternion, series, so3, spatial
from mafsil.algebra.spatial import angular, cross, linear, skew, skew_square


def pose(R: ex.Expression, p: ex.Expression) -> ex.Expression:
    """(4, 4) T = [[R, p], [0, 1]]."""
    return ex.vertcat(ex.horzcat(R, p), ex.Expression([[0, 0, 0, 1]]))


def rotation(T: ex.Expression) -> ex.Expression:
    """(3, 3) R of T."""
    return T[:3, :3]


def translation(T: ex.Expression) -> ex.Expression:
    """(3,) p of T [m]."""
    return T[:3, 3]


def compose(T_ab: ex.Expression, T_bc: ex.Expression) -> ex.Expression:
    """(4, 4) T_ac = T_ab T_bc = (R_ab R_bc, R_ab p_bc + p_ab)."""
    R, p = rotation(T_ab), translation(T_ab)
    return pose(R @ rotation(T_bc), R @ translation(T_bc) + p)


def inverse(T: ex.Expression) -> ex.Expression:
    """(4, 4) T^-1 = (R', -R'p)."""
    R = rotation(T)
    return pose(R.T, -(R.T @ translation(T)))


def act(T: ex.Expression, x: ex.Expression) -> ex.Expression:
    """(3,) R x + p: a point x_b seen from {a}, or a point displaced by T."""
    return rotation(T) @ x + translation(T)


def exp(V: ex.Expression) -> ex.Expression:
    """(4, 4) T = (exp(omega), J(omega) v) of exponential coordinates V = (omega, v) [rad, m].

    Reference: Lynch & Park, Modern Robotics, prop. 3.25, with omega any length.
    """
    r, v = angular(V), linear(V)
    return pose(so3.exp(r), so3.apply_left_jacobian(r, v))


def log(T: ex.Expression) -> ex.Expression:
    """(6,) V = (omega, v) with exp(V) = T, |omega| in [0, pi].

    omega = log R, v = J(omega)^-1 p

    Reference: Lynch & Park, Modern Robotics, sec. 3.3.3.2.
    """
    q = quaternion.proportional_to_matrix(rotation(T))
    r = quaternion.log(q)
    return ex.vertcat(r, so3.apply_left_jacobian_inverse(r, translation(T)))


def adjoint(T: ex.Expression) -> ex.Expression:
    """(6, 6) Ad(T) = [[R, 0], [[p] R, R]] for twists (omega, v).

    Reference: Lynch & Park, Modern Robotics, def. 3.20.
    """
    R = rotation(T)
    return ex.blockcat([[R, ex.zeros(3, 3)], [skew(translation(T)) @ R, R]])


def body_error(T_sb: ex.Expression, T_sd: ex.Expression) -> ex.Expression:
    """(6,) body twist log(T_sb^-1 T_sd) that takes {b} to {d} in unit time."""
    return log(compose(inverse(T_sb), T_sd))


def space_error(T_sb: ex.Expression, T_sd: ex.Expression) -> ex.Expression:
    """(6,) space twist log(T_sd T_sb^-1) that takes {b} to {d} in unit time."""
    return log(compose(T_sd, inverse(T_sb)))


def left_jacobian(V: ex.Expression) -> ex.Expression:
    """(6, 6) J with V_s = J(V) Vdot for T = exp(V): [[J, 0], [Q, J]], Q the slope of J(omega) along v.

    The blocks are those of an analytic function of ad(V) = [[ [omega], 0 ], [ [v], [omega] ]], which acts like the
    dual number [omega] + epsilon [v].

    Reference: Barfoot, State Estimation for Robotics, eq. 7.85.
    """
    r, v = angular(V), linear(V)
    s = ex.dot(r, r)
    Q = _slope(r, v, series.versinc(s), series.sinc_defect(s), series.versinc_slope(s), series.sinc_defect_slope(s))
    return _lower_block(so3.left_jacobian(r), Q)


def left_jacobian_inverse(V: ex.Expression) -> ex.Expression:
    """(6, 6) inverse of the left Jacobian, for |omega| < 2 pi: [[J^-1, 0], [slope of J^-1 along v, J^-1]]."""
    r, v = angular(V), linear(V)
    s = ex.dot(r, r)
    slope = _slope(
        r, v, ex.Expression(-0.5), series.cotangent_defect(s), ex.Expression(0), series.cotangent_defect_slope(s)
    )
    return _lower_block(so3.left_jacobian_inverse(r), slope)


def right_jacobian(V: ex.Expression) -> ex.Expression:
    """(6, 6) J(-V), with V_b = J_r(V) Vdot for T = exp(V)."""
    return left_jacobian(-V)


def right_jacobian_inverse(V: ex.Expression) -> ex.Expression:
    """(6, 6) inverse of the right Jacobian, for |omega| < 2 pi."""
    return left_jacobian_inverse(-V)


def interpolate_screw(T_0: ex.Expression, T_1: ex.Expression, t: ex.Expression) -> ex.Expression:
    """(4, 4) T_0 exp(t log(T_0^-1 T_1)): one screw motion from T_0 (t = 0) to T_1 (t = 1)."""
    return compose(T_0, exp(t * body_error(T_0, T_1)))


def interpolate_decoupled(T_0: ex.Expression, T_1: ex.Expression, t: ex.Expression) -> ex.Expression:
    """(4, 4) from T_0 (t = 0) to T_1 (t = 1): rotation at constant angular velocity, origin along the straight line."""
    R = rotation(T_0) @ so3.exp(t * so3.log(rotation(T_0).T @ rotation(T_1)))
    return pose(R, translation(T_0) + t * (translation(T_1) - translation(T_0)))


def _slope(
    r: ex.Expression,
    v: ex.Expression,
    b: ex.Expression,
    c: ex.Expression,
    b_slope: ex.Expression,
    c_slope: ex.Expression,
) -> ex.Expression:
    """(3, 3) derivative along v of I + b [r] + c [r]^2, b and c functions of s = r.r with the slopes given."""
    inner = ex.dot(r, v)
    outer = v @ r.T
    mixed = outer + outer.T - 2 * inner * ex.eye(3)
    return b * skew(v) + c * mixed + 2 * inner * (b_slope * skew(r) + c_slope * skew_square(r))


def _lower_block(diagonal: ex.Expression, corner: ex.Expression) -> ex.Expression:
    return ex.blockcat([[diagonal, ex.zeros(3, 3)], [corner, diagonal]])


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
    omega, defect = angular_body(rotation(T), rotation(Tdot))
    return ex.vertcat(omega, rotation(T).T @ translation(Tdot)), defect


def space_twist(T: ex.Expression, Tdot: ex.Expression) -> tuple[ex.Expression, ex.Expression]:
    """V_s (6,) with [V_s] = Tdot T^-1: (omega_s, pdot - omega_s x p), and the defect.

    Reference: Lynch & Park, Modern Robotics, eq. 3.74.
    """
    omega, defect = angular_space(rotation(T), rotation(Tdot))
    return ex.vertcat(omega, translation(Tdot) - cross(omega, translation(T))), defect


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
    return space_error(T_0, T_1) / duration


def _skew_part(W: ex.Expression) -> tuple[ex.Expression, ex.Expression]:
    symmetric = (W + W.T) / 2
    size, rest = ex.sqrt(ex.sumsqr(W)), ex.sqrt(ex.sumsqr(symmetric))
    return so3.vee(W), ex.if_else(size > 0, rest / ex.if_else(size > 0, size, 1.0), rest)
