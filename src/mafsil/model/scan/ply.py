"""Points of PLY files, as text or binary; faces and colours are passed over."""

from __future__ import annotations

import io
from dataclasses import dataclass, field
from itertools import islice

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import FileError

TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
LONGEST_HEADER = 1 << 16
AXES = ("x", "y", "z")


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
