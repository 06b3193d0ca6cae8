"""Lanes out, rows in memory: neighbouring elements of an output, transposed in registers as soon as all are known.

What is known early is written early: long outputs need no memory of their own between arithmetic and caller.
"""

from __future__ import annotations

from dataclasses import dataclass

from mafsil.kernels.emitter import Text
from mafsil.kernels.tape import Tape


@dataclass(frozen=True)
class Block:
    """Neighbouring elements of an output that are written together.

    Attributes:
        port: which output.
        first: index of the first element.
        nodes: the values.
    """

    port: int
    first: int
    nodes: tuple[int, ...]


def blocks(tape: Tape, width: int) -> list[Block]:
    """All outputs cut into blocks, the widest stores that fit; the last one of a port may overlap the one before."""
    found: list[Block] = []
    for port, nodes in enumerate(tape.outputs):
        size = len(nodes)
        length = block_length(size, width)
        firsts = [*range(0, size - length + 1, length)] if size else []
        if size % length:
            firsts.append(size - length)
        found.extend(Block(port, first, nodes[first : first + length]) for first in firsts)
    return found


def block_length(size: int, width: int) -> int:
    """The longest block for a port of that size."""
    return next(length for length in (4, 2, 1) if length <= min(size, width) or length == 1)


def row_pointers(text: Text, port: int, width: int) -> list[str]:
    """Addresses of the rows of an output, %step{port} bytes apart."""
    rows = [f"%rows{port}"]
    for lane in range(1, width):
        skip = text.let(f"mul i64 %step{port}, {lane}")
        rows.append(text.let(f"getelementptr i8, ptr %rows{port}, i64 {skip}"))
    return rows


def write(text: Text, rows: list[str], first: int, values: list[str]) -> None:
    """Store vectors of lanes as neighbouring elements of the rows, from element `first` on."""
    width, length = len(rows), len(values)
    places = [text.let(f"getelementptr double, ptr {row}, i64 {first}") if first else row for row in rows]
    if length == 1:
        for lane, place in enumerate(places):
            number = text.let(f"extractelement <{width} x double> {values[0]}, i64 {lane}")
            text.do(f"store double {number}, ptr {place}, align 8")
        return
    for place, piece in zip(places, rows_of(text, values, width, length), strict=True):
        text.do(f"store <{length} x double> {piece}, ptr {place}, align 8")


def columns_of(text: Text, rows: list[str], width: int, length: int) -> list[str]:
    """`length` vectors of `width` lanes from `width` vectors of `length` elements."""
    return _transpose(text, [_join(text, rows[k::length], length) for k in range(length)], width, length)


def rows_of(text: Text, columns: list[str], width: int, length: int) -> list[str]:
    """The inverse of `columns_of`."""
    split = [_pieces(text, row, width, length) for row in _transpose(text, columns, width, length)]
    return [split[row % length][row // length] for row in range(width)]


def _shuffle(text: Text, a: str, b: str, count: int, picks: list[int]) -> str:
    kind = f"<{count} x double>"
    mask = ", ".join(f"i32 {pick}" for pick in picks)
    return text.let(f"shufflevector {kind} {a}, {kind} {b}, <{len(picks)} x i32> <{mask}>")


def _join(text: Text, parts: list[str], count: int) -> str:
    """Vectors of `count` elements, one after another in one vector."""
    while len(parts) > 1:
        picks = list(range(2 * count))
        parts = [_shuffle(text, a, b, count, picks) for a, b in zip(parts[::2], parts[1::2], strict=True)]
        count *= 2
    return parts[0]


def _pieces(text: Text, vector: str, width: int, length: int) -> list[str]:
    """A vector cut into vectors of `length` elements."""
    if width == length:
        return [vector]
    return [_shuffle(text, vector, vector, width, list(range(k, k + length))) for k in range(0, width, length)]


def _transpose(text: Text, rows: list[str], width: int, length: int) -> list[str]:
    """Every group of `length` lanes transposed as a small square: halves of halves change places."""
    reach = 1
    while reach < length:
        rows = _exchange(text, rows, width, reach)
        reach *= 2
    return rows


def _exchange(text: Text, rows: list[str], width: int, reach: int) -> list[str]:
    """In every pair of rows `reach` apart, the second `reach` lanes of the one for the first ones of the other."""
    groups = [lane for lane in range(width) if not lane & reach]
    low = [pick for g in groups[::reach] for pick in (*range(g, g + reach), *range(g + width, g + width + reach))]
    found = list(rows)
    for k in range(len(rows)):
        if not k & reach:
            found[k] = _shuffle(text, rows[k], rows[k + reach], width, low)
            found[k + reach] = _shuffle(text, rows[k], rows[k + reach], width, [pick + reach for pick in low])
    return found
