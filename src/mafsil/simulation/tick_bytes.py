"""Ticks as bytes of one length: messages of protobuf whose numbers stand at fixed places, whole blocks at a time.

A message of doubles alone has the same length for every tick: tags and lengths are constants, and a block of ticks is a
table into which the columns of the arrays are copied. Infinities and NaN are numbers like others.

Reference: https://protobuf.dev/programming-guides/encoding.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import prod
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats

Bytes: TypeAlias = NDArray[np.uint8]
Shape: TypeAlias = tuple[int, ...]

MESSAGE = "mafsil.tick"
VARINT, FIXED64, LENGTH = 0, 1, 2
"""Kinds of values on the wire."""
OPTIONAL, REPEATED, DOUBLE = 1, 3, 1
"""Labels and type of fields in a descriptor."""
NUMBER = 8
"""Bytes of a double."""


@dataclass(frozen=True, eq=False)
class TickBytes:
    """Where the numbers of arrays stand in the bytes of a tick.

    Attributes:
        shapes: of each array of a tick, by name, in the order of their fields.
    """

    shapes: Mapping[str, Shape]

    @cached_property
    def places(self) -> dict[str, tuple[int, int]]:
        """First byte and end of the numbers of each array."""
        found: dict[str, tuple[int, int]] = {}
        at = 0
        for number, (name, shape) in enumerate(self.shapes.items(), 1):
            at += len(_head(number, shape))
            found[name] = at, at + NUMBER * prod(shape)
            at = found[name][1]
        return found

    @cached_property
    def template(self) -> Bytes:
        """(size,) a tick whose numbers are zero."""
        heads = (_head(number, shape) + bytes(NUMBER * prod(shape)) for number, shape in self._number())
        return np.frombuffer(b"".join(heads), dtype=np.uint8)

    def _number(self) -> Iterable[tuple[int, Shape]]:
        return enumerate(self.shapes.values(), 1)

    def written(self, rows: Mapping[str, Floats], into: Bytes) -> None:
        """Put ticks into a table.

        Args:
            rows: arrays by name, (k, *shape) each.
            into: (k, size).
        """
        into[:] = self.template
        for name, (first, end) in self.places.items():
            column = np.ascontiguousarray(rows[name], dtype="<f8")
            into[:, first:end] = column.reshape(len(into), -1).view(np.uint8).reshape(len(into), end - first)

    def read(self, ticks: Bytes) -> dict[str, Floats]:
        """Arrays (k, *shape) by name.

        Args:
            ticks: (k, size).

        Raises:
            ValueError: a tick of another size, or with other fields.
        """
        if ticks.shape[1:] != self.template.shape:
            raise ValueError(f"ticks of {ticks.shape[-1]} bytes instead of {len(self.template)}")
        rest = ticks.copy()
        found: dict[str, Floats] = {}
        for name, (first, end) in self.places.items():
            numbers = np.ascontiguousarray(ticks[:, first:end]).view("<f8").astype(np.float64)
            found[name] = numbers.reshape(len(ticks), *self.shapes[name])
            rest[:, first:end] = 0
        if not (rest == self.template).all():
            raise ValueError("ticks with other fields")
        return found

    def descriptor(self) -> bytes:
        """The message for tools that know nothing of it: a FileDescriptorSet, nested arrays flat in C order."""
        fields = b""
        for number, (name, shape) in enumerate(self.shapes.items(), 1):
            field = _text(1, name) + _whole(3, number) + _whole(4, REPEATED if shape else OPTIONAL)
            fields += _text(2, field + _whole(5, DOUBLE) + _text(10, name))
        package, _, message = MESSAGE.rpartition(".")
        file = _text(1, f"{message}.proto") + _text(2, package) + _text(4, _text(1, message) + fields)
        return _text(1, file + _text(12, "proto3"))


def _head(number: int, shape: Shape) -> bytes:
    """What stands before the numbers of a field: its tag, and how many bytes follow if it is an array."""
    if not shape:
        return _varint(number << 3 | FIXED64)
    return _varint(number << 3 | LENGTH) + _varint(NUMBER * prod(shape))


def _varint(value: int) -> bytes:
    """Seven bits in each byte, the lowest first."""
    found = bytearray()
    while value > 0x7F:
        found.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*found, value])


def _whole(number: int, value: int) -> bytes:
    return _varint(number << 3 | VARINT) + _varint(value)


def _text(number: int, value: bytes | str) -> bytes:
    """A text, or a message inside another."""
    inside = value.encode() if isinstance(value, str) else value
    return _varint(number << 3 | LENGTH) + _varint(len(inside)) + inside
