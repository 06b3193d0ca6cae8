"""Random states of a robot: positions within its limits, rates, loads and wrenches of its natural size."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats
from mafsil.mechanics.arm_size import RATE, TRAVEL, ArmSize
from mafsil.model import JointKind, Mechanism


@dataclass(frozen=True, eq=False, slots=True)
class States:
    """States (b, ...), the arguments of all quantities.

    Attributes:
        q, qd, qdd, tau: (b, n).
        tip_wrench, base_twist, base_acceleration: (b, 6), or None where a quantity is computed without them.
        frame: name of the link whose frame is meant; the tip frame if None.
    """

    q: Floats
    qd: Floats
    qdd: Floats
    tau: Floats
    tip_wrench: Floats | None = None
    base_twist: Floats | None = None
    base_acceleration: Floats | None = None
    frame: str | None = None


def random_states(mechanism: Mechanism, size: ArmSize, count: int, seed: int) -> States:
    """Positions within the limits (at most one turn and half a metre), rates, loads and wrenches of natural size.

    Args:
        mechanism: the robot.
        size: of the robot.
        count: of states.
        seed: of the random numbers.
    """
    rng, n = np.random.default_rng(seed), mechanism.n
    most = np.array([TRAVEL if joint.kind is JointKind.PRISMATIC else np.pi for joint in mechanism.coordinates])
    lower, upper = np.maximum(mechanism.limits.lower, -most), np.minimum(mechanism.limits.upper, most)
    lower, upper = np.where(lower < upper, lower, -most), np.where(lower < upper, upper, most)
    return States(
        rng.uniform(lower, upper, (count, n)),
        rng.uniform(-RATE, RATE, (count, n)) * size.unit,
        rng.uniform(-5, 5, (count, n)) * size.unit,
        rng.uniform(-1, 1, (count, n)) * size.force * size.length / size.unit,
        rng.uniform(-1, 1, (count, 6)) * size.force * np.array([size.length] * 3 + [1.0] * 3),
        rng.uniform(-1, 1, (count, 6)),
        rng.uniform(-3, 3, (count, 6)),
    )
