"""Paths of proved motions made shorter by proved motions, compiled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.workshop_loops import Workshop
from mafsil.kernels.loops.entry import Held
from mafsil.kernels.loops.loop import compiled, inlined
from mafsil.planning.arm_search_loops import apart, draw, proves_free

ROUNDS, SHARES, SWEEPS = 2, 6, 24
"""Rounds of shortening; of the tries, each makes one in SHARES shortcuts and one in SWEEPS rounds over the corners."""
LEAST_PULL, LEAST_GAIN = 0.1, 3e-3
"""Shares of the way to the chord, and of the length of its motions, below which a corner stays."""


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
