"""An order of computation that keeps few values alive at once."""

from __future__ import annotations

from collections import defaultdict

from mafsil.kernels.tape import Node, Tape, arguments, reordered

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


def scheduled(tape: Tape) -> Tape:
    """Depth first from the outputs, the operand that needs more registers first; expensive operations in groups.

    Reference: Sethi and Ullman 1970, The generation of optimal code for arithmetic expressions.
    """
    return reordered(tape, _Order(tape).order())


class _Order:
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
            i = stack[-1]
            if i in self.done:
                stack.pop()
                continue
            members = self.groups.get(i, (i,))
            wanted = [a for m in members for a in arguments(self.tape.nodes[m]) if a not in self.done]
            if wanted:
                stack.extend(sorted(set(wanted), key=lambda a: (self.need[a], -a)))
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
        below = sorted((need[a] for a in node.args), reverse=True)
        need.append(max([1, *(n + k for k, n in enumerate(below))]))
    return need


def _groups(tape: Tape) -> dict[int, tuple[int, ...]]:
    """For every expensive node, the nodes to be computed with it: one kind, one depth, at most GROUP arguments."""
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
