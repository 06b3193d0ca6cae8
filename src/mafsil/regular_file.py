"""The one opener of files to be read: regular files, at once, within a size; pipes and devices are refused unread."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Generator, Iterable
from contextlib import contextmanager, suppress
from io import TextIOWrapper
from pathlib import Path
from time import time_ns
from typing import BinaryIO, NamedTuple

from mafsil.messages import say


@contextmanager
def open_regular(path: str | os.PathLike[str], most: float = float("inf")) -> Generator[BinaryIO]:
    """A regular file, open for reading bytes.

    Args:
        path: of the file.
        most: bytes beyond which it is refused.

    Raises:
        OSError, ValueError: it cannot be opened, is no regular file, or is too large; the reason is in its `strerror`.
    """
    with open(path, "rb", opener=_without_waiting) as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode):
            raise OSError(errno.EINVAL, say("file.not_regular"))
        if status.st_size > most:
            raise OSError(errno.EFBIG, say("file.too_large", size=status.st_size, limit=int(most)))
        yield file


def regular_bytes(path: str | os.PathLike[str], most: int) -> bytes:
    """The first bytes of a regular file.

    Args:
        path: of the file.
        most: how many bytes are read.

    Raises:
        OSError, ValueError: it cannot be opened, or is no regular file.
    """
    with open_regular(path) as file:
        return file.read(most)


def whole_bytes(path: str | os.PathLike[str], most: int) -> bytes:
    """All bytes of a regular file.

    Args:
        path: of the file.
        most: bytes beyond which it is refused.

    Raises:
        OSError, ValueError: as `open_regular`.
    """
    with open_regular(path, most) as file:
        return file.read(most)


def whole_text(path: str | os.PathLike[str], most: int, encoding: str = "utf-8") -> str:
    """The text of a regular file, with plain line ends.

    Args:
        path, most: as `whole_bytes`.
        encoding: of the text.

    Raises:
        OSError, ValueError: as `open_regular`; bytes that are no text in the encoding.
    """
    with open_regular(path, most) as file:
        return TextIOWrapper(file, encoding=encoding).read()


def is_file(path: Path) -> bool:
    """Whether a file stands there; no name that no file can have (too long, with a null byte) stands anywhere."""
    with suppress(OSError, ValueError):
        return path.is_file()
    return False


def is_folder(path: Path) -> bool:
    """Whether a folder stands there; names as for `is_file`."""
    with suppress(OSError, ValueError):
        return path.is_dir()
    return False


def whole_path(path: Path) -> Path:
    """The absolute path without links; a name that no file can have as it is, for the reader to refuse."""
    with suppress(OSError, ValueError):
        return path.resolve()
    return path


def reason(fault: Exception) -> str:
    """Why a file was not read, in words."""
    if isinstance(fault, UnicodeDecodeError):
        return say("file.no_text", encoding=fault.encoding, place=fault.start)
    return getattr(fault, "strerror", None) or str(fault)


def _without_waiting(path: str, flags: int) -> int:
    """Opens pipes too, at once, so that they can be distinguished from files."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


SETTLED = 2.0
"""Seconds since the last change of a file after which another change has another time, on every file system."""


class FileStamps(NamedTuple):
    """Files as they were when something was read from them.

    Attributes:
        paths: of the files.
        stamps: of each its place on the disk, size and times of change; None if it was not there.
        settled: whether another change would show: the last one was long enough before.
    """

    paths: tuple[Path, ...]
    stamps: tuple[tuple[int, ...] | None, ...]
    settled: bool

    @classmethod
    def of(cls, paths: Iterable[Path]) -> FileStamps:
        """The files as they are; to be asked before they are read."""
        given = tuple(paths)
        stamps = tuple(map(_stamp, given))
        newest = max((max(stamp[-2:]) for stamp in stamps if stamp is not None), default=0)
        return cls(given, stamps, newest < time_ns() - int(SETTLED * 1e9))

    def has_changed(self) -> bool:
        """Whether a file is another one by now."""
        return any(_stamp(path) != stamp for path, stamp in zip(self.paths, self.stamps, strict=True))


def _stamp(path: Path) -> tuple[int, ...] | None:
    try:
        status = os.stat(path)
    except (OSError, ValueError):
        return None
    return status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns
