"""Identified robots in files: what the format can hold, and a sentence for what it cannot."""

from __future__ import annotations

from pathlib import Path

from mafsil.errors import ModelError
from mafsil.identification.remark import Remark
from mafsil.model import Mechanism, table, urdf
from mafsil.whole_file import write_whole


def save(mechanism: Mechanism, path: Path) -> tuple[Remark, ...]:
    """Write a .toml table or a .urdf file and say what the latter could not keep.

    Args:
        mechanism: what to write.
        path: an existing file is replaced.

    Raises:
        FileError: the place cannot be written.
        ModelError: a mechanism that the format cannot hold.
    """
    if path.suffix.lower() == ".toml":
        table.write(mechanism, path)
        return ()
    text, lost = _urdf(mechanism)
    write_whole(path, text.encode())
    return tuple(Remark(f"identification.lost_{what}", {"path": path.name, "name": name}) for what, name in lost)


def _urdf(mechanism: Mechanism) -> tuple[str, list[tuple[str, str]]]:
    """The text, and what was left out with the name of the first part that has it."""
    lost: list[tuple[str, str]] = []
    while True:
        try:
            return urdf.write(mechanism, without=[what for what, _ in lost]), lost
        except ModelError as refusal:
            if refusal.key != "urdf.cannot_keep_by_choice":
                raise
            lost.append((str(refusal.details["what"]), str(refusal.details["name"])))
