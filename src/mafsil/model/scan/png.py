"""Grey pictures in PNG files: what height maps are kept in. Pillow unpacks them."""

from __future__ import annotations

import io
import struct
import zlib
from importlib.util import find_spec

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import FileError

WHITE = {"L": 255.0, "LA": 255.0, "I;16": 65535.0}
"""Kinds of picture that are read -> the number of white: grey of 8 bits, with opacity, which is passed over, of 16."""

_FAULTS = (OSError, SyntaxError, ValueError, IndexError, KeyError, TypeError, EOFError, struct.error, zlib.error)
"""What Pillow raises at pictures that are damaged, or have no picture in them."""


def read_png(data: bytes, most: int) -> Floats:
    """(rows, columns) of a grey picture, black 0, white 1; the first row is the top one.

    Args:
        data: the file.
        most: points of the picture; one with more is refused before anything is unpacked.

    Raises:
        FileError: another format, colours, too many points, a cut or damaged file, no Pillow to read it with.
    """
    if find_spec("PIL") is None:
        raise FileError("scan.no_pillow")
    from PIL import Image

    try:
        with Image.open(io.BytesIO(data), formats=["PNG"]) as picture:
            kind, size = picture.mode, picture.width * picture.height
            picture.verify()  # Down to the last sum of what the file says of itself; after it nothing can be read.
    except (*_FAULTS, Image.DecompressionBombError) as fault:
        raise _damaged(fault) from None
    if kind not in WHITE:
        raise FileError("scan.grey")
    if size > most:
        raise FileError("scan.too_many", found=size, limit=most)
    try:
        with Image.open(io.BytesIO(data), formats=["PNG"]) as picture:
            values = np.asarray(picture, dtype=np.float64)
    except _FAULTS as fault:
        raise _damaged(fault) from None
    return (values if values.ndim == 2 else values[..., 0]) / WHITE[kind]


def _damaged(fault: Exception) -> FileError:
    words = str(fault).partition("<")[0]  # Pillow names the stream, which nobody knows.
    return FileError("scan.png", fault=" ".join(words.split())[:120])
