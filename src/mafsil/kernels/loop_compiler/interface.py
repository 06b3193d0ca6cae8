"""What compiled loops say beyond Python and NumPy: types of arrays, their addresses, calls of kernels by address."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Whole: TypeAlias = NDArray[np.int64]
"""Integers."""
Singles: TypeAlias = NDArray[np.float32]
"""Numbers of single precision."""


def address(array: NDArray[Any]) -> int:
    """Where the first element of an array or view lies."""
    return array.ctypes.data


def run_kernel(entry: int, arguments: Whole, dimensions: Whole, strides: Whole) -> None:
    """Run a kernel's batch entry: void (char **args, npy_intp *dims, npy_intp *steps, void *data).

    Args:
        entry: address, `Kernel.addresses.batch`; the caller keeps the kernel alive.
        arguments: addresses of all ports.
        dimensions: begins with the number of rows.
        strides: bytes from row to row of every port, then its core strides in bytes.
    """
    _prototype()(entry)(address(arguments), address(dimensions), address(strides), None)


@cache
def _prototype() -> Any:
    return ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 4)
