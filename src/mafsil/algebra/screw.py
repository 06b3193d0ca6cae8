"""Screws: axis, point and pitch <-> the 6-vector S = (omega, v), and displacements along them, as expressions."""

from __future__ import annotations

import mafsil.expression as ex
from mafsil.algebra import quaternion, se3, so3
from mafsil.algebra.spatial import angular, cross, length, linear
from mafsil.algebra.tolerance import TRANSLATION


def from_axis(direction: ex.Expression, point: ex.Expression, pitch: ex.Expression) -> ex.Expression:
    """(6,) S = (s, -s x q + h s), s the unit vector along a direction, q a point [m] of the axis, h its pitch [m/rad].

    Reference: Lynch & Park, Modern Robotics, sec. 3.3.2.2.
    """
    direction = direction / length(direction)
    return ex.vertcat(direction, cross(point, direction) + pitch * direction)


def pitch(S: ex.Expression) -> ex.Expression:
    """Pitch omega.v / omega.omega [m/rad]; infinite where omega is zero."""
    omega, v = angular(S), linear(S)
    size = length(omega)
    rotates = size > 0
    divisor = ex.if_else(rotates, size, 1.0)
    return ex.if_else(rotates, ex.dot(omega / divisor, v) / divisor, ex.inf)


def nearest_point(S: ex.Expression) -> ex.Expression:
    """(3,) point of the axis nearest to the origin, omega x v / omega.omega [m]; NaN where omega is zero."""
    size = length(angular(S))
    return cross(angular(S) / size, linear(S)) / size


def wrench_pitch(F: ex.Expression) -> ex.Expression:
    """Pitch m.f / f.f [m] of a wrench (m, f); infinite where f is zero."""
    return pitch(ex.vertcat(linear(F), angular(F)))


def wrench_axis_point(F: ex.Expression) -> ex.Expression:
    """(3,) f x m / f.f [m]: the point nearest to the origin of the line on which the wrench is a force and a couple."""
    return nearest_point(ex.vertcat(linear(F), angular(F)))


def magnitude(V: ex.Expression) -> ex.Expression:
    """|omega|, or |v| where omega is zero; scaled inside, so that nothing over- or underflows."""
    omega, v = angular(V), linear(V)
    size = length(omega)
    return ex.if_else(size > 0, size, length(v))


def normalise(V: ex.Expression) -> ex.Expression:
    """(6,) unit screw S of V = S theta: |omega| = 1, or omega = 0 and |v| = 1; zero for the zero twist."""
    size = magnitude(V)
    return V / ex.if_else(size > 0, size, 1.0)


def displacement(S: ex.Expression, amount: ex.Expression) -> ex.Expression:
    """(4, 4) exp([S] q) of a unit screw: |omega| = 1, q an angle [rad]; or omega = 0, q a distance [m].

    R = I + sin(q) [omega] + (1 - cos(q)) [omega]^2
    p = (q I + (1 - cos(q)) [omega] + (q - sin(q)) [omega]^2) v

    by half angles, so that small amounts keep their digits; no small-angle switch is needed.

    Reference: Lynch & Park, Modern Robotics, prop. 3.25.
    """
    omega, v = angular(S), linear(S)
    c, s = ex.cos(amount / 2), ex.sin(amount / 2)
    R = quaternion.to_matrix_unit(ex.vertcat(c, s * omega))
    a = cross(omega, v)
    return se3.pose(R, amount * v + 2 * s**2 * a + (amount - 2 * s * c) * cross(omega, a))


def motion(S: ex.Expression, amount: ex.Expression) -> ex.Expression:
    """(4, 4) exp([S] q) of a screw of any length: `displacement` without the promise that S is unit."""
    return se3.exp(S * amount)


def chasles(T: ex.Expression, tolerance: float = TRANSLATION) -> tuple[ex.Expression, ex.Expression]:
    """Unit screw S (6,) and amount (angle [rad], or distance [m]) of a displacement: T = exp([S] amount).

    Rotations of less than `tolerance` [rad] count as none: the displacement is then a translation.
    """
    V = se3.log(T)
    omega = angular(V)
    rotates = length(omega) > tolerance
    V = ex.vertcat(ex.if_else(rotates, omega, ex.zeros(3)), ex.if_else(rotates, linear(V), se3.translation(T)))
    return normalise(V), magnitude(V)


def integral(omega: ex.Expression, theta: ex.Expression) -> ex.Expression:
    """(3, 3) G(theta) = I theta + (1 - cos) [omega] + (theta - sin) [omega]^2, |omega| = 1: p = G v of exp([S] theta).

    Reference: Lynch & Park, Modern Robotics, eq. 3.87.
    """
    return theta * so3.left_jacobian(omega * theta)


def integral_inverse(omega: ex.Expression, theta: ex.Expression) -> ex.Expression:
    """(3, 3) G(theta)^-1 = I/theta - [omega]/2 + (1/theta - cot(theta/2)/2) [omega]^2, 0 < theta < 2 pi.

    Reference: Lynch & Park, Modern Robotics, eq. 3.92.
    """
    return so3.left_jacobian_inverse(omega * theta) / theta
