"""Files that are whole or not there: written beside their place, synced, renamed."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO

from mafsil.errors import FileError
from mafsil.messages.visible import visible
from mafsil.regular_file import reason


def write_whole(path: Path, contents: bytes | Callable[[BinaryIO], object]) -> None:
    """Write a file so that its name never stands for half of it, whatever happens meanwhile.

    Args:
        path: in a directory that exists; replaced if it is there.
        contents: the bytes, or what writes them into an open file.

    Raises:
        FileError: the place cannot be written, or the disk is full.
    """
    beside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with beside.open("wb") as file:
            if callable(contents):
                contents(file)
            else:
                file.write(contents)
            file.flush()
            os.fsync(file.fileno())
        beside.replace(path)
    except (OSError, ValueError) as fault:
        raise FileError("file.cannot_write", path=visible(str(path)), reason=reason(fault)) from None
    finally:
        with suppress(OSError, ValueError):
            beside.unlink(missing_ok=True)
