"""Content-addressed store of compiled objects on disk. A broken cache costs time, never a wrong result.

An entry is `header + payload`; the header holds magic, format version, key, length and BLAKE2b-256 of key and payload,
and nothing of a file is used before all five agree. Entries are written to a temporary file in the same directory,
synced and renamed. The directory is private (0700, our own user): it holds machine code.
"""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import os
import struct
import threading
import time
import warnings
from collections.abc import Generator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from mafsil.code_folder import CACHE_VARIABLE, TEMPORARY, code_folder, is_off, prepare, write_whole
from mafsil.messages import say

LIMIT_VARIABLE = "MAFSIL_CACHE_LIMIT"
"""Environment variable with the size in MiB above which the entries unused for longest are removed."""
LIMIT_MIB = 1024

MAGIC = b"mafsilK\0"
VERSION = 1
_HEADER = struct.Struct("<8sI32sQ32s")
_PARTS = struct.Struct("<IIIQ")
_SUFFIX, _LOCK = ".kernel", ".lock"
_ORPHAN_AGE = 3600.0
_SWEEP_EVERY = 600.0
_STAMP_AGE = 86400.0
_LARGEST = 1 << 30
_REMEMBERED = 256


class CacheWarning(UserWarning):
    """The cache of compiled code is damaged or cannot be used; results are right, starting takes longer."""


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
    parts = (entry.provenance, entry.inputs, entry.outputs, entry.code)
    payload = _PARTS.pack(*map(len, parts)) + b"".join(parts)
    return _HEADER.pack(MAGIC, VERSION, key, len(payload), _digest(key, payload)) + payload


def decode(key: bytes, data: bytes) -> Entry | None:
    """The entry in the bytes of a cache file, or None if a single bit of it is not as it was written for this key."""
    if len(data) < _HEADER.size:
        return None
    magic, version, named, length, digest = _HEADER.unpack_from(data)
    payload = data[_HEADER.size :]
    if magic != MAGIC or version != VERSION or named != key or length != len(payload):
        return None
    return _parts(payload) if digest == _digest(key, payload) else None


def _digest(key: bytes, payload: bytes) -> bytes:
    return hashlib.blake2b(payload, digest_size=32, key=key, person=MAGIC + struct.pack("<Q", VERSION)).digest()


def _parts(payload: bytes) -> Entry | None:
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
    """One directory of entries, or memory alone.

    Args:
        directory: created when missing; None keeps entries in memory only.
    """

    def __init__(self, directory: Path | None) -> None:
        self.directory = directory
        self._memory: dict[str, Entry] = {}
        self._lock = threading.Lock()
        self._ready: bool | None = None if directory else False

    def get(self, key: str) -> Entry | None:
        """The entry of this key, verified; None if there is none, or a damaged one, which is removed with a warning."""
        if key in self._memory:
            return self._memory[key]
        path = self._path(key)
        if path is None:
            return None
        data = _read(path)
        if data is None:
            return None
        entry = decode(bytes.fromhex(key), data)
        if entry is None:
            self.discard(key)
            warn("cache.damaged", path=str(path))
        return entry

    def put(self, key: str, entry: Entry) -> None:
        """Keep an entry; where the disk refuses, in memory, with one warning."""
        path = self._path(key)
        if path is not None:
            try:
                write_whole(path, encode(bytes.fromhex(key), entry))
            except OSError as error:
                warn("cache.unwritable", path=str(self.directory), reason=error.strerror or str(error))
            else:
                self._sweep_now_and_then()
                return
        with self._lock:
            self._memory[key] = entry
            while len(self._memory) > _REMEMBERED:
                del self._memory[next(iter(self._memory))]

    def discard(self, key: str) -> None:
        """Forget an entry."""
        self._memory.pop(key, None)
        path = self._path(key)
        if path is not None:
            with contextlib.suppress(OSError):
                path.unlink()

    @contextlib.contextmanager
    def compiling(self, key: str, patience: float = 60.0) -> Generator[bool, None, None]:
        """Hold the right to compile this key among all processes; yields whether another process had held it.

        The lock is the system's own and dies with its holder. After `patience` seconds, or where there are no locks,
        work goes on without it: two processes then compile the same entry, which is only slower.
        """
        path = self._path(key)
        handle = None if path is None else _lock(path.with_suffix(_LOCK), 0.0)
        waited = path is not None and handle is None
        if path is not None and waited:
            handle = _lock(path.with_suffix(_LOCK), patience)
        try:
            yield waited
        finally:
            if handle is not None and path is not None:
                with contextlib.suppress(OSError):
                    path.with_suffix(_LOCK).unlink()
                _unlock(handle)

    def sweep(self, limit: int | None = None, now: float | None = None) -> int:
        """Remove orphans older than an hour, then the entries unused for longest until the rest fits.

        Args:
            limit: bytes that may stay; the default is 1 GiB or MAFSIL_CACHE_LIMIT (in MiB).
            now: seconds since the epoch.

        Returns:
            Number of files removed; 0 if another process is sweeping.
        """
        if not self._usable() or self.directory is None:
            return 0
        handle = _lock(self.directory / f"sweep{_LOCK}", 0.0)
        if handle is None:
            return 0
        try:
            return _remove_old(self.directory, _limit() if limit is None else limit, now or time.time())
        except OSError:
            return 0
        finally:
            os.utime(handle)
            _unlock(handle)

    def _sweep_now_and_then(self) -> None:
        if self.directory is None:
            return
        try:
            last = (self.directory / f"sweep{_LOCK}").stat().st_mtime
        except OSError:
            last = 0.0
        if not 0.0 <= time.time() - last < _SWEEP_EVERY:
            self.sweep()

    def _path(self, key: str) -> Path | None:
        return self.directory / (key + _SUFFIX) if self.directory is not None and self._usable() else None

    def _usable(self) -> bool:
        if self._ready is None and self.directory is not None:
            reason = prepare(self.directory)
            self._ready = not reason
            if reason:
                warn("cache.unusable", path=str(self.directory), reason=reason)
        return bool(self._ready)


def default() -> Store:
    """The store of this process, as MAFSIL_CACHE and the user's cache directory say."""
    return _store(os.environ.get(CACHE_VARIABLE, ""), os.environ.get("XDG_CACHE_HOME", ""), os.environ.get("HOME", ""))


@cache
def _store(_named: str, _xdg: str, _home: str) -> Store:
    directory = code_folder()
    if directory is None and not is_off():
        warn("cache.homeless")
    return Store(directory)


def _read(path: Path) -> bytes | None:
    try:
        with open(path, "rb") as file:
            found = os.fstat(file.fileno())
            if found.st_size > _LARGEST:
                return b""
            data = file.read()
        if time.time() - found.st_mtime > _STAMP_AGE:
            os.utime(path)
        return data
    except FileNotFoundError:
        return None
    except PermissionError:
        return None
    except OSError:
        return b""


def _lock(path: Path, patience: float) -> int | None:
    """An exclusive lock on a file, held while the returned descriptor is open; None when not had in time."""
    try:
        import fcntl
    except ImportError:
        return None
    try:
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
    except OSError:
        return None
    give_up = time.monotonic() + patience
    while True:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return handle
        except OSError:
            if time.monotonic() >= give_up:
                os.close(handle)
                return None
            time.sleep(0.005)


def _unlock(handle: int) -> None:
    """Let go explicitly: a child forked meanwhile holds a copy of the descriptor."""
    import fcntl

    fcntl.flock(handle, fcntl.LOCK_UN)
    os.close(handle)


def _remove_old(directory: Path, limit: int, now: float) -> int:
    kept: list[tuple[float, int, str]] = []
    removed = 0
    with os.scandir(directory) as files:
        for file in files:
            found = file.stat(follow_symlinks=False)
            if file.name.endswith(_SUFFIX):
                kept.append((found.st_mtime, found.st_size, file.path))
            elif file.name.endswith((TEMPORARY, _LOCK)) and now - found.st_mtime > _ORPHAN_AGE:
                removed += _unlinked(file.path)
    total = sum(size for _, size, _ in kept)
    for _, size, path in sorted(kept):
        if total <= limit:
            break
        total -= size
        removed += _unlinked(path)
    return removed


def _unlinked(path: str) -> bool:
    try:
        os.unlink(path)
    except OSError:
        return False
    return True


def _limit() -> int:
    try:
        return int(os.environ.get(LIMIT_VARIABLE, "")) << 20
    except ValueError:
        return LIMIT_MIB << 20


_told: set[str] = set()


def warn(key: str, **facts: str) -> None:
    """Say it once in a process."""
    if key not in _told:
        _told.add(key)
        warnings.warn(say(key, **facts), CacheWarning, stacklevel=2)
