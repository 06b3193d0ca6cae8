"""Sums of products in one row: a + (b c + d e) becomes (a + b c) + d e, where every product can be fused.

A sum of two products leaves one of them unfused, whatever is added later. In a row that begins with a term that is no
product none is left, at the price of another order of addition: the rounding error keeps its bound, since a product
that was rounded by itself is now rounded with the sum so far.
"""

from __future__ import annotations

from mafsil.kernels.fusion import ready_times, takes, users_of
from mafsil.kernels.tape import Node, Tape, alive

_SUMS = frozenset(("add", "sub"))

Term = tuple[int, bool]
"""A node, and whether it is subtracted."""


def in_rows(tape: Tape) -> Tape:
    """The tape with every sum in a row that then needs fewer operations; all others stay as they are.

    1. Inner sums, which one other sum alone uses, are parts of that one (`partial`).
    2. For every outermost sum, all its terms with their signs (`terms`), and how many sums of two products it holds:
       each of those leaves a product unfused.
    3. A row that begins with a term that is no product leaves none, one that begins with a product leaves that one. If
       it is fewer than now, the row is built in the order in which the terms are ready (`row`).
    """
    rows = _Rows(tape)
    for i, node in enumerate(tape.nodes):
        rows.place.append(rows.rebuilt(i) if node.op in _SUMS else rows.copy_node(node))
    outputs = tuple(tuple(rows.place[i] for i in port) for port in tape.outputs)
    return alive(Tape(tuple(rows.nodes), tape.input_sizes, outputs))


class _Rows:
    """Grows the new tape; `place` is the new index of every old node."""

    def __init__(self, tape: Tape) -> None:
        users = users_of(tape)
        self.old = tape.nodes
        self.ready = ready_times(tape)
        self.partial = {i for i, node in enumerate(tape.nodes) if node.op in _SUMS and self._only_summed(users[i])}
        self.products = {
            i
            for i, node in enumerate(tape.nodes)
            if node.op == "mul" and all(takes(tape.nodes, user, i) for user in users[i])
        }
        self.nodes: list[Node] = []
        self.place: list[int] = []

    def _only_summed(self, users: list[int]) -> bool:
        return len(users) == 1 and users[0] >= 0 and self.old[users[0]].op in _SUMS

    def put(self, op: str, *args: int) -> int:
        """Append an operation on new nodes."""
        self.nodes.append(Node(op, args))
        return len(self.nodes) - 1

    def copy_node(self, node: Node) -> int:
        """Append an old node that is no sum."""
        if node.op in ("input", "const"):
            self.nodes.append(node)
            return len(self.nodes) - 1
        return self.put(node.op, *(self.place[a] for a in node.args))

    def rebuilt(self, i: int) -> int:
        """Append sum i, in a row if that saves operations; part of a larger sum it is there only to be left out."""
        first, second = self.old[i].args
        plain = self.put(self.old[i].op, self.place[first], self.place[second])
        if i in self.partial:
            return plain
        terms, unfused = self.terms(i)
        terms.sort(key=lambda term: self.ready[term[0]])
        others = [term for term in terms if term[0] not in self.products]
        if unfused <= (not others):
            return plain
        return self.row(terms, others or terms)

    def terms(self, root: int) -> tuple[list[Term], int]:
        """What is added up in a sum, and how many sums of two products are in it."""
        found: list[Term] = []
        pairs, stack = 0, [(root, False)]
        while stack:
            i, minus = stack.pop()
            if i != root and i not in self.partial:
                found.append((i, minus))
                continue
            first, second = self.old[i].args
            pairs += first in self.products and second in self.products
            stack += [(second, minus != (self.old[i].op == "sub")), (first, minus)]
        return found, pairs

    def row(self, terms: list[Term], heads: list[Term]) -> int:
        """One term after another, beginning with one of the heads, with one that is not subtracted if there is."""
        head = next((term for term in heads if not term[1]), heads[0])
        terms.remove(head)
        total, negated = self.place[head[0]], head[1]
        for i, minus in terms:
            if negated and not minus:
                total, negated = self.put("sub", self.place[i], total), False
            else:
                total = self.put("sub" if minus != negated else "add", total, self.place[i])
        return self.put("neg", total) if negated else total
