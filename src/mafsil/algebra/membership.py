"""Conditions under which numbers of a user are what they are called: a rotation, a pose, a unit quaternion, an axis."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca

from mafsil.algebra import se3, so3
from mafsil.algebra.tolerance import AXIS, ROTATION, UNIT


def unit_quaternion(q: ca.SX) -> ca.SX:
    """1 where | |q| - 1 | is within the tolerance UNIT, else 0."""
    return ca.fabs(ca.sqrt(ca.dot(q, q)) - 1) <= UNIT


def non_zero(x: ca.SX) -> ca.SX:
    """1 where the vector has a direction: not zero and finite, else 0."""
    largest = ca.fabs(x[0])
    for k in range(1, x.numel()):
        largest = ca.fmax(largest, ca.fabs(x[k]))
    return ca.logic_and(largest >= AXIS, ca.dot(x, x) < ca.inf)


def axis_triple(axes: ca.SX) -> ca.SX:
    """1 where the rows are unit and the second is orthogonal to the other two, within UNIT, else 0."""
    inside = ca.SX(1)
    for k in range(3):
        inside = ca.logic_and(inside, ca.fabs(ca.dot(axes[k, :], axes[k, :]) - 1) <= UNIT)
    for k in (0, 2):
        inside = ca.logic_and(inside, ca.fabs(ca.dot(axes[1, :], axes[k, :])) <= UNIT)
    return inside


def planar_rotation(R: ca.SX) -> ca.SX:
    """1 where a (2, 2) matrix is a rotation within the tolerance ROTATION, else 0."""
    a, b = R[:, 0], R[:, 1]
    inside = ca.logic_and(ca.fabs(ca.dot(a, a) - 1) <= ROTATION, ca.fabs(ca.dot(b, b) - 1) <= ROTATION)
    return ca.logic_and(ca.logic_and(inside, ca.fabs(ca.dot(a, b)) <= ROTATION), a[0] * b[1] - a[1] * b[0] > 0)


def planar_pose(T: ca.SX) -> ca.SX:
    """1 where a (3, 3) matrix is a planar pose: its rotation is one and its last row is (0, 0, 1), else 0."""
    inside = planar_rotation(T[:2, :2])
    for k, wanted in enumerate((0, 0, 1)):
        inside = ca.logic_and(inside, T[2, k] == wanted)
    return inside


CONDITIONS: dict[str, Callable[[ca.SX], ca.SX]] = {
    "rotation": so3.is_rotation,
    "pose": se3.is_pose,
    "unit_quaternion": unit_quaternion,
    "axis": non_zero,
    "axis_triple": axis_triple,
    "planar_rotation": planar_rotation,
    "planar_pose": planar_pose,
}
"""Conditions by the name under which declarations and error sentences know them."""
