"""Compiled kernels on disk: the code, the canary that it must repeat, and where it comes from."""

from __future__ import annotations

import itertools
import os
import struct
import threading
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from mafsil.code_store import CACHE_VARIABLE, FileStore, Kind, code_folder, is_off, warn

KERNEL = Kind(b"mafsilK\0", ".kernel")
_PARTS = struct.Struct("<IIIQ")
_REMEMBERED = 256


@dataclass(frozen=True)
class Entry:
    """What the cache keeps of one kernel.

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


def encode(key: bytes, entry: Entry) -> bytes:
    """The bytes of a cache file.

    Args:
        key: 32 bytes.
        entry: what to keep.
    """
    return KERNEL.sealed(key, _payload(entry))


def decode(key: bytes, data: bytes) -> Entry | None:
    """The entry in the bytes of a cache file, or None if a single bit of it is not as it was written for this key."""
    payload = KERNEL.opened(key, data)
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


class Store:
    """The kernels of one directory, or of memory alone.

    Args:
        directory: created when missing; None keeps entries in memory only.
    """

    def __init__(self, directory: Path | None) -> None:
        self._files = FileStore(directory, KERNEL)
        self._memory: dict[str, Entry] = {}
        self._lock = threading.Lock()

    @property
    def directory(self) -> Path | None:
        """Where the files are."""
        return self._files.directory

    def get(self, key: str) -> Entry | None:
        """The entry of this key, verified; None if there is none, or a damaged one, which is removed with a warning."""
        if key in self._memory:
            return self._memory[key]
        payload = self._files.get(key)
        return None if payload is None else _entry(payload)

    def put(self, key: str, entry: Entry) -> None:
        """Keep an entry; where the disk refuses, in memory, with one warning."""
        if self._files.put(key, _payload(entry)):
            return
        with self._lock:
            self._memory[key] = entry
            while len(self._memory) > _REMEMBERED:
                del self._memory[next(iter(self._memory))]

    def discard(self, key: str) -> None:
        """Forget an entry."""
        self._memory.pop(key, None)
        self._files.discard(key)

    @contextmanager
    def compiling(self, key: str, patience: float = 60.0) -> Generator[bool, None, None]:
        """Hold the right to compile this key among all processes; see `FileStore.compiling`."""
        with self._files.compiling(key, patience) as waited:
            yield waited

    def sweep(self, limit: int | None = None, now: float | None = None) -> int:
        """Remove orphans and what does not fit; see `FileStore.sweep`."""
        return self._files.sweep(limit, now)


def default() -> Store:
    """The store of this process, as MAFSIL_CACHE and the user's cache directory say."""
    return _store(os.environ.get(CACHE_VARIABLE, ""), os.environ.get("XDG_CACHE_HOME", ""), os.environ.get("HOME", ""))


@cache
def _store(_named: str, _xdg: str, _home: str) -> Store:
    directory = code_folder()
    if directory is None and not is_off():
        warn("cache.homeless")
    return Store(directory)
