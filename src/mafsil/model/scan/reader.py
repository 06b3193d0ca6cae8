"""Chooses the reader by the file's name; every refusal is a FileError with the reason.

Arrays of numbers in NumPy's format; the header is held against the bytes before anything is made of it.

Grey pictures in PNG files: what height maps are kept in. Pillow unpacks them.

Rows of numbers in text files: separated by blanks, commas, semicolons or tabs.

Points of PLY files, as text or binary; faces and colours are passed over.
"""

from __future__ import annotations

import io
import math
import struct
import tokenize
import zlib
from array import array
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from typing import cast

import numpy as np
from numpy.lib import format as numpy_format

from mafsil.arrays import Floats
from mafsil.errors import FileError
from mafsil.model.diagnostics import shown
from mafsil.model.mesh.reader import read_by

TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
LONGEST_HEADER = 1 << 16
AXES = ("x", "y", "z")
SEPARATORS = b",;"
COMMENTS = (b"#", b"//")
WHITE = {"L": 255.0, "LA": 255.0, "I;16": 65535.0}
"""Kinds of picture that are read -> the number of white: grey of 8 bits, with opacity, which is passed over, of 16."""
_FAULTS = (OSError, SyntaxError, ValueError, IndexError, KeyError, TypeError, EOFError, struct.error, zlib.error)
"""What Pillow raises at pictures that are damaged, or have no picture in them."""
KINDS = "fiu"
"""Kinds of numbers that are read: floating point, whole."""
_HEADERS = {(1, 0): numpy_format.read_array_header_1_0, (2, 0): numpy_format.read_array_header_2_0}
"""By the version of the format."""


@dataclass(frozen=True, slots=True)
class ScanLimits:
    """Sizes beyond which a file is refused: its bytes, points of a cloud, points of a grid of heights."""

    bytes: int = 128 << 20
    points: int = 1_000_000
    heights: int = 500_000


DEFAULT_LIMITS = ScanLimits()


def read_points(path: str | Path, *, limits: ScanLimits = DEFAULT_LIMITS) -> Floats:
    """(k, 3) points of a file, in its unit.

    Args:
        path: of an .npy array (k, 3) or more columns, a .ply file, or text (.xyz, .txt, .csv) with x, y, z first on
            each line; the name's end says which.
        limits: sizes beyond which the file is refused.

    Raises:
        FileError: no such file, another format, too large, damaged, a point that is not finite.
    """
    readers: dict[str, Callable[[bytes], Floats]] = {
        ".npy": read_npy,
        ".ply": lambda data: read_ply(data, limits.points),
        **dict.fromkeys((".xyz", ".txt", ".csv"), lambda data: read_rows(data, 12 * limits.points)),
    }
    points = read_by(readers, path, limits.bytes, "scan.format")
    if points.ndim == 3:
        # The picture of a depth camera: rows and columns of points.
        points = points.reshape(-1, points.shape[2])
    if points.ndim != 2 or points.shape[1] < 3 or not len(points):
        raise FileError("scan.points", path=shown(str(path)), got=points.shape)
    if len(points) > limits.points:
        raise FileError("scan.too_many", path=shown(str(path)), found=len(points), limit=limits.points)
    return _finite(path, points[:, :3])


def read_heights(path: str | Path, *, limits: ScanLimits = DEFAULT_LIMITS) -> Floats:
    """(rows, columns) heights of a file on a regular grid, in its unit; the first row is the one of smallest y.

    Args:
        path: of an .npy array (rows, columns), text (.csv, .txt) with one row each line, or a grey .png picture, black
            0 and white 1, whose top row is the one of largest y; the name's end says which.
        limits: sizes beyond which the file is refused.

    Raises:
        FileError: no such file, another format, too large, damaged, a height that is not finite.
    """
    readers: dict[str, Callable[[bytes], Floats]] = {
        ".npy": read_npy,
        ".png": lambda data: read_png(data, limits.heights)[::-1],
        **dict.fromkeys((".csv", ".txt"), lambda data: read_rows(data, limits.heights)),
    }
    heights = read_by(readers, path, limits.bytes, "scan.format")
    if heights.ndim != 2 or min(heights.shape) < 2:
        raise FileError("scan.heights", path=shown(str(path)), got=heights.shape)
    if heights.size > limits.heights:
        raise FileError("scan.too_many", path=shown(str(path)), found=heights.size, limit=limits.heights)
    return _finite(path, heights)


def _finite(path: str | Path, values: Floats) -> Floats:
    """The values themselves, all finite: what a sensor did not see is not known to be free."""
    bad = int((~np.isfinite(values)).sum())
    if bad:
        raise FileError("scan.not_finite", path=shown(str(path)), count=bad)
    return np.ascontiguousarray(values)


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


@dataclass(slots=True)
class _Element:
    """A table of the file.

    Attributes:
        name, count: of its rows.
        columns: name and type of each property.
        lists: whether a property has a length of its own in each row.
    """

    name: str
    count: int
    columns: list[tuple[str, str]] = field(default_factory=list[tuple[str, str]])
    lists: bool = False


def read_ply(data: bytes, most: int) -> Floats:
    """(k, 3) vertices of a PLY file.

    1. The header.
    2. Tables before that of the vertices are passed over.
    3. The columns x, y, z.

    Args:
        data: the file.
        most: points that are read.

    Raises:
        FileError: another format, no vertices with x, y and z, too many, fewer than the header says.
    """
    # 1
    order, elements, begin = _header(data)
    before: list[_Element] = []
    vertices = None
    for element in elements:
        if element.name == "vertex":
            vertices = element
            break
        before.append(element)
    if vertices is None or vertices.lists or any(each.lists for each in before):
        raise FileError("scan.ply", fault="vertex x y z")
    names = [name for name, _ in vertices.columns]
    if any(axis not in names for axis in AXES) or len(set(names)) < len(names):
        raise FileError("scan.ply", fault="vertex x y z")
    if vertices.count > most:
        raise FileError("scan.too_many", found=vertices.count, limit=most)
    # 2, 3
    if not order:
        lines = islice(io.BytesIO(data[begin:]), sum(each.count for each in before), None)
        return _text_rows(lines, vertices.count, [names.index(axis) for axis in AXES])
    begin += sum(each.count * sum(np.dtype(kind).itemsize for _, kind in each.columns) for each in before)
    row = _row(vertices, order)
    if vertices.count * row.itemsize > len(data) - begin:
        raise FileError("scan.cut", declared=vertices.count, found=max(len(data) - begin, 0) // row.itemsize)
    table = np.frombuffer(data, row, vertices.count, begin)
    return np.stack([table[axis].astype(np.float64) for axis in AXES], axis=1)


def _header(data: bytes) -> tuple[str, list[_Element], int]:
    """Order of bytes, tables, and where the numbers begin."""
    end = data.find(b"end_header", 0, LONGEST_HEADER)
    begin = data.find(b"\n", max(end, 0)) + 1
    if not data.startswith(b"ply") or end < 0 or begin == 0:
        raise FileError("scan.ply", fault="end_header")
    order, elements = None, list[_Element]()
    for line in data[:end].decode("ascii", "replace").splitlines():
        match line.split():
            case ["format", kind, *_] if kind in ORDERS:
                order = ORDERS[kind]
            case ["element", name, count] if count.isdecimal():
                elements.append(_Element(name, int(count)))
            case ["property", "list", *_] if elements:
                elements[-1].lists = True
            case ["property", kind, name] if elements and kind in TYPES:
                elements[-1].columns.append((name, TYPES[kind]))
            case ["ply"] | ["comment", *_] | ["obj_info", *_] | []:
                pass
            case _:
                raise FileError("scan.ply", fault=" ".join(line.split())[:80])
    if order is None:
        raise FileError("scan.ply", fault="format")
    return order, elements, begin


def _row(element: _Element, order: str) -> np.dtype[np.void]:
    return np.dtype([(name, order + kind) for name, kind in element.columns])


def _text_rows(lines: islice[bytes], count: int, columns: list[int]) -> Floats:
    """(count, 3) numbers of so many lines."""
    found = np.empty((count, 3))
    for k in range(count):
        words = next(lines, b"").split()
        if len(words) <= max(columns):
            raise FileError("scan.cut", declared=count, found=k)
        try:
            found[k] = [float(words[column]) for column in columns]
        except ValueError:
            raise FileError("scan.ply", fault=f"vertex {k + 1}") from None
    return found
