"""`-` in the place of a file: what standard input holds, kept as a file as long as a command runs."""

from __future__ import annotations

import re
import sys
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from mafsil.cli.operation import Operation
from mafsil.errors import FileError

STANDARD_INPUT = "-"
LARGEST = 200_000_000
"""Bytes; the readers behind it have narrower limits of their own."""
_ROOTS = {b"mujoco": ".xml", b"sdf": ".sdf"}
_ROOT = re.compile(rb"<\s*([a-z]\w*)", re.IGNORECASE)
_PROLOGUE = re.compile(rb"<\?.*?\?>|<!--.*?-->|<!.*?>", re.DOTALL)


@contextmanager
def as_files(operation: Operation, given: dict[str, Any]) -> Generator[dict[str, Any], None, None]:
    """The arguments with a file in the place of `-`.

    Args:
        operation: that is called.
        given: its arguments by name.

    Raises:
        FileError: nothing comes, or too much, or two arguments ask for it.
    """
    asking = [one.name for one in operation.parameters if one.reads and given.get(one.name) == STANDARD_INPUT]
    if not asking:
        yield given
        return
    if len(asking) > 1:
        raise FileError("cli.stdin_twice", names=", ".join(asking))
    data = sys.stdin.buffer.read(LARGEST + 1)
    if not data.strip() or len(data) > LARGEST:
        raise FileError("cli.stdin_empty" if not data.strip() else "cli.stdin_large", limit=LARGEST)
    with TemporaryDirectory(prefix="mafsil-") as folder:
        path = Path(folder) / f"stdin{_ending(operation, asking[0], data)}"
        path.write_bytes(data)
        yield {**given, asking[0]: str(path)}


def _ending(operation: Operation, name: str, data: bytes) -> str:
    """The ending that tells a reader what the data are: by their first element or sign, else the argument's own."""
    start = _PROLOGUE.sub(b"", data[:100_000]).lstrip(b"\xef\xbb\xbf \t\r\n")
    if start.startswith(b"<"):
        root = _ROOT.match(start)
        return _ROOTS.get(root.group(1).lower() if root else b"", ".urdf")
    if start.startswith(b"{"):
        return ".json"
    endings = next(one.endings for one in operation.parameters if one.name == name)
    return endings[0] if endings else ".toml"
