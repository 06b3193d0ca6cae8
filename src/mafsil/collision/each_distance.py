"""The distance of every body of an arm to what is around it, and of every pair that is checked, with gradients."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch
from mafsil.collision import distance_loops, each_distance_loops, layout
from mafsil.collision.checker import Checker
from mafsil.collision.pair_loops import ROW


def each_distance(checker: Checker, q: ArrayLike, within: float) -> tuple[Floats, Floats]:
    """What the arm keeps, body by body and pair by pair, and how that changes with the coordinates.

    Args:
        checker: the arm in its scene.
        q: (*batch, n) joint coordinates [rad | m].
        within: distances beyond it count as infinite [m].

    Returns:
        (*batch, bodies + pairs) distances [m], less than zero where something meets; (*batch, bodies + pairs, n) their
        gradients, zero beyond `within`.
    """
    n, arm, around = checker.robot.n, checker.arm, checker.scene.surroundings
    array = as_batch("q", q, (n,), finite=True)
    rows, batch = np.ascontiguousarray(array).reshape(-1, n), array.shape[:-1]
    items = len(arm.bodies) + len(arm.pairs)
    out, who = np.empty((len(rows), items, ROW)), np.empty((len(rows), items, 2), np.int64)
    gradient = np.zeros((len(rows), items, n))
    for begin, poses in layout.poses_in_parts(checker.robot, rows):
        part = slice(begin, begin + len(poses))
        each_distance_loops.each_distance(arm, poses, around, float(within), out[part], who[part])
        of_items = np.repeat(poses, items, axis=0)
        found, rates = (x[part].reshape(-1, x.shape[2]) for x in (out, gradient))
        distance_loops.gradients(checker.laid.motion, of_items, found, who[part].reshape(-1, 2), rates)
    return out[:, :, 0].reshape(*batch, items), gradient.reshape(*batch, items, n)
