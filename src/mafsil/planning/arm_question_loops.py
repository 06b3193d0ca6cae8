"""A whole question about a path of an arm in one compiled call: ends, straight motions, first samples, shortcuts."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.segment_loops import free_at
from mafsil.collision.workshop_loops import Workshop
from mafsil.kernels.loops.entry import Held, open_held
from mafsil.kernels.loops.lanes import WIDTH
from mafsil.kernels.loops.loop import compiled, inlined
from mafsil.planning.arm_search_loops import (
    FULL,
    GOALS_LEFT,
    GROWING,
    JOINED,
    ROOT,
    Forests,
    apart,
    grow,
    place,
    proves_free,
)  # fmt: skip
from mafsil.planning.retreat_loops import Limbs
from mafsil.planning.shorten_loops import shorten

REFUSED = FULL + 1
"""An end cannot be; beside JOINED, GROWING and FULL."""
AROUND = 0.3
"""How far beyond start and goal the samples around them lie, as share of what a coordinate can do."""


class Limits(NamedTuple):
    """Between which configurations a search goes.

    Attributes:
        lower, upper: (n,) of the coordinates; infinite where there are none.
        moves: (n,) whether a coordinate moves the tip.
        limb: (n, n) whether coordinate i may move where j ends elsewhere than it starts.
        behind: (n, n) whether it may do so where all that does moves the tip.
        changes: (n,) to work in.
        around: how far beyond start and goals one without limits is searched [rad | m].
    """

    lower: Floats
    upper: Floats
    moves: NDArray[np.bool_]
    limb: NDArray[np.bool_]
    behind: NDArray[np.bool_]
    changes: NDArray[np.bool_]
    around: float


@compiled
def bounds_around(limits: Limits, start: Floats, goals: Floats, bounds: Floats, near: Floats) -> None:
    """Lowest and highest coordinates of samples, (2, n), out: of all, and of those around the start and the first goal.

    Coordinates with one value at all ends keep it unless `_may_move` frees them.
    """
    of_tip = True
    for c in range(len(start)):
        low, high = start[c], start[c]
        for k in range(len(goals)):
            low, high = min(low, goals[k, c]), max(high, goals[k, c])
        bounds[0, c] = limits.lower[c] if limits.lower[c] > -np.inf else low - limits.around
        bounds[1, c] = limits.upper[c] if limits.upper[c] < np.inf else high + limits.around
        limits.changes[c] = low != high
        of_tip &= limits.moves[c] or low == high
    for c in range(len(start)):
        if not limits.changes[c] and not _may_move(limits, c, of_tip):
            bounds[0, c], bounds[1, c] = start[c], start[c]
        beyond = AROUND * (bounds[1, c] - bounds[0, c])
        near[0, c] = max(min(start[c], goals[0, c]) - beyond, bounds[0, c])
        near[1, c] = min(max(start[c], goals[0, c]) + beyond, bounds[1, c])


@compiled
def _may_move(limits: Limits, c: int, of_tip: bool) -> bool:
    """Whether a coordinate that ends where it starts belongs to the motion of those that do not.

    Args:
        limits: of configurations.
        c: the coordinate.
        of_tip: whether all those that change move the tip.
    """
    found = False
    for j in range(len(limits.changes)):
        found |= limits.changes[j] and (limits.limb[c, j] or (of_tip and limits.behind[c, j]))
    return found


class Question(NamedTuple):
    """Where a thread searches.

    Attributes:
        limits: of configurations.
        forests: to search in, with place for two nodes more than there are goals.
        bounds, near: (2, n) out: between which it samples, and around the ends.
        limbs: whose tools can go back.
    """

    limits: Limits
    forests: Forests
    bounds: Floats
    near: Floats
    limbs: Limbs


@compiled
def _is_open(shop: Held[Workshop], limits: Limits, q: Floats) -> bool:
    """Whether a configuration is within the limits and keeps more than the clearance."""
    for c in range(len(q)):
        if not limits.lower[c] <= q[c] <= limits.upper[c]:
            return False
    return free_at(shop, q)


@inlined
def _copy(row: Floats, to: Floats) -> None:
    for c in range(len(row)):
        to[c] = row[c]


@compiled
def _begin(
    shop: Held[Workshop], question: Question, start: Floats, goals: Floats, seed: int
) -> int:  # fmt: skip
    """The beginning of `solve`: REFUSED, JOINED or GROWING.

    1. Goals that are open become roots, nearest first.
    2. A straight motion to one of them.
    """
    limits, forests = question.limits, question.forests
    forests.sizes[:] = 0
    if not _is_open(shop, limits, start):
        return REFUSED
    roots, count = forests.q[1], 0
    for k in range(len(goals)):  # 1
        if not _is_open(shop, limits, goals[k]):
            continue
        rank, away = count, apart(start, goals[k])
        while rank > 0 and apart(start, roots[rank - 1]) > away:
            _copy(roots[rank - 1], roots[rank])
            rank -= 1
        _copy(goals[k], roots[rank])
        count += 1
    if count == 0:
        return REFUSED
    place(forests, 0, 0, start)
    for k in range(count):
        place(forests, 1, k, roots[k])
    forests.parent[:, :count] = ROOT
    forests.sizes[0], forests.sizes[1], forests.sizes[2] = 1, count, 0
    forests.random[0] = seed
    forests.seen[:] = 0
    bounds_around(limits, start, roots[:count], question.bounds, question.near)
    for k in range(count):  # 2
        if proves_free(shop, start, roots[k], forests.seen):
            _copy(start, forests.path[0])
            _copy(roots[k], forests.path[1])
            forests.sizes[2] = 2
            return JOINED
    return GROWING


@compiled
def solve(
    shop: Held[Workshop], question: Held[Question], start: Floats, goals: Floats, seed: int, drawn: int, samples: int,
    tries: int, leave: bool,
) -> tuple[int, Floats]:  # fmt: skip
    """A whole question in one call: how it stands, and the path if there is one.

    Start and goals are looked at; without a start or a goal that is open it is REFUSED. A straight motion to a goal is
    the path where it is free. Else both sides grow; if that does not join them, the forests hold what to go on from.
    `shorten` makes the path shorter.

    Args:
        shop: what is free.
        question: where to search.
        start, goals: (n,), (k, n).
        seed: of the samples.
        drawn: samples before this call; if there were any, it goes on from what the forests hold.
        samples: before it comes back.
        tries: about how many motions are tried to make it shorter.
        leave: whether the first ends are those of `retreats`, if there are to be so many samples.
    """
    asked = open_held(question)
    forests, code, left = asked.forests, GROWING, 0
    if drawn == 0:
        code = _begin(shop, asked, start, goals, seed)
        left = max(min(forests.sizes[1], GOALS_LEFT, samples // WIDTH - 1), 0) if leave else 0
    if code == GROWING:
        code = grow(shop, asked.bounds, asked.near, asked.limbs, left, drawn, samples, forests)
    path = forests.path[: forests.sizes[2] if code == JOINED else 0].copy()
    if len(path) > 2 and tries > 0:
        path = shorten(shop, path, tries, forests.random, forests.seen)
    return code, path
