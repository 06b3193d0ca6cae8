"""An order of computation that keeps few values alive at once: registers are 16 or 32, tapes have thousands of values.

1. For every value, how many registers its expression takes as if it were a tree (`_registers`, Sethi and Ullman): of
   two operands the needier goes first, while few results are waiting; n and n take n + 1.
2. Expensive operations of one kind and one depth do not need each other: up to eight go together (`_groups`), side by
   side in the processor or, on one row, in one vector.
3. Depth first from the outputs in their order: before a value, its operands, the needier first; with a member of a
   group, the whole group (`_Order`).
"""

from __future__ import annotations

from collections import defaultdict

from mafsil.kernels.tape import Node, Tape, arguments, reorder_nodes

TRIGONOMETRIC = frozenset(("sin", "cos"))
"""Operations that share one reduction of their argument."""
EXPENSIVE = TRIGONOMETRIC | frozenset(
    [
        "tan",
        "exp",
        "log",
        "pow",
        "asin",
        "acos",
        "atan",
        "atan2",
        "tanh",
    ]
)
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
        self.need = _registers(tape)
        self.groups = _groups(tape)
        self.done: set[int] = set()
        self.result: list[int] = []

    def order(self) -> list[int]:
        for port in self.tape.outputs:
            for output in port:
                self.visit(output)
        return self.result

    def visit(self, root: int) -> None:
        """Emit everything `root` needs, then itself; an explicit stack, since tapes are deep."""
        stack = [root]
        while stack:
            # The top of the stack is emitted when nothing is missing; until then what is missing goes on top of it.
            i = stack[-1]
            if i in self.done:
                stack.pop()
                continue
            members = self.groups.get(i, (i,))
            needed = [a for m in members for a in arguments(self.tape.nodes[m]) if a not in self.done]
            if needed:
                # The last on the stack is the first to be computed: sorted by need, the neediest on top.
                stack.extend(sorted(set(needed), key=lambda a: (self.need[a], -a)))
                continue
            stack.pop()
            self.done.update(members)
            self.result.extend(members)


def _registers(tape: Tape) -> list[int]:
    """Sethi-Ullman numbers, taking the program for a tree."""
    need: list[int] = []
    for node in tape.nodes:
        if node.op in ("input", "const"):
            need.append(0)
            continue
        # The k-th operand is computed while the k before it wait in a register each.
        below = sorted((need[a] for a in node.args), reverse=True)
        need.append(max([1, *(n + k for k, n in enumerate(below))]))
    return need


def _groups(tape: Tape) -> dict[int, tuple[int, ...]]:
    """For every expensive node, the nodes to be computed with it: one kind, one depth, at most GROUP arguments."""
    # Depth: how many expensive operations lie below. Of one depth, none can need another. Sine and cosine of the same
    # argument are one bundle; GROUP bundles fill a vector.
    depth: list[int] = []
    alike: dict[tuple[int, str], dict[tuple[int, ...], list[int]]] = defaultdict(lambda: defaultdict(list))
    for i, node in enumerate(tape.nodes):
        below = max((depth[a] for a in arguments(node)), default=0)
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
