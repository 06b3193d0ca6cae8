"""Machine code in memory with its entries, and the canary that proves it before its first use."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.kernels import elf, target
from mafsil.kernels.call import BIND, CALL
from mafsil.kernels.layout import BATCH, LOOP, SINGLE, Signature, contiguous_steps
from mafsil.kernels.lazy import lazy
from mafsil.kernels.provenance import Provenance, from_json

ENTRIES = (BATCH, SINGLE, LOOP, CALL, BIND)
CANARY_ROWS = 8


@dataclass(frozen=True, eq=False)
class Image:
    """Loaded code; everything made from it keeps it alive.

    Attributes:
        addresses: of every symbol in ENTRIES.
        record: provenance as JSON text.
        cached: whether it came from the disk.
        owner: what holds the memory.
    """

    addresses: Mapping[str, int]
    record: bytes
    cached: bool
    owner: Any = field(repr=False)

    @lazy
    def provenance(self) -> Provenance:
        """Where the code comes from."""
        return from_json(self.record, cached=self.cached)


def load(code: bytes, record: bytes, *, cached: bool) -> Image:
    """Bring verified object code into memory.

    Args:
        code: object code.
        record: provenance as JSON text.
        cached: whether it came from the disk.
    """
    loaded = elf.load(code, ENTRIES) or target.load(code, ENTRIES)
    return Image(loaded.addresses, record, cached, loaded)


def canary_inputs(signature: Signature) -> bytes:
    """CANARY_ROWS rows of every input port, port after port: numbers in -1..1 that are no round ones."""
    count = CANARY_ROWS * sum(port.size for port in signature.inputs)
    golden = 0.6180339887498949
    return (np.arange(1, count + 1, dtype=np.float64) * golden % 1.0 * 2.0 - 1.0).tobytes()


def canary_outputs(image: Image, signature: Signature, inputs: bytes) -> bytes | None:
    """What the code answers to canary inputs, port after port; None if its two entries do not agree bit for bit."""
    given = _ports(np.frombuffer(inputs), signature, "inputs")
    batch = [np.full((CANARY_ROWS, port.size), np.nan) for port in signature.outputs]
    single = [np.full((CANARY_ROWS, port.size), np.nan) for port in signature.outputs]
    _run_batch(image.addresses[LOOP], signature, [*given, *batch])
    call = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * len(signature.ports))(image.addresses[SINGLE])
    places = [(x.ctypes.data, x.shape[1] * 8) for x in (*given, *single)]
    for row in range(CANARY_ROWS):
        call(*(start + row * step for start, step in places))
    answers = [b"".join(x.tobytes() for x in side) for side in (batch, single)]
    return answers[0] if same_bits(*answers) else None


def same_bits(a: bytes, b: bytes) -> bool:
    """Whether two runs of float64 numbers agree bit for bit, any NaN being equal to any other."""
    if a == b:
        return True
    if len(a) != len(b):
        return False
    x, y = np.frombuffer(a), np.frombuffer(b)
    return bool(((x.view(np.int64) == y.view(np.int64)) | (np.isnan(x) & np.isnan(y))).all())


def _ports(numbers: Floats, signature: Signature, side: str) -> list[Floats]:
    """Views of (CANARY_ROWS, size) per port."""
    views: list[Floats] = []
    start = 0
    for port in getattr(signature, side):
        stop = start + CANARY_ROWS * port.size
        views.append(numbers[start:stop].reshape(CANARY_ROWS, port.size))
        start = stop
    return views


def _run_batch(address: int, signature: Signature, arrays: list[Floats]) -> None:
    pointers = (ctypes.c_void_p * len(arrays))(*(x.ctypes.data for x in arrays))
    cores = sorted({size for port in signature.ports for size in port.shape})
    dims = (ctypes.c_ssize_t * (1 + len(cores)))(CANARY_ROWS, *cores)
    steps = [8 * port.size for port in signature.ports]
    steps += [step for port in signature.ports for step in contiguous_steps(port)]
    loop = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 4)(address)
    loop(pointers, dims, (ctypes.c_ssize_t * len(steps))(*steps), None)
