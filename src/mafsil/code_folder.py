"""The directory of compiled code on this machine: which it is, that it is ours alone, and how its files are written."""

from __future__ import annotations

import contextlib
import os
import stat
from pathlib import Path

from mafsil.messages import say

CACHE_VARIABLE = "MAFSIL_CACHE"
"""Environment variable: `off` keeps compiled code in memory only, anything else is the directory to use."""
TEMPORARY = ".tmp"
"""How the names of files end that are being written."""


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
    """Make the directory and see that it is ours alone; otherwise the reason why it cannot be used."""
    try:
        directory.mkdir(mode=0o700, parents=True, exist_ok=True)
        found = directory.stat()
        if hasattr(os, "geteuid"):
            if found.st_uid != os.geteuid():
                return say("cache.foreign")
            if stat.S_IMODE(found.st_mode) & 0o077:
                directory.chmod(0o700)
        return ""
    except OSError as error:
        return error.strerror or str(error)


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
