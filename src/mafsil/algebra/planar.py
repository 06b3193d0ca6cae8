"""Rigid motions of the plane: SO(2), SE(2) and poles, as expressions. Planar twist (omega, v_x, v_y)."""

from __future__ import annotations

import mafsil.expression as ex
from mafsil.algebra import series


def rotation(theta: ex.Expression) -> ex.Expression:
    """(2, 2) [[cos, -sin], [sin, cos]]."""
    c, s = ex.cos(theta), ex.sin(theta)
    return ex.blockcat([[c, -s], [s, c]])


def angle(R: ex.Expression) -> ex.Expression:
    """Angle theta in (-pi, pi] [rad] of a planar rotation."""
    return ex.atan2(R[1, 0] - R[0, 1], R[0, 0] + R[1, 1])


def pose(theta: ex.Expression, p: ex.Expression) -> ex.Expression:
    """(3, 3) homogeneous matrix of (theta [rad], p [m])."""
    return ex.vertcat(ex.horzcat(rotation(theta), p), ex.Expression([[0, 0, 1]]))


def coordinates(T: ex.Expression) -> ex.Expression:
    """(3,) (theta, p_x, p_y) [rad, m], theta in (-pi, pi]."""
    return ex.vertcat(angle(T[:2, :2]), T[0, 2], T[1, 2])


def inverse(T: ex.Expression) -> ex.Expression:
    """(3, 3) T^-1 = (R', -R'p)."""
    R = T[:2, :2]
    return ex.vertcat(ex.horzcat(R.T, -(R.T @ T[:2, 2])), ex.Expression([[0, 0, 1]]))


def compose(T_ab: ex.Expression, T_bc: ex.Expression) -> ex.Expression:
    """(3, 3) T_ac = (PQ, p + P q)."""
    P = T_ab[:2, :2]
    return ex.vertcat(ex.horzcat(P @ T_bc[:2, :2], T_ab[:2, 2] + P @ T_bc[:2, 2]), ex.Expression([[0, 0, 1]]))


def exp(V: ex.Expression) -> ex.Expression:
    """(3, 3) exp of a planar twist times time (omega, v_x, v_y) [rad, m].

    p = sin(omega)/omega v + (1 - cos(omega))/omega J v, J = [[0, -1], [1, 0]]

    Reference: Lynch & Park, Modern Robotics, sec. 3.3.3, restricted to the plane.
    """
    s, v = V[0] ** 2, V[1:]
    return pose(V[0], series.sinc(s) * v + V[0] * series.versinc(s) * _quarter(v))


def log(T: ex.Expression) -> ex.Expression:
    """(3,) planar twist (omega, v_x, v_y), omega in (-pi, pi]: v = (omega/2) cot(omega/2) p - (omega/2) J p."""
    theta, p = angle(T[:2, :2]), T[:2, 2]
    v = (1 - theta**2 * series.cotangent_defect(theta**2)) * p - theta / 2 * _quarter(p)
    return ex.vertcat(theta, v)


def pole(T: ex.Expression) -> ex.Expression:
    """(3,) homogeneous point (x, y, w) that the displacement keeps: (x, y) / w, or a direction where w is zero.

    (p + cot(psi/2) J p) / 2, multiplied by sin(psi/2): a translation by p has its pole at infinity across p.
    """
    half = angle(T[:2, :2]) / 2
    p = T[:2, 2]
    s, c = ex.sin(half), ex.cos(half)
    return ex.vertcat((s * p + c * _quarter(p)) / 2, s)


def about_pole(psi: ex.Expression, point: ex.Expression) -> ex.Expression:
    """(3, 3) displacement by psi [rad] about a point s [m]: d = (I - Rot(psi)) s, by half angles."""
    s, c = ex.sin(psi / 2), ex.cos(psi / 2)
    return pose(psi, 2 * s * (s * point - c * _quarter(point)))


def twist_of_pole(omega: ex.Expression, point: ex.Expression) -> ex.Expression:
    """(3,) omega (1, q_y, -q_x) of a rotation about the point q."""
    return omega * ex.vertcat(1, point[1], -point[0])


def adjoint(T: ex.Expression) -> ex.Expression:
    """(3, 3) for planar twists: V_a = Ad(T_ab) V_b, v_a = R v - omega J p."""
    R, p = T[:2, :2], T[:2, 2]
    return ex.blockcat([[ex.Expression([[1]]), ex.zeros(1, 2)], [-_quarter(p), R]])


def spatial_rotation(R: ex.Expression) -> ex.Expression:
    """(3, 3) the planar rotation about z in space."""
    return ex.blockcat([[R, ex.zeros(2, 1)], [ex.zeros(1, 2), ex.Expression([[1]])]])


def spatial_pose(T: ex.Expression) -> ex.Expression:
    """(4, 4) the planar motion in the x-y plane of space."""
    top = ex.horzcat(spatial_rotation(T[:2, :2]), ex.vertcat(T[:2, 2], 0))
    return ex.vertcat(top, ex.Expression([[0, 0, 0, 1]]))


def spatial_twist(V: ex.Expression) -> ex.Expression:
    """(6,) (0, 0, omega, v_x, v_y, 0): axis parallel to z, pitch zero."""
    return ex.vertcat(0, 0, V[0], V[1], V[2], 0)


def _quarter(x: ex.Expression) -> ex.Expression:
    """J x, a quarter turn to the left."""
    return ex.vertcat(-x[1], x[0])
