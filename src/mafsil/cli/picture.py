"""Pictures that commands write: kinds of files, and one sentence where a place refuses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from mafsil.errors import FileError, InputError

PLAIN = (".png", ".svg", ".pdf")


def require_kind(path: str, known: Sequence[str]) -> None:
    """Refuse a file of another kind before anything is computed.

    Args:
        path: of the picture.
        known: endings, with their points.

    Raises:
        InputError: another ending; the sentence lists those that are known.
    """
    if Path(path).suffix.lower() not in known:
        raise InputError("cli.picture_kind", path=path, known=", ".join(known))


def drawn(draw: Callable[[Path], None], path: str) -> None:
    """Draw into a file.

    Args:
        draw: writes the picture into a file.
        path: of that file.

    Raises:
        FileError: the place cannot be written.
    """
    try:
        draw(Path(path))
    except OSError as error:
        raise FileError("file.cannot_write", path=path, reason=error.strerror or str(error)) from None
