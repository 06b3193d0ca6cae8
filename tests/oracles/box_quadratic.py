"""The smallest value of a convex quadratic function in a box: projected Newton steps.

Reference: Bertsekas, Projected Newton methods for optimization problems with simple constraints, SIAM J. Control and
Optimization 20, 1982.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats

MOST_STEPS = 200
TOLERANCE = 1e-10
"""Of the projected gradient over the largest entry of the linear term and of H x."""
SUFFICIENT, SHORTEST = 1e-4, 1e-12
"""Share of the promised decrease that a step has to bring, and the shortest step that is tried."""


class BoxMinimum(NamedTuple):
    """A minimiser.

    Attributes:
        x: (n,) within the bounds.
        free: (n,) which entries are between their bounds.
        steps: Newton steps taken.
        residual: length of the projected gradient.
    """

    x: Floats
    free: NDArray[np.bool_]
    steps: int
    residual: float


def box_minimum(H: Floats, g: Floats, lower: Floats, upper: Floats, start: Floats) -> BoxMinimum:
    """The x with lower <= x <= upper that minimises x' H x / 2 + g' x.

    1. Entries at a bound whose gradient pushes outward stay; the others are free.
    2. A Newton step of the free ones, cut off at the bounds.
    3. Halved until the value falls enough; done when the free gradient vanishes.

    Args:
        H: (n, n) symmetric, positive definite.
        g: (n,).
        lower, upper: (n,) bounds, infinite ones allowed.
        start: (n,) where it begins.
    """
    x = np.clip(start, lower, upper)
    scale = max(float(np.abs(g).max(initial=0.0)), float(np.abs(H @ x).max(initial=0.0)), 1.0)
    gradient = H @ x + g
    free = _free(x, gradient, lower, upper)
    for steps in range(MOST_STEPS):
        residual = float(np.linalg.norm(gradient[free]))
        if residual <= TOLERANCE * scale:
            return BoxMinimum(x, free, steps, residual)
        direction = np.zeros_like(x)
        direction[free] = -np.linalg.solve(H[np.ix_(free, free)], gradient[free])
        moved = _searched(H, g, x, gradient, direction, lower, upper)
        if np.array_equal(moved, x):
            return BoxMinimum(x, free, steps, residual)
        x = moved
        gradient = H @ x + g
        free = _free(x, gradient, lower, upper)
    return BoxMinimum(x, free, MOST_STEPS, float(np.linalg.norm(gradient[free])))


def _free(x: Floats, gradient: Floats, lower: Floats, upper: Floats) -> NDArray[np.bool_]:
    return ~(((x <= lower) & (gradient > 0.0)) | ((x >= upper) & (gradient < 0.0)))


def _searched(
    H: Floats, g: Floats, x: Floats, gradient: Floats, direction: Floats, lower: Floats, upper: Floats
) -> Floats:
    """The first of the halved steps, cut off at the bounds, with enough decrease."""
    share = 1.0
    while share > SHORTEST:
        trial = np.clip(x + share * direction, lower, upper)
        step = trial - x
        if step @ (gradient + 0.5 * (H @ step)) <= SUFFICIENT * float(gradient @ step):
            return trial
        share /= 2.0
    return x
