"""Products that only sums use become fused multiply-adds: fewer operations and roundings, alike on every target.

1. Who uses every value (`users_of`), and when it is ready at the earliest (`ready_times`).
2. A product may disappear if all its users are sums in which it occurs once; each sum can swallow one product. Products
   are offered to their sums in order: few users first, late ones first, for the late one is what the sum waits for.
3. Every sum that swallows becomes fma, fms or fnma, by the signs of its two terms.
4. A negation whose operand has no other user turns the signs of that operation instead: the opposite of a*b + c is
   -(a*b) - c.

Sums of products in one row: a + (b c + d e) becomes (a + b c) + d e, where every product can be fused.

A sum of two products leaves one of them unfused, whatever is added later. In a row that begins with a term that is no
product none is left, at the price of another order of addition: the rounding error keeps its bound, since a product
that was rounded by itself is now rounded with the sum so far.
"""

from __future__ import annotations

from mafsil.kernels.tape import Node, Tape, alive, arguments

LATENCY = {"input": 0, "const": 0, "neg": 1, "div": 13, "sqrt": 18, "sin": 60, "cos": 60, "atan2": 80}
"""Rough clock cycles until a result is there; 4 if not listed."""


def fuse(tape: Tape) -> Tape:
    """The tape with chosen pairs of a product and a sum as one operation, and negations moved into it.

    A product is fused only if all its uses are sums that can take it, so that it disappears. Of two products in one
    sum, the one that is ready later is fused.
    """
    # 1. and 2.
    users = users_of(tape)
    claims = _claims(tape, users)
    # 3.; the swallowed products are dead now.
    nodes = [_with_product(tape, i, claims[i]) if i in claims else node for i, node in enumerate(tape.nodes)]
    merged = alive(Tape(tuple(nodes), tape.input_sizes, tape.outputs))
    # 4.
    return _without_signs(merged)


def users_of(tape: Tape) -> list[list[int]]:
    """For every node, the nodes that use it; an output counts as user -1."""
    users: list[list[int]] = [[] for _ in tape.nodes]
    for i, node in enumerate(tape.nodes):
        for a in arguments(node):
            users[a].append(i)
    for port in tape.outputs:
        for i in port:
            users[i].append(-1)
    return users


def _claims(tape: Tape, users: list[list[int]]) -> dict[int, int]:
    """Sum -> the product that it swallows."""
    nodes, ready = tape.nodes, ready_times(tape)
    claims: dict[int, int] = {}
    products = [i for i, node in enumerate(nodes) if node.op == "mul" and all(takes(nodes, u, i) for u in users[i])]
    for i in sorted(products, key=lambda i: (len(users[i]), -ready[i])):
        if all(user not in claims for user in users[i]):
            claims.update(dict.fromkeys(users[i], i))
    return claims


def takes(nodes: tuple[Node, ...], user: int, product: int) -> bool:
    """`user` is a sum in which `product` occurs once."""
    return user >= 0 and nodes[user].op in ("add", "sub") and nodes[user].args.count(product) == 1


def ready_times(tape: Tape) -> list[int]:
    """Clock cycles after which each value is there, if nothing waits for a free unit."""
    ready: list[int] = []
    for node in tape.nodes:
        ready.append(LATENCY.get(node.op, 4) + max((ready[a] for a in arguments(node)), default=0))
    return ready


def _with_product(tape: Tape, i: int, product: int) -> Node:
    """Sum i with its product inside: p + c, p - c or c - p with p = a*b."""
    first, second = tape.nodes[i].args
    factors = tape.nodes[product].args
    if tape.nodes[i].op == "add":
        return Node("fma", (*factors, second if first == product else first))
    return Node("fms", (*factors, second)) if first == product else Node("fnma", (*factors, first))


_OPPOSITE = {"fma": "fnms", "fms": "fnma", "fnma": "fms", "fnms": "fma"}


def _without_signs(tape: Tape) -> Tape:
    """Negations of values used nowhere else become part of the operation that computes them."""
    users = users_of(tape)
    nodes = list(tape.nodes)
    for i, node in enumerate(nodes):
        if node.op == "neg" and len(users[node.args[0]]) == 1:
            inner = nodes[node.args[0]]
            if inner.op == "sub":
                nodes[i] = Node("sub", (inner.args[1], inner.args[0]))
            elif inner.op in _OPPOSITE:
                nodes[i] = Node(_OPPOSITE[inner.op], inner.args)
    return alive(Tape(tuple(nodes), tape.input_sizes, tape.outputs))


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
