"""Kernels on disk, in two levels: the tape of an expression, and machine code with the canary that it must repeat.

A `KernelRecord` says where a kernel comes from: what was compiled, for which machine, from which expression, and how
long it took.
"""

from __future__ import annotations

import itertools
import json
import os
import struct
import threading
import zlib
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from functools import cache
from hashlib import blake2b
from pathlib import Path
from typing import Any, TypeVar

from mafsil.code_store import CACHE_VARIABLE, FileStore, StoreKind, code_folder, is_off, warn

KERNEL = StoreKind(b"mafsilK\0", ".kernel")
"""Machine code."""
TAPE = StoreKind(b"mafsilT\0", ".tape")
"""The operations of an expression."""
_PARTS = struct.Struct("<IIIQ")
_HEAD = struct.Struct("<I")
_REMEMBERED = 256
Kept = TypeVar("Kept")


@dataclass(frozen=True)
class Entry:
    """What the cache keeps of machine code.

    Attributes:
        code: object code.
        inputs: rows of the canary, float64 bytes, port after port.
        outputs: the answers that this very code gave to them.
        provenance: JSON text.
    """

    code: bytes
    inputs: bytes
    outputs: bytes
    provenance: bytes


@dataclass(frozen=True)
class TapeEntry:
    """What the cache keeps of an expression.

    Attributes:
        hash: of the reduced tape: `Tape.hash`.
        operations: how many of each one evaluation takes.
        seconds: that tracing and reducing took.
        packed: text of the tape, compressed.
    """

    hash: str
    operations: Mapping[str, int]
    seconds: float
    packed: bytes

    def text(self) -> str | None:
        """The text of the tape; None if it is not the one of `hash`."""
        try:
            text = zlib.decompress(self.packed)
        except zlib.error:
            return None
        return text.decode() if blake2b(text, digest_size=16).hexdigest() == self.hash else None


def pack_tape(text: str) -> bytes:
    """The text of a tape, compressed."""
    return zlib.compress(text.encode(), 1)


def encode(key: bytes, entry: Entry) -> bytes:
    """The bytes of a cache file.

    Args:
        key: 32 bytes.
        entry: what to keep.
    """
    return KERNEL.seal(key, _payload(entry))


def decode(key: bytes, data: bytes) -> Entry | None:
    """The entry in the bytes of a cache file, or None if a single bit of it is not as it was written for this key."""
    payload = KERNEL.unseal(key, data)
    return None if payload is None else _entry(payload)


def _payload(entry: Entry) -> bytes:
    parts = (entry.provenance, entry.inputs, entry.outputs, entry.code)
    return _PARTS.pack(*map(len, parts)) + b"".join(parts)


def _entry(payload: bytes) -> Entry | None:
    if len(payload) < _PARTS.size:
        return None
    sizes = _PARTS.unpack_from(payload)
    if sum(sizes) != len(payload) - _PARTS.size:
        return None
    cut = [_PARTS.size]
    for size in sizes:
        cut.append(cut[-1] + size)
    provenance, inputs, outputs, code = (payload[a:b] for a, b in itertools.pairwise(cut))
    return Entry(code, inputs, outputs, provenance)


def _tape_payload(entry: TapeEntry) -> bytes:
    head = json.dumps([entry.hash, dict(entry.operations), entry.seconds]).encode()
    return _HEAD.pack(len(head)) + head + entry.packed


def _tape_entry(payload: bytes) -> TapeEntry | None:
    try:
        (size,) = _HEAD.unpack_from(payload)
        known, operations, seconds = json.loads(payload[_HEAD.size : _HEAD.size + size])
        return TapeEntry(str(known), dict(operations), float(seconds), payload[_HEAD.size + size :])
    except (struct.error, ValueError, TypeError):
        return None


class Store:
    """The kernels of one directory, or of memory alone.

    Args:
        directory: created when missing; None keeps entries in memory only.
    """

    def __init__(self, directory: Path | None) -> None:
        self._codes = FileStore(directory, KERNEL)
        self._tapes = FileStore(directory, TAPE)
        self._memory: dict[tuple[StoreKind, str], Any] = {}
        self._lock = threading.Lock()

    @property
    def directory(self) -> Path | None:
        """Where the files are."""
        return self._codes.directory

    def get(self, key: str) -> Entry | None:
        """The code of this key, verified; None if there is none, or a damaged one, which is removed with a warning."""
        return self._got(self._codes, key, _entry)

    def put(self, key: str, entry: Entry) -> None:
        """Keep code; where the disk refuses, in memory, with one warning."""
        self._keep(self._codes, key, _payload(entry), entry)

    def get_tape(self, key: str) -> TapeEntry | None:
        """The tape of this key, verified; None as for `get`."""
        return self._got(self._tapes, key, _tape_entry)

    def put_tape(self, key: str, entry: TapeEntry) -> None:
        """Keep a tape; where the disk refuses, in memory, with one warning."""
        self._keep(self._tapes, key, _tape_payload(entry), entry)

    def discard(self, key: str) -> None:
        """Forget what is kept under a key."""
        for files in (self._codes, self._tapes):
            self._memory.pop((files.kind, key), None)
            files.discard(key)

    @contextmanager
    def compiling(self, key: str, patience: float = 60.0) -> Generator[bool, None, None]:
        """Hold the right to make this key among all processes; see `FileStore.compiling`."""
        with self._codes.compiling(key, patience) as waited:
            yield waited

    def sweep(self, limit: int | None = None, now: float | None = None) -> int:
        """Remove orphans and what does not fit; see `FileStore.sweep`."""
        return self._codes.sweep(limit, now)

    def _got(self, files: FileStore, key: str, read: Callable[[bytes], Kept | None]) -> Kept | None:
        if (files.kind, key) in self._memory:
            return self._memory[files.kind, key]
        payload = files.get(key)
        return None if payload is None else read(payload)

    def _keep(self, files: FileStore, key: str, payload: bytes, entry: object) -> None:
        if files.put(key, payload):
            return
        with self._lock:
            self._memory[files.kind, key] = entry
            while len(self._memory) > _REMEMBERED:
                del self._memory[next(iter(self._memory))]


def default() -> Store:
    """The store of this process, as MAFSIL_CACHE and the user's cache directory say."""
    return _store(os.environ.get(CACHE_VARIABLE, ""), os.environ.get("XDG_CACHE_HOME", ""), os.environ.get("HOME", ""))


@cache
def _store(_named: str, _xdg: str, _home: str) -> Store:
    directory = code_folder()
    if directory is None and not is_off():
        warn("cache.homeless")
    return Store(directory)


@dataclass(frozen=True)
class KernelRecord:
    """The record that travels with compiled code, also through the cache.

    Attributes:
        name: of the kernel.
        key: of the cache entry of the tape; in the record of a piece of code, of that piece; hexadecimal.
        expression: BLAKE2b hash of the operations that were compiled, hexadecimal.
        operations: how many of each operation one evaluation takes.
        target: processor as LLVM names it.
        lanes: rows evaluated together.
        object_bytes: size of the object code that is loaded.
        seconds: time of each stage: build, lower, compile (of the run that compiled it).
        cached: whether this process found all code that it has loaded in the cache.
    """

    name: str
    key: str
    expression: str = ""
    operations: Mapping[str, int] = field(default_factory=dict[str, int])
    target: str = ""
    lanes: int = 0
    object_bytes: int = 0
    seconds: Mapping[str, float] = field(default_factory=dict[str, float])
    cached: bool = False

    @property
    def total(self) -> int:
        """Operations of one evaluation."""
        return sum(self.operations.values())

    def as_json(self) -> bytes:
        """The record as text, for the cache."""
        return json.dumps(asdict(self)).encode()

    def __str__(self) -> str:
        most = sorted(self.operations.items(), key=lambda item: -item[1])
        counts = ", ".join(f"{count} {name}" for name, count in most)
        took = ", ".join(f"{stage} {seconds:.3f} s" for stage, seconds in self.seconds.items())
        return "\n".join(
            (
                f"{self.name}: {self.total} operations ({counts})",
                f"  expression {self.expression[:16]}, key {self.key[:16]}",
                f"  {self.target}, {self.lanes} lanes, {self.object_bytes} bytes of object code",
                f"  {took}{', from the cache' if self.cached else ''}",
            )
        )


def from_json(text: bytes, *, cached: bool) -> KernelRecord:
    """The record written by `KernelRecord.as_json`."""
    return replace(KernelRecord(**json.loads(text)), cached=cached)
