"""Straight lines in time from point to point, without blends: their velocity jumps, and the jumps are named."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.solvers import Outcome
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.splines.points import points_and_durations
from mafsil.trajectory.status import PlanStatus


def straight_lines(points: ArrayLike, durations: ArrayLike) -> Outcome[PiecewisePolynomial]:
    """u = u_j + (u_k - u_j)/d (t - T_j): the line that an arm cannot follow, for its velocity jumps at every point.

    Args:
        points: (*batch, k + 1, n) positions [rad | m]; (k + 1,) is one coordinate.
        durations: (k,) times from point to point, or one number for all [s].

    Returns:
        The motion, of which no arm is capable: the status is VELOCITY_JUMPS, its residual the largest jump, its details
        the `jumps` (k + 1, *batch, n) at all points, those from and into rest included. Without any jump nothing
        moves, and the status is PLANNED.

    Raises:
        InputError: a wrong shape, a number that is not finite, a duration that is not positive.
    """
    u, h = points_and_durations(points, durations)
    slopes = np.diff(u, axis=0) / h.reshape((-1,) + (1,) * (u.ndim - 1))
    still = np.zeros((1, *u.shape[1:]))
    jumps = np.diff(np.concatenate([still, slopes, still]), axis=0)
    largest = float(np.abs(jumps).max(initial=0.0))
    motion = PiecewisePolynomial.from_pieces(h, np.stack([u[:-1], slopes], axis=1))
    status = PlanStatus.VELOCITY_JUMPS if largest > 0.0 else PlanStatus.PLANNED
    worst = int(np.abs(jumps).reshape(len(jumps), -1).max(axis=1, initial=0.0).argmax())
    details: dict[str, object] = {"duration": motion.duration, "jumps": jumps, "index": worst}
    return Outcome(motion, status, largest, details=details)
