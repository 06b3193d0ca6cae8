"""In which cells of a parameter a branch surely exists within the limits, compiled."""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false
from __future__ import annotations

from math import atan2, floor, hypot, pi

import numpy as np

from mafsil.ik.redundant.interval_loops import BIG, LANES, evaluated, plain, product
from mafsil.solvers.loops import compiled

SLACK = 1e-10
"""By how much a joint may be beyond its limit: rounding [rad | m]."""

MISS = 1e-12
"""By how much a step may miss: the postures then miss some times more [rad | m]."""


@compiled
def fixed_values(code, first, second, values):
    """What does not depend on the parameter, in place.

    Args:
        code, first, second: (k,) operation and places of its arguments; code -1 leaves the value.
        values: (k,) inputs and constants, then all of them.
    """
    for i in range(len(code)):
        if code[i] >= 0:
            values[i] = plain(code[i], values[first[i]], values[second[i]])


@compiled
def inside_cells(
    code, first, second, target, values, ports, slides, middle, half, cells, width, work, room, out, details
):
    """Cells in which a branch exists within the limits, those in which it does not left out.

    1. Take up to LANES cells from the list and evaluate the branch's program on all of them at once.
    2. A cell is inside if every joint's interval is within its limits and no step can miss; outside if one joint's is
       beyond, or a step misses surely.
    3. Where only one joint may cross only one of its limits, and its slope has one sign, the crossing is confined by
       Newton's interval step: what is before and after it is decided, what is left is a smaller cell.
    4. Any other cell is halved. Cells narrower than `width` are left undecided.

    Args:
        code, first, second, target: (k,) operation, places of its arguments (negative: -1 - place in `values`), place
            of the result.
        values: what does not depend on the parameter.
        ports: (2 n + 1) places of the branch's outputs.
        slides: (n,) which coordinates are lengths.
        middle, half: (n,) of the limits.
        cells: (m, 2) to begin with.
        width: below which cells are left undecided.
        work: most cells that are looked at; those that are then left are written with their ends exchanged.
        room: (registers, 5, LANES) to work in; register 0 is the parameter.
        out: (most, 2) cells inside, in no order.
        details: (2,) number of cells written; of undecided ones.
    """
    most = len(out)
    stack = np.empty((len(cells) + 64 * LANES, 2))
    depth = len(cells)
    stack[:depth] = cells
    radius = np.empty(LANES)
    inside = narrow = 0
    angle = np.empty(5)
    while depth > 0:
        count = min(depth, LANES)
        depth -= count
        tired = work <= 0 or inside + depth + 3 * LANES > most
        for l in range(LANES):
            k = depth + min(l, count - 1)
            lo, hi = stack[k, 0], stack[k, 1]
            radius[l] = 0.5 * (hi - lo)
            room[0, 0, l] = 0.5 * (lo + hi)
            room[0, 1, l], room[0, 2, l], room[0, 3, l], room[0, 4, l] = lo, hi, 1.0, 1.0
        taken = stack[depth : depth + count].copy()
        evaluated(code, first, second, target, values, radius, room)
        work -= count
        for l in range(count):
            lo, hi = taken[l, 0], taken[l, 1]
            unsure, begin, end, rising = _judged(ports, slides, middle, half, values, room, l, lo, hi, angle)
            if unsure < 0:
                continue
            if unsure == 0:
                out[inside, 0], out[inside, 1] = lo, hi
                inside += 1
                continue
            if unsure == 1:
                # One crossing at most: inside before it, or after it where it rises into the limits.
                if begin > end:
                    unsure = 2
                elif rising and end < hi:
                    out[inside, 0], out[inside, 1] = end, hi
                    inside += 1
                elif not rising and begin > lo:
                    out[inside, 0], out[inside, 1] = lo, begin
                    inside += 1
            if unsure > 1:
                begin, end = lo, hi
            if end - begin <= width:
                narrow += 1
            elif tired or depth + 2 > len(stack):
                # Told apart by their order: their ends are exchanged.
                out[inside, 0], out[inside, 1] = end, begin
                inside += 1
            elif unsure == 1 and end - begin < 0.4 * (hi - lo):
                stack[depth, 0], stack[depth, 1] = begin, end
                depth += 1
            else:
                centre = 0.5 * (begin + end)
                stack[depth, 0], stack[depth, 1] = begin, centre
                stack[depth + 1, 0], stack[depth + 1, 1] = centre, end
                depth += 2
    details[0], details[1] = inside, narrow


@compiled
def _judged(ports, slides, middle, half, values, room, l, lo, hi, angle):
    """What is sure of one cell: 0 inside, 1 inside but for one crossing, more: nothing, -1 outside.

    With it the ends of the part in which the crossing lies, and whether the branch is inside after it.
    """
    n, r = len(slides), 0.5 * (hi - lo)
    short_low, short_high = _bounds(ports[2 * n], values, room, l)
    if short_low > MISS:
        return -1, lo, hi, True
    unsure = 0 if short_high <= MISS else 2
    begin, end, rising = lo, hi, True
    for j in range(n):
        if not half[j] < 1e100 or (not slides[j] and half[j] >= pi):
            continue
        _enclosed(ports[2 * j], ports[2 * j + 1], slides[j], values, room, l, r, angle)
        e, turn, h = angle[0] - middle[j], 1e300, half[j]
        if not slides[j]:
            turn = 2 * pi
            e -= turn * floor(e / turn + 0.5)
        low, high = e + angle[1], e + angle[2]
        if low >= -h - SLACK and high <= h + SLACK:
            continue
        if (low > h + SLACK and high < turn - h - SLACK) or (high < -h - SLACK and low > h + SLACK - turn):
            return -1, lo, hi, True
        unsure += 1
        at_top = high > h and low > -h and high < turn - h
        at_bottom = low < -h and high < h and low > h - turn
        steep = angle[3] > 0.0 or angle[4] < 0.0
        if not steep or not (at_top or at_bottom) or abs(angle[3]) > 1e8 or abs(angle[4]) > 1e8:
            unsure += 1
            continue
        way = (h if at_top else -h) - e
        near, far = way / angle[3], way / angle[4]
        if near > far:
            near, far = far, near
        centre = 0.5 * (lo + hi)
        dust = 1e-14 + 4e-16 * abs(centre)
        begin, end = max(lo, centre + near - dust), min(hi, centre + far + dust)
        rising = (angle[3] > 0.0) == at_bottom
    return unsure, begin, end, rising


@compiled
def _bounds(place, values, room, l):
    """The interval of an output on a cell."""
    if place < 0:
        return values[-1 - place], values[-1 - place]
    return room[place, 1, l], room[place, 2, l]


@compiled
def _enclosed(c, s, slides, values, room, l, r, out):
    """A coordinate on a cell: value at the middle, interval about that, and interval of the slope."""
    x0, xl, xh, xdl, xdh = _all_of(c, values, room, l)
    if slides:
        out[0], out[1], out[2], out[3], out[4] = x0, xl - x0, xh - x0, xdl, xdh
        return
    y0, yl, yh, ydl, ydh = _all_of(s, values, room, l)
    size = hypot(x0, y0)
    out[0], out[1], out[2], out[3], out[4] = atan2(y0, x0), -pi, pi, -BIG, BIG
    if not (size > 0.0 and size < BIG):
        return
    # Seen in the frame of the middle: u along it, v across it.
    a, b = x0 / size, y0 / size
    ul, uh = _sum(_scaled_low(xl, xh, a), _scaled_high(xl, xh, a), _scaled_low(yl, yh, b), _scaled_high(yl, yh, b))
    vl, vh = _sum(_scaled_low(yl, yh, a), _scaled_high(yl, yh, a), _scaled_low(xl, xh, -b), _scaled_high(xl, xh, -b))
    if not ul > 0.0:
        return
    out[1] = atan2(vl, ul if vl < 0.0 else uh)
    out[2] = atan2(vh, ul if vh > 0.0 else uh)
    # The slope of the angle: (u dv - v du) / (u u + v v).
    dul, duh = _sum(
        _scaled_low(xdl, xdh, a), _scaled_high(xdl, xdh, a), _scaled_low(ydl, ydh, b), _scaled_high(ydl, ydh, b)
    )
    dvl, dvh = _sum(
        _scaled_low(ydl, ydh, a), _scaled_high(ydl, ydh, a), _scaled_low(xdl, xdh, -b), _scaled_high(xdl, xdh, -b)
    )
    pl, ph = product(ul, uh, dvl, dvh)
    ql, qh = product(vl, vh, dul, duh)
    tl, th = pl - qh, ph - ql
    v = 0.0 if vl <= 0.0 <= vh else min(abs(vl), abs(vh))
    w = max(abs(vl), abs(vh))
    small, large = ul * ul + v * v, uh * uh + w * w
    out[3] = tl / (small if tl < 0.0 else large)
    out[4] = th / (small if th > 0.0 else large)
    rad = r * max(abs(out[3]), abs(out[4]))
    out[1], out[2] = max(out[1], -rad), min(out[2], rad)


@compiled
def _all_of(place, values, room, l):
    if place < 0:
        x = values[-1 - place]
        return x, x, x, 0.0, 0.0
    return room[place, 0, l], room[place, 1, l], room[place, 2, l], room[place, 3, l], room[place, 4, l]


@compiled
def _scaled_low(lo, hi, k):
    return k * lo if k >= 0 else k * hi


@compiled
def _scaled_high(lo, hi, k):
    return k * hi if k >= 0 else k * lo


@compiled
def _sum(al, ah, bl, bh):
    return al + bl, ah + bh
