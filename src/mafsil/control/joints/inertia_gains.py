"""Gains of independent joints from the inertia that they move, as hard as the sampling rate allows."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, positive, require_finite, require_kind
from mafsil.control.laws.gains import Gains
from mafsil.robot import Robot

NATURAL_FREQUENCY, DAMPING_RATIO = 55.0, 0.7
"""Of each joint, all others locked [rad/s, 1]."""
MOST_RAISED = 5.0
"""How much faster a light joint may be than requested, that it is not dragged along by the heavy ones."""
MOST_DECAY = 1.5
"""Largest decay of any error in one sampling period; from 2 on the sampled loop is unstable."""
SOFT, AROUND = 0.2, 0.4
"""Where a joint gets less than this share of the requested frequency, the arm will stray; then the loop has to be
stable this far around the motion too [1, rad | m]."""
_SHRINK, _ROUNDS = 0.5, 500


def inertia_gains(
    robot: Robot,
    q: ArrayLike,
    period: float,
    natural_frequency: float = NATURAL_FREQUENCY,
    damping_ratio: float = DAMPING_RATIO,
) -> Gains:
    """PD gains scaled with the inertia of each joint: Kp = w^2 M_ii, Kd = 2 zeta w M_ii.

    Algorithm:
        1. M_ii is the largest along q. w is the requested natural frequency, raised by sqrt(sum_j |M_ij| / M_ii) where
           the other joints push more mass through this one than it moves itself.
        2. The sampled rate loop is stable while period * eig(M^-1 Kd) < 2; the largest eigenvalue along q, with its
           mode, is looked for.
        3. While it is above 1.5, w of each joint is lowered by that joint's part in the mode.
        4. If that leaves a joint soft, the same again with configurations around the motion.

    Args:
        robot: the model.
        q: (k, n) configurations that the motion passes [rad | m].
        period: between two calls of the law [s].
        natural_frequency: w of each joint, the others locked [rad/s].
        damping_ratio: zeta.

    Returns:
        Gains in units of effort, without an integral.

    Raises:
        InputError: a wrong shape, a number that is not finite or not positive.
    """
    require_kind("robot", robot, "Robot", "mass_matrix")
    for name, value in (("period", period), ("natural_frequency", natural_frequency), ("damping_ratio", damping_ratio)):
        positive(name, value)
    places = require_finite("q", as_batch("q", q, (robot.n,))).reshape(-1, robot.n)
    inertia, w = _frequencies(robot, places, period, natural_frequency, damping_ratio)
    if w.min() < SOFT * natural_frequency:
        around = [places + side * row for row in AROUND * np.eye(robot.n) for side in (-1.0, 1.0)]
        inertia, w = _frequencies(robot, np.concatenate([places, *around]), period, natural_frequency, damping_ratio)
    return Gains.of(robot.n, w**2 * inertia, 2.0 * damping_ratio * w * inertia)


def _frequencies(robot: Robot, q: Floats, period: float, requested: float, damping: float) -> tuple[Floats, Floats]:
    """Largest inertia (n,) of each joint along q (k, n), and the frequency (n,) that the sampling allows [rad/s]."""
    M = np.asarray(robot.mass_matrix(q), dtype=np.float64)
    inertia = np.einsum("kii->ki", M).max(axis=0)
    coupled = np.abs(M).sum(axis=2).max(axis=0)
    w = requested * np.minimum(np.sqrt(coupled / inertia), MOST_RAISED)
    inverse = np.asarray(np.linalg.inv(M), dtype=np.float64)
    for _ in range(_ROUNDS):
        decay, part = _fastest(inverse, 2.0 * damping * w * inertia)
        if decay * period <= MOST_DECAY:
            break
        w = w * (1.0 - part * (1.0 - max(MOST_DECAY / (decay * period), _SHRINK)))
    return inertia, w


def _fastest(inverse: Floats, kd: Floats) -> tuple[float, Floats]:
    """Largest eigenvalue of M^-1 Kd among all configurations [1/s], and the part (n,) of each joint in its mode."""
    root = np.sqrt(kd)
    values, modes = np.linalg.eigh(root[:, None] * inverse * root)
    hardest = int(values[:, -1].argmax())
    return float(values[hardest, -1]), modes[hardest, :, -1] ** 2
