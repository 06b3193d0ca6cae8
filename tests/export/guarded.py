"""A child's work: kernels on arrays that end, or begin, exactly at pages that may not be touched.

python -m tests.export.guarded ROWS: every batch of 0 to ROWS rows; a read or a write beyond is the end of the process.
"""

from __future__ import annotations

import ctypes
import mmap
import sys
from collections.abc import Callable
from typing import Any

import numpy as np

import mafsil as mf
from mafsil.kernels import target
from mafsil.kernels.export.exported import tapes
from mafsil.kernels.export.object_file import object_file
from mafsil.kernels.export.wasm import machine
from mafsil.kernels.kernel import Kernel
from tests.export.fake_driver import emulated

QUANTITIES = ("inverse_dynamics", "mass_matrix", "potential_energy")
_KEPT: list[mmap.mmap] = []


def guarded(numbers: np.ndarray[Any, Any], *, at_end: bool) -> np.ndarray[Any, Any]:
    """A copy of the numbers between two forbidden pages, touching the one behind it or the one before it."""
    page = mmap.PAGESIZE
    pages = max(1, -(-numbers.nbytes // page))
    memory = mmap.mmap(-1, (pages + 2) * page)
    _KEPT.append(memory)
    start = ctypes.addressof(ctypes.c_char.from_buffer(memory))
    first = page + (pages * page - numbers.nbytes if at_end else 0)
    found = np.frombuffer(memory, np.float64, numbers.size, first).reshape(numbers.shape)
    found[...] = numbers
    protect = ctypes.CDLL(None, use_errno=True).mprotect
    for place in (start, start + (pages + 1) * page):
        assert protect(ctypes.c_void_p(place), ctypes.c_size_t(page), 0) == 0
    return found


Runner = Callable[[list[np.ndarray[Any, Any]], np.ndarray[Any, Any]], None]


def runners(kernel: Kernel) -> dict[str, Runner]:
    """The ways in which a kernel's code writes a batch: the ufunc, an exported object, a block of a device."""
    code = object_file(tapes(kernel)[1], kernel.signature, machine("host"), "f")
    loaded = target.load(code, ("f_rows",))
    pointers = [ctypes.c_void_p] * len(kernel.signature.ports)
    rows = ctypes.CFUNCTYPE(None, *pointers, ctypes.c_size_t)(loaded.addresses["f_rows"])
    (block, _), program = emulated(kernel)

    def by_ufunc(inputs: list[np.ndarray[Any, Any]], out: np.ndarray[Any, Any]) -> None:
        kernel(*inputs, out=out)

    def by_object(inputs: list[np.ndarray[Any, Any]], out: np.ndarray[Any, Any], kept: object = loaded) -> None:
        rows(*(x.ctypes.data for x in (*inputs, out)), len(out))

    def by_blocks(inputs: list[np.ndarray[Any, Any]], out: np.ndarray[Any, Any]) -> None:
        given: list[Any] = []
        for x in inputs:
            given += [ctypes.c_uint64(x.ctypes.data), ctypes.c_int64(1), ctypes.c_int64(0)]
        for k in range(program.plan.blocks(len(out))):
            block(ctypes.c_int64(k), *given, ctypes.c_uint64(out.ctypes.data), ctypes.c_int64(len(out)))

    return {"ufunc": by_ufunc, "object": by_object, "blocks": by_blocks}


def main(largest: int) -> None:
    """All quantities, ways, tails and sides."""
    rng = np.random.default_rng(1)
    robot = mf.load("planar3r")
    for quantity in QUANTITIES:
        kernel = robot.kernel(quantity)
        ways = runners(kernel)
        for count in range(largest + 1):
            plain = [rng.uniform(-3, 3, (count, *port.shape)) for port in kernel.signature.inputs]
            expected = kernel(*plain)
            for at_end in (True, False):
                inputs = [guarded(x, at_end=at_end) for x in plain]
                for name, way in ways.items():
                    out = guarded(np.full(expected.shape, np.nan), at_end=at_end)
                    way(inputs, out)
                    assert np.array_equal(out, expected), (quantity, name, count, at_end)
    print("untouched")


if __name__ == "__main__":
    main(int(sys.argv[1]))
