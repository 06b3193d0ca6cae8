"""In which cells of a parameter a branch surely exists within the limits, compiled."""

from __future__ import annotations

from math import atan2, floor, hypot, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.ik.redundant.interval_loops import (
    BIG,
    DHI,
    DLO,
    HI,
    LANES,
    LO,
    Codes,
    M,
    Program,
    evaluate,
    plain,
    product,
)
from mafsil.ik.tolerances import CELL_SLACK, RELATIVELY, SLIGHT, STEP_RESIDUAL
from mafsil.kernels.loops.loop import compiled

UNLIMITED, ENDLESS = 1e100, 1e300
"""Half widths of limits from which there are none; period of coordinates that have none."""

STEEPEST = 1e8
"""Slope from which a crossing is not confined by Newton's step: its cell would be one of rounding, 1 / sqrt(eps)."""


@compiled
def fixed_values(code: Codes, first: Codes, second: Codes, values: Floats) -> None:
    """What does not depend on the parameter, in place.

    Args:
        code, first, second: (k,) operation and places of its arguments; code -1 leaves the value.
        values: (k,) inputs and constants, then all of them.
    """
    for i in range(len(code)):
        if code[i] >= 0:
            values[i] = plain(code[i], values[int(first[i])], values[int(second[i])])


class Limits(NamedTuple):
    """Of the coordinates.

    Attributes:
        prismatic: (n,) which coordinates are lengths.
        middle, half: (n,) of the limits.
    """

    prismatic: NDArray[np.bool_]
    middle: Floats
    half: Floats


OUTSIDE, INSIDE, CROSSING, UNSURE = -1, 0, 1, 2
"""What is sure of a cell: outside, inside, inside but for one crossing of one limit, nothing."""


@compiled
def inside_cells(
    program: Program, limits: Limits, cells: Floats, width: float, work: int, registers: Floats, out: Floats
) -> tuple[int, int]:
    """Cells in which a branch exists within the limits, those in which it does not left out.

    1. Take up to LANES cells from the stack and evaluate the branch's program on all of them at once.
    2. A cell is inside if every joint's interval is within its limits and every step exists; outside if one joint's is
       beyond, or a step surely does not exist.
    3. Where only one joint may cross only one of its limits, and its slope has one sign, the crossing is confined by
       Newton's interval step: what is before and after it is decided, what is left is a smaller cell.
    4. Any other cell is halved. Cells narrower than `width` are left undecided, and so are all when the work is done.

    Args:
        program: of the branch.
        limits: of its coordinates.
        cells: (m, 2) to begin with.
        width: below which cells are left undecided.
        work: most cells that are looked at; those that are then left are written with their ends exchanged.
        registers: (registers, 5, LANES) scratch; register 0 is the parameter.
        out: (most, 2) cells inside, in no order.

    Returns:
        Number of cells written; of undecided ones.
    """
    most = len(out)
    stack = np.empty((len(cells) + 64 * LANES, 2))
    depth = len(cells)
    stack[:depth] = cells
    radius, angle = np.empty(LANES), np.empty(5)
    inside = narrow = 0
    while depth > 0:
        # 1.
        count = min(depth, LANES)
        depth -= count
        exhausted = work <= 0 or inside + depth + 3 * LANES > most
        for l in range(LANES):
            k = depth + min(l, count - 1)
            lo, hi = stack[k, 0], stack[k, 1]
            radius[l] = 0.5 * (hi - lo)
            registers[0, M, l] = 0.5 * (lo + hi)
            registers[0, LO, l], registers[0, HI, l], registers[0, DLO, l], registers[0, DHI, l] = lo, hi, 1.0, 1.0
        taken = stack[depth : depth + count].copy()
        evaluate(program, radius, registers)
        work -= count
        for l in range(count):
            # 2.
            lo, hi = taken[l, 0], taken[l, 1]
            found, begin, end, rising = _judge(program, limits, registers, l, lo, hi, angle)
            if found == OUTSIDE:
                continue
            if found == INSIDE:
                out[inside, 0], out[inside, 1] = lo, hi
                inside += 1
                continue
            # 3. Inside before the crossing, or after it where the joint rises into the limits.
            if found == CROSSING:
                if begin > end:
                    found = UNSURE
                elif rising and end < hi:
                    out[inside, 0], out[inside, 1] = end, hi
                    inside += 1
                elif not rising and begin > lo:
                    out[inside, 0], out[inside, 1] = lo, begin
                    inside += 1
            # 4.
            if found >= UNSURE:
                begin, end = lo, hi
            if end - begin <= width:
                narrow += 1
            elif exhausted or depth + 2 > len(stack):
                out[inside, 0], out[inside, 1] = end, begin
                inside += 1
            elif found == CROSSING and end - begin < 0.4 * (hi - lo):
                stack[depth, 0], stack[depth, 1] = begin, end
                depth += 1
            else:
                centre = 0.5 * (begin + end)
                stack[depth, 0], stack[depth, 1] = begin, centre
                stack[depth + 1, 0], stack[depth + 1, 1] = centre, end
                depth += 2
    return inside, narrow


@compiled
def _judge(
    program: Program, limits: Limits, registers: Floats, l: int, lo: float, hi: float, angle: Floats
) -> tuple[int, float, float, bool]:
    """What is sure of one cell; the ends of the part in which a crossing lies; whether the branch is inside after it.

    1. The residual of the steps: outside where it is surely too large, unsure where it may be.
    2. Each joint's interval about the middle of its limits, angles wound there: within, or beyond, or neither.
    3. Of a joint that may cross one limit with a slope of one sign, Newton's interval step from the middle of the cell.

    Args:
        program, limits: of the branch.
        registers: (registers, 5, LANES) evaluated.
        l: lane of the cell.
        lo, hi: its ends.
        angle: (5,) scratch.
    """
    values, ports = program.values, program.ports
    n, r = len(limits.middle), 0.5 * (hi - lo)
    # 1.
    least, most = _bounds(ports[2 * n], values, registers, l)
    if least > STEP_RESIDUAL:
        return OUTSIDE, lo, hi, True
    found = INSIDE if most <= STEP_RESIDUAL else UNSURE
    begin, end, rising = lo, hi, True
    for j in range(n):
        prismatic, h = limits.prismatic[j], limits.half[j]
        if not h < UNLIMITED or (not prismatic and h >= pi):
            continue
        # 2.
        _enclose(ports[2 * j], ports[2 * j + 1], prismatic, values, registers, l, r, angle)
        e, turn = angle[M] - limits.middle[j], ENDLESS
        if not prismatic:
            turn = 2 * pi
            e -= turn * floor(e / turn + 0.5)
        low, high = e + angle[LO], e + angle[HI]
        if low >= -h - CELL_SLACK and high <= h + CELL_SLACK:
            continue
        if (low > h + CELL_SLACK and high < turn - h - CELL_SLACK) or (
            high < -h - CELL_SLACK and low > h + CELL_SLACK - turn
        ):
            return OUTSIDE, lo, hi, True
        found += 1
        # 3.
        at_top = high > h and low > -h and high < turn - h
        at_bottom = low < -h and high < h and low > h - turn
        steep = angle[DLO] > 0.0 or angle[DHI] < 0.0
        if not steep or not (at_top or at_bottom) or abs(angle[DLO]) > STEEPEST or abs(angle[DHI]) > STEEPEST:
            found += 1
            continue
        way = (h if at_top else -h) - e
        near, far = way / angle[DLO], way / angle[DHI]
        if near > far:
            near, far = far, near
        centre = 0.5 * (lo + hi)
        roundoff = SLIGHT + RELATIVELY * abs(centre)
        begin, end = max(lo, centre + near - roundoff), min(hi, centre + far + roundoff)
        rising = (angle[DLO] > 0.0) == at_bottom
    return found, begin, end, rising


@compiled
def _bounds(place: int, values: Floats, registers: Floats, l: int) -> tuple[float, float]:
    """The interval of an output on a cell."""
    if place < 0:
        return values[-1 - place], values[-1 - place]
    return registers[place, LO, l], registers[place, HI, l]


@compiled
def _enclose(c: int, s: int, prismatic: bool, values: Floats, registers: Floats, l: int, r: float, out: Floats) -> None:
    """A coordinate on a cell: value at the middle, interval about that, and interval of the slope.

    1. A length is what its output is; an angle that of two outputs, its cosine and sine up to a factor.
    2. The two are seen in the frame of the middle: u along it, v across it. Where u is not surely positive, nothing is
       known of the angle.
    3. The slope of the angle is (u dv - v du) / (u u + v v).
    4. The interval is cut down to what the slope allows.

    Args:
        c, s: places of the outputs.
        prismatic: whether it is a length.
        values: what does not depend on the parameter.
        registers: (registers, 5, LANES) evaluated.
        l: lane of the cell.
        r: half its width.
        out: (5,) rows as of a register, the interval about the value at the middle.
    """
    # 1.
    x0, xl, xh, xdl, xdh = _all_of(c, values, registers, l)
    if prismatic:
        out[M], out[LO], out[HI], out[DLO], out[DHI] = x0, xl - x0, xh - x0, xdl, xdh
        return
    y0, yl, yh, ydl, ydh = _all_of(s, values, registers, l)
    size = hypot(x0, y0)
    out[M], out[LO], out[HI], out[DLO], out[DHI] = atan2(y0, x0), -pi, pi, -BIG, BIG
    if not (size > 0.0 and size < BIG):
        return
    # 2.
    a, b = x0 / size, y0 / size
    ul, uh = _sum(_scaled_low(xl, xh, a), _scaled_high(xl, xh, a), _scaled_low(yl, yh, b), _scaled_high(yl, yh, b))
    vl, vh = _sum(_scaled_low(yl, yh, a), _scaled_high(yl, yh, a), _scaled_low(xl, xh, -b), _scaled_high(xl, xh, -b))
    if not ul > 0.0:
        return
    out[LO] = atan2(vl, ul if vl < 0.0 else uh)
    out[HI] = atan2(vh, ul if vh > 0.0 else uh)
    # 3.
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
    out[DLO] = tl / (small if tl < 0.0 else large)
    out[DHI] = th / (small if th > 0.0 else large)
    # 4.
    rad = r * max(abs(out[DLO]), abs(out[DHI]))
    out[LO], out[HI] = max(out[LO], -rad), min(out[HI], rad)


@compiled
def _all_of(place: int, values: Floats, registers: Floats, l: int) -> tuple[float, float, float, float, float]:
    if place < 0:
        x = values[-1 - place]
        return x, x, x, 0.0, 0.0
    z = registers[place]
    return z[M, l], z[LO, l], z[HI, l], z[DLO, l], z[DHI, l]


@compiled
def _scaled_low(lo: float, hi: float, k: float) -> float:
    return k * lo if k >= 0 else k * hi


@compiled
def _scaled_high(lo: float, hi: float, k: float) -> float:
    return k * hi if k >= 0 else k * lo


@compiled
def _sum(al: float, ah: float, bl: float, bh: float) -> tuple[float, float]:
    return al + bl, ah + bh
