"""Twists (omega, v), wrenches (m, f), their brackets, changes of frame and power, as expressions."""

from __future__ import annotations

import mafsil.expression as ex


def cross(a: ex.Expression, b: ex.Expression) -> ex.Expression:
    """(3,) a x b."""
    return ex.vertcat(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def skew(w: ex.Expression) -> ex.Expression:
    """(3, 3) matrix [w] with [w] x = w x x."""
    return ex.blockcat([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def skew_square(w: ex.Expression) -> ex.Expression:
    """(3, 3) [w]^2 = w w' - (w.w) I, the diagonal as sums of squares: nothing cancels."""
    x, y, z = w[0], w[1], w[2]
    return ex.blockcat([[-(y**2 + z**2), x * y, x * z], [x * y, -(x**2 + z**2), y * z], [x * z, y * z, -(x**2 + y**2)]])


def length(x: ex.Expression) -> ex.Expression:
    """|x| without over- or underflow."""
    scale = ex.fmax(ex.fmax(ex.fabs(x[0]), ex.fabs(x[1])), ex.fabs(x[2]))
    y = x / ex.if_else(scale > 0, scale, 1.0)
    return scale * ex.sqrt(ex.if_else(scale > 0, ex.dot(y, y), 1.0))


def angular(V: ex.Expression) -> ex.Expression:
    """(3,) first half: omega of a twist [rad/s], m of a wrench [N m]."""
    return V[:3]


def linear(V: ex.Expression) -> ex.Expression:
    """(3,) second half: v of a twist [m/s], f of a wrench [N]."""
    return V[3:]


def hat(V: ex.Expression) -> ex.Expression:
    """(4, 4) matrix [V] = [[ [omega], v ], [0, 0]] of a twist.

    Reference: Lynch & Park, Modern Robotics, eq. 3.70.
    """
    return ex.vertcat(ex.horzcat(skew(angular(V)), linear(V)), ex.zeros(1, 4))


def vee(M: ex.Expression) -> ex.Expression:
    """(6,) twist of a (4, 4) matrix [V]; of its skew part where the upper left block is not skew."""
    return ex.vertcat((M[2, 1] - M[1, 2]) / 2, (M[0, 2] - M[2, 0]) / 2, (M[1, 0] - M[0, 1]) / 2, M[:3, 3])


def ad(V: ex.Expression) -> ex.Expression:
    """The (6, 6) matrix [[ [omega], 0 ], [ [v], [omega] ]] whose product with a twist is the Lie bracket.

    Reference: Lynch & Park, Modern Robotics, def. 8.5.
    """
    W = skew(angular(V))
    return ex.blockcat([[W, ex.zeros(3, 3)], [skew(linear(V)), W]])


def bracket(V: ex.Expression, W: ex.Expression) -> ex.Expression:
    """(6,) Lie bracket ad(V) W = (omega x w, v x w + omega x u) of twists V = (omega, v), W = (w, u)."""
    omega, v, w, u = angular(V), linear(V), angular(W), linear(W)
    return ex.vertcat(cross(omega, w), cross(v, w) + cross(omega, u))


def dual_bracket(V: ex.Expression, F: ex.Expression) -> ex.Expression:
    """(6,) ad(V)' F = -(omega x m + v x f, omega x f), how a moving frame sees a constant wrench F = (m, f) change."""
    omega, v, m, f = angular(V), linear(V), angular(F), linear(F)
    return -ex.vertcat(cross(omega, m) + cross(v, f), cross(omega, f))


def transform_twist(T_ab: ex.Expression, V_b: ex.Expression) -> ex.Expression:
    """(6,) V_a = Ad(T_ab) V_b = (R omega, R v + p x R omega).

    Reference: Lynch & Park, Modern Robotics, eq. 3.83.
    """
    R, p = T_ab[:3, :3], T_ab[:3, 3]
    omega = R @ angular(V_b)
    return ex.vertcat(omega, R @ linear(V_b) + cross(p, omega))


def transform_wrench(T_ab: ex.Expression, F_a: ex.Expression) -> ex.Expression:
    """(6,) F_b = Ad(T_ab)' F_a = (R' (m - p x f), R' f): twists and wrenches cancel subscripts the other way round.

    Reference: Lynch & Park, Modern Robotics, eq. 3.98.
    """
    R, p = T_ab[:3, :3], T_ab[:3, 3]
    m, f = angular(F_a), linear(F_a)
    return ex.vertcat(R.T @ (m - cross(p, f)), R.T @ f)


def wrench_of_force(point: ex.Expression, force: ex.Expression) -> ex.Expression:
    """(6,) wrench (r x f, f) of a force f [N] acting at a point r [m], both in one frame."""
    return ex.vertcat(cross(point, force), force)


def power(V: ex.Expression, F: ex.Expression) -> ex.Expression:
    """V . F [W] of a twist and a wrench in one frame; the same in every frame."""
    return ex.dot(V, F)


def point_velocity(V: ex.Expression, point: ex.Expression) -> ex.Expression:
    """(3,) omega x r + v [m/s]: velocity of the body point that is at r [m] now, all in the frame of the twist."""
    return cross(angular(V), point) + linear(V)


def reciprocal_product(V: ex.Expression, W: ex.Expression) -> ex.Expression:
    """omega_V . v_W + v_V . omega_W: zero when two screws do no work on each other."""
    return ex.dot(angular(V), linear(W)) + ex.dot(linear(V), angular(W))
