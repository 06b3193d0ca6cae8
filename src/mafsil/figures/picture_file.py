"""Where a picture is written: a path or its text, with an ending that says the kind of picture."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import cast

from mafsil.errors import InputError

ENDINGS = (".png", ".svg", ".pdf")


def picture_file(path: str | PathLike[str], endings: tuple[str, ...] = ENDINGS) -> Path:
    """The path of a picture.

    Args:
        path: as the user gave it.
        endings: that can be written.

    Raises:
        InputError: no path, or an ending of no picture.
    """
    if not isinstance(cast(object, path), str | PathLike):
        raise InputError("input.kind", name="path", expected="str / pathlib.Path", got=type(path).__name__)
    file = Path(path)
    if file.suffix.lower() not in endings:
        raise InputError("pictures.ending", path=str(path), known=", ".join(endings))
    return file
