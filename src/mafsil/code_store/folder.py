"""The directory of compiled code on this machine, and what is being compiled.

Which directory it is, and that only we can have written there; for whoever watches, the logger `mafsil.compiling` gets
one record as each piece begins.
"""

from __future__ import annotations

import contextlib
import errno
import itertools
import logging
import os
import stat
import time
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

from mafsil.messages import say

LOGGER = "mafsil.compiling"
"""Its records have the level DEBUG: a program that uses the package stays silent; the command line shows the latest."""
_number = itertools.count(1).__next__
_seconds: list[float] = []
CACHE_VARIABLE = "MAFSIL_CACHE"
"""Environment variable: `off` keeps compiled code in memory only, anything else is the directory to use."""
TEMPORARY = ".tmp"
"""How the names of files end that are being written."""
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


class UntrustedFile(Exception):
    """A file in the place of an entry that somebody else may have written."""


def is_off() -> bool:
    """Whether the user wants no directory."""
    return os.environ.get(CACHE_VARIABLE, "").lower() == "off"


def code_folder() -> Path | None:
    """The directory that MAFSIL_CACHE names, or the user's cache directory; None: off, or no home is known."""
    named, xdg = os.environ.get(CACHE_VARIABLE, ""), os.environ.get("XDG_CACHE_HOME", "")
    if is_off():
        return None
    if named:
        return Path(named).absolute()
    if xdg and os.path.isabs(xdg):
        return Path(xdg) / "mafsil"
    home = os.path.expanduser("~")
    return Path(home) / ".cache" / "mafsil" if os.path.isabs(home) else None


def prepare(directory: Path) -> str:
    """Make the directory, or see that nobody else can write to the one that is there; otherwise why it is not used.

    It will hold machine code that we run, so a link, another owner, or a mode that lets others write into it is
    refused. What was there before is never changed.
    """
    with contextlib.suppress(FileExistsError):
        try:
            directory.mkdir(mode=0o700, parents=True)
        except FileExistsError:
            raise
        except OSError as error:
            return error.strerror or str(error)
    try:
        return _distrust(directory.lstat()) or _distrust_of_parents(directory)
    except OSError as error:
        return error.strerror or str(error)


def _distrust(found: os.stat_result) -> str:
    """Why a directory is not ours alone; empty if it is."""
    if stat.S_ISLNK(found.st_mode):
        return say("cache.link")
    if not stat.S_ISDIR(found.st_mode):
        return os.strerror(errno.ENOTDIR)
    if hasattr(os, "geteuid"):
        if found.st_uid != os.geteuid():
            return say("cache.foreign")
        if found.st_mode & _OTHERS_WRITE:
            return say("cache.open", mode=f"{stat.S_IMODE(found.st_mode):o}")
    return ""


def _distrust_of_parents(directory: Path) -> str:
    """Whoever may write to a parent could put another directory in the place of ours, unless its sticky bit is set."""
    if hasattr(os, "geteuid"):
        for parent in directory.resolve().parents:
            mode = parent.stat().st_mode
            if mode & stat.S_IWOTH and not mode & stat.S_ISVTX:
                return say("cache.open_parent", path=str(parent), mode=f"{stat.S_IMODE(mode):o}")
    return ""


def read_own(path: Path, largest: int) -> bytes | None:
    """The contents of a file that only we can have written; None if there is none that we may read.

    Args:
        path: of the file; neither a link is followed nor a pipe waited for.
        largest: size above which it is not read [bytes].

    Raises:
        UntrustedFile: it is no regular file, not ours, writable by others, or larger than that.
    """
    flags = os.O_RDONLY | sum(getattr(os, name, 0) for name in ("O_NOFOLLOW", "O_NONBLOCK", "O_CLOEXEC", "O_BINARY"))
    try:
        handle = os.open(path, flags)
    except (FileNotFoundError, PermissionError):
        return None
    except OSError as error:
        raise UntrustedFile from error
    try:
        found = os.fstat(handle)
        ours = not hasattr(os, "geteuid") or (found.st_uid == os.geteuid() and not found.st_mode & _OTHERS_WRITE)
        if not stat.S_ISREG(found.st_mode) or not ours or found.st_size > largest:
            raise UntrustedFile
        with open(handle, "rb", closefd=False) as file:
            return file.read()
    finally:
        os.close(handle)


def write_whole(path: Path, data: bytes) -> None:
    """All of it or nothing, also when killed or without power.

    Args:
        path: file in a directory that exists; replaced if it is there.
        data: its contents.
    """
    temporary = path.with_name(f"{path.stem[:16]}-{os.getpid()}-{os.urandom(6).hex()}{TEMPORARY}")
    handle = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), 0o600)
    try:
        with open(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except OSError:
        with contextlib.suppress(OSError):
            os.unlink(temporary)
        raise


@contextmanager
def compilation(name: str) -> Generator[None, None, None]:
    """Announce what is compiled while this lasts: its name, how many pieces it makes with it, the seconds so far.

    Args:
        name: for people: a quantity, a module of loops.
    """
    logger, number, began = logging.getLogger(LOGGER), _number(), time.monotonic()
    if logger.isEnabledFor(logging.DEBUG):
        logger.debug(say("cache.compiling", name=name, number=number, seconds=f"{sum(_seconds):.0f}"))
    try:
        yield
    finally:
        _seconds.append(time.monotonic() - began)
