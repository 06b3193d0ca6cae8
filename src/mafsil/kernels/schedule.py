"""In which order and in which pieces a tape is computed: few values alive at once, short compile times.

Registers are 16 or 32, tapes have thousands of values.

1. For every value, how many registers its expression takes as if it were a tree (`_registers`, Sethi and Ullman): of
   two operands the needier goes first, while few results are waiting; n and n take n + 1.
2. Expensive operations of one kind and one depth do not need each other: up to eight go together (`_groups`), side by
   side in the processor or, on one row, in one vector.
3. Depth first from the outputs in their order: before a value, its operands, the needier first; with a member of a
   group, the whole group (`_Order`).
4. A long tape is cut into pieces, each a function of its own, after so many operations, never within a group;
   expensive ones count for many.
5. For every value, the last piece that needs it; for every block of outputs, the piece that completes it.
6. Piece by piece: a value that a later piece needs gets a memory cell; the cells of values that no piece needs any more
   are given to others, so that few cells stay in the nearest cache.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from mafsil.kernels.rows import Block
from mafsil.kernels.tape import Node, Tape, reorder_nodes

TRIGONOMETRIC = frozenset(("sin", "cos"))
"""Operations that share one reduction of their argument."""
EXPENSIVE = TRIGONOMETRIC | frozenset((
    "tan", "exp", "log", "pow", "asin", "acos", "atan", "atan2", "tanh",
))  # fmt: skip
"""Operations made of many instructions; independent ones of a kind are computed side by side."""
GROUP = 8
"""Most arguments in one group: what the widest vector holds."""


def kind(node: Node) -> str:
    """What a node can be grouped by: operations on one argument that share work count as one kind."""
    return "trigonometric" if node.op in TRIGONOMETRIC else node.op


def schedule(tape: Tape) -> Tape:
    """Depth first from the outputs, the operand that needs more registers first; expensive operations in groups.

    Reference: Sethi and Ullman 1970, The generation of optimal code for arithmetic expressions.
    """
    return reorder_nodes(tape, _Order(tape).order())


class _Order:
    """Step 3."""

    def __init__(self, tape: Tape) -> None:
        self.tape = tape
        need = _registers(tape)
        self.rank = [need[i] * len(need) - i for i in range(len(need))]
        """Rises with the need; of two equally needy values the earlier one ranks above."""
        self.groups = _groups(tape)
        self.done = bytearray(len(need))
        self.result: list[int] = []

    def order(self) -> list[int]:
        for port in self.tape.outputs:
            for output in port:
                self.visit(output)
        return self.result

    def visit(self, root: int) -> None:
        """Emit everything `root` needs, then itself; an explicit stack, since tapes are deep."""
        operands, done = self.tape.operands, self.done
        stack = [root]
        while stack:
            # The top of the stack is emitted when nothing is missing; until then what is missing goes on top of it.
            i = stack[-1]
            if done[i]:
                stack.pop()
                continue
            members = self.groups.get(i, (i,))
            needed = [a for m in members for a in operands[m] if not done[a]]
            if len(needed) > 1:
                # The last on the stack is the first to be computed: sorted by need, the neediest on top.
                stack.extend(sorted(set(needed), key=self.rank.__getitem__))
            elif needed:
                stack.extend(needed)
            else:
                stack.pop()
                self.result.extend(members)
                for m in members:
                    done[m] = 1


def _registers(tape: Tape) -> list[int]:
    """Sethi-Ullman numbers, taking the program for a tree."""
    need: list[int] = []
    for args in tape.operands:
        # The k-th operand is computed while the k before it wait in a register each.
        if len(args) == 2:
            first, second = need[args[0]], need[args[1]]
            need.append(first + 1 if first == second else max(first, second))
        elif args:
            below = sorted([need[a] for a in args], reverse=True)
            need.append(max([1, *[n + k for k, n in enumerate(below)]]))
        else:
            need.append(0)
    return need


def _groups(tape: Tape) -> dict[int, tuple[int, ...]]:
    """For every expensive node, the nodes to be computed with it: one kind, one depth, at most GROUP arguments."""
    # Depth: how many expensive operations lie below. Of one depth, none can need another. Sine and cosine of the same
    # argument are one bundle; GROUP bundles fill a vector.
    depth: list[int] = []
    alike: dict[tuple[int, str], dict[tuple[int, ...], list[int]]] = defaultdict(lambda: defaultdict(list))
    last = max([i for i, node in enumerate(tape.nodes) if node.op in EXPENSIVE], default=-1)
    for i, node in enumerate(tape.nodes[: last + 1]):
        below = max([depth[a] for a in tape.operands[i]], default=0)
        depth.append(below + (node.op in EXPENSIVE))
        if node.op in EXPENSIVE:
            alike[below, kind(node)][node.args].append(i)
    groups: dict[int, tuple[int, ...]] = {}
    for by_argument in alike.values():
        bundles = list(by_argument.values())
        for first in range(0, len(bundles), GROUP):
            members = tuple(i for bundle in bundles[first : first + GROUP] for i in bundle)
            groups.update(dict.fromkeys(members, members))
    return groups


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
    groups = list(_independent_groups(tape))
    pieces = _pieces(tape, groups, length) or [[]]
    if len(pieces) > 2:
        pieces = _pieces(tape, groups, min(length, SHORT))
    # 2.
    last, complete = _last_pieces(tape, pieces, blocks)
    # 3.
    known: dict[int, int] = {}
    free: list[int] = []
    cells = 0
    found: list[Segment] = []
    for k, piece in enumerate(pieces):
        for i in [i for i in known if last[i] < k]:
            free.append(known.pop(i))
        kept: dict[int, int] = {}
        for i in (i for group in piece for i in group if last[i] > k):
            kept[i] = free.pop() if free else cells
            cells = max(cells, kept[i] + 1)
        found.append(Segment(tuple(piece), kept, dict(known), tuple(complete.get(k, ()))))
        known |= kept
    return found, cells


def _last_pieces(
    tape: Tape, pieces: list[list[Group]], blocks: Sequence[Block]
) -> tuple[list[int], dict[int, list[Block]]]:
    """The last piece that needs each value, -1 if none does, and the blocks that each piece completes."""
    home, last = [-1] * len(tape.nodes), [-1] * len(tape.nodes)
    for k, piece in enumerate(pieces):
        for group in piece:
            for i in group:
                home[i] = k
                for a in tape.operands[i]:
                    last[a] = k
    complete: dict[int, list[Block]] = {}
    for block in blocks:
        end = max(0, *(home[i] for i in block.nodes))
        complete.setdefault(end, []).append(block)
        for i in block.nodes:
            last[i] = max(last[i], end)
    return last, complete


def _pieces(tape: Tape, groups: list[Group], length: int) -> list[list[Group]]:
    """The groups in pieces of about this many operations."""
    found: list[list[Group]] = []
    weight = length
    for group in groups:
        if weight >= length:
            found.append([])
            weight = 0
        found[-1].append(group)
        weight += len(group) * (WEIGHT if tape.nodes[group[0]].op in EXPENSIVE else 1)
    return found


def _independent_groups(tape: Tape) -> Iterator[Group]:
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
