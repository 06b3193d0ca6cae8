"""Grey pictures in PNG files, 8 or 16 bits: what height maps are kept in."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.errors import FileError

SIGNATURE = b"\x89PNG\r\n\x1a\n"
CHANNELS = {0: 1, 4: 2}
"""Kinds of colour that are read -> channels: grey, and grey with opacity, which is passed over."""
UP, AVERAGE, PAETH = 2, 3, 4
"""Predictions of a row from the row above it."""


def read_png(data: bytes, most: int) -> Floats:
    """(rows, columns) of a grey picture, black 0, white 1; the first row is the top one.

    1. The header; too many points are refused before anything is unpacked.
    2. The packed rows, each with how it was predicted.
    3. Each row from its prediction.

    Args:
        data: the file.
        most: points of the picture.

    Raises:
        FileError: another format, colours, too many points, a cut or damaged file.
    """
    # 1
    chunks = list(_chunks(data))
    if not chunks or chunks[0][0] != b"IHDR" or len(chunks[0][1]) != 13:
        raise FileError("scan.png", fault="IHDR")
    width, height, depth, colour, _, _, interlaced = struct.unpack(">IIBBBBB", chunks[0][1])
    if depth not in (8, 16) or colour not in CHANNELS or interlaced:
        raise FileError("scan.grey")
    if width * height > most:
        raise FileError("scan.too_many", found=width * height, limit=most)
    # 2
    step = CHANNELS[colour] * depth // 8
    length = width * step
    unpacker = zlib.decompressobj()
    try:
        raw = unpacker.decompress(b"".join(body for name, body in chunks if name == b"IDAT"), height * (length + 1))
    except zlib.error:
        raise FileError("scan.png", fault="IDAT") from None
    if len(raw) != height * (length + 1):
        raise FileError("scan.png", fault="IDAT")
    lines = np.frombuffer(raw, np.uint8).reshape(height, length + 1)
    # 3
    above = np.zeros(length, np.uint8)
    rows = np.empty((height, length), np.uint8)
    for k in range(height):
        above = rows[k] = _row(int(lines[k, 0]), lines[k, 1:], above, step)
    values = rows.reshape(height, width, step)[:, :, : depth // 8].astype(np.float64)
    grey = values[..., 0] if depth == 8 else values[..., 0] * 256.0 + values[..., 1]
    return grey / (2**depth - 1)


def _chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Name and contents of each part, up to the last."""
    if not data.startswith(SIGNATURE):
        raise FileError("scan.png", fault="PNG")
    place = len(SIGNATURE)
    while place + 12 <= len(data):
        length = int.from_bytes(data[place : place + 4], "big")
        name, body = data[place + 4 : place + 8], data[place + 8 : place + 8 + length]
        check = data[place + 8 + length : place + 12 + length]
        if len(body) < length or len(check) < 4 or zlib.crc32(name + body) != int.from_bytes(check, "big"):
            raise FileError("scan.png", fault=name.decode("ascii", "replace"))
        yield name, body
        if name == b"IEND":
            return
        place += 12 + length
    raise FileError("scan.png", fault="IEND")


def _row(kind: int, coded: NDArray[np.uint8], above: NDArray[np.uint8], step: int) -> NDArray[np.uint8]:
    """A row from its differences to a prediction; `step` bytes belong to a point."""
    if kind == 0:
        return coded
    if kind == 1:
        return np.cumsum(coded.reshape(-1, step), axis=0, dtype=np.uint8).ravel()
    if kind == UP:
        return coded + above
    if kind not in (AVERAGE, PAETH):
        raise FileError("scan.png", fault=f"filter {kind}")
    row, over = [0] * step + coded.tolist(), [0] * step + above.tolist()
    for k in range(step, len(row)):
        left, up = row[k - step], over[k]
        guess = (left + up) // 2 if kind == AVERAGE else _nearest(left, up, over[k - step])
        row[k] = (row[k] + guess) & 255
    return np.array(row[step:], np.uint8)


def _nearest(left: int, up: int, corner: int) -> int:
    """Of the three neighbours the one nearest to left + up - corner; Paeth's prediction."""
    guess = left + up - corner
    return min((left, up, corner), key=lambda value: abs(guess - value))
