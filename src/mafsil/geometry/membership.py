"""Refusing what is not a rotation, a pose, a unit quaternion or an axis: which row, how far off, and what to do.

Rotations, poses and quaternions that were printed with three to five digits, as NumPy and MATLAB do, are mended with a
warning. How far off a row is, a `Declared` function says: an expression of `mafsil.algebra` in one line, compiled at
its first use as all array functions of geometry are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil import kernels
from mafsil.algebra.tolerance import LIMITS, MENDED
from mafsil.arrays import Floats, Scalar, Truth, as_batch
from mafsil.errors import InputError, InputWarning, warn
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.algebra.membership as expression
else:
    expression = lazily("mafsil.algebra.membership")


Ports = tuple[tuple[str, tuple[int, ...]], ...]
"""(name, shape) of every input or output."""
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
    """The value as an array, if every row without NaN is a member of its kind, or was one before it was printed.

    Args:
        kind: one of CORES.
        name: the argument's name, for the error.
        value: (*batch, *core).
        tolerance: largest measure; the named limit of the kind if None, and only then printed digits are mended.

    Raises:
        InputError: names the first row that is not, its distance, the limit and the likely cause.

    Warns:
        InputWarning: as `snap_to_kind`.
    """
    array = as_batch(name, value, CORES[kind])
    limit = LIMITS[kind] if tolerance is None else tolerance
    distance = np.asarray(measure(kind, array))
    if (distance > limit).any():
        better = snap_to_kind(kind, name, array) if tolerance is None else array
        if better is not array:
            return require(kind, name, better)
        index = tuple(int(i) for i in np.argwhere(distance > limit)[0])
        widest = MENDED.get(kind, limit) if tolerance is None else limit
        raise _refusal(kind, name, array[index], index, float(distance[index]), widest)
    return array


def snap_to_kind(kind: str, name: str, array: Floats) -> Floats:
    """The array, with rows of three to five printed digits replaced by the nearest members of their kind.

    Args:
        kind: one of CORES.
        name: the argument's name, for the warning.
        array: (*batch, *core); rows farther away stay as they are.

    Warns:
        InputWarning: some were replaced; it says how far they were from members.
    """
    distance = np.asarray(measure(kind, array))
    rough = (distance > LIMITS[kind]) & (distance <= MENDED.get(kind, 0.0))
    if kind.endswith("pose"):
        rough &= np.abs(array[..., -1, :] - np.eye(CORES[kind][0])[-1]).max(axis=-1) <= LIMITS[kind]
    if not rough.any():
        return array
    warn(InputWarning(f"geometry.mended_{kind}", name=name, distance=float(distance[rough].max())))
    made = np.array(array)
    made[rough] = _nearest(kind, array[rough])
    return made


def _nearest(kind: str, rows: Floats) -> Floats:
    """(k, *core) members of a kind nearest to rows that nearly are; each Newton step squares the distance."""
    if kind == "unit_quaternion":
        return rows / np.linalg.norm(rows, axis=-1, keepdims=True)
    size = rows.shape[-1] - kind.endswith("pose")
    near, R = np.array(rows), rows[:, :size, :size]
    for _ in range(4):
        R = R @ (1.5 * np.eye(size) - 0.5 * (R.transpose(0, 2, 1) @ R))
    near[:, :size, :size] = R
    return near


def _refusal(kind: str, name: str, row: Floats, index: tuple[int, ...], distance: float, limit: float) -> InputError:
    """The error about a row, with the cause that its numbers show."""
    place = f"[{', '.join(map(str, index))}]" if index else ""
    details: dict[str, object] = {"name": name + place, "value": row.tolist(), "distance": distance, "limit": limit}
    if not kind.endswith(("rotation", "pose")):
        return InputError(f"geometry.{kind}", **details)
    size = len(row) - kind.endswith("pose")
    R, last = row[:size, :size], row[-1] - np.eye(len(row))[-1]
    exact = LIMITS[kind]
    if size < len(row) and np.linalg.norm(last) > exact:
        transposed = np.abs(row[:-1, -1]).max() <= exact and abs(last[-1]) <= exact
        return InputError("geometry.transposed" if transposed else "geometry.last_row", **details, row=row[-1].tolist())
    scale, determinant = float(np.sqrt((R * R).sum() / size)), float(np.linalg.det(R))
    if np.isinf(distance):
        return InputError("geometry.improper", **details, determinant=determinant)
    if np.abs(R.T @ R - scale**2 * np.eye(size)).max() <= MENDED[kind] * scale**2:
        return InputError("geometry.scaled", **details, scale=scale)
    return InputError(f"geometry.{kind}", **details)


@cache
def _measure(kind: str) -> Declared:
    core = ",".join(map(str, CORES[kind]))
    return Declared(f"membership.{kind}", f"value:{core}", "distance")


class Declared:
    """A batched array function of an algebra expression; `at` evaluates it, and once compiled is the builtin itself.

    Args:
        source: `module.function` of `mafsil.algebra`.
        inputs: ports, or ports as text: `"R:3,3 t"` is a (3, 3) matrix R and a number t.
        outputs: likewise.
        constants: further arguments of the expression, such as the name of an Euler sequence.
    """

    conditions: dict[str, str]
    """Argument -> name of the condition that the expression may take as met (`conditioned.Conditioned`)."""

    def __init__(self, source: str, inputs: str | Ports, outputs: str | Ports, *constants: object) -> None:
        self.source = source
        self.inputs, self.outputs = _ports(inputs), _ports(outputs)
        self.conditions = {}
        self.constants = constants
        self.at: Callable[..., Any] = self._first

    def __call__(self, *args: Any) -> Any:
        """Evaluate at one point or over a broadcast batch.

        Raises:
            InputError: wrong shape, not numbers, NaN in a call without batch, or a condition that is not met.
        """
        return self.at(*args)

    def _first(self, *args: Any) -> Any:
        """The first evaluation compiles, or loads, the kernel and takes this method's place."""
        self.at = self.evaluation()
        return self.at(*args)

    def evaluation(self) -> Callable[..., Any]:
        """What evaluates from the second call on: the kernel's own."""
        return self.kernel.call

    @cached_property
    def kernel(self) -> kernels.Kernel:
        """The compiled expression."""
        signature = kernels.Signature(_name(self), _signature_ports(self.inputs), _signature_ports(self.outputs))
        given = (self.source, self.inputs, self.outputs, tuple(self.conditions.items()), self.constants)
        return kernels.compile(
            signature,
            partial(_build, *given),
            key=repr(given),
            fingerprints=(kernels.fingerprint("mafsil.algebra"),),
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.source, self.inputs, self.outputs, *self.constants)


def _build(
    source: str, inputs: Ports, outputs: Ports, conditions: tuple[tuple[str, str], ...], constants: tuple[object, ...]
) -> Any:
    return expression.function(source, inputs, outputs, dict(conditions), constants)


def _name(declared: Declared) -> str:
    return "_".join([declared.source.replace(".", "_"), *map(str, declared.constants)])


def _ports(given: str | Ports) -> Ports:
    if not isinstance(given, str):
        return given
    parts = (entry.partition(":") for entry in given.split())
    return tuple((name, tuple(map(int, shape.split(","))) if shape else ()) for name, _, shape in parts)


def _signature_ports(ports: Ports) -> tuple[kernels.Port, ...]:
    return tuple(kernels.Port(name, shape) for name, shape in ports)
