"""How far numbers of a user are from being what they are called: a rotation, a pose, a unit quaternion, an axis.

Every measure is zero at a perfect member, infinite where no rounding can explain the distance, and NaN for NaN.

An algebra function by its name, as a function with one column per port, elements in C order.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from math import nan

import mafsil.expression as ex
from mafsil.algebra.spatial import angular, cross, length, linear
from mafsil.algebra.tolerance import LIMITS
from mafsil.floating_point import LEAST_DIVISOR


def rotation(M: ex.Expression) -> ex.Expression:
    """Frobenius norm of M'M - I of a (3, 3) matrix; infinite where det M <= 0."""
    a, b, c = M[:, 0], M[:, 1], M[:, 2]
    norms = (ex.dot(a, a) - 1) ** 2 + (ex.dot(b, b) - 1) ** 2 + (ex.dot(c, c) - 1) ** 2
    angles = ex.dot(a, b) ** 2 + ex.dot(a, c) ** 2 + ex.dot(b, c) ** 2
    return ex.if_else(ex.dot(a, cross(b, c)) > 0, ex.sqrt(norms + 2 * angles), ex.inf)


def pose(T: ex.Expression) -> ex.Expression:
    """Norm of that of the rotation of a (4, 4) matrix and of what its last row misses to (0, 0, 0, 1)."""
    return _with_last_row(T, rotation(T[:3, :3]))


def unit_quaternion(q: ex.Expression) -> ex.Expression:
    """| |q| - 1 | of four numbers."""
    return ex.fabs(ex.sqrt(ex.dot(q, q)) - 1)


def axis(x: ex.Expression) -> ex.Expression:
    """Zero where three numbers have a direction; infinite where their squares vanish or overflow."""
    s = ex.dot(x, x)
    return ex.if_else(ex.logic_and(s >= LEAST_DIVISOR, s < ex.inf), 0.0, ex.inf)


def quaternion(q: ex.Expression) -> ex.Expression:
    """Zero where four numbers can be scaled to unit length; infinite where they are all zero."""
    return ex.if_else(ex.fabs(q[0]) + ex.fabs(q[1]) + ex.fabs(q[2]) + ex.fabs(q[3]) > 0, 0.0, ex.inf)


def unit_screw(S: ex.Expression) -> ex.Expression:
    """| |omega| - 1 | of a screw (omega, v), or | |v| - 1 | where omega is zero."""
    omega, v = angular(S), linear(S)
    return ex.fabs(ex.if_else(ex.dot(omega, omega) > 0, length(omega), length(v)) - 1)


def axis_triple(axes: ex.Expression) -> ex.Expression:
    """Frobenius norm of what three rows miss to be unit and the second to be orthogonal to the other two."""
    total = ex.Expression(0)
    for k in range(3):
        total += (ex.dot(axes[k, :], axes[k, :]) - 1) ** 2
    for k in (0, 2):
        total += ex.dot(axes[1, :], axes[k, :]) ** 2
    return ex.sqrt(total)


def rotation_vector(r: ex.Expression) -> ex.Expression:
    """Square of the length of three numbers; infinite where it overflows."""
    return ex.dot(r, r)


def exponential_coordinates(V: ex.Expression) -> ex.Expression:
    """That of the angular half of six numbers (omega, v)."""
    return rotation_vector(angular(V))


def planar_coordinates(V: ex.Expression) -> ex.Expression:
    """That of the angle of three numbers (omega, v_x, v_y)."""
    return V[0] ** 2


def amount(x: ex.Expression) -> ex.Expression:
    """Square of one number, an angle or a length."""
    return x**2


def duration(t: ex.Expression) -> ex.Expression:
    """What a velocity over this time is multiplied by, 1 / |t|: infinite at zero."""
    return 1 / ex.fabs(t)


def part_turn(theta: ex.Expression) -> ex.Expression:
    """How much of an angle's digits is lost where it is a whole number of turns, none included: infinite there."""
    return (1 + ex.fabs(theta)) / ex.fabs(ex.sin(theta / 2))


def planar_rotation(R: ex.Expression) -> ex.Expression:
    """Frobenius norm of R'R - I of a (2, 2) matrix; infinite where det R <= 0."""
    a, b = R[:, 0], R[:, 1]
    defect = (ex.dot(a, a) - 1) ** 2 + (ex.dot(b, b) - 1) ** 2 + 2 * ex.dot(a, b) ** 2
    return ex.if_else(a[0] * b[1] - a[1] * b[0] > 0, ex.sqrt(defect), ex.inf)


def planar_pose(T: ex.Expression) -> ex.Expression:
    """Norm of that of the rotation of a (3, 3) matrix and of what its last row misses to (0, 0, 1)."""
    return _with_last_row(T, planar_rotation(T[:2, :2]))


MEASURES: dict[str, Callable[[ex.Expression], ex.Expression]] = {
    "rotation": rotation,
    "pose": pose,
    "unit_quaternion": unit_quaternion,
    "axis": axis,
    "quaternion": quaternion,
    "unit_screw": unit_screw,
    "axis_triple": axis_triple,
    "rotation_vector": rotation_vector,
    "exponential_coordinates": exponential_coordinates,
    "planar_coordinates": planar_coordinates,
    "amount": amount,
    "duration": duration,
    "part_turn": part_turn,
    "planar_rotation": planar_rotation,
    "planar_pose": planar_pose,
}
"""Measures by the name under which declarations, limits and error sentences know them."""


def is_member(kind: str, value: ex.Expression) -> ex.Expression:
    """1 where the measure is within its limit, else 0 (also for NaN)."""
    return MEASURES[kind](value) <= LIMITS[kind]


def _with_last_row(T: ex.Expression, distance: ex.Expression) -> ex.Expression:
    last = T.shape[0] - 1
    squared_defect = distance**2 + (T[last, last] - 1) ** 2
    for k in range(last):
        squared_defect += T[last, k] ** 2
    return ex.sqrt(squared_defect)


Shape = tuple[int, ...]


def function(
    source: str,
    inputs: Sequence[tuple[str, Shape]],
    outputs: Sequence[tuple[str, Shape]],
    conditions: Mapping[str, str] | None = None,
    constants: Sequence[object] = (),
) -> ex.Function:
    """The function of symbols.

    Args:
        source: `module.function` of this package.
        inputs: name and core shape of every argument that is an expression, in order; at most two dimensions.
        outputs: name and core shape of every result.
        conditions: argument name -> kind it must be a member of (`membership.MEASURES`); where it is not, every
            result is NaN.
        constants: further arguments, after the expressions.
    """
    columns = [ex.symbol(name, max(1, _size(shape))) for name, shape in inputs]
    arguments = [_shape(column, shape) for column, (_, shape) in zip(columns, inputs, strict=True)]
    answer = _find(source)(*arguments, *constants)
    results = list(answer) if isinstance(answer, tuple) else [answer]
    names = [name for name, _ in inputs]
    for name, condition in (conditions or {}).items():
        met = is_member(condition, arguments[names.index(name)])
        results = [ex.if_else(met, result, nan) for result in results]
    flat = [ex.vec(ex.Expression(result).T) for result in results]
    return ex.Function(source.replace(".", "_"), columns, flat, names, [name for name, _ in outputs], cse=True)


def _find(source: str) -> Callable[..., ex.Expression | tuple[ex.Expression, ...]]:
    module, _, name = source.partition(".")
    return getattr(import_module(f"mafsil.algebra.{module}"), name)


def _shape(column: ex.Expression, shape: Shape) -> ex.Expression:
    return ex.reshape(column, shape[1], shape[0]).T if len(shape) == 2 else column


def _size(shape: Shape) -> int:
    size = 1
    for each in shape:
        size *= each
    return size
