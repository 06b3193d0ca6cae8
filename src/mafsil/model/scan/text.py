"""Rows of numbers in text files: separated by blanks, commas, semicolons or tabs."""

from __future__ import annotations

import io
from array import array

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import FileError

SEPARATORS = b",;"
COMMENTS = (b"#", b"//")


def read_rows(data: bytes, most: int) -> Floats:
    """(k, c) numbers, one row each line; empty lines, comments and one line of names at the top are passed over.

    Args:
        data: the file.
        most: numbers that are read.

    Raises:
        FileError: rows of different lengths, a word that is no number, too many numbers.
    """
    numbers, width, named = array("d"), 0, False
    for number, line in enumerate(io.BytesIO(data.removeprefix(b"\xef\xbb\xbf")), 1):
        words = line.translate(bytes.maketrans(SEPARATORS, b"  ")).split()
        if not words or words[0].startswith(COMMENTS):
            continue
        try:
            row = [float(word) for word in words]
        except ValueError:
            if width or named:
                raise FileError("scan.line", line=number) from None
            named = True
            continue
        if width and len(row) != width:
            raise FileError("scan.width", line=number, got=len(row), expected=width)
        width = len(row)
        numbers.extend(row)
        if len(numbers) > most:
            raise FileError("scan.too_many", found=len(numbers), limit=most)
    return np.array(numbers, np.float64).reshape(-1, max(width, 1))
