"""Eight paths timed side by side, compiled: rows of every interval, both passes, and the proof of what came out.

1. Limits, lengths and end velocities into lanes; lanes without a path of their own do the last path again.
2. Forth: per interval the caps of velocity, valid everywhere inside; a corner is a stop.
3. Back: the rows of acceleration as lines, and the sets from which the end can be reached.
4. Forth: always the largest velocity that lines and sets allow.
5. The duration, and the largest excess of a Bernstein coefficient over its limit: a bound of every excess.

Paths of fewer intervals than the longest of the eight are at rest in their lanes beyond their end. Of long paths only
one stretch of rows is kept at a time: each pass makes them again, which is sooner done than fetched from memory.
"""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false, reportUnknownParameterType=false
# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false
from __future__ import annotations

import numpy as np

from mafsil.kernels.loops.lanes import (
    any_lane,
    buffer,
    get,
    in_lanes,
    lanes,
    magnitude,
    part,
    put,
    seen,
    square_root,
    where,
)
from mafsil.kernels.loops.loop import compiled
from mafsil.trajectory.timing.path_grid_loops import (
    CAP,
    HIGH,
    LANES,
    LENGTH,
    LINE,
    LOSS,
    LOW,
    PLACE,
    STRETCH,
    WHOLE,
    Asked,
    Found,
    Grids,
    X,
    eight_of,
)
from mafsil.trajectory.timing.path_rows_loops import (
    FREE,
    beyond,
    chosen_of,
    lanes_that_turn,
    larger,
    largest_square,
    lesser,
    line_of,
    part_weights,
    row_of,
    slope_controls,
    taken,
    used_at_ends,
    velocity_caps,
    velocity_shares,
)
from mafsil.trajectory.timing.reachability_loops import bounds_at, least_at_start, most_at_start
from mafsil.trajectory.tolerances import ROUNDING


@compiled
def controls_of(grids, eight, base, choose, slopes):
    """Step 2: slopes' Bernstein coefficients and shares of a stretch's intervals.

    1. The intervals of the eight paths into lanes; the polynomial only where a path comes to its next piece.
    2. The coefficients there.

    Args:
        grids: of all paths.
        eight: of `eight_of`.
        base: first interval of the stretch.
        choose: of `chosen_of`.
        slopes: (m + 1) n + n + (m + 1)^2 lanes to work in.
    """
    m, n, own, paths = eight.m, eight.n, (eight.m + 1) * eight.n, len(grids.begins) - 1
    before, edge = np.full(LANES, -1), buffer(2)
    factors, weights = part(slopes, own), part(slopes, own + n)
    for i in range(base, min(base + eight.stretch, eight.most)):
        # 1.
        for lane in range(LANES):
            b, at = min(eight.first + lane, paths - 1), eight.here[lane] + min(i, eight.last[lane] - 1)
            k = grids.piece[at]
            put(edge, 0, lane, grids.s[at + 1] - grids.s[at])
            put(edge, 1, lane, grids.s[at] - grids.knots[grids.firsts[b] + b + k])
            if k != before[lane]:
                taken(grids.coefficients[grids.firsts[b] + k], slopes, lane)
                before[lane] = k
        # 2.
        h, controls = edge[0], part(eight.D, (i - base + 1) * own)
        part(eight.places, PLACE * i)[LENGTH] = h
        part_weights(edge[1], h, choose, m, weights)
        slope_controls(slopes, m, n, weights, controls)
        velocity_shares(controls, m, n, eight.slowness, factors, part(eight.shares, (i - base) * (m + 1)))


@compiled
def cap_velocities(grids, eight, base, choose):
    """Step 2: the caps of velocity at the ends of a stretch's intervals.

    At a corner the cap is zero; in lanes beyond their end nothing changes.

    Args:
        grids, eight, base, choose: as in `controls_of`, after that.
    """
    m, n, own, pieces = eight.m, eight.n, (eight.m + 1) * eight.n, buffer(1)
    for i in range(base, min(base + eight.stretch, eight.most)):
        place, then = part(eight.places, PLACE * i), part(eight.places, PLACE * (i + 1))
        begin, finish = velocity_caps(part(eight.shares, (i - base) * (m + 1)), m, place[LENGTH], choose)
        changed = False
        for lane in range(LANES):
            at = eight.here[lane] + i
            comes = 0 < i < eight.last[lane] and grids.piece[at] != grids.piece[at - 1]
            put(pieces, 0, lane, 1.0 if comes else 0.0)
            changed |= comes
        if changed:
            controls = part(eight.D, (i - base + 1) * own)
            ending, length = part(eight.D, (i - base) * own + m * n), part(place, -PLACE)[LENGTH]
            corner = lanes_that_turn(ending, length, controls, place[LENGTH], n) & (pieces[0] > 0.0)
            begin = where(corner, 0.0, begin)
        inside = eight.lengths > float(i)
        place[CAP] = where(inside, lesser(begin, place[CAP]), place[CAP])
        then[CAP] = where(inside, lesser(finish, then[CAP]), then[CAP])
    D, following = eight.D, part(eight.D, eight.stretch * own)
    for k in range(own):
        D[k] = following[k]


@compiled
def lines_of(eight, asked, base, i):
    """The rows of one interval as lines, and the largest x they allow that do not speak about y.

    Args:
        eight, asked, base: as in `controls_of` and `eight_of`.
        i: the interval.

    Returns:
        Slopes, upper and lower bounds; the largest x; the largest magnitude of alpha.
    """
    m, n, place = eight.m, eight.n, part(eight.places, PLACE * i)
    controls, y_cap = part(eight.D, (i - base + 1) * (m + 1) * n), place[PLACE + CAP]
    square, slope = place[LENGTH] * place[LENGTH], part(eight.lines, LINE * eight.rows * (i - base))
    above, below = part(slope, eight.rows), part(slope, 2 * eight.rows)
    most, motion, at = lanes(FREE), lanes(0.0), 0
    for k in range(m + 1):
        for j in range(n):
            alpha, beta = row_of(controls, m, n, k, j)
            low, high = eight.bounds[j] * square, eight.bounds[n + j] * square
            slope[at], above[at], below[at], bound = line_of(alpha, beta, low, high, y_cap)
            most, motion, at = lesser(bound, most), larger(magnitude(alpha), motion), at + 1
    for k in range(asked.rows.shape[2]):
        alpha, beta = lanes(asked.rows[0, i, k]), lanes(asked.rows[1, i, k])
        low, high = lanes(asked.bounds[0, i, k]), lanes(asked.bounds[1, i, k])
        slope[at], above[at], below[at], bound = line_of(alpha, beta, low, high, y_cap)
        most, motion, at = lesser(bound, most), larger(magnitude(alpha), motion), at + 1
    return slope, above, below, most, motion


@compiled
def passed_back(grids, eight, asked, choose, slopes):
    """Step 3: the sets from which the end can be reached.

    Args:
        grids, eight, choose, slopes: as in `controls_of`.
        asked: as in `eight_of`.

    Returns:
        Of each lane the place that stops the pass, or -1; whether there is any motion.
    """
    resting, rows, edge = True, eight.rows, buffer(1)
    for k in range(asked.rows.shape[2]):
        for i in range(asked.rows.shape[1]):
            resting &= asked.bounds[0, i, k] <= 0.0 <= asked.bounds[1, i, k]
    for lane in range(LANES):
        put(edge, 0, lane, get(eight.places, PLACE * eight.last[lane] + CAP, lane))
    low, high = larger(eight.end, lanes(0.0)), where(eight.end >= 0.0, eight.end, edge[0])
    blocked, motion = where(high > edge[0] * (1.0 + ROUNDING), eight.lengths, -1.0), lanes(0.0)
    last = part(eight.places, PLACE * eight.most)
    last[LOW], last[HIGH] = low, high
    # 3.
    base = (eight.most - 1) // eight.stretch * eight.stretch
    for i in range(eight.most - 1, -1, -1):
        if i < base:
            base -= eight.stretch
            controls_of(grids, eight, base, choose, slopes)
        inside, place = eight.lengths > float(i), part(eight.places, PLACE * i)
        going = inside & (blocked < 0.0)
        slope, above, below, most, size = lines_of(eight, asked, base, i)
        motion = larger(where(inside, size, 0.0), motion)
        place[CAP] = where(inside, lesser(most, place[CAP]), place[CAP])
        found = most_at_start(slope, above, below, rows, low, high, place[CAP])
        stops, least = going & (found < 0.0), lanes(0.0)
        if not resting or any_lane(going & (low > 0.0)):
            least = least_at_start(slope, above, below, rows, low, high, found)
            if resting:
                least = where(low > 0.0, least, 0.0)
        blocked = where(stops, float(i), blocked)
        low, high = where(going, least, low), where(going, found, high)
        place[LOW], place[HIGH] = low, where(inside & ~going, 0.0, high)
    return blocked, motion


@compiled
def start_square(eight, blocked):
    """Step 4: the square of the path velocity at the start.

    Args:
        eight: after `passed_back`.
        blocked: what that returned.

    Returns:
        Of each lane the place that stops a pass, or -1.
    """
    first = part(eight.places, 0)
    x = where(eight.start >= 0.0, eight.start, first[HIGH])
    starts = (x >= first[LOW] * (1.0 - ROUNDING)) & (x <= first[HIGH] * (1.0 + ROUNDING))
    first[X] = x
    return where((blocked < 0.0) & ~starts, 0.0, blocked)


@compiled
def passed_forth(eight, base):
    """Step 4: the squares of the path velocity on a stretch.

    Args:
        eight, base: as in `controls_of`, with lines.
    """
    rows = eight.rows
    x = part(eight.places, PLACE * base)[X]
    for i in range(base, min(base + eight.stretch, eight.most)):
        then, slope = part(eight.places, PLACE * (i + 1)), part(eight.lines, LINE * rows * (i - base))
        low, high = then[LOW], then[HIGH]
        upper, lower = bounds_at(slope, part(slope, rows), part(slope, 2 * rows), rows, low, high, x)
        x = where(upper < lower, larger(larger(upper, lesser(lower, high)), lanes(0.0)), upper)
        then[X] = x


@compiled
def measure_loss(eight, asked, base, choose, finer, total, worst):
    """Step 5: durations and excesses; of every interval its loss, if a finer grid is to come.

    Args:
        eight, asked, base: after both passes over a stretch.
        choose: of `chosen_of`.
        finer: whether losses are asked for.
        total, worst: duration and largest excess up to here.
    """
    m, n, own = eight.m, eight.n, (eight.m + 1) * eight.n
    for i in range(base, min(base + eight.stretch, eight.most)):
        inside, place = eight.lengths > float(i), part(eight.places, PLACE * i)
        controls, shares = part(eight.D, (i - base + 1) * own), part(eight.shares, (i - base) * (m + 1))
        h, x, y = place[LENGTH], place[X], place[PLACE + X]
        square, excess = h * h, lanes(0.0)
        passing = 2.0 * h / (square_root(x) + square_root(y))
        total = where(inside, total + passing, total)
        for k in range(m + 1):
            for j in range(n):
                alpha, beta = row_of(controls, m, n, k, j)
                low, high = eight.bounds[j] * square, eight.bounds[n + j] * square
                excess = larger(beyond(alpha * x + beta * y, low, high) * eight.smallness[j], excess)
        excess = excess / square
        for k in range(asked.rows.shape[2]):
            low, high = asked.bounds[0, i, k], asked.bounds[1, i, k]
            over = beyond(asked.rows[0, i, k] * x + asked.rows[1, i, k] * y, lanes(low), lanes(high))
            excess = larger(over / max(high, -low, 1.0 / FREE), excess)
        reached = largest_square(shares, m, x / square, y / square, choose)
        excess = where(reached > 1.0, larger(square_root(reached) - 1.0, excess), excess)
        worst = where(inside, larger(excess, worst), worst)
        if finer:
            begin, finish = used_at_ends(controls, m, n, eight.bounds, h, x, y, shares)
            used = 0.5 * (lesser(begin, lanes(1.0)) + lesser(finish, lanes(1.0)))
            place[LOSS] = passing * larger(1.0 - used, lanes(0.0))
    return total, worst


@compiled
def eight_timed(grids, asked, first, finer, memory, found):
    """All steps for eight paths, in place.

    Args:
        grids, asked: of all paths.
        first: of the eight.
        finer: whether losses are asked for.
        memory: of `eight_of`.
        found: of all paths.
    """
    caps, low, high, x, loss, durations, stopped, excess = found
    choose = chosen_of(grids.coefficients.shape[1] - 2)
    limits, eight = eight_of(grids, asked, first, memory)
    n, own = eight.n, (eight.m + 1) * eight.n
    work = in_lanes(own + n + (eight.m + 1) * (eight.m + 1))
    slopes, total, worst = seen(work), lanes(0.0), lanes(0.0)
    stretches = (eight.most + eight.stretch - 1) // eight.stretch
    # 2.
    for k in range(stretches):
        base = k * eight.stretch
        controls_of(grids, eight, base, choose, slopes)
        cap_velocities(grids, eight, base, choose)
    # 3.
    blocked, motion = passed_back(grids, eight, asked, choose, slopes)
    # 4. and 5.
    blocked = start_square(eight, blocked)
    for k in range(stretches):
        base = k * eight.stretch
        if base > 0:
            controls_of(grids, eight, base, choose, slopes)
            for i in range(base, min(base + eight.stretch, eight.most)):
                lines_of(eight, asked, base, i)
        passed_forth(eight, base)
        total, worst = measure_loss(eight, asked, base, choose, finer, total, worst)
    summary = buffer(4)
    summary[0], summary[1], summary[2], summary[3] = blocked, motion, total, worst
    for lane in range(min(LANES, len(durations) - first)):
        b, here, count = first + lane, eight.here[lane], eight.last[lane] + 1
        stop, moves = int(get(summary, 0, lane)), get(summary, 1, lane) > 0.0
        timed = moves and stop < 0
        stopped[b] = stop if moves else -1
        durations[b] = get(summary, 2, lane) if timed else (np.inf if moves else 0.0)
        excess[b] = get(summary, 3, lane) if timed else (np.inf if moves else 0.0)
        for i in range(count):
            caps[here + i] = get(eight.places, PLACE * i + CAP, lane)
            low[here + i] = get(eight.places, PLACE * i + LOW, lane) if moves else 0.0
            high[here + i] = get(eight.places, PLACE * i + HIGH, lane) if moves else 0.0
            x[here + i] = get(eight.places, PLACE * i + X, lane) if timed else 0.0
            loss[here + i] = get(eight.places, PLACE * i + LOSS, lane) if timed and finer and i < count - 1 else 0.0
    return limits, work


@compiled
def lanes_timed(grids: Grids, asked: Asked, first: int, last: int, finer: bool, found: Found) -> None:
    """The paths from `first` up to `last`, eight at a time, in place; arguments as in `eight_timed`."""
    m, n = grids.coefficients.shape[1] - 2, grids.coefficients.shape[2]
    own, rows, most = (m + 1) * n, (m + 1) * n + asked.rows.shape[2], 1
    for b in range(first, last):
        most = max(most, grids.begins[b + 1] - grids.begins[b])
    kept = max(WHOLE, STRETCH) if most > WHOLE else most
    memory = (
        in_lanes(PLACE * (most + 1)),
        in_lanes((kept + 1) * own),
        in_lanes(kept * (m + 1)),
        in_lanes(LINE * kept * rows),
    )
    for b in range(first, last, LANES):
        eight_timed(grids, asked, b, finer, memory, found)
