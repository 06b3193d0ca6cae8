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
    tau = rng.uniform(-2, 2, (count, n)) * _holding_efforts(mechanism)
    return States(q, qd, qdd, tau, rng.uniform(-10, 10, (count, 6)))


def _holding_efforts(mechanism: Mechanism) -> Floats:
    """(n,) what each joint may have to hold: the weight behind it, times the length behind it if it turns."""
    mass = {link.name: 0.0 if link.inertial is None else link.inertial.mass for link in mechanism.links}
    length = {
        link.name: 0.0 if link.inertial is None else float(np.linalg.norm(link.inertial.com))
        for link in mechanism.links
    }
    for joint in reversed(mechanism.joints):
        mass[joint.parent] += mass[joint.child]
        way = float(np.linalg.norm(joint.T_pj[:3, 3])) + length[joint.child]
        length[joint.parent] = max(length[joint.parent], way)
    return np.array(
        [
            9.81 * mass[joint.child] * (1.0 if joint.kind is JointKind.PRISMATIC else length[joint.child])
            for joint in mechanism.coordinates
        ]
    )
