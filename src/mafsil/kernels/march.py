"""Calling a kernel many times in a row without returning to Python: every call may read what the one before wrote."""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from mafsil import threads
from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.kernels import cache as code_cache
from mafsil.kernels import elf, identity, target
from mafsil.kernels.cache import Entry
from mafsil.kernels.compiler import _llvm  # pyright: ignore[reportPrivateUsage]
from mafsil.kernels.kernel import Kernel
from mafsil.kernels.layout import Port, Signature, contiguous_steps

MARCH = "mafsil_march"
"""Symbol: void (loop, char **args, npy_intp *dims, npy_intp *steps, int64 ports, int64 *advance, int64 count)."""
_LEAST_ROWS = 16
"""Rows that are worth a thread of their own."""

_IR = f"""
; 1. for k in 0 ... count: the kernel's loop over the rows of this call
; 2.     for p in 0 ... ports: args[p] += advance[p], the row of the next call; 0 repeats the same
define void @{MARCH}(ptr %loop, ptr %args, ptr %dims, ptr %steps, i64 %ports, ptr %advance, i64 %count) {{
entry:
  %some = icmp sgt i64 %count, 0
  br i1 %some, label %call, label %leave
call:
  %k = phi i64 [ 0, %entry ], [ %k.next, %called ]
  call void %loop(ptr %args, ptr %dims, ptr %steps, ptr null)
  br label %port
port:
  %p = phi i64 [ 0, %call ], [ %p.next, %port ]
  %place = getelementptr ptr, ptr %args, i64 %p
  %base = load ptr, ptr %place, align 8
  %by.place = getelementptr i64, ptr %advance, i64 %p
  %by = load i64, ptr %by.place, align 8
  %moved = getelementptr i8, ptr %base, i64 %by
  store ptr %moved, ptr %place, align 8
  %p.next = add i64 %p, 1
  %p.more = icmp slt i64 %p.next, %ports
  br i1 %p.more, label %port, label %called
called:
  %k.next = add i64 %k, 1
  %k.more = icmp slt i64 %k.next, %count
  br i1 %k.more, label %call, label %leave
leave:
  ret void
}}
"""


def march(kernel: Kernel, arrays: Sequence[Floats], count: int, workers: int | None = None) -> None:
    """Call a kernel `count` times over a batch of rows; the rows of different batches are shared by threads.

    Call i reads and writes row i of every array. An output may lie over an input one row further on, which is how a
    state marches: pass x[:-1] as the input and x[1:] as the output.

    Args:
        kernel: inputs and outputs are the ports of `arrays`, in order.
        arrays: (count or 1, rows or 1, *core) each, float64, the core contiguous; length 1 is broadcast (inputs only).
        count: number of calls.
        workers: threads; all cores if None.

    Raises:
        InputError: an array of another type or shape.
    """
    ports = kernel.signature.ports
    rows = max((array.shape[1] for array in arrays), default=0)
    for number, (port, array) in enumerate(zip(ports, arrays, strict=True)):
        _require(port, array, count, rows, written=number >= len(kernel.signature.inputs))
    if not rows or not count:
        return
    loop = kernel.image.few if rows == 1 else kernel.image.loop
    steps = _steps(kernel.signature, arrays)
    advance = (ctypes.c_int64 * len(ports))(*(0 if a.shape[0] == 1 < count else a.strides[0] for a in arrays))
    requested = threads.available() if workers is None else threads.check_count(workers, "workers")
    parts = max(1, min(requested, rows // _LEAST_ROWS))
    edges = [rows * part // parts for part in range(parts + 1)]
    run = _entry()

    def part(index: int) -> None:
        first, last = edges[index], edges[index + 1]
        starts = [a.ctypes.data + (0 if a.shape[1] == 1 < rows else first * a.strides[1]) for a in arrays]
        args = (ctypes.c_void_p * len(ports))(*starts)
        run(loop, args, (ctypes.c_ssize_t * 1)(last - first), steps, len(ports), advance, count)

    threads.run(part, parts, parts)


def _require(port: Port, array: Floats, count: int, rows: int, *, written: bool) -> None:
    plain = array.dtype == np.float64 and array.shape[2:] == port.shape
    if plain and port.size:
        plain = array.strides[2:] == contiguous_steps(port)
    fits = plain and array.shape[0] in ((count,) if written else (1, count)) and array.shape[1] in (1, rows)
    if not fits or (written and (array.shape[1] != rows or not array.flags.writeable)):
        raise InputError("input.shape", name=port.name, expected=(count, rows, *port.shape), got=array.shape, hint="")


def _steps(signature: Signature, arrays: Sequence[Floats]) -> Any:
    """Strides over the rows of every port, then the core strides."""
    rows = max(array.shape[1] for array in arrays)
    outer = [0 if array.shape[1] == 1 < rows else array.strides[1] for array in arrays]
    inner = [step for port in signature.ports for step in contiguous_steps(port)]
    return (ctypes.c_ssize_t * (len(outer) + len(inner)))(*outer, *inner)


_once = threading.Lock()


def _entry() -> Any:
    with _once:
        return _load()


@cache
def _load() -> Any:
    """The marching loop as a function of ctypes: it runs without Python's lock."""
    store = code_cache.default()
    key = identity.object_key(MARCH, _IR, Signature(MARCH, (), ()), identity.machine())
    entry = store.get(key)
    if entry is None:
        with _llvm:
            entry = Entry(target.compile(_IR, target.host()), b"", b"", b"{}")
        store.put(key, entry)
    with _llvm:
        code = elf.load(entry.code, (MARCH,)) or target.load(entry.code, (MARCH,))
    pointer, integer = ctypes.c_void_p, ctypes.c_int64
    function = ctypes.CFUNCTYPE(None, pointer, pointer, pointer, pointer, integer, pointer, integer)
    _kept.append(code)
    return function(code.addresses[MARCH])


_kept: list[object] = []
"""Code that lives as long as the process."""
