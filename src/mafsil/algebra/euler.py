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

import mafsil.expression as ex
from mafsil.algebra import quaternion, series
from mafsil.algebra.euler_sequence import SEQUENCES

GIMBAL = 4 * series.EPS
"""Angle [rad] to a gimbal lock, about the rounding of R, below which the leftmost angle is set to zero."""


def matrix(angles: ex.Expression, sequence: str) -> ex.Expression:
    """(3, 3) R of three angles [rad] in the order of the sequence's axes."""
    first, second, third = (elementary(axis, angle) for axis, angle in _factors(angles, sequence))
    return first @ second @ third


def elementary_rotation(angle: ex.Expression, axis: int) -> ex.Expression:
    """(3, 3) rotation about a coordinate axis; `elementary` with the expression first."""
    return elementary(axis, angle)


def elementary(axis: int, angle: ex.Expression) -> ex.Expression:
    """(3, 3) rotation about x (0), y (1) or z (2)."""
    c, s = ex.cos(angle), ex.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R = ex.eye(3)
    R[i, i], R[i, j], R[j, i], R[j, j] = c, -s, s, c
    return R


def to_quaternion(angles: ex.Expression, sequence: str) -> ex.Expression:
    """(4,) unit quaternion of three angles [rad]."""
    q = ex.Expression([1, 0, 0, 0])
    for axis, angle in _factors(angles, sequence):
        turn = ex.zeros(4)
        turn[0], turn[1 + axis] = ex.cos(angle / 2), ex.sin(angle / 2)
        q = quaternion.multiply(q, turn)
    return q


def angles_of_quaternion(q: ex.Expression, sequence: str) -> ex.Expression:
    """(2, 3) both solutions [rad] of a quaternion of any length; row 0 is the principal one.

    Principal middle angle: [-pi/2, pi/2], or [0, pi] where first and third axis are equal; the others in (-pi, pi].
    At a gimbal lock the first factor's angle (leftmost in R) is zero in both rows.
    """
    known = SEQUENCES[sequence]
    n1, n2, n3 = (_unit(axis) for axis in known.body_axes)
    rows = ex.vertcat(*_solve(q, n1, n2, n3, known.symmetric))
    return rows[:, ::-1] if known.fixed else rows


def principal_angles(R: ex.Expression, sequence: str) -> ex.Expression:
    """(3,) the principal solution [rad] of a rotation matrix; see `angles_of_quaternion`."""
    return angles(R, sequence)[0, :].T


def angles(R: ex.Expression, sequence: str) -> ex.Expression:
    """(2, 3) both solutions [rad] of a rotation matrix; see `angles_of_quaternion`."""
    return angles_of_quaternion(quaternion.proportional_to_matrix(R), sequence)


def davenport_matrix(a: ex.Expression, axes: ex.Expression) -> ex.Expression:
    """(3, 3) R = Rot(n1, a1) Rot(n2, a2) Rot(n3, a3); unit axes n1, n2, n3 are the rows of `axes`."""
    q = ex.Expression([1, 0, 0, 0])
    for k in range(3):
        turn = ex.vertcat(ex.cos(a[k] / 2), ex.sin(a[k] / 2) * axes[k, :].T)
        q = quaternion.multiply(q, turn)
    return quaternion.to_matrix(q)


def davenport_angles(R: ex.Expression, axes: ex.Expression) -> ex.Expression:
    """(2, 3) both angle triples [rad] of R about the rows n1, n2, n3 of `axes`, n2 orthogonal to n1 and n3."""
    q = quaternion.proportional_to_matrix(R)
    return ex.vertcat(*_solve(q, axes[0, :].T, axes[1, :].T, axes[2, :].T, None))


def gimbal_distance(R: ex.Expression, axes: ex.Expression) -> ex.Expression:
    """|sin(b + lambda)|: zero exactly at a gimbal lock, n1 and the moved n3 then being parallel."""
    moved = ex.cross(axes[0, :].T, R @ axes[2, :].T)
    return ex.sqrt(ex.dot(moved, moved))


def rate_matrix(angles: ex.Expression, sequence: str) -> ex.Expression:
    """(3, 3) E with omega_s = E (angle rates): column k is the axis of angle k as it stands now, in {s}.

    Reference: Craig, Introduction to Robotics, sec. 5.3.
    """
    carried = ex.eye(3)
    columns: list[ex.Expression] = []
    for axis, angle in _factors(angles, sequence):
        columns.append(carried[:, axis])
        carried = carried @ elementary(axis, angle)
    return ex.horzcat(*(columns[::-1] if SEQUENCES[sequence].fixed else columns))


def _factors(angles: ex.Expression, sequence: str) -> list[tuple[int, ex.Expression]]:
    """Axis and angle of every factor of R, from left to right."""
    known = SEQUENCES[sequence]
    ordered = [angles[0], angles[1], angles[2]]
    return list(zip(known.body_axes, ordered[::-1] if known.fixed else ordered, strict=True))


def _unit(axis: int) -> ex.Expression:
    return ex.Expression([float(axis == k) for k in range(3)])


def _solve(
    q: ex.Expression, n1: ex.Expression, n2: ex.Expression, n3: ex.Expression, symmetric: bool | None
) -> Sequence[ex.Expression]:
    """Both angle triples, rows (1, 3); `symmetric` is None for axes not known beforehand."""
    n0 = ex.cross(n2, n1)
    cos_lambda, sin_lambda = ex.dot(n1, n3), ex.dot(n2, ex.cross(n1, n3))
    u = quaternion.vector(q)
    turned = ex.vertcat(q[0], ex.dot(n0, u), ex.dot(n2, u), ex.dot(n1, u))
    w, x, y, z = ex.vertsplit(quaternion.multiply(turned, _half_turn(cos_lambda, sin_lambda)))

    upright, tilted = w**2 + z**2, x**2 + y**2
    half_sum, half_difference = ex.atan2(z, w), ex.atan2(-x, y)
    flat, inverted = tilted <= (GIMBAL / 2) ** 2 * upright, upright <= (GIMBAL / 2) ** 2 * tilted
    half_sum = ex.if_else(inverted, -half_difference, half_sum)
    half_difference = ex.if_else(flat, -half_sum, half_difference)
    first, third = half_sum + half_difference, half_sum - half_difference
    locked = ex.logic_or(flat, inverted)
    other_first = ex.if_else(locked, 0.0, first + ex.pi)
    # At a lock both rows keep the first angle zero: turning b over the lock changes nothing but rounding.
    other_third = ex.if_else(locked, third, third + ex.pi)

    if symmetric is True:
        b = 2 * ex.atan2(ex.sqrt(tilted), ex.sqrt(upright))
        plus, minus, plus_first = b, -b, ex.Expression(1)
    elif symmetric is False:
        # sin(b) is an entry of R here: taken directly, so that small middle angles keep their digits.
        sine = -sin_lambda * ex.dot(n1, _rotate(q, n3))
        b = ex.atan2(sine, 2 * ex.sqrt(upright * tilted))
        far = ex.if_else(b < 0, -ex.pi - b, ex.pi - b)
        is_plus = sin_lambda > 0
        plus, minus = ex.if_else(is_plus, b, far), ex.if_else(is_plus, far, b)
        plus_first = is_plus
    else:
        b = 2 * ex.atan2(ex.sqrt(tilted), ex.sqrt(upright))
        shift = ex.atan2(sin_lambda, cos_lambda)
        plus, minus, plus_first = _wrap(b - shift), _wrap(-b - shift), sin_lambda >= 0
    first_plus = ex.horzcat(_wrap(first), plus, _wrap(third))
    first_minus = ex.horzcat(_wrap(other_first), minus, _wrap(other_third))
    return ex.if_else(plus_first, first_plus, first_minus), ex.if_else(plus_first, first_minus, first_plus)


def _half_turn(cos_lambda: ex.Expression, sin_lambda: ex.Expression) -> ex.Expression:
    """Quaternion, of any length, of the turn lambda about y: (1 + cos, 0, sin, 0), or (0, 0, 1, 0) at lambda = pi."""
    opposite = cos_lambda < -0.5
    w = ex.if_else(opposite, sin_lambda, 1 + cos_lambda)
    y = ex.if_else(opposite, 1 - cos_lambda, sin_lambda)
    return ex.vertcat(w, 0, y, 0)


def _rotate(q: ex.Expression, x: ex.Expression) -> ex.Expression:
    """R(q) x times twice |q|^2, which is the squared length of the turned quaternion."""
    u = quaternion.vector(q)
    a = 2 * ex.cross(u, x)
    return 2 * (ex.dot(q, q) * x + q[0] * a + ex.cross(u, a))


def _wrap(angle: ex.Expression) -> ex.Expression:
    """The angle in (-pi, pi], for angles within (-3 pi, 3 pi]."""
    lowered = ex.if_else(angle > ex.pi, angle - 2 * ex.pi, angle)
    return ex.if_else(lowered <= -ex.pi, lowered + 2 * ex.pi, lowered)
