"""Content-addressed files of compiled code. A broken store costs time, never a wrong result.

An entry is `header + payload`; the header holds magic, format version, key, length and BLAKE2b-256 of key and payload,
and nothing of a file is used before all five agree. Entries are written to a temporary file in the same directory,
synced and renamed. The directory and its files are ours alone (`folder`): they hold machine code.

Arrays that take long to compute and follow from what their key says alone are kept beside it (`kept_array`).
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import struct
import time
import warnings
from collections.abc import Callable, Generator
from dataclasses import dataclass
from importlib.util import find_spec
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.code_store.folder import TEMPORARY, UntrustedFile, code_folder, prepare, read_own, write_whole
from mafsil.messages import say

LIMIT_VARIABLE = "MAFSIL_CACHE_LIMIT"
"""Environment variable with the size in MiB above which the entries unused for longest are removed."""
LIMIT_MIB = 1024
VERSION = 1
HAS_LOCKS = find_spec("fcntl") is not None
"""Whether the system has locks on files that die with their holder; without, several processes may do the same work."""
_HEADER = struct.Struct("<8sI32sQ32s")
_LOCK = ".lock"
_ORPHAN_AGE = 3600.0
_SWEEP_EVERY = 600.0
_STAMP_AGE = 86400.0
_LARGEST = 1 << 30
_SUFFIXES = (".kernel", ".tape", ".sources", ".loop", ".bundle", ".arrays")
"""Of all kinds of entries: together they share the bound on size."""


class CacheWarning(UserWarning):
    """The cache of compiled code is damaged or cannot be used; results are right, starting takes longer."""


@dataclass(frozen=True)
class StoreKind:
    """What lies in a file.

    Attributes:
        magic: 8 bytes that its files begin with.
        suffix: how their names end, one of the known ones.
    """

    magic: bytes
    suffix: str

    def seal(self, key: bytes, payload: bytes) -> bytes:
        """The bytes of a file: the payload under its header.

        Args:
            key: 32 bytes.
            payload: what to keep.
        """
        header = _HEADER.pack(self.magic, VERSION, key, len(payload), self._digest(key, payload))
        return header + payload

    def unseal(self, key: bytes, data: bytes) -> bytes | None:
        """The payload of a file, or None if a single bit of it is not as it was written for this key."""
        if len(data) < _HEADER.size:
            return None
        magic, version, named, length, digest = _HEADER.unpack_from(data)
        payload = data[_HEADER.size :]
        if magic != self.magic or version != VERSION or named != key or length != len(payload):
            return None
        return payload if digest == self._digest(key, payload) else None

    def _digest(self, key: bytes, payload: bytes) -> bytes:
        person = self.magic + struct.pack("<Q", VERSION)
        return hashlib.blake2b(payload, digest_size=32, key=key, person=person).digest()


class FileStore:
    """The entries of one kind in a directory.

    Args:
        directory: created when missing; None keeps nothing.
        kind: of the entries.
    """

    def __init__(self, directory: Path | None, kind: StoreKind) -> None:
        self.directory = directory
        self.kind = kind
        self._ready: bool | None = None if directory else False

    def get(self, key: str) -> bytes | None:
        """The payload of this key, verified; None if there is none, or a damaged one, which is removed with a warning.

        Args:
            key: 64 hexadecimal digits.
        """
        path = self._path(key)
        if path is None:
            return None
        try:
            data = read_own(path, _LARGEST)
        except UntrustedFile:
            data = b""
        if data is None:
            return None
        payload = self.kind.unseal(bytes.fromhex(key), data)
        if payload is None:
            self.discard(key)
            warn("cache.damaged", path=str(path))
        else:
            _stamp(path)
        return payload

    def put(self, key: str, payload: bytes) -> bool:
        """Keep a payload; where the disk refuses, one warning, and False."""
        path = self._path(key)
        if path is None:
            return False
        try:
            write_whole(path, self.kind.seal(bytes.fromhex(key), payload))
        except OSError as error:
            warn("cache.unwritable", path=str(self.directory), reason=error.strerror or str(error))
            return False
        self._sweep_now_and_then()
        return True

    def discard(self, key: str) -> None:
        """Forget an entry."""
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
        path = self._path(key) if HAS_LOCKS else None
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
        lock = self.directory / f"sweep{_LOCK}"
        handle = _lock(lock, 0.0) if HAS_LOCKS else None
        if handle is None and HAS_LOCKS:
            return 0
        try:
            return _remove_old(self.directory, _limit() if limit is None else limit, now or time.time())
        except OSError:
            return 0
        finally:
            with contextlib.suppress(OSError):
                lock.touch(0o600)
            if handle is not None:
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
        return self.directory / (key + self.kind.suffix) if self.directory is not None and self._usable() else None

    def _usable(self) -> bool:
        if self._ready is None and self.directory is not None:
            reason = prepare(self.directory)
            self._ready = not reason
            if reason:
                warn("cache.unusable", path=str(self.directory), reason=reason)
        return bool(self._ready)


def _stamp(path: Path) -> None:
    """Note the day of use, for what is unused for longest goes first."""
    with contextlib.suppress(OSError):
        if time.time() - path.stat().st_mtime > _STAMP_AGE:
            os.utime(path)


def _lock(path: Path, patience: float) -> int | None:
    """An exclusive lock on a file, held while the returned descriptor is open; None when not had in time."""
    import fcntl

    try:
        handle = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o600)
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
            if file.name.endswith(_SUFFIXES):
                kept.append((found.st_mtime, found.st_size, file.path))
            elif file.name.endswith((TEMPORARY, _LOCK)) and now - found.st_mtime > _ORPHAN_AGE:
                removed += _unlink(file.path)
    total = sum(size for _, size, _ in kept)
    for _, size, path in sorted(kept):
        if total <= limit:
            break
        total -= size
        removed += _unlink(path)
    return removed


def _unlink(path: str) -> bool:
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


_warned: set[str] = set()


def warn(key: str, **details: str) -> None:
    """Say it once in a process."""
    if key not in _warned:
        _warned.add(key)
        warnings.warn(say(key, **details), CacheWarning, stacklevel=2)


ARRAYS = StoreKind(b"mafsilN\0", ".arrays")


def digest_of(*parts: str | bytes | NDArray[Any]) -> str:
    """64 hexadecimal digits that differ when any of the parts does: texts, bytes, arrays with their shapes."""
    hashed = hashlib.blake2b(digest_size=32)
    for part in parts:
        kind = f"{part.dtype} {part.shape}" if isinstance(part, np.ndarray) else type(part).__name__
        data = part.encode() if isinstance(part, str) else part if isinstance(part, bytes) else part.tobytes()
        hashed.update(f"{kind} {len(data)}\n".encode() + data)
    return hashed.hexdigest()


def kept_array(key: str, compute: Callable[[], NDArray[np.float64]]) -> NDArray[np.float64]:
    """The array of a key: as it was kept, else computed and kept.

    Args:
        key: `digest_of` all that it follows from, the code that computes it among them.
        compute: makes it.
    """
    store = FileStore(code_folder(), ARRAYS)
    data = store.get(key)
    if data is None:
        array = np.ascontiguousarray(compute(), np.float64)
        store.put(key, np.array([array.ndim, *array.shape], "<i8").tobytes() + array.astype("<f8").tobytes())
        return array
    dimensions = int.from_bytes(data[:8], "little")
    shape = np.frombuffer(data, "<i8", dimensions, 8).tolist()
    return np.frombuffer(data, "<f8", prod(shape), 8 * (1 + dimensions)).reshape(shape).astype(np.float64)
