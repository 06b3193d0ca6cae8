"""What the language offers of Python and NumPy, written in the language: loops that are made part of their callers."""

from __future__ import annotations

from functools import partial
from math import copysign, fmod, hypot
from typing import Any

import numpy as np

from mafsil.kernels.loops.definition import Definition

_inlined = partial(Definition, inline=True)


@_inlined
def fill(array: Any, value: Any) -> None:
    """Every element, or every row, set to a value."""
    for i in range(len(array)):
        array[i] = value


@_inlined
def assign(array: Any, other: Any) -> None:
    """The elements of another array of these sizes."""
    for i in range(len(array)):
        array[i] = other[i]


def along(value: Any, i: int, made: Any) -> Any:
    """What row i of a result takes of an operand: its row i, or all of it where it has fewer axes."""
    return value[i] if np.ndim(value) == made.ndim else value


@_inlined
def each_sum(made: Any, a: Any, b: Any) -> None:
    """a + b, element by element."""
    for i in range(len(made)):
        made[i] = along(a, i, made) + along(b, i, made)


@_inlined
def each_difference(made: Any, a: Any, b: Any) -> None:
    """a - b, element by element."""
    for i in range(len(made)):
        made[i] = along(a, i, made) - along(b, i, made)


@_inlined
def each_product(made: Any, a: Any, b: Any) -> None:
    """a b, element by element."""
    for i in range(len(made)):
        made[i] = along(a, i, made) * along(b, i, made)


@_inlined
def each_quotient(made: Any, a: Any, b: Any) -> None:
    """a / b, element by element."""
    for i in range(len(made)):
        made[i] = along(a, i, made) / along(b, i, made)


@_inlined
def each_magnitude(made: Any, a: Any) -> None:
    """The magnitudes of the numbers of a row."""
    for i in range(len(made)):
        made[i] = abs(a[i])


@_inlined
def total(array: Any) -> Any:
    """The sum of a row."""
    found = 0
    for i in range(len(array)):
        found += array[i]
    return found


@_inlined
def largest(array: Any) -> Any:
    """The largest number of a row."""
    found = array[0]
    for i in range(1, len(array)):
        found = max(found, array[i])
    return found


@_inlined
def least(array: Any) -> Any:
    """The least number of a row."""
    found = array[0]
    for i in range(1, len(array)):
        found = min(found, array[i])
    return found


@_inlined
def place_of_largest(array: Any) -> int:
    """Where the largest number of a row stands, the first of equal ones."""
    place = 0
    for i in range(1, len(array)):
        if array[i] > array[place]:
            place = i
    return place


@_inlined
def place_of_least(array: Any) -> int:
    """Where the least number of a row stands, the first of equal ones."""
    place = 0
    for i in range(1, len(array)):
        if array[i] < array[place]:
            place = i
    return place


@_inlined
def counted(count: int) -> Any:
    """The numbers from 0 to a count."""
    numbers = np.empty(count, np.int64)
    for i in range(count):
        numbers[i] = i
    return numbers


@Definition
def rows_joined(parts: Any) -> Any:
    """The rows of some arrays, one after another."""
    count = 0
    for part in parts:
        count += len(part)
    rows = np.empty((count, parts[0].shape[1]))
    count = 0
    for part in parts:
        rows[count : count + len(part)] = part
        count += len(part)
    return rows


@_inlined
def magnitude_of(z: Any) -> float:
    """The magnitude of a complex number."""
    return hypot(z.real, z.imag)


@_inlined
def remainder(a: float, b: float) -> float:
    """a % b, of the sign of b."""
    rest = fmod(a, b)
    if rest == 0.0:
        return copysign(0.0, b)
    return rest + b if (b < 0.0) != (rest < 0.0) else rest


@_inlined
def quotient(a: float, b: float) -> float:
    """a // b as Python finds it."""
    rest = fmod(a, b)
    found = (a - rest) / b
    if rest != 0.0 and (b < 0.0) != (rest < 0.0):
        found -= 1.0
    if found == 0.0:
        return copysign(0.0, a / b)
    down = np.floor(found)
    return down + 1.0 if found - down > 0.5 else down


@_inlined
def power(x: Any, exponent: int) -> Any:
    """x to a whole power, by squaring."""
    found, n = x * 0 + 1, abs(exponent)
    while n > 0:
        if n & 1:
            found *= x
        n >>= 1
        x *= x
    return found if exponent >= 0 else 1 / found


@_inlined
def complex_quotient(a: complex, b: complex) -> complex:
    """a / b, scaled by the larger part of b."""
    x, y = b.real, b.imag
    if abs(x) >= abs(y):
        if x == 0.0:
            return complex(np.nan, np.nan)
        ratio = y / x
        size = x + y * ratio
        return complex((a.real + a.imag * ratio) / size, (a.imag - a.real * ratio) / size)
    ratio = x / y
    size = x * ratio + y
    return complex((a.real * ratio + a.imag) / size, (a.imag * ratio - a.real) / size)


OPERATIONS = {
    ("float64", "//"): quotient, ("float64", "%"): remainder, ("complex128", "/"): complex_quotient,
}  # fmt: skip
ELEMENTWISE = {"+": each_sum, "-": each_difference, "*": each_product, "/": each_quotient}
METHODS = {"sum": total, "max": largest, "min": least, "argmax": place_of_largest, "argmin": place_of_least}
"""Methods of arrays of one axis."""
DEFINITIONS = {each.name: each for each in list(globals().values()) if isinstance(each, Definition)}
"""All of them, by name."""
