"""A loop over the tables of pairs that only the tests call."""

from __future__ import annotations

from mafsil.collision.clearance_loops import clearance, place_cells
from mafsil.kernels.loops.lanes import WIDTH, in_lanes, part, put, seen
from mafsil.kernels.loops.loop import compiled


@compiled
def bounds(known, q, out):
    """Lower bounds (pairs, 8) of eight configurations (8, n); -inf for pairs without a table."""
    lanes, cells = in_lanes(q.shape[1]), in_lanes(len(known.axes))
    for lane in range(WIDTH):
        for c in range(q.shape[1]):
            put(seen(lanes), c, lane, q[lane, c])
    place_cells(known, lanes, cells)
    for k in range(len(known.table)):
        if known.table[k] >= 0:
            seen(out)[k] = clearance(known, k, part(seen(cells), known.table[k]))
