"""Order conditions of Runge-Kutta methods of any order: one for each rooted tree."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from itertools import combinations_with_replacement
from typing import TypeAlias

import numpy as np

from mafsil.arrays import Floats

Tree: TypeAlias = tuple["Tree", ...]
"""A rooted tree as the sorted tuple of its branches; () is the single node."""


@cache
def trees(order: int) -> tuple[Tree, ...]:
    """All rooted trees with that many nodes: 1, 1, 2, 4, 9, 20, 48, 115, ..."""
    return tuple(sorted(_forests(order - 1, order - 1)))


def _forests(nodes: int, largest: int) -> Iterator[Tree]:
    """All multisets of trees with `nodes` nodes together, none larger than `largest`."""
    if nodes == 0:
        yield ()
        return
    for size in range(min(nodes, largest), 0, -1):
        for count in range(1, nodes // size + 1):
            for rest in _forests(nodes - count * size, size - 1):
                for group in combinations_with_replacement(trees(size), count):
                    yield tuple(sorted((*group, *rest)))


@cache
def nodes(tree: Tree) -> int:
    """Number of nodes."""
    return 1 + sum(nodes(branch) for branch in tree)


@cache
def density(tree: Tree) -> int:
    """Gamma(t) = nodes(t) times the densities of the branches."""
    product = nodes(tree)
    for branch in tree:
        product *= density(branch)
    return product


def violation(a: Floats, weights: Floats, order: int, theta: float = 1.0) -> tuple[float, Tree]:
    """Largest |b . Phi(t) - theta^nodes / gamma(t)| over the trees up to an order, and the tree.

    Errors count relative to the sum of |b_i Phi_i|, so that large coefficients are not blamed for their rounding.

    Args:
        a: (s, s) the method's matrix.
        weights: (s,) weights b, or b(theta) of a continuous extension.
        order: up to which the conditions are asked.
        theta: fraction of the step at which the result is taken.

    Reference: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, theorem II.2.13.
    """
    known: dict[Tree, Floats] = {(): np.ones(len(weights))}

    def stages(tree: Tree) -> Floats:
        if tree not in known:
            value = np.ones(len(weights))
            for branch in tree:
                value = value * (a @ stages(branch))
            known[tree] = value
        return known[tree]

    worst, culprit = 0.0, ()
    for count in range(1, order + 1):
        for tree in trees(count):
            terms = weights * stages(tree)
            error = abs(float(terms.sum()) - theta**count / density(tree)) / max(1.0, float(np.abs(terms).sum()))
            if error > worst:
                worst, culprit = error, tree
    return worst, culprit
