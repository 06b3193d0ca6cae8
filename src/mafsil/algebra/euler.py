"""Rotations by three successive angles: all 24 coordinate sequences as data, and general (Davenport) axis triples.

R = Rot(n1, a) Rot(n2, b) Rot(n3, c) with n2 orthogonal to n1 and n3. With C = [n2 x n1, n2, n1] and
cos(lambda) = n1.n3, sin(lambda) = n2.(n1 x n3), the ZYZ angles of C' R Rot(n2, lambda) C are (a, b + lambda, c).
On the quaternion of that product, (w, x, y, z),

    a + c = 2 atan2(z, w),  a - c = 2 atan2(-x, y),  b + lambda = 2 atan2(|(x, y)|, |(w, z)|)

so at a gimbal lock the well-defined one of a + c and a - c stays exact.

Reference: Shuster & Markley, Generalization of the Euler angles, J. Astronautical Sciences 51, 2003.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from mafsil.algebra import quaternion, series
from mafsil.algebra.euler_sequence import SEQUENCES

GIMBAL = 4 * series.EPS
"""Angle [rad] to a gimbal lock, about the rounding of R, below which the leftmost angle is set to zero."""


def matrix(angles: ca.SX, sequence: str) -> ca.SX:
    """(3, 3) R of three angles [rad] in the order of the sequence's axes."""
    first, second, third = (elementary(axis, angle) for axis, angle in _factors(angles, sequence))
    return first @ second @ third


def elementary_rotation(angle: ca.SX, axis: int) -> ca.SX:
    """(3, 3) rotation about a coordinate axis; `elementary` with the expression first."""
    return elementary(axis, angle)


def elementary(axis: int, angle: ca.SX) -> ca.SX:
    """(3, 3) rotation about x (0), y (1) or z (2)."""
    c, s = ca.cos(angle), ca.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R = ca.SX.eye(3)
    R[i, i], R[i, j], R[j, i], R[j, j] = c, -s, s, c
    return R


def to_quaternion(angles: ca.SX, sequence: str) -> ca.SX:
    """(4,) unit quaternion of three angles [rad]."""
    q = ca.SX([1, 0, 0, 0])
    for axis, angle in _factors(angles, sequence):
        turn = ca.SX.zeros(4)
        turn[0], turn[1 + axis] = ca.cos(angle / 2), ca.sin(angle / 2)
        q = quaternion.multiply(q, turn)
    return q


def angles_of_quaternion(q: ca.SX, sequence: str) -> ca.SX:
    """(2, 3) both solutions [rad] of a quaternion of any length; row 0 is the principal one.

    Principal middle angle: [-pi/2, pi/2], or [0, pi] where first and third axis are equal; the others in (-pi, pi].
    At a gimbal lock the first factor's angle (leftmost in R) is zero in both rows.
    """
    known = SEQUENCES[sequence]
    n1, n2, n3 = (_unit(axis) for axis in known.body_axes)
    rows = ca.vertcat(*_solve(q, n1, n2, n3, known.symmetric))
    return rows[:, ::-1] if known.fixed else rows


def principal_angles(R: ca.SX, sequence: str) -> ca.SX:
    """(3,) the principal solution [rad] of a rotation matrix; see `angles_of_quaternion`."""
    return angles(R, sequence)[0, :].T


def angles(R: ca.SX, sequence: str) -> ca.SX:
    """(2, 3) both solutions [rad] of a rotation matrix; see `angles_of_quaternion`."""
    return angles_of_quaternion(quaternion.proportional_to_matrix(R), sequence)


def davenport_matrix(a: ca.SX, axes: ca.SX) -> ca.SX:
    """(3, 3) R = Rot(n1, a1) Rot(n2, a2) Rot(n3, a3); unit axes n1, n2, n3 are the rows of `axes`."""
    q = ca.SX([1, 0, 0, 0])
    for k in range(3):
        turn = ca.vertcat(ca.cos(a[k] / 2), ca.sin(a[k] / 2) * axes[k, :].T)
        q = quaternion.multiply(q, turn)
    return quaternion.to_matrix(q)


def davenport_angles(R: ca.SX, axes: ca.SX) -> ca.SX:
    """(2, 3) both angle triples [rad] of R about the rows n1, n2, n3 of `axes`, n2 orthogonal to n1 and n3."""
    q = quaternion.proportional_to_matrix(R)
    return ca.vertcat(*_solve(q, axes[0, :].T, axes[1, :].T, axes[2, :].T, None))


def gimbal_distance(R: ca.SX, axes: ca.SX) -> ca.SX:
    """|sin(b + lambda)|: zero exactly at a gimbal lock, n1 and the moved n3 then being parallel."""
    moved = ca.cross(axes[0, :].T, R @ axes[2, :].T)
    return ca.sqrt(ca.dot(moved, moved))


def rate_matrix(angles: ca.SX, sequence: str) -> ca.SX:
    """(3, 3) E with omega_s = E (angle rates): column k is the axis of angle k as it stands now, in {s}.

    Reference: Craig, Introduction to Robotics, sec. 5.3.
    """
    carried, columns = ca.SX.eye(3), []
    for axis, angle in _factors(angles, sequence):
        columns.append(carried[:, axis])
        carried = carried @ elementary(axis, angle)
    return ca.horzcat(*(columns[::-1] if SEQUENCES[sequence].fixed else columns))


def _factors(angles: ca.SX, sequence: str) -> list[tuple[int, ca.SX]]:
    """Axis and angle of every factor of R, from left to right."""
    known = SEQUENCES[sequence]
    ordered = [angles[0], angles[1], angles[2]]
    return list(zip(known.body_axes, ordered[::-1] if known.fixed else ordered, strict=True))


def _unit(axis: int) -> ca.SX:
    return ca.SX([float(axis == k) for k in range(3)])


def _solve(q: ca.SX, n1: ca.SX, n2: ca.SX, n3: ca.SX, symmetric: bool | None) -> Sequence[ca.SX]:
    """Both angle triples, rows (1, 3); `symmetric` is None for axes not known beforehand."""
    n0 = ca.cross(n2, n1)
    cos_lambda, sin_lambda = ca.dot(n1, n3), ca.dot(n2, ca.cross(n1, n3))
    u = quaternion.vector(q)
    turned = ca.vertcat(q[0], ca.dot(n0, u), ca.dot(n2, u), ca.dot(n1, u))
    w, x, y, z = ca.vertsplit(quaternion.multiply(turned, _half_turn(cos_lambda, sin_lambda)))

    upright, tilted = w**2 + z**2, x**2 + y**2
    half_sum, half_difference = ca.atan2(z, w), ca.atan2(-x, y)
    flat, inverted = tilted <= (GIMBAL / 2) ** 2 * upright, upright <= (GIMBAL / 2) ** 2 * tilted
    half_sum = ca.if_else(inverted, -half_difference, half_sum)
    half_difference = ca.if_else(flat, -half_sum, half_difference)
    first, third = half_sum + half_difference, half_sum - half_difference
    locked = ca.logic_or(flat, inverted)
    other_first = ca.if_else(locked, 0.0, first + ca.pi)
    # At a lock both rows keep the first angle zero: turning b over the lock changes nothing but rounding.
    other_third = ca.if_else(locked, third, third + ca.pi)

    if symmetric is True:
        b = 2 * ca.atan2(ca.sqrt(tilted), ca.sqrt(upright))
        plus, minus, plus_first = b, -b, ca.SX(1)
    elif symmetric is False:
        # sin(b) is an entry of R here: taken directly, so that small middle angles keep their digits.
        sine = -sin_lambda * ca.dot(n1, _rotated(q, n3))
        b = ca.atan2(sine, 2 * ca.sqrt(upright * tilted))
        far = ca.if_else(b < 0, -ca.pi - b, ca.pi - b)
        is_plus = sin_lambda > 0
        plus, minus = ca.if_else(is_plus, b, far), ca.if_else(is_plus, far, b)
        plus_first = is_plus
    else:
        b = 2 * ca.atan2(ca.sqrt(tilted), ca.sqrt(upright))
        shift = ca.atan2(sin_lambda, cos_lambda)
        plus, minus, plus_first = _wrap(b - shift), _wrap(-b - shift), sin_lambda >= 0
    first_plus = ca.horzcat(_wrap(first), plus, _wrap(third))
    first_minus = ca.horzcat(_wrap(other_first), minus, _wrap(other_third))
    return ca.if_else(plus_first, first_plus, first_minus), ca.if_else(plus_first, first_minus, first_plus)


def _half_turn(cos_lambda: ca.SX, sin_lambda: ca.SX) -> ca.SX:
    """Quaternion, of any length, of the turn lambda about y: (1 + cos, 0, sin, 0), or (0, 0, 1, 0) at lambda = pi."""
    opposite = cos_lambda < -0.5
    w = ca.if_else(opposite, sin_lambda, 1 + cos_lambda)
    y = ca.if_else(opposite, 1 - cos_lambda, sin_lambda)
    return ca.vertcat(w, 0, y, 0)


def _rotated(q: ca.SX, x: ca.SX) -> ca.SX:
    """R(q) x times twice |q|^2, which is the squared length of the turned quaternion."""
    u = quaternion.vector(q)
    a = 2 * ca.cross(u, x)
    return 2 * (ca.dot(q, q) * x + q[0] * a + ca.cross(u, a))


def _wrap(angle: ca.SX) -> ca.SX:
    """The angle in (-pi, pi], for angles within (-3 pi, 3 pi]."""
    lowered = ca.if_else(angle > ca.pi, angle - 2 * ca.pi, angle)
    return ca.if_else(lowered <= -ca.pi, lowered + 2 * ca.pi, lowered)
