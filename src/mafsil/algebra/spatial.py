"""Twists (omega, v), wrenches (m, f), their brackets, changes of frame and power, as expressions."""

from __future__ import annotations

import casadi as ca


def cross(a: ca.SX, b: ca.SX) -> ca.SX:
    """(3,) a x b."""
    return ca.vertcat(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def skew(w: ca.SX) -> ca.SX:
    """(3, 3) matrix [w] with [w] x = w x x."""
    return ca.blockcat([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def skew_square(w: ca.SX) -> ca.SX:
    """(3, 3) [w]^2 = w w' - (w.w) I, the diagonal as sums of squares: nothing cancels."""
    x, y, z = w[0], w[1], w[2]
    return ca.blockcat([[-(y**2 + z**2), x * y, x * z], [x * y, -(x**2 + z**2), y * z], [x * z, y * z, -(x**2 + y**2)]])


def length(x: ca.SX) -> ca.SX:
    """|x| without over- or underflow."""
    scale = ca.fmax(ca.fmax(ca.fabs(x[0]), ca.fabs(x[1])), ca.fabs(x[2]))
    y = x / ca.if_else(scale > 0, scale, 1.0)
    return scale * ca.sqrt(ca.if_else(scale > 0, ca.dot(y, y), 1.0))


def angular(V: ca.SX) -> ca.SX:
    """(3,) first half: omega of a twist [rad/s], m of a wrench [N m]."""
    return V[:3]


def linear(V: ca.SX) -> ca.SX:
    """(3,) second half: v of a twist [m/s], f of a wrench [N]."""
    return V[3:]


def hat(V: ca.SX) -> ca.SX:
    """(4, 4) matrix [V] = [[ [omega], v ], [0, 0]] of a twist.

    Reference: Lynch & Park, Modern Robotics, eq. 3.70.
    """
    return ca.vertcat(ca.horzcat(skew(angular(V)), linear(V)), ca.SX.zeros(1, 4))


def vee(M: ca.SX) -> ca.SX:
    """(6,) twist of a (4, 4) matrix [V]; of its skew part where the upper left block is not skew."""
    return ca.vertcat((M[2, 1] - M[1, 2]) / 2, (M[0, 2] - M[2, 0]) / 2, (M[1, 0] - M[0, 1]) / 2, M[:3, 3])


def ad(V: ca.SX) -> ca.SX:
    """The (6, 6) matrix [[ [omega], 0 ], [ [v], [omega] ]] whose product with a twist is the Lie bracket.

    Reference: Lynch & Park, Modern Robotics, def. 8.5.
    """
    W = skew(angular(V))
    return ca.blockcat([[W, ca.SX.zeros(3, 3)], [skew(linear(V)), W]])


def bracket(V: ca.SX, W: ca.SX) -> ca.SX:
    """(6,) Lie bracket ad(V) W = (omega x w, v x w + omega x u) of twists V = (omega, v), W = (w, u)."""
    omega, v, w, u = angular(V), linear(V), angular(W), linear(W)
    return ca.vertcat(cross(omega, w), cross(v, w) + cross(omega, u))


def dual_bracket(V: ca.SX, F: ca.SX) -> ca.SX:
    """(6,) ad(V)' F = -(omega x m + v x f, omega x f), how a moving frame sees a constant wrench F = (m, f) change."""
    omega, v, m, f = angular(V), linear(V), angular(F), linear(F)
    return -ca.vertcat(cross(omega, m) + cross(v, f), cross(omega, f))


def transform_twist(T_ab: ca.SX, V_b: ca.SX) -> ca.SX:
    """(6,) V_a = Ad(T_ab) V_b = (R omega, R v + p x R omega).

    Reference: Lynch & Park, Modern Robotics, eq. 3.83.
    """
    R, p = T_ab[:3, :3], T_ab[:3, 3]
    omega = R @ angular(V_b)
    return ca.vertcat(omega, R @ linear(V_b) + cross(p, omega))


def transform_wrench(T_ab: ca.SX, F_a: ca.SX) -> ca.SX:
    """(6,) F_b = Ad(T_ab)' F_a = (R' (m - p x f), R' f): twists and wrenches cancel subscripts the other way round.

    Reference: Lynch & Park, Modern Robotics, eq. 3.98.
    """
    R, p = T_ab[:3, :3], T_ab[:3, 3]
    m, f = angular(F_a), linear(F_a)
    return ca.vertcat(R.T @ (m - cross(p, f)), R.T @ f)


def wrench_of_force(point: ca.SX, force: ca.SX) -> ca.SX:
    """(6,) wrench (r x f, f) of a force f [N] acting at a point r [m], both in one frame."""
    return ca.vertcat(cross(point, force), force)


def power(V: ca.SX, F: ca.SX) -> ca.SX:
    """V . F [W] of a twist and a wrench in one frame; the same in every frame."""
    return ca.dot(V, F)


def point_velocity(V: ca.SX, point: ca.SX) -> ca.SX:
    """(3,) omega x r + v [m/s]: velocity of the body point that is at r [m] now, all in the frame of the twist."""
    return cross(angular(V), point) + linear(V)


def reciprocal_product(V: ca.SX, W: ca.SX) -> ca.SX:
    """omega_V . v_W + v_V . omega_W: zero when two screws do no work on each other."""
    return ca.dot(angular(V), linear(W)) + ca.dot(linear(V), angular(W))
