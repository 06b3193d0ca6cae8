"""A tree of configurations that grows, with the nearest node found at once."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, JointVector


class Tree:
    """Configurations, each but the root with a parent and the cost of the way from the root.

    Memory: n + 2 numbers a node, doubled where more are needed.

    Args:
        root: (n,).
    """

    def __init__(self, root: JointVector) -> None:
        self.count = 1
        self._q: Floats = np.empty((64, len(root)))
        self._q[0] = root
        self.parent, self.cost = [-1], [0.0]

    @property
    def q(self) -> Floats:
        """(count, n) configurations."""
        return self._q[: self.count]

    def nearest(self, q: JointVector) -> int:
        """The node nearest to a configuration (n,)."""
        away = self.q - q
        return int(np.einsum("kn,kn->k", away, away).argmin())

    def near(self, q: JointVector, radius: float) -> list[int]:
        """Nodes within a radius of a configuration (n,)."""
        away = self.q - q
        return [int(k) for k in np.flatnonzero(np.einsum("kn,kn->k", away, away) <= radius**2)]

    def add(self, q: JointVector, parent: int) -> int:
        """A node more; its index."""
        if self.count == len(self._q):
            self._q = np.concatenate([self._q, np.empty_like(self._q)])
        self._q[self.count] = q
        self.parent.append(parent)
        self.cost.append(self.cost[parent] + float(np.linalg.norm(q - self._q[parent])))
        self.count += 1
        return self.count - 1

    def way(self, node: int) -> JointVector:
        """(k, n) from the root to a node."""
        rows: list[JointVector] = []
        while node >= 0:
            rows.append(self._q[node].copy())
            node = self.parent[node]
        return np.stack(rows[::-1])
