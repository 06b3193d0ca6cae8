"""Kernels called from loops by their address, without Python in between."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any

from numpy.typing import NDArray


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
