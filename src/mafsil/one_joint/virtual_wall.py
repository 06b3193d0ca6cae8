"""The stiffest virtual wall against which a sampled device is stable by itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, whole
from mafsil.one_joint.arguments import above_zero, magnitude, together
from mafsil.one_joint.joint_arm import JointArm
from mafsil.one_joint.joint_law import JointLaw
from mafsil.one_joint.sampled_stability import DECAYS, held_plant, sampled_stability

HALVINGS = 80
"""In the search."""


def stiffest_stable_wall(
    mass: ArrayLike, friction: ArrayLike, period: ArrayLike, wall_damping: ArrayLike = 0.0, delay: int = 0
) -> Floats:
    """Stiffest virtual wall against which a free device is stable by itself (*batch) [N/m].

    The wall is a sampled spring and differenced damper; by halving on the spectral radius of the exact step, to
    rounding of its eigenvalues; a spring alone without delay by its closed form. A hand that holds the device may still
    make it unstable: the passive limit is `mafsil.control.contact.stiffest_wall`.

    Args:
        mass: of the device (*batch) [kg].
        friction: b (*batch) of the device [N s/m].
        period: T (*batch) [s].
        wall_damping: B (*batch) [N s/m].
        delay: whole periods.

    Returns:
        0 where no wall is stable.
    """
    m, b, T, B = together(
        mass=above_zero("mass", mass), friction=magnitude("friction", friction), period=above_zero("period", period),
        wall_damping=magnitude("wall_damping", wall_damping),
    )  # fmt: skip
    late, device = whole("delay", delay), JointArm.of(m, friction=b)
    low, high = np.zeros_like(m), 16.0 * m / (T * T) + 16.0 * (b + B) / T
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        fine = sampled_stability(device, JointLaw.pid(middle, 0.0, B), T, late).spectral_radius < 1.0 - DECAYS
        low, high = np.where(fine, middle, low), np.where(fine, high, middle)
    if late:
        return low
    # A spring without delay: theta, theta' go by [[1 - P K, S], [-Q K, E]], stable while its determinant is below 1 and
    # no eigenvalue passes -1. No difference of nearly equal numbers is needed, however light the damping.
    E, S, Q, P = held_plant(m, b, T)
    turns, flips = S * Q - P * E, P * (1.0 + E) - S * Q
    with np.errstate(divide="ignore"):
        spring = np.minimum(-np.expm1(-b * T / m) / turns, np.where(flips > 0.0, 2.0 * (1.0 + E) / flips, np.inf))
    return np.where(B > 0.0, low, spring)
