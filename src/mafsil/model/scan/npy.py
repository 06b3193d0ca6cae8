"""Arrays of numbers in NumPy's format; the header is held against the bytes before anything is made of it."""

from __future__ import annotations

import io
import math
import tokenize
from typing import cast

import numpy as np
from numpy.lib import format as numpy_format

from mafsil.arrays import Floats
from mafsil.errors import FileError

KINDS = "fiu"
"""Kinds of numbers that are read: floating point, whole."""

_HEADERS = {(1, 0): numpy_format.read_array_header_1_0, (2, 0): numpy_format.read_array_header_2_0}
"""By the version of the format."""


def read_npy(data: bytes) -> Floats:
    """The array of an .npy file as float64.

    Raises:
        FileError: another format, no plain numbers, fewer bytes than the header says.
    """
    stream = io.BytesIO(data)
    try:
        header = _HEADERS[numpy_format.read_magic(stream)]
        shape, by_columns, kind = header(stream)
    except (ValueError, KeyError, TypeError, OverflowError, RecursionError, SyntaxError, tokenize.TokenError) as fault:
        raise FileError("scan.npy", fault=" ".join(str(fault).split())[:120]) from None
    if kind.kind not in KINDS or kind.hasobject:
        raise FileError("scan.numbers", got=str(kind))
    count, begin = math.prod(shape), stream.tell()
    if min(shape, default=0) < 0 or count * kind.itemsize > len(data) - begin:
        raise FileError("scan.cut", declared=count, found=(len(data) - begin) // max(kind.itemsize, 1))
    flat = np.frombuffer(data, kind, count, begin).astype(np.float64)
    return cast("Floats", flat.reshape(shape, order="F" if by_columns else "C"))
