"""Refusing what is not a rotation, a pose, a unit quaternion or an axis: which row, how far off, and what to do."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from mafsil.algebra.tolerance import LIMITS
from mafsil.arrays import Floats, Scalar, Truth, as_batch
from mafsil.errors import InputError
from mafsil.geometry.declared import Declared

CORES: dict[str, tuple[int, ...]] = {
    "rotation": (3, 3),
    "pose": (4, 4),
    "planar_rotation": (2, 2),
    "planar_pose": (3, 3),
    "unit_quaternion": (4,),
    "axis_triple": (3, 3),
    "axis": (3,),
    "unit_screw": (6,),
    "quaternion": (4,),
    "rotation_vector": (3,),
    "exponential_coordinates": (6,),
    "planar_coordinates": (3,),
    "amount": (),
    "duration": (),
    "part_turn": (),
}
"""Core shape of every kind of member."""


@dataclass(frozen=True, slots=True)
class Member:
    """In an annotation: the argument is a member of a kind, any batch of them, and refused otherwise.

    Attributes:
        kind: one of CORES.
    """

    kind: str


def measure(kind: str, value: ArrayLike) -> Scalar:
    """How far numbers are from a kind of member: zero, a distance, infinity, or NaN for NaN.

    Args:
        kind: one of CORES.
        value: (*batch, *core).

    Returns:
        (*batch).
    """
    array = as_batch(kind, value, CORES[kind])
    distance = _measure(kind).kernel.ufunc(array)
    unknown = np.isnan(array).any(axis=tuple(range(-len(CORES[kind]), 0)))
    return np.where(unknown, np.nan, distance) if unknown.any() else distance


def is_member(kind: str, value: ArrayLike, tolerance: float | None = None) -> Truth:
    """Whether numbers are members of their kind: the measure within the tolerance; False for NaN.

    Args:
        kind: one of CORES.
        value: (*batch, *core).
        tolerance: largest measure; the named limit of the kind (`mafsil.algebra.tolerance`) if None.

    Returns:
        (*batch).
    """
    return measure(kind, value) <= (LIMITS[kind] if tolerance is None else tolerance)


def require(kind: str, name: str, value: ArrayLike, tolerance: float | None = None) -> Floats:
    """The value as an array, if every row without NaN is a member of its kind.

    Args:
        kind: one of CORES.
        name: the argument's name, for the error.
        value: (*batch, *core).
        tolerance: largest measure; the named limit of the kind if None.

    Raises:
        InputError: names the first row that is not, its distance and the limit.
    """
    array = as_batch(name, value, CORES[kind])
    limit = LIMITS[kind] if tolerance is None else tolerance
    distance = np.asarray(measure(kind, array))
    if (distance > limit).any():
        index = tuple(int(i) for i in np.argwhere(distance > limit)[0])
        raise _refusal(kind, name, array[index], index, float(distance[index]), limit)
    return array


def _refusal(kind: str, name: str, row: Floats, index: tuple[int, ...], distance: float, limit: float) -> InputError:
    place = f"[{', '.join(map(str, index))}]" if index else ""
    details = {"name": name + place, "value": row.tolist(), "distance": distance, "limit": limit}
    if kind.endswith("pose") and np.linalg.norm(row[-1] - np.eye(len(row))[-1]) > limit:
        return InputError("geometry.last_row", **details, row=row[-1].tolist())
    if kind.endswith(("rotation", "pose")) and np.isinf(distance):
        size = len(row) - kind.endswith("pose")
        return InputError("geometry.improper", **details, determinant=float(np.linalg.det(row[:size, :size])))
    return InputError(f"geometry.{kind}", **details)


@cache
def _measure(kind: str) -> Declared:
    core = ",".join(map(str, CORES[kind]))
    return Declared(f"membership.{kind}", f"value:{core}", "distance")
