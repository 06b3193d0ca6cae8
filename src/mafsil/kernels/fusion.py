"""Products that only sums use become fused multiply-adds: fewer operations and roundings, alike on every target.

1. Who uses every value (`users_of`), and when it is ready at the earliest (`ready_times`).
2. A product may disappear if all its users are sums in which it occurs once; each sum can swallow one product. Products
   are offered to their sums in order: few users first, late ones first, for the late one is what the sum waits for.
3. Every sum that swallows becomes fma, fms or fnma, by the signs of its two terms.
4. A negation whose operand has no other user turns the signs of that operation instead: the opposite of a*b + c is
   -(a*b) - c.
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
