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
    draw,
    grow,
    place,
    proves_free,
)
from mafsil.planning.retreat_loops import Limbs

ROUNDS, SHARES, SWEEPS = 2, 6, 24
"""Rounds of shortening; of the tries, each makes one in SHARES shortcuts and one in SWEEPS rounds over the corners."""
LEAST_PULL, LEAST_GAIN = 0.1, 3e-3
"""Shares of the way to the chord, and of the length of its motions, below which a corner stays."""
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


@inlined
def _one_in(many: int, tries: int) -> int:
    """How many tries are one in so many, at least one if there are any."""
    return (tries + many - 1) // many


@compiled
def shorten(
    shop: Held[Workshop], path: Floats, tries: int, random: NDArray[np.uint64], seen: NDArray[np.int64]
) -> Floats:  # fmt: skip
    """A path of proved motions, made shorter by proved motions.

    1. Corners are left out.
    2. Rounds: shortcuts, which make corners where the path passes something; corners are left out; what is left of them
       is pulled straight.
    3. What a shortcut leaves of a motion is part of what was proved, and can fail a proof of its own where the whole
       passed within a micrometre of the clearance. So each motion of the result is proved; if one cannot be, all is
       done again from the first corners, and what shortcuts leave is proved each time.

    Args:
        shop: what is free.
        path: (k, n) proved.
        tries: about how many motions are tried in place of others.
        random: (1,) state of the source of samples.
        seen: (3,) counts.
    """
    room = len(path) + 2 * ROUNDS * _one_in(SHARES, tries)
    rows, lengths = np.empty((room, path.shape[1])), np.empty(room)
    rows[: len(path)] = path
    straight = _leave_out_corners(shop, rows, len(path), seen)  # 1
    before = rows[:straight].copy()
    count = _rounds(shop, rows, straight, tries, False, random, lengths, seen)  # 2
    for k in range(count - 1 if count > 2 else 0):  # 3
        if not proves_free(shop, rows[k], rows[k + 1], seen):
            rows[:straight] = before
            count = _rounds(shop, rows, straight, tries, True, random, lengths, seen)
            break
    return rows[:count].copy()


@compiled
def _rounds(
    shop: Held[Workshop], rows: Floats, count: int, tries: int, careful: bool, random: NDArray[np.uint64],
    lengths: Floats, seen: NDArray[np.int64],
) -> int:  # fmt: skip
    """Step 2 of `shorten`; how many points there are then. Arguments as `_cut_short`."""
    ends = np.empty((2, rows.shape[1]))
    for _ in range(ROUNDS):
        count = _cut_short(shop, rows, count, _one_in(SHARES, tries), careful, random, lengths, ends, seen)
        count = _leave_out_corners(shop, rows, count, seen)
        _pull_straight(shop, rows, count, _one_in(SWEEPS, tries), lengths, ends[0], seen)
    return count


@compiled
def _leave_out_corners(shop: Held[Workshop], rows: Floats, count: int, seen: NDArray[np.int64]) -> int:
    """After each point the furthest one follows that a straight motion reaches; how many points are left."""
    k = 0
    while k + 2 < count:
        j = count - 1
        while j > k + 1 and not proves_free(shop, rows[k], rows[j], seen):
            j -= 1
        gone = j - k - 1
        for i in range(k + 1, count - gone):
            rows[i] = rows[i + gone]
        count -= gone
        k += 1
    return count


@compiled
def _cut_short(
    shop: Held[Workshop], rows: Floats, count: int, tries: int, careful: bool, random: NDArray[np.uint64],
    lengths: Floats, ends: Floats, seen: NDArray[np.int64],
) -> int:  # fmt: skip
    """Straight motions between random places of a path; how many points it has then.

    1. Two places; the straight motion between them has to be shorter and free.
    2. It replaces the way between them.

    Args:
        rows: (count + 2 tries, n) at least, the path in the first ones; out.
        careful: whether what a shortcut leaves of the motions that it cuts is proved by itself.
        lengths, ends: arrays to work in, as long as `rows`, and (2, n).
    """
    first, second = ends[0], ends[1]
    for _ in range(tries):
        if count < 3:
            break
        lengths[0] = 0.0
        for i in range(1, count):
            lengths[i] = lengths[i - 1] + apart(rows[i], rows[i - 1])
        s, t = draw(random) * lengths[count - 1], draw(random) * lengths[count - 1]  # 1
        if s > t:
            s, t = t, s
        i = _place_on(rows, lengths, count, s, first)
        j = _place_on(rows, lengths, count, t, second)
        if i == j:
            continue
        away = apart(first, second)
        if away >= (t - s) * (1.0 - 1e-9) or not proves_free(shop, first, second, seen):
            continue
        if careful and not proves_free(shop, rows[i], first, seen):
            continue
        if careful and not proves_free(shop, second, rows[j + 1], seen):
            continue
        shift = j - i - 2  # 2
        if shift > 0:
            for m in range(j + 1, count):
                rows[m - shift] = rows[m]
        else:
            for m in range(count - 1, j, -1):
                rows[m - shift] = rows[m]
        rows[i + 1], rows[i + 2] = first, second
        count -= shift
    return count


@compiled
def _pull_straight(
    shop: Held[Workshop], rows: Floats, count: int, sweeps: int, shares: Floats, new: Floats, seen: NDArray[np.int64]
) -> None:  # fmt: skip
    """Each corner goes towards the chord between its neighbours as long as both motions stay free.

    1. A share of the way to the nearest place of the chord.
    2. Where that is not free, half of the share is tried in the next sweep.

    Args:
        sweeps: over all corners.
        shares, new: arrays to work in.
    """
    shares[:count] = 1.0
    for _ in range(sweeps):
        for k in range(1, count - 1):
            a, p, b = rows[k - 1], rows[k], rows[k + 1]
            if shares[k] < LEAST_PULL:
                continue
            _towards_chord(a, p, b, shares[k], new)  # 1
            old = apart(a, p) + apart(p, b)
            if apart(a, new) + apart(new, b) > (1.0 - LEAST_GAIN) * old:
                shares[k] = 0.0
            elif proves_free(shop, a, new, seen) and proves_free(shop, new, b, seen):
                rows[k] = new
            else:
                shares[k] *= 0.5  # 2


@compiled
def _towards_chord(a: Floats, p: Floats, b: Floats, share: float, out: Floats) -> None:
    """A point moved a share of the way to the nearest place between two others."""
    along, square = 0.0, 0.0
    for c in range(len(p)):
        along += (p[c] - a[c]) * (b[c] - a[c])
        square += (b[c] - a[c]) * (b[c] - a[c])
    t = min(1.0, max(0.0, along / square)) if square > 0.0 else 0.0
    for c in range(len(p)):
        out[c] = p[c] + share * (a[c] + t * (b[c] - a[c]) - p[c])


@compiled
def _place_on(rows: Floats, lengths: Floats, count: int, s: float, out: Floats) -> int:
    """The place at a length of a path, in `out`; the motion it lies on."""
    k = 0
    while k + 2 < count and lengths[k + 1] <= s:
        k += 1
    way = lengths[k + 1] - lengths[k]
    share = (s - lengths[k]) / way if way > 0.0 else 0.0
    for c in range(len(out)):
        out[c] = rows[k, c] + share * (rows[k + 1, c] - rows[k, c])
    return k
