"""Machine code in memory, part by part, and the canary that proves each part before its first use."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.kernels import elf, small_batch, target
from mafsil.kernels.cache import Entry, KernelRecord, TapeEntry, from_json
from mafsil.kernels.call import BIND, CALL
from mafsil.kernels.layout import (
    ALONE,
    BATCH,
    LANE_COUNT,
    LANES,
    LOOP,
    SINGLE,
    Signature,
    contiguous_steps,
)
from mafsil.kernels.small_batch import FEW, MOST, TO_LOOP, TO_SINGLE, most_rows
from mafsil.kernels.target import Code

CANARY_ROWS = LANE_COUNT
ENTRIES = {
    BATCH: (BATCH, LOOP, ALONE),
    SINGLE: (SINGLE,),
    LANES: (LANES,),
    CALL: (CALL, BIND, FEW, TO_SINGLE, TO_LOOP, MOST),
}
"""The parts of a kernel, named after their first entry, and the symbols of each."""
FROM_PYTHON = (CALL, SINGLE, BATCH)
"""The parts that calls from Python bring in; LANES is for compiled loops alone."""


@dataclass(frozen=True, eq=False)
class Part:
    """Loaded code of one part; everything made from it keeps it alive.

    Attributes:
        addresses: of every symbol of the part.
        record: provenance as JSON text.
        cached: whether it came from the disk.
        owner: what holds the memory.
        answers: to the canary; empty for the part that does no arithmetic.
    """

    addresses: Mapping[str, int]
    record: bytes
    cached: bool
    owner: Any = field(repr=False)
    answers: bytes = field(default=b"", repr=False)


class Image:
    """All code of a kernel: each part is made when it is first asked for, and told where the others are.

    Args:
        make: called as `make(image, part, compiles)`: puts the part in place with `add`, once however many threads ask;
            unless it compiles, only if the store has it.
        entry: what the cache keeps of the expression.
        origin: what stays the same in the provenance.
        signature: ports.
    """

    def __init__(
        self, make: Callable[[Image, str, bool], None], entry: TapeEntry, origin: KernelRecord, signature: Signature
    ) -> None:
        self._make = make
        self._signature = signature
        self._row_ns = 0.0
        self._origin = origin
        self.hash = entry.hash
        self.operations = sum(entry.operations.values())
        self.parts: dict[str, Part] = {}
        self._missing: set[str] = set()

    def part(self, name: str) -> Part:
        """A part of the code; compiled, or loaded from the cache, at its first use.

        Args:
            name: BATCH, SINGLE, LANES or CALL.
        """
        if name not in self.parts:
            self._make(self, name, True)
        return self.parts[name]

    def at_hand(self, name: str) -> bool:
        """Whether a part is in memory, or was in the store when this was first asked.

        Args:
            name: as for `part`.
        """
        if name not in self.parts and name not in self._missing:
            self._make(self, name, False)
            self._missing.add(name)
        return name in self.parts

    def add(self, name: str, part: Part) -> None:
        """Put a part in its place and connect it with the others: each connection is one pointer, written at once."""
        self.parts[name] = part
        single, batch, around = (self.parts.get(part) for part in (SINGLE, BATCH, CALL))
        if around is not None and batch is not None:
            ctypes.c_int64.from_address(around.addresses[MOST]).value = most_rows(self.row_ns(), self._signature)
        for here, symbol, there, entry in (
            (batch, ALONE, single, SINGLE),
            (around, TO_SINGLE, single, SINGLE),
            (around, TO_LOOP, batch, LOOP),
        ):
            if here is not None and there is not None:
                ctypes.c_void_p.from_address(here.addresses[symbol]).value = there.addresses[entry]

    def row_ns(self) -> float:
        """Nanoseconds of one row of a batch, about (`cost`)."""
        if not self._row_ns:
            lanes = from_json(self.part(BATCH).record, cached=True).lanes
            self._row_ns = small_batch.row_ns(self.operations, lanes, self._signature)
        return self._row_ns

    @property
    def loop(self) -> int:
        """Address of LOOP: any rows, in the lanes of vectors."""
        return self.part(BATCH).addresses[LOOP]

    @property
    def few(self) -> int:
        """Address of FEW: contiguous rows, one after another; of LOOP's convention."""
        self.part(SINGLE)
        return self.part(CALL).addresses[FEW]

    @property
    def provenance(self) -> KernelRecord:
        """Where the code comes from that is in memory; if there is none yet, that of batches is made."""
        if not self.parts.keys() - {CALL}:
            self.part(BATCH)
        found = [from_json(part.record, cached=part.cached) for part in self.parts.values()]
        stages = {stage for record in found for stage in record.seconds}
        seconds = {stage: sum(record.seconds.get(stage, 0.0) for record in found) for stage in sorted(stages)}
        return replace(
            self._origin,
            target=found[0].target,
            lanes=found[0].lanes,
            object_bytes=sum(record.object_bytes for record in found),
            seconds={**self._origin.seconds, **seconds},
            cached=all(part.cached for part in self.parts.values()),
        )


def load(
    name: str, entry: Entry, signature: Signature, imports: Mapping[str, int], *, cached: bool
) -> Part | None:  # fmt: skip
    """Bring verified object code into memory; None if it does not repeat its canary.

    Args:
        name: of the part.
        entry: code and canary.
        signature: ports.
        imports: addresses of what the code may call.
        cached: whether it came from the disk; code that did not has no answers to repeat yet.
    """
    loaded = elf.load(entry.code, ENTRIES[name], imports) or target.load(entry.code, ENTRIES[name], imports)
    answers = b"" if name == CALL else canary_outputs(loaded, name, signature, entry.inputs)
    right = not cached or same_bits(answers, entry.outputs)
    return Part(loaded.addresses, entry.provenance, cached, loaded, answers) if right else None


def canary_inputs(signature: Signature) -> bytes:
    """CANARY_ROWS rows of every input port, port after port: numbers in -1..1 that are no round ones."""
    count = CANARY_ROWS * sum(port.size for port in signature.inputs)
    golden = 0.6180339887498949
    return (np.arange(1, count + 1, dtype=np.float64) * golden % 1.0 * 2.0 - 1.0).tobytes()


def canary_outputs(part: Part | Code, name: str, signature: Signature, inputs: bytes) -> bytes:
    """What the code answers to canary inputs, port after port.

    Args:
        part: loaded code.
        name: of the part: BATCH, SINGLE or LANES.
        signature: ports.
        inputs: as `canary_inputs`.
    """
    given = _ports(np.frombuffer(inputs), signature, "inputs")
    found = [np.full((CANARY_ROWS, port.size), np.nan) for port in signature.outputs]
    if name == BATCH:
        _run_batch(part.addresses[LOOP], signature, [*given, *found])
    elif name == LANES:
        _run_lanes(part.addresses[LANES], given, found)
    else:
        call = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * len(signature.ports))(part.addresses[SINGLE])
        places = [(x.ctypes.data, x.shape[1] * 8) for x in (*given, *found)]
        for row in range(CANARY_ROWS):
            call(*(start + row * step for start, step in places))
    return b"".join(x.tobytes() for x in found)


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


def _run_lanes(address: int, given: list[Floats], found: list[Floats]) -> None:
    tiles = [_align(np.concatenate([x.T for x in given])), *(_align(x.T) for x in found)]
    ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * len(tiles))(address)(*(tile.ctypes.data for tile in tiles))
    for x, tile in zip(found, tiles[1:], strict=True):
        x[:] = tile.T


def _align(numbers: Floats) -> Floats:
    """A copy that begins at a multiple of 64 bytes."""
    room = np.empty(numbers.size + 8)
    first = -(room.ctypes.data // 8) % 8
    copy = room[first : first + numbers.size].reshape(numbers.shape)
    copy[:] = numbers
    return copy


def _run_batch(address: int, signature: Signature, arrays: list[Floats]) -> None:
    pointers = (ctypes.c_void_p * len(arrays))(*(x.ctypes.data for x in arrays))
    cores = sorted({size for port in signature.ports for size in port.shape})
    dims = (ctypes.c_ssize_t * (1 + len(cores)))(CANARY_ROWS, *cores)
    steps = [8 * port.size for port in signature.ports]
    steps += [step for port in signature.ports for step in contiguous_steps(port)]
    loop = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 4)(address)
    loop(pointers, dims, (ctypes.c_ssize_t * len(steps))(*steps), None)
