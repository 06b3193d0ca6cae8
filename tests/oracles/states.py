"""Random states of a mechanism: the arguments of all quantities, batched."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats
from mafsil.model import JointKind, Mechanism


@dataclass(frozen=True, eq=False)
class States:
    """N states: q, qd, qdd, tau (N, n) and tip_wrench (N, 6)."""

    q: Floats
    qd: Floats
    qdd: Floats
    tau: Floats
    tip_wrench: Floats

    def __len__(self) -> int:
        return len(self.q)

    def part(self, rows: slice) -> States:
        return States(self.q[rows], self.qd[rows], self.qdd[rows], self.tau[rows], self.tip_wrench[rows])

    def arguments(self, names: tuple[str, ...]) -> list[Floats]:
        return [getattr(self, name) for name in names]


def sample(mechanism: Mechanism, count: int, rng: np.random.Generator) -> States:
    """Positions uniform within the limits (at most one turn and 0.5 m each way), rates and loads of natural size."""
    n = mechanism.n
    reach = np.array([0.5 if joint.kind is JointKind.PRISMATIC else np.pi for joint in mechanism.coordinates])
    lower, upper = np.maximum(mechanism.limits.lower, -reach), np.minimum(mechanism.limits.upper, reach)
    lower, upper = np.where(lower < upper, lower, -reach), np.where(lower < upper, upper, reach)
    q = rng.uniform(lower, upper, (count, n))
    qd, qdd = rng.uniform(-2, 2, (count, n)), rng.uniform(-5, 5, (count, n))
    return States(q, qd, qdd, rng.uniform(-20, 20, (count, n)), rng.uniform(-10, 10, (count, 6)))
