"""Products that only sums use become fused multiply-adds: fewer operations and roundings, alike on every target.

1. How often every value is used, which by sums alone, and when it is ready at the earliest (`_Uses`).
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

from mafsil.kernels.tape import Node, Tape, places

LATENCY = {"input": 0, "const": 0, "neg": 1, "div": 13, "sqrt": 18, "sin": 60, "cos": 60, "atan2": 80}
"""Rough clock cycles until a result is there; 4 if not listed."""
_SUMS = frozenset(("add", "sub"))
_OPPOSITE = {"fma": "fnms", "fms": "fnma", "fnma": "fms", "fnms": "fma"}
Term = tuple[int, bool]
"""A node, and whether it is subtracted."""


class _Uses:
    """How the values of a tape are used.

    Attributes:
        count: how often each is an operand of a value that is used, or an output; 0 for the dead.
        products: those that only sums use, in which they occur once, and these sums.
        partial: the sums that one other sum alone uses.
        ready: clock cycles after which each is there, if nothing waits for a free unit.
    """

    def __init__(self, tape: Tape) -> None:
        size = len(tape.nodes)
        self.count = count = [0] * size
        self.products: dict[int, list[int]] = {}
        self.partial: set[int] = set()
        for port in tape.outputs:
            for i in port:
                count[i] += 1
        sums: list[list[int]] = [[] for _ in range(size)]
        for i, node, args in zip(range(size - 1, -1, -1), reversed(tape.nodes), reversed(tape.operands), strict=True):
            if not count[i]:
                continue
            for a in args:
                count[a] += 1
            if node.op in _SUMS:
                first, second = args
                if first != second:
                    sums[first].append(i)
                    sums[second].append(i)
                if count[i] == len(sums[i]) == 1:
                    self.partial.add(i)
            elif node.op == "mul" and count[i] == len(sums[i]):
                self.products[i] = sums[i]
        self.ready = _ready_times(tape)


def _ready_times(tape: Tape) -> list[int]:
    ready: list[int] = []
    for node, args in zip(tape.nodes, tape.operands, strict=True):
        latest = 0
        for a in args:
            if ready[a] > latest:
                latest = ready[a]
        ready.append(LATENCY.get(node.op, 4) + latest)
    return ready


def fuse(tape: Tape) -> Tape:
    """The tape with chosen pairs of a product and a sum as one operation, and negations moved into it.

    A product is fused only if all its uses are sums that can take it, so that no output needs it any more. Of two
    products in one sum, the one that is ready later is fused.
    """
    # 1. and 2.
    uses = _Uses(tape)
    claims = _claims(uses)
    # 3.; the factors of a product that was used k times are now used by k sums in place of one product.
    nodes = list(tape.nodes)
    for i, product in claims.items():
        nodes[i] = _with_product(tape.nodes[i], product, tape.nodes[product].args)
        for factor in tape.nodes[product].args:
            uses.count[factor] += 1
    for product in set(claims.values()):
        for factor in tape.nodes[product].args:
            uses.count[factor] -= 1
    # 4.
    _absorb_signs(nodes, uses.count)
    return Tape(tuple(nodes), tape.input_sizes, tape.outputs)


def _claims(uses: _Uses) -> dict[int, int]:
    """Sum -> the product that it swallows."""
    claims: dict[int, int] = {}
    ready = uses.ready
    order = sorted((len(sums), -ready[product], product) for product, sums in uses.products.items())
    for _, _, product in order:
        if claims.keys().isdisjoint(uses.products[product]):
            claims.update(dict.fromkeys(uses.products[product], product))
    return claims


def _with_product(total: Node, product: int, factors: tuple[int, ...]) -> Node:
    """A sum with its product inside: p + c, p - c or c - p with p = a*b."""
    first, second = total.args
    if total.op == "add":
        return Node("fma", (*factors, second if first == product else first))
    return Node("fms", (*factors, second)) if first == product else Node("fnma", (*factors, first))


def _absorb_signs(nodes: list[Node], count: list[int]) -> None:
    """Negations of values used nowhere else become part of the operation that computes them."""
    for i, node in enumerate(nodes):
        if node.op == "neg" and count[node.args[0]] == 1:
            inner = nodes[node.args[0]]
            if inner.op == "sub":
                nodes[i] = Node("sub", (inner.args[1], inner.args[0]))
            elif inner.op in _OPPOSITE:
                nodes[i] = Node(_OPPOSITE[inner.op], inner.args)


def in_rows(tape: Tape) -> Tape:
    """The tape with every sum in a row that then needs fewer operations; all others stay, but for the dead.

    1. Inner sums, which one other sum alone uses, are parts of that one (`_Uses.partial`).
    2. For every sum, how many sums of two products it holds, each of which leaves a product unfused, and whether all
       its terms are products.
    3. A row that begins with a term that is no product leaves none, one that begins with a product leaves that one. If
       it is fewer than now, the terms (`terms`) are added up in the order in which they are ready (`row`), and the
       inner sums are gone.
    """
    rows = _Rows(tape)
    chains = {root: rows.terms(root) for root in rows.worth_it()}
    gone = rows.absorbed.union([i for i, count in enumerate(rows.uses.count) if not count])
    nodes: list[Node] = []
    place: list[int] = []
    for i, (node, args) in enumerate(zip(tape.nodes, tape.operands, strict=True)):
        if i in chains:
            nodes += rows.row([(place[k], minus) for k, minus in chains[i]], len(nodes))
        elif i not in gone:
            nodes.append(Node(node.op, places(args, place)) if args else node)
        place.append(len(nodes) - 1)
    return Tape(tuple(nodes), tape.input_sizes, tuple(tuple(place[i] for i in port) for port in tape.outputs))


class _Rows:
    """Sums and their terms; `absorbed` are the inner sums of rows."""

    def __init__(self, tape: Tape) -> None:
        self.nodes = tape.nodes
        self.uses = _Uses(tape)
        self.absorbed: set[int] = set()

    def worth_it(self) -> list[int]:
        """Step 2, and the outermost sums that are better in a row."""
        products, partial = self.uses.products, self.uses.partial
        unfused: dict[int, int] = {}
        pure: dict[int, bool] = {}
        found: list[int] = []
        for i, node in enumerate(self.nodes):
            if node.op in _SUMS and self.uses.count[i]:
                first, second = node.args
                below = [a for a in node.args if a in partial]
                unfused[i] = (first in products and second in products) + sum([unfused[a] for a in below])
                pure[i] = all(pure[a] if a in partial else a in products for a in node.args)
                if i not in partial and unfused[i] > pure[i]:
                    found.append(i)
        return found

    def terms(self, root: int) -> list[Term]:
        """What is added up in a sum, in the order in which it is ready, but for the head of the row.

        The head is no product if there is another term, and not subtracted if there is such a one.
        """
        found: list[Term] = []
        stack = [(root, False)]
        while stack:
            i, minus = stack.pop()
            if i != root and i not in self.uses.partial:
                found.append((i, minus))
                continue
            self.absorbed.add(i)
            first, second = self.nodes[i].args
            stack += [(second, minus != (self.nodes[i].op == "sub")), (first, minus)]
        found.sort(key=lambda term: self.uses.ready[term[0]])
        heads = [term for term in found if term[0] not in self.uses.products] or found
        head = next((term for term in heads if not term[1]), heads[0])
        found.remove(head)
        return [head, *found]

    def row(self, terms: list[Term], first: int) -> list[Node]:
        """One sum after another of these terms; `first` is the place of the first of them."""
        (total, negated), *others = terms
        nodes: list[Node] = []
        for i, minus in others:
            if negated and not minus:
                nodes.append(Node("sub", (i, total)))
                negated = False
            else:
                nodes.append(Node("sub" if minus != negated else "add", (total, i)))
            total = first + len(nodes) - 1
        return [*nodes, Node("neg", (total,))] if negated else nodes
