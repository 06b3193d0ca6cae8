"""RRT-Connect on the configurations that keep something, compiled: steps are projected onto them and proved between.

Nodes keep the constraints to the aim of projections; the straight motion between two of them keeps them to their
limits, proved by `kept_loops.keeps`. So a path is a chain of short motions where the constraints bend, of long ones
where not.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.workshop_loops import Workshop
from mafsil.kernels.loops.entry import Held, open_held
from mafsil.kernels.loops.loop import compiled
from mafsil.planning.arm_search_loops import (
    FULL,
    GROWING,
    JOINED,
    Forests,
    add,
    apart,
    draw,
    looks_free,
    nearest,
    proves_free,
    way_is_proved,
    write_path,
)
from mafsil.planning.kept_loops import Kept, Sheet, keeps, project, sheet_for

CHAIN = 400
"""Motions that one steering makes at most."""
SHORTEST = 1.0 / 16.0
"""Of the longest step: below it a motion that is not proved to keep the constraints ends the steering."""
PROGRESS = 0.1
"""Share of a step by which the target must come nearer."""


@compiled
def steer(
    shop: Held[Workshop], kept: Kept, slack: float, a: Floats, b: Floats, exact: bool, step: float, reach: float,
    rows: Floats, sheet: Sheet, seen: NDArray[np.int64],
) -> tuple[int, bool]:  # fmt: skip
    """Points from a towards b on what keeps the constraints, in `rows`; how many, and whether b is the last.

    1. A step straight towards b, projected; at b itself there is nothing to project.
    2. It must come nearer to b and not leap; if the motion is not proved to keep the limits, half the step is tried.
    3. The motion must look free.

    Args:
        shop: what is free.
        kept: the constraints.
        slack: share of the limits that may be used.
        a, b: (n,); a keeps the constraints.
        exact: whether b keeps them, too.
        step: longest motion.
        reach: way after which it ends.
        rows: (CHAIN, n) out.
        sheet: to work in.
        seen: (3,) counts.
    """
    count, now, new, size, way, kinematics = 0, sheet.q[0], sheet.q[1], step, 0.0, open_held(shop).world.kinematics
    for c in range(len(a)):
        now[c] = a[c]
    while count < CHAIN and way < reach:
        left = apart(now, b)
        if left == 0.0:
            return count, True
        last = left <= size
        share = 1.0 if last else size / left  # 1
        for c in range(len(a)):
            new[c] = b[c] if last else now[c] + share * (b[c] - now[c])
        if not (last and exact) and not project(kept, kinematics, new, sheet):
            return count, False
        moved, ahead = apart(now, new), apart(new, b)
        if moved == 0.0 or ahead > left - PROGRESS * min(size, left):  # 2
            return count, False
        if moved > 2.0 * size or not keeps(kept, kinematics, now, new, slack, sheet):
            size /= 2.0
            if size < SHORTEST * step:
                return count, False
            continue
        if not looks_free(shop, now, new, seen):  # 3
            return count, False
        way += moved
        for c in range(len(a)):
            rows[count, c] = now[c] = new[c]
        count += 1
        if last and ahead == 0.0:
            return count, True
        size = min(step, 2.0 * size)
    return count, False


@compiled
def grow_kept(
    shop: Held[Workshop], kept: Kept, slack: float, lower: Floats, upper: Floats, step: float, reach: float,
    iterations: int, forests: Forests,
) -> int:  # fmt: skip
    """Both sides grow until a path of proved motions joins start and goal: JOINED, GROWING, or FULL.

    1. The side with fewer nodes is steered towards a sample, from its nearest node, as far as `reach`.
    2. The other side is steered towards the last new node, from its own nearest one.
    3. If it arrives, the motions of the path are proved free; one that cannot be is cut off, and growing goes on.

    Args:
        shop: what is free.
        kept, slack, step, reach: as for `steer`.
        lower, upper: (n,) of the samples.
        iterations: samples before it comes back.
        forests: the roots stand in them.

    Reference:
        D. Berenson, S. Srinivasa, J. Kuffner, Task space regions, IJRR 30(12), 2011 (CBiRRT2).
    """
    sheet, n = sheet_for(kept), len(lower)
    sample, rows = np.empty(n), np.empty((CHAIN, n))
    most = forests.q.shape[1]
    for _ in range(iterations):
        ours = 0 if forests.sizes[0] <= forests.sizes[1] else 1
        theirs = 1 - ours
        if max(forests.sizes[0], forests.sizes[1]) + CHAIN >= most:
            return FULL
        for c in range(n):  # 1
            sample[c] = lower[c] + draw(forests.random) * (upper[c] - lower[c])
        mine = nearest(forests, ours, sample)
        count, _ = steer(
            shop, kept, slack, forests.q[ours, mine], sample, False, step, reach, rows, sheet, forests.seen
        )
        if count == 0:
            continue
        for k in range(count):
            mine = add(forests, ours, rows[k], mine, False)
        goal = forests.q[ours, mine]
        other = nearest(forests, theirs, goal)  # 2
        count, arrived = steer(
            shop, kept, slack, forests.q[theirs, other], goal, True, step, np.inf, rows, sheet, forests.seen
        )
        for k in range(count):
            other = add(forests, theirs, rows[k], other, False)
        if not arrived:
            continue
        at_start, at_goal = (mine, other) if ours == 0 else (other, mine)  # 3
        if way_is_proved(shop, forests, 0, at_start) and way_is_proved(shop, forests, 1, at_goal):
            write_path(forests, at_start, at_goal)
            return JOINED
    return GROWING


@compiled
def _chain_is_proved(shop: Held[Workshop], a: Floats, rows: Floats, count: int, seen: NDArray[np.int64]) -> bool:
    k = 0
    while k < count and proves_free(shop, a if k == 0 else rows[k - 1], rows[k], seen):
        k += 1
    return k == count


@compiled
def _length(a: Floats, rows: Floats, count: int) -> float:
    total = 0.0
    for k in range(count):
        total += apart(a if k == 0 else rows[k - 1], rows[k])
    return total


@compiled
def steer_to_first_goal(
    shop: Held[Workshop], kept: Kept, slack: float, a: Floats, goals: Floats, step: float, seen: NDArray[np.int64]
) -> Floats:
    """A proved chain (m, n) steered from a to the first of (k, n) goals that it reaches; empty if to none."""
    sheet, rows = sheet_for(kept), np.empty((CHAIN, len(a)))
    for k in range(len(goals)):
        count, arrived = steer(shop, kept, slack, a, goals[k], True, step, np.inf, rows, sheet, seen)
        if arrived and _chain_is_proved(shop, a, rows, count, seen):
            return rows[:count].copy()
    return rows[:0].copy()


@compiled
def shorten_kept(
    shop: Held[Workshop], kept: Kept, slack: float, path: Floats, step: float, tries: int,
    random: NDArray[np.uint64], seen: NDArray[np.int64],
) -> Floats:  # fmt: skip
    """A path of proved motions made shorter: chains steered between two of its points replace longer ways.

    Args:
        shop: what is free.
        kept, slack, step: as for `steer`.
        path: (k, n) proved.
        tries: pairs of points that are tried.
        random: (1,) state of the source of samples.
        seen: (3,) counts.
    """
    sheet, n = sheet_for(kept), path.shape[1]
    rows, now = np.empty((CHAIN, n)), path.copy()
    for _ in range(tries):
        if len(now) < 3:
            break
        i, j = int(draw(random) * len(now)), int(draw(random) * len(now))
        i, j = min(i, j), max(i, j)
        if j - i < 2:
            continue
        before = _length(now[i], now[i + 1 : j + 1], j - i)
        if apart(now[i], now[j]) >= before * (1.0 - 1e-6):
            continue
        count, arrived = steer(shop, kept, slack, now[i], now[j], True, step, before, rows, sheet, seen)
        if not arrived or _length(now[i], rows, count) >= before * (1.0 - 1e-6):
            continue
        if _chain_is_proved(shop, now[i], rows, count, seen):
            now = np.concatenate((now[: i + 1], rows[:count], now[j + 1 :]))
    return now
