"""Pairs of bodies, compiled: how near they can be at some joint angles, looked up, and how often they meet in samples.

Hand and forearm are near each other always, and meet nearly never: balls around them say nothing, and their pieces take
longer than all the surroundings. What two coordinates decide is known before: over the cells of a grid of both, a lower
bound of the distance (`clearance_tables`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.arm_loops import Arm, gap_between, just_above, place_bodies, scratch_for
from mafsil.kernels.loops.lanes import looked_up, magnitude, rounded_down, seen, where
from mafsil.kernels.loops.loop import compiled, inlined

if TYPE_CHECKING:
    from mafsil.kernels.loops.lanes import Buffer, Lanes


SIDE = 64
"""Cells along each coordinate."""
UNKNOWN = -np.inf
FURTHEST = 1e9
"""Cells from the first beyond which an angle is too large to be told where it is within its turn."""


class Clearances(NamedTuple):
    """Lower bounds of distances, by tables over two coordinates each.

    Attributes:
        table: (pairs,) the table that knows a pair; -1 for none.
        slot: (pairs,) place of the pair in a cell of its table.
        axes: (t, 2, 4) of both coordinates of a table: column, lowest value, cells per unit (0 where there is but one
            coordinate), 1 if the table repeats itself after a turn, 0 if the coordinate has to lie between its ends.
        span: (t, n, 2) between which the other coordinates have to lie; infinite for those that do not matter.
        cells: (t, 2) where the cells of a table begin in `values`, and how many pairs a cell has.
        values: (m,) bounds [m].
    """

    table: NDArray[np.int64]
    slot: NDArray[np.int64]
    axes: Floats
    span: Floats
    cells: NDArray[np.int64]
    values: Floats


@inlined
def place_cells(known: Clearances, q: Floats, out: Floats) -> None:
    """Lanes for each table: where the cell of a configuration begins in its values; -1 where it has none.

    Args:
        q: (n,) lanes.
        out: (t,) lanes.
    """
    for t in range(len(known.axes)):
        _place_cell(known, t, seen(q), seen(out))


@inlined
def _place_cell(known: Clearances, t: int, q: Buffer, out: Buffer) -> None:
    cell, inside = q[0] * 0.0, q[0] == q[0]
    for k in range(2):
        axis = known.axes[t, k]
        x = (q[int(axis[0])] - axis[1]) * axis[2]
        if axis[3] != 0.0:
            inside = inside & (magnitude(x) < FURTHEST)
            x = x - rounded_down(x * (1.0 / SIDE)) * SIDE
        else:
            inside = inside & (x >= 0.0) & (x <= SIDE)
        x = rounded_down(x)
        cell = cell * SIDE + where(x > SIDE - 1.0, SIDE - 1.0, where(x > 0.0, x, 0.0))
    span = known.span[t]
    for c in range(len(span)):
        if span[c, 0] > -np.inf:
            inside = inside & (q[c] >= span[c, 0]) & (q[c] <= span[c, 1])
    out[t] = where(inside, cell * float(known.cells[t, 1]) + float(known.cells[t, 0]), -1.0)


@inlined
def clearance(known: Clearances, k: int, cell: Buffer) -> Lanes:
    """How near the bodies of pair k are at least in each lane; UNKNOWN where its table has no cell."""
    place = cell[0]
    found = looked_up(known.values, where(place < 0.0, 0.0, place + float(known.slot[k])))
    return where(place < 0.0, UNKNOWN, found)


@compiled
def lower_clearances(arm: Arm, poses: Floats, pairs: NDArray[np.int64], out: Floats) -> None:
    """Distances of pairs of bodies where they are less than what stands there, zero or less where they meet.

    Args:
        poses: (m, L, 4, 4).
        pairs: (k,) rows of the arm's pairs.
        out: (m, k) in and out.
    """
    s = scratch_for(arm)
    for r in range(len(poses)):
        place_bodies(arm, poses[r], s)
        for k in range(len(pairs)):
            a, b = arm.pairs[pairs[k], 0], arm.pairs[pairs[k], 1]
            out[r, k] = gap_between(arm, a, b, poses[r], out[r, k], 0.0, s)


@compiled
def count_meetings(arm: Arm, poses: Floats, counts: NDArray[np.int64]) -> None:
    """Add to `counts` (m,), for each pair of the arm, the states in which it meets.

    Args:
        poses: (k, L, 4, 4) of the links.
        counts: of each pair.
    """
    s, least = scratch_for(arm), just_above(0.0)
    for r in range(len(poses)):
        place_bodies(arm, poses[r], s)
        for k in range(len(arm.pairs)):
            if gap_between(arm, arm.pairs[k, 0], arm.pairs[k, 1], poses[r], least, 0.0, s) <= 0.0:
                counts[k] += 1


@compiled
def measure_gaps(arm: Arm, poses: Floats, most: float, gaps: Floats) -> None:
    """Distances of the pairs of an arm in some states; zero where they meet.

    Args:
        poses: (k, L, 4, 4) of the links.
        most: larger distances count as this one [m].
        gaps: (k, m) of each pair.
    """
    s = scratch_for(arm)
    for r in range(len(poses)):
        place_bodies(arm, poses[r], s)
        for k in range(len(arm.pairs)):
            gaps[r, k] = max(gap_between(arm, arm.pairs[k, 0], arm.pairs[k, 1], poses[r], most, 0.0, s), 0.0)
