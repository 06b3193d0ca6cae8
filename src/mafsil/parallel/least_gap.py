"""How near loops come to closing where they cannot: the distance to what is feasible, found by least squares."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, Integers, JointVector
from mafsil.model import JointKind
from mafsil.parallel.closed_terms import LoopConditions
from mafsil.solvers import levenberg_marquardt

ROTATIONS = {
    JointKind.FIXED: 3, JointKind.PRISMATIC: 3, JointKind.REVOLUTE: 2, JointKind.HELICAL: 2, JointKind.CYLINDRICAL: 2,
    JointKind.UNIVERSAL: 1, JointKind.SPHERICAL: 0, JointKind.PLANAR: 2,
}  # fmt: skip
"""Directions about which a joint does not let its child rotate: the first rows of its loop."""


def least_open(chain: LoopConditions, q: JointVector, free: Integers) -> JointVector:
    """(n,) coordinates near q at which the loops gape least: squares of angles, and of lengths over the size.

    Newton's method asks for loops that close; where they cannot it wanders, and its gap says nothing.

    Args:
        chain: with loops.
        q: (n,) where the search begins [rad | m].
        free: indices of the coordinates that may change.
    """
    lengths = np.concatenate([np.repeat([1.0, chain.size], split) for split in _splits(chain)])

    def gaps(x: Floats) -> tuple[Floats, Floats]:
        here = q.copy()
        here[free] = x * chain.unit[free]
        found = chain.terms(here)
        return found.gap / lengths, found.J[:, free] * chain.unit[free] / lengths[:, None]

    nearest = q.copy()
    nearest[free] = levenberg_marquardt(gaps, q[free] / chain.unit[free]).value * chain.unit[free]
    return nearest


def widest_loop(chain: LoopConditions, q: JointVector) -> tuple[str, float, float]:
    """The loop that gapes most at coordinates (n,), and by how much [m], [rad]."""
    first, gap, loop = 0, chain.terms(q).gap, int(chain.loop_errors(q).argmax())
    for rotations, shifts in _splits(chain)[:loop]:
        first += rotations + shifts
    rotations, shifts = _splits(chain)[loop]
    own = gap[first : first + rotations + shifts]
    distance, angle = float(np.linalg.norm(own[rotations:])), float(np.linalg.norm(own[:rotations]))
    return chain.robot.mechanism.loops[loop].name, distance, angle


def _splits(chain: LoopConditions) -> list[tuple[int, int]]:
    """For each loop its numbers of rows about and along directions."""
    kinds = [loop.kind for loop in chain.robot.mechanism.loops]
    return [(ROTATIONS[kind], 6 - kind.freedoms - ROTATIONS[kind]) for kind in kinds]
