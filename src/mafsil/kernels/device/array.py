"""Numbers on a device: our own array, and the arrays of others that speak the CUDA array interface."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod
from typing import Any, NoReturn, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, real_array
from mafsil.errors import InputError
from mafsil.kernels.device.driver import Device, Memory, driver

INTERFACE = "__cuda_array_interface__"
_NEEDED = ("shape", "typestr", "data", "version")


class DeviceArray:
    """float64 numbers on a device, row after row; `cupy.asarray(x)` and `torch.as_tensor(x)` take it without a copy.

    Attributes:
        shape: (*batch, *core).
        device: where it lies.
        stream: handle of the stream on which it is made; 0 is the default one.
    """

    dtype = np.dtype(np.float64)

    def __init__(self, device: Device, shape: tuple[int, ...], stream: int = 0, memory: Memory | None = None) -> None:
        self.device = device
        self.shape = shape
        self.stream = stream
        self._memory = memory or device.allocate(8 * prod(shape))

    @property
    def __cuda_array_interface__(self) -> dict[str, Any]:
        """As CuPy, PyTorch and Numba read it."""
        return {
            "shape": self.shape,
            "typestr": "<f8",
            "data": (self._memory.pointer, False),
            "version": 3,
            "strides": None,
            "stream": self.stream or 1,
        }

    @property
    def ndim(self) -> int:
        """Number of dimensions."""
        return len(self.shape)

    @property
    def size(self) -> int:
        """Number of elements."""
        return prod(self.shape)

    @property
    def nbytes(self) -> int:
        """Size in bytes."""
        return 8 * self.size

    def numpy(self) -> Floats:
        """A copy in main memory, once all work on it is done."""
        result = np.empty(self.shape)
        if result.size:
            self.device.synchronize(self.stream)
            self.device.read(result.ctypes.data, self._memory.pointer, result.nbytes)
        return result

    def __array__(self, *_: object, **__: object) -> NoReturn:
        raise InputError("export.implicit")

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("len() of an array without dimensions")
        return self.shape[0]

    def __repr__(self) -> str:
        return f"<DeviceArray {self.shape} on {self.device.name}>"


def device_array(values: ArrayLike, device: int = 0) -> DeviceArray:
    """A copy of numbers on a device.

    Args:
        values: numbers of any shape.
        device: its number.

    Raises:
        InputError: not real numbers, no such device.
        KernelError: no driver, no device, no room.
    """
    array = np.ascontiguousarray(real_array("values", values)).reshape(np.shape(cast("Any", values)))
    place = driver().device(device)
    result = DeviceArray(place, array.shape)
    if array.size:
        pointer = cast("int", result.__cuda_array_interface__["data"][0])
        place.write(pointer, array.ctypes.data, array.nbytes)
    return result


def on_device(value: object) -> bool:
    """Whether a value lies on a device: it has the interface (a PyTorch tensor in main memory has not)."""
    return type(value) is not np.ndarray and hasattr(value, INTERFACE)


@dataclass(frozen=True)
class View:
    """What a launch needs to know of an array on a device.

    Attributes:
        pointer: where it begins.
        shape: (*batch, *core).
        stream: handle of the stream that makes it; None where nobody says.
        writable: whether it may be written.
    """

    pointer: int
    shape: tuple[int, ...]
    stream: int | None
    writable: bool


def view(name: str, value: object) -> View:
    """The array behind the interface.

    Raises:
        InputError: not float64, not contiguous, masked or incomplete.
    """
    details = cast("dict[str, Any]", getattr(value, INTERFACE))
    missing = [key for key in _NEEDED if key not in details]
    if missing or details.get("mask") is not None:
        raise InputError("export.interface", argument=name, missing=", ".join(missing) or "-")
    if details["typestr"] not in ("<f8", "=f8"):
        raise InputError("export.dtype", argument=name, got=details["typestr"])
    shape = tuple(int(size) for size in details["shape"])
    strides = details.get("strides")
    if strides is not None and not _contiguous(shape, tuple(strides)):
        raise InputError("export.contiguous", argument=name, strides=tuple(strides), shape=shape)
    pointer, read_only = details["data"]
    stream = details.get("stream")
    return View(int(pointer or 0), shape, None if stream is None else int(stream), not read_only)


def _contiguous(shape: tuple[int, ...], strides: tuple[int, ...]) -> bool:
    """Whether the strides of all dimensions longer than 1 are those of row-major order."""
    expected = 8
    for size, stride in zip(reversed(shape), reversed(strides), strict=True):
        if size > 1 and stride != expected:
            return prod(shape) == 0
        expected *= size
    return True
