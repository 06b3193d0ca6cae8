"""A long tape cut into pieces, each a function of its own: compile time stays proportional to length.

1. The tape is cut after so many operations, never within a group; expensive ones count for many.
2. For every value, the last piece that needs it; for every block of outputs, the piece that completes it.
3. Piece by piece: a value that a later piece needs gets a memory cell; the cells of values that no piece needs any more
   are given to others, so that few cells stay in the nearest cache.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from mafsil.kernels.rows import Block
from mafsil.kernels.schedule import EXPENSIVE, GROUP, kind
from mafsil.kernels.tape import Tape, arguments

LENGTH = 3000
"""Operations in one piece, about; a compiler's register allocation takes time that grows faster than the length."""
SHORT = 700
"""Operations in one piece of a tape that takes more than two: evaluated as fast, compiled in a fifth less time."""
WEIGHT = 25
"""Operations that an expensive function counts for."""

Group = tuple[int, ...]


@dataclass(frozen=True)
class Segment:
    """A piece of a tape.

    Attributes:
        groups: nodes in order; nodes of one group are computed side by side.
        kept: values computed here and needed later, and the memory cell of each.
        known: values computed earlier, and the memory cell of each.
        blocks: outputs that can be written by the end of this piece and not before.
    """

    groups: tuple[Group, ...]
    kept: Mapping[int, int]
    known: Mapping[int, int]
    blocks: tuple[Block, ...] = ()


def segments(tape: Tape, length: int = LENGTH, blocks: Sequence[Block] = ()) -> tuple[list[Segment], int]:
    """The pieces, and the number of memory cells that carry values between them.

    Args:
        tape: the program.
        length: operations in one piece, about; fewer in a tape that needs more than two pieces.
        blocks: outputs that are written together.
    """
    # 1.
    pieces = list(_pieces(tape, length)) or [[]]
    if len(pieces) > 2:
        pieces = list(_pieces(tape, min(length, SHORT)))
    # 2.
    home = {i: k for k, piece in enumerate(pieces) for group in piece for i in group}
    last: dict[int, int] = {}
    for i, k in home.items():
        for a in arguments(tape.nodes[i]):
            if a in home:
                last[a] = max(last.get(a, 0), k)
    complete: dict[int, list[Block]] = {}
    for block in blocks:
        end = max((home[i] for i in block.nodes if i in home), default=0)
        complete.setdefault(end, []).append(block)
        last.update({i: max(last.get(i, 0), end) for i in block.nodes if i in home})
    # 3.
    known: dict[int, int] = {}
    free: list[int] = []
    cells = 0
    found: list[Segment] = []
    for k, piece in enumerate(pieces):
        for i in [i for i in known if last[i] < k]:
            free.append(known.pop(i))
        kept: dict[int, int] = {}
        for i in (i for group in piece for i in group if last.get(i, -1) > k):
            kept[i] = free.pop() if free else cells
            cells = max(cells, kept[i] + 1)
        found.append(Segment(tuple(piece), kept, dict(known), tuple(complete.get(k, ()))))
        known |= kept
    return found, cells


def _pieces(tape: Tape, length: int) -> Iterator[list[Group]]:
    piece: list[Group] = []
    weight = 0
    for group in _groups(tape):
        piece.append(group)
        weight += len(group) * (WEIGHT if tape.nodes[group[0]].op in EXPENSIVE else 1)
        if weight >= length:
            yield piece
            piece, weight = [], 0
    if piece:
        yield piece


def _groups(tape: Tape) -> Iterator[Group]:
    """Runs of expensive nodes that do not need each other and are of one kind; every other operation alone."""
    run: list[int] = []
    for i, node in enumerate(tape.nodes):
        joins = run and kind(node) == kind(tape.nodes[run[0]]) and not set(node.args) & set(run)
        joins = joins and len({node.args, *(tape.nodes[k].args for k in run)}) <= GROUP
        if run and not joins:
            yield tuple(run)
            run = []
        if node.op in EXPENSIVE:
            run.append(i)
        elif node.op not in ("input", "const"):
            yield (i,)
    if run:
        yield tuple(run)
