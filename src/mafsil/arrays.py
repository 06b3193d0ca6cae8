"""Shape vocabulary, and the one check through which numbers of users enter: lists in, float64 arrays out."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from inspect import signature
from math import isfinite, pi
from typing import Annotated, Any, ParamSpec, TypeAlias, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.errors import InputError, InputWarning, warn
from mafsil.messages import say

P = ParamSpec("P")
Result = TypeVar("Result")


@dataclass(frozen=True, slots=True, init=False)
class Shape:
    """Dimensions of an annotated array, checked by `pytest --check-shapes` and read by people and type checkers.

    A number is itself; a name such as `n` is one number throughout a call; `*batch` is any leading dimensions,
    the same throughout a call. `Annotated[NDArray[np.float64], Shape("*batch", 3)]` is an array to a type checker.

    Attributes:
        dimensions: from the first axis to the last.
    """

    dimensions: tuple[int | str, ...]

    def __init__(self, *dimensions: int | str) -> None:
        object.__setattr__(self, "dimensions", dimensions)

    def __str__(self) -> str:
        return " ".join(map(str, self.dimensions))


Floats: TypeAlias = NDArray[np.float64]
"""A float64 array of any shape; the docstring says which, `*batch` being any leading dimensions."""
Integers: TypeAlias = NDArray[np.integer[Any]]
"""An array of whole numbers: places in others, or counts."""
Booleans: TypeAlias = NDArray[np.bool_]
"""An array of yes and no, of any shape."""
Scalar: TypeAlias = Annotated[Floats, Shape("*batch")]
"""(*batch) one number each; without batch a NumPy number or an array of no dimensions."""
Truth: TypeAlias = Annotated[NDArray[np.bool_], Shape("*batch")]
"""(*batch) one yes or no each."""
Vector2: TypeAlias = Annotated[Floats, Shape("*batch", 2)]
"""(*batch, 2) a point or vector of the plane."""
Vector3: TypeAlias = Annotated[Floats, Shape("*batch", 3)]
"""(*batch, 3)."""
Vector6: TypeAlias = Annotated[Floats, Shape("*batch", 6)]
"""(*batch, 6) a twist (omega, v), a wrench (m, f) or a screw."""
Matrix3: TypeAlias = Annotated[Floats, Shape("*batch", 3, 3)]
"""(*batch, 3, 3) of any kind: skew, Jacobian of a rotation, rate of a rotation."""
Matrix4: TypeAlias = Annotated[Floats, Shape("*batch", 4, 4)]
"""(*batch, 4, 4) of any kind: [V], rate of a pose."""
Matrix6: TypeAlias = Annotated[Floats, Shape("*batch", 6, 6)]
"""(*batch, 6, 6) of any kind: Ad(T), ad(V), spatial inertia, compliance."""
RotationMatrix: TypeAlias = Annotated[Floats, Shape("*batch", 3, 3)]
"""(*batch, 3, 3) axes of {b} as columns, in {a}."""
Quaternion: TypeAlias = Annotated[Floats, Shape("*batch", 4)]
"""(*batch, 4) (w, x, y, z)."""
PoseMatrix: TypeAlias = Annotated[Floats, Shape("*batch", 4, 4)]
"""(*batch, 4, 4) homogeneous matrix [[R, p], [0, 1]]."""
PlanarRotation: TypeAlias = Annotated[Floats, Shape("*batch", 2, 2)]
"""(*batch, 2, 2) rotation of the plane."""
PlanarPose: TypeAlias = Annotated[Floats, Shape("*batch", 3, 3)]
"""(*batch, 3, 3) homogeneous matrix of a motion of the plane."""
Points: TypeAlias = Annotated[Floats, Shape("points", 3)]
"""(points, 3) a list of points, which is no batch [m]."""
JointVector: TypeAlias = Annotated[Floats, Shape("*batch", "n")]
"""(*batch, n) one number per joint coordinate [rad | m]."""
JointMatrix: TypeAlias = Annotated[Floats, Shape("*batch", "n", "n")]
"""(*batch, n, n) such as the mass matrix."""
JacobianMatrix: TypeAlias = Annotated[Floats, Shape("*batch", 6, "n")]
"""(*batch, 6, n) twist (omega, v) per joint rate."""


FLOAT64 = np.dtype(np.float64)
SHORT_TEXT = 20
"""Letters of a text that an error repeats."""
SMALLEST, LARGEST = 1e-40, 1e40
"""Sizes of a scalar that enters a formula: what is zero or between them can be cubed, multiplied and divided in float64
without leaving it. No length, time, mass or stiffness of any machine lies beyond."""
TURN = 2.0 * pi
FEW = 32
"""Numbers up to which Python itself is quicker than NumPy's call."""


class Symbolic:
    """An array of expressions instead of numbers; it passes where numbers are checked."""

    __slots__ = ()


def fails(condition: object) -> bool:
    """Whether a condition of numbers holds anywhere, which is an error; of expressions nobody knows it yet.

    Args:
        condition: array of yes and no.
    """
    return not isinstance(condition, Symbolic) and bool(np.any(cast("Any", condition)))


def real_array(name: str, value: ArrayLike) -> Floats:
    """`value` as a float64 array, refusing what is not real numbers.

    Args:
        name: the argument's name, for the error.
        value: numbers, (nested) lists of numbers, an array of any integer or real type, or an object with a matrix:
            SciPy's Rotation and RigidTransform, spatialmath's SO3 and SE3, Pinocchio's SE3.

    Raises:
        InputError: text, complex numbers, ragged lists, masked arrays, None.
    """
    if type(value) is np.ndarray and value.dtype is FLOAT64:
        return value
    if isinstance(value, Symbolic):
        return cast("Floats", value)
    masked = sys.modules.get("numpy.ma")  # An array of it cannot be there before the module is.
    if masked is not None and isinstance(value, masked.MaskedArray):
        raise InputError("input.numbers", name=name, got="masked array")
    numbers: Any = value
    if not isinstance(value, np.ndarray | list | tuple | float | int):
        numbers = _matrix_of(value)
    try:
        array: NDArray[Any] = np.asarray(numbers)
    except (ValueError, TypeError):
        rows = cast("list[Any]", numbers) if isinstance(numbers, list | tuple) else []
        lengths = sorted({len(row) for row in rows if hasattr(row, "__len__")})
        if len(lengths) > 1:
            raise InputError("input.ragged", name=name, lengths=", ".join(map(str, lengths))) from None
        raise InputError("input.numbers", name=name, got=_kind(cast("object", numbers))) from None
    if array.dtype.kind not in "fiu":
        if array.size or array.dtype.kind != "O":
            key = "input.numbers_in_q" if array.ndim == 0 and hasattr(numbers, "q") else "input.numbers"
            raise InputError(key, name=name, got=_kind(numbers, array))
    return array.astype(np.float64, copy=False)


def _matrix_of(value: Any) -> Any:
    """The matrix of an object that stands for a rotation or a pose (SciPy, spatialmath, Pinocchio), or the value."""
    if isinstance(value, type):
        return value
    as_matrix = getattr(value, "as_matrix", None)
    if callable(as_matrix):
        return as_matrix()
    for attribute in ("homogeneous", "A"):
        matrix = getattr(value, attribute, None)
        if isinstance(matrix, np.ndarray | list):
            return cast("Any", matrix)
    return value


def as_batch(name: str, value: ArrayLike, core: tuple[int, ...], *, finite: bool = False, hint: str = "") -> Floats:
    """`value` as a float64 array of shape (*batch, *core).

    Args:
        name: the argument's name, for the error.
        value: what the user gave.
        core: the last dimensions that are required, such as (7,) or (4, 4).
        finite: refuse NaN and infinities, naming the first one's index.
        hint: appended to the sentence about a wrong shape: what to do; found from the shapes if empty.

    Raises:
        InputError: not real numbers, wrong shape, or (if `finite`) a NaN or infinity.
    """
    array = real_array(name, value)
    if array.shape[array.ndim - len(core) :] != core or array.ndim < len(core):
        expected = "(*batch, " + ", ".join(map(str, core)) + ")"
        advice = hint or Advice(core, array.shape)
        raise InputError("input.shape", name=name, expected=expected, got=array.shape, hint=advice)
    return require_finite(name, array) if finite else array


@dataclass(frozen=True, slots=True)
class Advice:
    """What to do about a wrong shape, at the end of its sentence.

    Attributes:
        core: the last dimensions that are required.
        got: the shape that was given.
    """

    core: tuple[int, ...]
    got: tuple[int, ...]

    def spoken(self, language: str | None = None) -> str:
        """The advice, beginning with a semicolon."""
        return say(f"input.advice_{self._kind()}", language=language, count=self.core[-1] if self.core else 1)

    def _kind(self) -> str:
        core, got = self.core, self.got
        if len(core) == 1:
            return "column" if got[-2:] == (*core, 1) else "transposed" if got[-2:-1] == core else "row"
        if core == (4, 4):
            return "rotation" if got[-2:] == (3, 3) else "place" if got[-1:] in ((3,), (6,), (7,)) else "pose"
        return "plain"


def single(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Floats:
    """`value` as a float64 array of finite numbers, of this very shape: no batch.

    Args:
        name: the argument's name, for the error.
        value: what the user gave.
        shape: of the whole array.

    Raises:
        InputError: not real numbers, another shape, a NaN or infinity, a number too large to calculate with.
    """
    array = real_array(name, value)
    if array.shape != shape:
        raise InputError("input.shape", name=name, expected=shape, got=array.shape, hint="")
    require_finite(name, array)
    if array.size and max(abs(array.max()), abs(array.min())) > LARGEST:
        calculable(name, array[np.abs(array) > LARGEST])
    return array


def require_finite(name: str, array: Floats) -> Floats:
    """The array itself, if all its numbers are finite.

    Raises:
        InputError: names the first NaN or infinity and its index.
    """
    if isinstance(array, Symbolic):
        return array
    # The sum of few numbers is finite if they are, and found sooner; finite numbers whose sum overflows are looked at.
    if not (array.size <= FEW and isfinite(sum(array.ravel().tolist()))) and not np.isfinite(array).all():
        index = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise InputError("input.finite" if index else "input.finite_alone", name=name, value=array[index], index=index)
    return array


def require_kind(name: str, value: object, expected: str, *members: str) -> None:
    """Refuse an object that is something else than expected.

    Args:
        name: the argument's name, for the error.
        value: what the user gave.
        expected: what it should be, in the words of the documentation.
        members: names of what such a thing has.

    Raises:
        InputError: it lacks one of the members.
    """
    # The class is asked first: a property of the value would be computed.
    if isinstance(value, type) or not all(hasattr(type(value), each) or hasattr(value, each) for each in members):
        raise InputError("input.kind", name=name, expected=expected, got=type(value).__name__)


def spread(name: str, value: ArrayLike, shape: tuple[int, ...], *, finite: bool = True) -> Floats:
    """`value` as a float64 array spread out to a shape: one number for all, or one for each.

    Args:
        name: the argument's name, for the error.
        value: what the user gave.
        shape: of the whole array.
        finite: refuse NaN and infinities.

    Raises:
        InputError: not real numbers, a shape that does not spread so, or (if `finite`) a NaN or infinity.
    """
    array = real_array(name, value)
    array = require_finite(name, array) if finite else array
    try:
        return np.broadcast_to(array, shape)
    except ValueError:
        raise InputError("input.shape", name=name, expected=shape, got=array.shape, hint="") from None


def radians(name: str, value: ArrayLike, *, degrees: bool = False, places: bool = False) -> Floats:
    """Angles in radians as an array; whole numbers of which one is more than a turn are remarked on.

    Args:
        name: the argument's name, for the remark.
        value: what the user gave.
        degrees: it is in degrees.
        places: they say where parts stand on a circle, which no part does beyond a turn: refuse instead.

    Raises:
        InputError: not real numbers, or places that can only be in degrees.

    Warns:
        InputWarning: they look like degrees.
    """
    array = real_array(name, value)
    if degrees:
        return np.radians(array)
    beyond = np.abs(array) > TURN
    if beyond.any() and (array[np.isfinite(array)] % 1.0 == 0.0).all():
        if places:
            raise InputError("input.degrees", name=name, value=float(array[beyond][0]))
        warn(InputWarning("input.degrees", name=name, value=float(array[beyond][0])))
    return array


def positive(name: str, value: object) -> float:
    """The value itself, if it is a positive number of a size that can be calculated with.

    Raises:
        InputError: it is not.
    """
    if type(value) is float and SMALLEST <= value <= LARGEST:
        return value
    array = real_array(name, cast("ArrayLike", value))
    if array.ndim or not np.isfinite(array) or array <= 0.0:
        raise InputError("input.positive", name=name, value=value)
    return float(calculable(name, array))


def number(name: str, value: object) -> float:
    """The value itself, if it is a finite number that can be calculated with; of any sign, however small.

    Raises:
        InputError: it is not.
    """
    if type(value) is float and abs(value) <= LARGEST:
        return value
    return float(single(name, cast("ArrayLike", value), ()))


def not_negative(name: str, value: object, *, unbounded: bool = False, most: float = LARGEST) -> float:
    """The value itself, if it is zero or a positive number of a size that can be calculated with.

    Args:
        name: the argument's name, for the error.
        value: what the user gave.
        unbounded: whether infinity is allowed and means that there is no bound.
        most: largest number that makes sense.

    Raises:
        InputError: it is not.
    """
    array = real_array(name, cast("ArrayLike", value))
    if array.ndim or not array >= 0.0 or (np.isinf(array) and not unbounded) or (most < LARGEST and array > most):
        raise InputError("input.range", name=name, value=value, low=0.0, high=np.inf if unbounded else most)
    return float(array if np.isinf(array) else calculable(name, array))


def calculable(name: str, array: Floats) -> Floats:
    """The array itself, if all its numbers are zero or of a size that can be calculated with.

    Raises:
        InputError: names the first one that is too small or too large; NaN and infinities are left to others.
    """
    size = np.abs(array)
    beyond = (size > LARGEST) & (size < np.inf) | (size < SMALLEST) & (size > 0.0)
    if beyond.any():
        value = float(np.asarray(array)[beyond].flat[0])
        raise InputError("input.size", name=name, value=value, low=SMALLEST, high=LARGEST)
    return array


def whole(name: str, value: object, least: int = 0, most: int = 2**31 - 1) -> int:
    """The value itself, if it is a whole number between two bounds.

    Raises:
        InputError: it is not.
    """
    kind = type(value)
    if kind is int and least <= cast("int", value) <= most:
        return cast("int", value)
    if (kind is not int and not issubclass(kind, np.integer)) or not least <= cast("int", value) <= most:
        raise InputError("input.whole", name=name, value=value, low=least, high=most)
    return int(cast("int", value))


def require_function(name: str, value: object, form: str, count: int) -> None:
    """Refuse what cannot be called with `count` arguments.

    Args:
        name: the argument's name, for the sentence.
        value: what the user gave.
        form: how it is called, such as "function g(t, y)".
        count: number of arguments.

    Raises:
        InputError: it is no function, or one of other arguments.
    """
    if not callable(value):
        raise InputError("input.kind", name=name, expected=form, got=type(value).__name__)
    try:
        taken = signature(value)
    except ValueError:  # some functions written in C do not tell
        return
    try:
        taken.bind(*range(count))
    except TypeError:
        raise InputError("input.kind", name=name, expected=form, got=f"function of {taken}") from None


def frozen(array: ArrayLike) -> Floats:
    """A read-only float64 copy: what immutable descriptions hold."""
    copy = np.array(array, dtype=np.float64)
    copy.setflags(write=False)
    return copy


_NEXT, _LAST = [1, 2, 0], [2, 0, 1]


def cross(a: Vector3, b: Vector3) -> Vector3:
    """a x b, row by row: of few vectors NumPy's own spends ten times as long on moving axes.

    Args:
        a, b: (*batch, 3), of one shape.
    """
    return a[..., _NEXT] * b[..., _LAST] - a[..., _LAST] * b[..., _NEXT]


def _kind(value: object, array: NDArray[Any] | None = None) -> str:
    """The type, and what an array, list or short text holds where that says more."""
    name = type(value).__name__
    if isinstance(value, str) and len(value) <= SHORT_TEXT:
        return f"{name} {value!r}"
    if array is None or not isinstance(value, np.ndarray | list | tuple):
        return name
    return f"{name} of {array.dtype}"
