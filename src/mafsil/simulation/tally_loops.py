"""What is kept of many runs, compiled: gone through once, tick after tick, while they are in the processor's cache."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled


class Tally(NamedTuple):
    """Sums and peaks of b runs so far.

    Attributes:
        ends: (b,) ticks that count; as many as there are until a run blows up.
        tip: (b, 2) largest distance and angle of the tip from its reference [m], [rad].
        tip_squares: (b,) sum over the ticks [m^2].
        joint_squares: (b, n) sum of squared errors of the joints.
        effort: (b, n) largest magnitudes.
        clipped: (b,) ticks at which some effort was clipped.
        power: (b,) sum of the magnitudes of power over the ticks.
    """

    ends: NDArray[np.int64]
    tip: Floats
    tip_squares: Floats
    joint_squares: Floats
    effort: Floats
    clipped: Floats
    power: Floats


def tally_of(ends: NDArray[np.int64], n: int) -> Tally:
    """Nothing so far.

    Args:
        ends: (b,) ticks that count, where that is known.
        n: coordinates.
    """
    b = len(ends)
    return Tally(
        ends, np.zeros((b, 2)), np.zeros(b), np.zeros((b, n)), np.zeros((b, n)), np.zeros(b), np.zeros(b)
    )  # fmt: skip


@compiled
def add(
    tally: Tally, first: int, q: Floats, qd: Floats, tau: Floats, commanded: Floats, u: Floats, tip: Floats,
    runaway: float,
) -> None:  # fmt: skip
    """Some ticks more.

    1. A run whose rates ran away or whose efforts are not finite ends before that tick.
    2. Peaks and sums of what counts.

    Args:
        tally: out.
        first: number of the first tick.
        q, qd, tau, commanded: (k, b, n) states, efforts that act, efforts before clipping.
        u: (k, 1, n) the reference.
        tip: (k, b, 2) distance and angle of the tip from its reference.
        runaway: sum of squared rates from which on a run has blown up.
    """
    ticks, b, n = q.shape
    for k in range(ticks):
        for r in range(b):
            if first + k >= tally.ends[r]:
                continue
            rates, effort = 0.0, 0.0
            for i in range(n):  # 1
                rates += qd[k, r, i] * qd[k, r, i]
                effort += tau[k, r, i] * 0.0
            if not rates <= runaway or effort != 0.0:
                tally.ends[r] = first + k
                continue
            clipped, power = False, 0.0
            for i in range(n):  # 2
                error = u[k, 0, i] - q[k, r, i]
                tally.joint_squares[r, i] += error * error
                tally.effort[r, i] = max(tally.effort[r, i], abs(tau[k, r, i]))
                power += abs(tau[k, r, i] * qd[k, r, i])
                clipped |= tau[k, r, i] != commanded[k, r, i]
            tally.power[r] += power
            tally.clipped[r] += 1.0 if clipped else 0.0
            tally.tip_squares[r] += tip[k, r, 0] * tip[k, r, 0]
            for i in range(2):
                tally.tip[r, i] = max(tally.tip[r, i], tip[k, r, i])
