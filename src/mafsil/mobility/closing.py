"""A linkage that is drawn apart, closed near where it is drawn; or how near it comes to closing."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.geometry import pose, rotation
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.linkages.loop_closure import are_lengths, closed_near, loop_state, units
from mafsil.solvers import levenberg_marquardt

TRIES, FARTHEST = 48, np.pi
"""Further starts, and how far from the drawing the last of them are [rad, sizes]."""


def closed_beside_drawing(linkage: Linkage, seed: int = 0) -> Floats | None:
    """Coordinates (F,) that close all loops, the nearest that a search finds; None if it finds none.

    1. Newton's method from where the linkage is drawn: links on one line keep it there, though they could meet.
    2. Then from starts around, ever farther away; of those that close, the one with the least coordinates.

    Args:
        linkage: as drawn.
        seed: of the starts.
    """
    found = closed_near(linkage)
    if found:
        return found.theta
    reach = np.linspace(0.0, FARTHEST, TRIES + 1)[1:, None]
    starts = reach * np.random.default_rng(seed).uniform(-1.0, 1.0, (TRIES, linkage.coordinates))
    starts = np.where(are_lengths(linkage), starts / FARTHEST, starts) * units(linkage)
    around = closed_near(linkage, starts)
    if not around.closed.any():
        return None
    closed = around.theta[around.closed]
    return closed[int(np.abs(closed / units(linkage)).max(axis=1).argmin())]


def least_gap(linkage: Linkage) -> tuple[str, float, float]:
    """The joint that gapes most where all together gape least, and by how much [m], [rad]; found by least squares.

    Gaps are taken at the joints that close the loops, where an angle is no distance: squares of angles, and of lengths
    over the size.

    Args:
        linkage: as drawn, with loops that do not close.
    """
    scale = units(linkage)

    def gaps(u: Floats) -> tuple[Floats, Floats]:
        return _at_joints(linkage, u * scale)

    rng = np.random.default_rng(0)
    starts = [np.zeros(linkage.coordinates), *rng.uniform(-1.0, 1.0, (3, linkage.coordinates))]
    best = min((levenberg_marquardt(gaps, start) for start in starts), key=lambda found: found.residual)
    twists = gaps(best.value)[0][: 6 * linkage.loops].reshape(-1, 6) * np.repeat([1.0, linkage.size], 3)
    worst = int(np.abs(twists).max(axis=1).argmax())
    omega, v = np.linalg.norm(twists[worst].reshape(2, 3), axis=1).tolist()
    return linkage.joints[linkage.closing[worst]].name, v, omega


def _at_joints(linkage: Linkage, theta: Floats) -> tuple[Floats, Floats]:
    """What loops and couplings miss (m,), and its rates (m, F), of the loops where the joints that close them stand."""
    state = loop_state(linkage, theta)
    gap, rows = state.gap.copy(), state.matrix.copy()
    for loop, index in enumerate(linkage.closing):
        here = pose.act(state.poses[linkage.ends[index, 0]], linkage.joints[index].point)
        lever = -rotation.hat((here - linkage.middle) / linkage.size)
        turns, shifts = slice(6 * loop, 6 * loop + 3), slice(6 * loop + 3, 6 * loop + 6)
        gap[shifts] += lever @ gap[turns]
        rows[shifts] += lever @ rows[turns]
    return gap, rows
