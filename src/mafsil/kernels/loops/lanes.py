"""What a loop may say besides Python: eight numbers side by side, with what it means in plain Python, and kernels.

A variable is eight lanes by its type, so a loop is written once for eight problems: nothing is left for LLVM to prove.
It splits the lanes where a processor's vectors are narrower. What a loop may write:

- `Lanes` with + - * /, unary -, comparisons (to a `Mask`), and numbers, which are the same in all lanes;
- `Mask` with & | ~; `where(mask, a, b)`, `any_lane(mask)`, `lane_bits(mask)` (bit l for lane l),
  `how_many(bits)`;
- `square_root`, `magnitude`, `rounded_down`, `larger`, `smaller`, `lanes(number)`;
- `buffer(n)` (n a constant): n lanes on the stack, `r[i]` and `r[i] = x`; `part(r, i)`: the buffer that begins at i;
  `seen(array)`: a float64 array as a buffer, whose rows are in order;
- `in_lanes(n)`: an array for n lanes, to be `seen`;
- `put(r, i, l, number)` and `get(r, i, l)`: one lane of place i;
- `spread(array, begin, stride, x)`: lane l to the flat array at begin + l stride;
- `looked_up(array, places)`: in lane l what stands in a flat float64 array at the place that lane l of `places` names;
- `call_kernel`, `call_lanes`: a kernel by its address, without Python in between.

Products and sums may be contracted to one rounding. Nothing is reordered: the same numbers in any lane give the same
result, whatever stands beside them.
"""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.kernels.loops.kinds import WIDTH


class Mask:
    """A truth value in each lane."""

    def __init__(self, bits: NDArray[np.bool_]) -> None:
        self.bits = bits

    def __and__(self, other: Mask) -> Mask:
        return Mask(self.bits & other.bits)

    def __or__(self, other: Mask) -> Mask:
        return Mask(self.bits | other.bits)

    def __invert__(self) -> Mask:
        return Mask(~self.bits)


class Lanes:
    """A number in each lane."""

    def __init__(self, numbers: Floats) -> None:
        self.numbers = numbers

    def __add__(self, other: Lanes | float) -> Lanes:
        return Lanes(self.numbers + _numbers(other))

    def __radd__(self, other: float) -> Lanes:
        return Lanes(other + self.numbers)

    def __sub__(self, other: Lanes | float) -> Lanes:
        return Lanes(self.numbers - _numbers(other))

    def __rsub__(self, other: float) -> Lanes:
        return Lanes(other - self.numbers)

    def __mul__(self, other: Lanes | float) -> Lanes:
        return Lanes(self.numbers * _numbers(other))

    def __rmul__(self, other: float) -> Lanes:
        return Lanes(other * self.numbers)

    def __truediv__(self, other: Lanes | float) -> Lanes:
        with np.errstate(all="ignore"):
            return Lanes(self.numbers / _numbers(other))

    def __rtruediv__(self, other: float) -> Lanes:
        with np.errstate(all="ignore"):
            return Lanes(other / self.numbers)

    def __neg__(self) -> Lanes:
        return Lanes(-self.numbers)

    def __lt__(self, other: Lanes | float) -> Mask:
        return Mask(self.numbers < _numbers(other))

    def __le__(self, other: Lanes | float) -> Mask:
        return Mask(self.numbers <= _numbers(other))

    def __gt__(self, other: Lanes | float) -> Mask:
        return Mask(self.numbers > _numbers(other))

    def __ge__(self, other: Lanes | float) -> Mask:
        return Mask(self.numbers >= _numbers(other))

    # As with arrays, equality of lanes is no truth value but one for each lane.
    def __eq__(self, other: object) -> Mask:  # pyright: ignore[reportIncompatibleMethodOverride]
        return Mask(self.numbers == _numbers(other))

    __hash__ = None  # pyright: ignore[reportAssignmentType]


class Buffer:
    """Lanes one after another.

    Args:
        numbers: (count, 8) rows of a buffer, (8 count,) of an array that is seen as one.
    """

    def __init__(self, numbers: Any) -> None:
        self.rows = numbers.reshape(-1, WIDTH)

    def __getitem__(self, index: int) -> Lanes:
        return Lanes(self.rows[index].copy())

    def __setitem__(self, index: int, value: Lanes | float) -> None:
        self.rows[index] = _numbers(value)


def _numbers(value: Any) -> Any:
    return value.numbers if isinstance(value, Lanes) else value


def lanes(number: float) -> Lanes:
    """A number in all lanes."""
    return Lanes(np.full(WIDTH, float(number)))


def square_root(x: Lanes) -> Lanes:
    """The root of each lane."""
    with np.errstate(all="ignore"):
        return Lanes(np.sqrt(x.numbers))


def magnitude(x: Lanes) -> Lanes:
    """The absolute value of each lane."""
    return Lanes(np.abs(x.numbers))


def rounded_down(x: Lanes) -> Lanes:
    """The greatest whole number not above each lane."""
    return Lanes(np.floor(x.numbers))


def where(mask: Mask | bool, a: Lanes | float, b: Lanes | float) -> Lanes:
    """Lanes of a where the mask is set, else of b; either may be a number."""
    bits = mask.bits if isinstance(mask, Mask) else np.full(WIDTH, mask)
    return Lanes(cast(Any, np.where(bits, _numbers(a), _numbers(b))))


def larger(a: Lanes, b: Lanes | float) -> Lanes:
    """The larger of both in each lane; the second may be a number."""
    return where(a > b, a, b)


def smaller(a: Lanes, b: Lanes | float) -> Lanes:
    """The smaller of both in each lane; the second may be a number."""
    return where(a < b, a, b)


def lane_bits(mask: Mask) -> int:
    """Bit l for lane l."""
    return sum(1 << lane for lane in range(WIDTH) if mask.bits[lane])


def how_many(bits: int) -> int:
    """Bits of a whole number that are set."""
    return int(bits).bit_count()


def any_lane(mask: Mask) -> bool:
    """Whether a lane of the mask is set."""
    return bool(mask.bits.any())


def buffer(count: int) -> Buffer:
    """Lanes on the stack, as many as a constant says; they hold nothing yet."""
    return Buffer(np.empty((count, WIDTH)))


def part(place: Buffer, index: int) -> Buffer:
    """The buffer that begins at a place of another."""
    return Buffer(place.rows[index:])


def seen(array: Any) -> Buffer:
    """A float64 array whose rows are in order, as a buffer."""
    flat = array.reshape(-1)
    return Buffer(flat[: len(flat) // WIDTH * WIDTH])


def looked_up(array: Floats, places: Lanes) -> Lanes:
    """In each lane the number of a flat float64 array at its place; whoever asks keeps the places inside."""
    return Lanes(array.reshape(-1)[places.numbers.astype(np.int64)])


def put(place: Buffer, index: int, lane: int, value: float) -> None:
    """One lane of a place set."""
    place.rows[index, lane] = value


def get(place: Buffer, index: int, lane: int) -> float:
    """One lane of a place."""
    return float(place.rows[index, lane])


def spread(array: Floats, begin: int, stride: int, x: Lanes) -> None:
    """Lane l to the array, seen as flat, at begin + l stride."""
    array.reshape(-1)[begin : begin + (WIDTH - 1) * stride + 1 : stride] = x.numbers


def in_lanes(count: int) -> Floats:
    """An array for so many lanes that begins with a cache line: keep it as long as what is `seen` of it."""
    numbers = np.empty((count + 1) * WIDTH)
    beyond = (numbers.ctypes.data // 8) % WIDTH
    return numbers[(WIDTH - beyond) % WIDTH :][: count * WIDTH]


def address(array: NDArray[Any]) -> int:
    """Where the first element of an array or view lies."""
    return array.ctypes.data


def call_lanes(entry: int, given: int, result: int) -> None:
    """Run a kernel of one result on eight rows in lanes: void (double *in, double *out).

    Args:
        entry: address, `Kernel.addresses.lanes`; the caller keeps the kernel alive.
        given: address of the inputs, one after another, each element eight numbers; a multiple of 64.
        result: address of the result, in the same form.
    """
    _prototype(2)(entry)(given, result)


def call_kernel(entry: int, arguments: int, dimensions: int, strides: int) -> None:
    """Run a kernel's batch entry: void (char **args, npy_intp *dims, npy_intp *steps, void *data).

    Args:
        entry: address, `Kernel.addresses.batch`; the caller keeps the kernel alive.
        arguments: address of an array with the addresses of all ports.
        dimensions: address of an array that begins with the number of rows.
        strides: address of an array with the bytes from row to row of every port, then its core strides in bytes.
    """
    _prototype(4)(entry)(arguments, dimensions, strides, None)


@cache
def _prototype(count: int) -> Any:
    return ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * count)
