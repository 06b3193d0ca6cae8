"""A configuration to begin with, or to be drawn in."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mafsil.arrays import JointVector
from mafsil.errors import ModelError
from mafsil.lazy_module import lazily
from mafsil.model import JointLimits, Mechanism
from mafsil.robot import Robot

if TYPE_CHECKING:
    import mafsil.parallel as parallel
else:
    parallel = lazily("mafsil.parallel")

MARGIN = 0.15
"""Distance to each bound, as share of the range."""
REGULAR = 0.03
"""Smallest singular value of the Jacobian from which on a start is regular."""
BENDS = (0.2, 0.4, 0.8)
"""How far a start that is singular is bent [rad | m]."""


def resting_place(limits: JointLimits) -> JointVector:
    """(n,) zero, moved into the middle 70 % of each range where it has bounds [rad | m]."""
    return _inside(limits, np.zeros(len(limits.lower)))


def resting_configuration(mechanism: Mechanism) -> JointVector:
    """(n,) the resting place; of a robot with loops the nearest that was found with all loops closed.

    Args:
        mechanism: any.

    Raises:
        ModelError: none was found.
    """
    q = resting_place(mechanism.limits)
    if not mechanism.loops:
        return q
    found = parallel.ClosedChain(mechanism).close_loops(q)
    if not found:
        raise ModelError("robot.loops_never", robot=mechanism.name, why=found.explain())
    return np.asarray(found.q)


def starting_place(robot: Robot) -> JointVector:
    """(n,) the resting place; the most regular of some bent configurations around it where the arm is singular there.

    The configurations bend neighbouring joints to one or to alternating sides, in the middle 70 % of their ranges; of
    equally good ones the first, which is the nearest.
    """
    q = resting_place(robot.limits)
    if robot.n == 0 or _margin(robot, q) >= REGULAR:
        return q
    k = np.arange(robot.n)
    patterns = [(-1.0) ** (k // period + shift) for period in (1, 2, 3) for shift in (0, 1)]
    bent = [_inside(robot.limits, q + bend * pattern) for bend in BENDS for pattern in patterns]
    return max([q, *bent], key=lambda configuration: round(_margin(robot, configuration), 9))


def _inside(limits: JointLimits, q: JointVector) -> JointVector:
    span = limits.upper - limits.lower
    margin = np.where(np.isfinite(span), MARGIN * span, 0.0)
    return np.clip(q, limits.lower + margin, limits.upper - margin)


def _margin(robot: Robot, q: JointVector) -> float:
    """Smallest singular value of the body Jacobian."""
    return float(np.linalg.svd(robot.jacobian_body(q), compute_uv=False)[-1])
