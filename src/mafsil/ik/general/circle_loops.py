"""All zeros of a real trigonometric polynomial on the circle, isolated with a proof where rounding allows one.

f(t) = a_0 + sum_k a_k cos k t + b_k sin k t, on cells with a Taylor expansion about the middle of each: a cell without
zeros has |f_0| > sum |f_j|, one with f monotone |f_1| > sum j |f_j|; the others are halved until rounding stops it.
"""

from __future__ import annotations

from functools import lru_cache
from math import cos, pi, sin, sqrt
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Booleans, Floats, Integers
from mafsil.floating_point import EPS, LEAST_DIVISOR
from mafsil.ik.tolerances import LAST_CORRECTION
from mafsil.kernels.loops.lanes import any_lane, buffer, get, lane_bits, lanes, magnitude, put, seen, where
from mafsil.kernels.loops.loop import reordered

if TYPE_CHECKING:
    from mafsil.kernels.loops.lanes import Buffer, Lanes

CELLS = 48
"""Of the circle: a multiple of eight."""

ORDER = 13
"""Taylor terms of a cell: what is left is (8 pi / 48)^13 / 13! = 4e-14, and 7e-12 of degree twelve."""

HALF = pi / CELLS
"""Half the width of a cell [rad]."""

DEPTH = 14
"""Halvings of a cell."""

MOST = 48
"""Zeros that are looked at."""

HIDDEN = 24
"""Cells of one polynomial in which rounding may hide what happens; beyond that nothing is certain anyway."""

START = 0.1234
"""Where the first cell begins: no angle that arms prefer."""


@lru_cache(maxsize=4)
def harmonics(degree: int) -> tuple[Floats, Floats]:
    """(2, degree + 1, CELLS) cos and sin of k times the middle of each cell; (ORDER, degree + 1) Taylor factors."""
    k, j = np.arange(degree + 1), np.arange(ORDER)[:, None]
    angle = k[:, None] * (START + (2 * np.arange(CELLS) + 1) * HALF)
    sign = np.where(j // 2 % 2 == 0, 1.0, -1.0)
    factorial = np.cumprod(np.maximum(j, 1), axis=0)
    return np.stack([np.cos(angle), np.sin(angle)]), sign * (k * HALF) ** j / factorial


def zeros_of(
    coefficients: Floats, roundoff: Floats, degree: int
) -> tuple[Floats, NDArray[np.int64], NDArray[np.bool_]]:
    """Zeros of many polynomials: (k, MOST) zeros, (k,) their number, (k,) whether it is proven that these are all.

    Args:
        coefficients: (k, 2 degree + 1 or more) a_0, a_1, ..., b_1, b_2, ...; what follows is not looked at.
        roundoff: (k,) what the samples have of higher harmonics that must be zero: rounding.
        degree: of the polynomials.
    """
    k = len(coefficients)
    zeros, number, certain = np.empty((k, MOST)), np.empty(k, dtype=np.int64), np.empty(k, dtype=np.bool_)
    cells, hidden = np.empty((k, HIDDEN, 5)), np.empty(k, dtype=np.int64)
    zeros_on_circles(coefficients, roundoff, degree, *harmonics(degree), zeros, number, certain, cells, hidden)
    return zeros, number, certain


@reordered
def zeros_on_circles(
    coefficients: Floats,
    roundoff: Floats,
    degree: int,
    waves: Floats,
    factors: Floats,
    zeros: Floats,
    number: Integers,
    certain: Booleans,
    cells: Floats,
    hidden: Integers,
) -> None:
    """Zeros of many polynomials.

    1. How far the values of an expansion may be off: rounding, and the terms beyond its end.
    2. The expansions of all cells, eight cells at a time; which of them may hold a zero.
    3. Each of these cells is empty, or monotone, or halved. Ends that neighbours share have one sign, found once: a
       zero there is counted once, on whichever side.
    4. Zeros of monotone cells wait until there are eight, and are found side by side.

    Args:
        coefficients: (k, 2 degree + 1 or more) a_0, a_1, ..., b_1, b_2, ...
        roundoff: (k,) what the samples have of higher harmonics that must be zero: rounding.
        degree: of the polynomials.
        waves, factors: as `harmonics` makes them.
        zeros: (k, most); only the first `number` count.
        number: (k,) of zeros.
        certain: (k,) whether it is proven that all are simple and that there are no others.
        cells: (k, most, 5) cells in which rounding hides what happens: centre, half the width, which of the zeros the
            pair is that stands for it, and the values that its ends were taken to have.
        hidden: (k,) of such cells; negative where more is in doubt.
    """
    T, unknown, stack = buffer(78), np.empty(CELLS, np.bool_), np.empty((64, ORDER + 2))
    waiting, place, queued = np.empty((zeros.shape[1] + 8, ORDER + 3)), np.empty((zeros.shape[1] + 8, 2), np.int64), 0
    for b in range(len(coefficients)):
        # 1.
        total, truncated = abs(coefficients[b, 0]), 0.0
        for k in range(1, degree + 1):
            size = abs(coefficients[b, k]) + abs(coefficients[b, degree + k])
            total += size
            truncated += size * abs(factors[ORDER - 1, k]) * k * HALF / ORDER
        rounding = 64 * EPS * total + 8 * roundoff[b]
        noise, steep = rounding + truncated, rounding * degree + truncated * ORDER / HALF
        number[b], certain[b], hidden[b] = 0, False, -1
        if total > 100 * roundoff[b]:
            count, sure = 0, total < 1e300
            # 2.
            if _expand(coefficients[b], degree, waves, factors, noise, T, unknown):
                # 3.
                first = coefficients[b, 0]
                for k in range(1, degree + 1):
                    first += coefficients[b, k] * cos(k * START) + coefficients[b, degree + k] * sin(k * START)
                count, doubts, taken = _isolated(
                    T, unknown, first, noise, steep, zeros[b], waiting[queued:], stack, cells[b]
                )
                for i in range(taken):
                    place[queued + i, 0], place[queued + i, 1] = b, int(waiting[queued + i, ORDER + 2])
                hidden[b] = doubts if sure and count <= zeros.shape[1] and doubts <= cells.shape[1] else -1
                sure, queued = hidden[b] == 0, queued + taken
            # No zero at all is believed only where rounding is far below: no solution would confirm it.
            number[b], certain[b] = min(count, zeros.shape[1]), sure and (count > 0 or total > 1e5 * roundoff[b])
        # 4.
        while queued >= 8 or (queued > 0 and b == len(coefficients) - 1):
            some = min(queued, 8)
            queued -= some
            for l in range(8):
                for j in range(ORDER + 2):
                    put(T, j, l, waiting[queued + min(l, some - 1), j])
            x = T[ORDER] + T[ORDER + 1] * _crossing(T)
            T[0] = x
            for l in range(some):
                zeros[place[queued + l, 0], place[queued + l, 1]] = get(T, 0, l)


@reordered
def _expand(
    coefficients: Floats, degree: int, waves: Floats, factors: Floats, noise: float, T: Buffer, unknown: Booleans
) -> bool:
    """Taylor coefficients of all cells, eight cells at a time; whether there are cells that may hold a zero.

    1. Each harmonic about the middle of a cell: its even and its odd derivatives are these two, up to factors.
    2. The Taylor coefficients, the highest first, and the sum of the sizes of all but the constant.
    3. A cell whose constant exceeds that sum has no zero; the others may have one.

    Args:
        coefficients, degree, waves, factors: as for `zeros_on_circles`, of one polynomial.
        noise: by how much values may be off.
        T: ORDER places for each eight cells.
        unknown: (CELLS,) which cells may hold a zero.
    """
    circle, turns, some = seen(waves), buffer(26), False
    for g in range(CELLS // 8):
        # 1.
        for k in range(1, degree + 1):
            x, y = circle[k * (CELLS // 8) + g], circle[(degree + 1 + k) * (CELLS // 8) + g]
            turns[2 * k] = coefficients[k] * x + coefficients[degree + k] * y
            turns[2 * k + 1] = coefficients[degree + k] * x - coefficients[k] * y
        # 2.
        others = lanes(0.0)
        for j in range(ORDER - 1, -1, -1):
            value = lanes(coefficients[0] if j == 0 else 0.0)
            for k in range(1, degree + 1):
                value += factors[j, k] * turns[2 * k + (j & 1)]
            if j > 0:
                others += magnitude(value)
            T[ORDER * g + j] = value
        # 3.
        bits = lane_bits(~(magnitude(T[ORDER * g]) > others + noise))
        some = some or bits != 0
        for l in range(8):
            unknown[8 * g + l] = (bits >> l) & 1 != 0
    return some


@reordered
def _isolated(
    T: Buffer,
    unknown: Booleans,
    first: float,
    noise: float,
    steep: float,
    zeros: Floats,
    waiting: Floats,
    stack: Floats,
    cells: Floats,
) -> tuple[int, int, int]:
    """Cells of one polynomial: how many zeros, in how many cells rounding hides them, how many wait to be found.

    1. A cell that may hold a zero is looked at; what is before it has the sign of `last`.
    2. It is empty, or monotone and holds a zero if its ends differ in sign; or
    3. rounding hides what happens there, and there may be a pair of zeros; or
    4. it is halved, and the left half looked at first.

    Args:
        T, unknown: as `_expand` leaves them.
        first: value where the first cell begins.
        noise, steep: by how much values and slopes may be off.
        zeros: (most,) those that rounding hides are written down.
        waiting: (most, ORDER + 3) monotone cells with a zero: coefficients, centre, width, and place of the zero.
        stack: (64, ORDER + 2) buffer for halves that are still to be looked at.
        cells: (most, 5) the cells in doubt, see `zeros_on_circles`.
    """
    count, taken, doubts, last, most = 0, 0, 0, first, len(zeros)
    for cell in range(CELLS):
        # 1.
        if not unknown[cell]:
            continue
        if cell > 0 and not unknown[cell - 1]:
            last = get(T, ORDER * ((cell - 1) >> 3), (cell - 1) & 7)
        for j in range(ORDER):
            stack[0, j] = get(T, ORDER * (cell >> 3) + j, cell & 7)
        stack[0, ORDER], stack[0, ORDER + 1] = START + (2 * cell + 1) * HALF, HALF
        depth = 1
        while depth > 0:
            depth -= 1
            t = stack[depth]
            rest = slope = 0.0
            for j in range(1, ORDER):
                rest += abs(t[j])
                slope += j * abs(t[j])
            slope -= abs(t[1])
            # 2.
            if abs(t[0]) > rest + noise:
                last = t[0]
                continue
            width, low, high = t[ORDER + 1], last, first
            if cell < CELLS - 1 or depth > 0:
                high = 0.0
                for j in range(ORDER):
                    high += t[j]
            if abs(t[1]) > slope + steep * width:
                last = high
                if (low < 0.0) != (high < 0.0):
                    if count < most:
                        for j in range(ORDER + 2):
                            waiting[taken, j] = t[j]
                        waiting[taken, ORDER + 2] = count
                        taken += 1
                    count += 1
                continue
            # 3.
            if rest < 4 * noise or width < HALF * 0.5**DEPTH:
                last = high
                if doubts < len(cells):
                    cells[doubts, 0], cells[doubts, 1], cells[doubts, 2] = t[ORDER], width, count
                    cells[doubts, 3], cells[doubts, 4] = low, high
                doubts += 1
                centre = -t[1] / (2 * t[2]) if abs(t[2]) > 0.5 * abs(t[1]) else 0.0
                lift = t[0] + 0.5 * t[1] * centre
                apart = min(2.0, sqrt((abs(lift) + noise) / (abs(t[2]) + LEAST_DIVISOR)))
                for side in range(2):
                    zeros[min(count, most - 1)] = t[ORDER] + width * (centre + (apart if side else -apart))
                    count += 1
                continue
            # 4.
            _halve(t, stack[depth + 1])
            depth += 2
    return count, doubts, taken


@reordered
def _halve(t: Floats, left: Floats) -> None:
    """The right half in place of the whole, and the left half."""
    scale = 1.0
    for j in range(ORDER):
        t[j] *= scale
        left[j] = t[j]
        scale *= 0.5
    for i in range(ORDER - 1):
        for j in range(ORDER - 2, i - 1, -1):
            left[j] -= left[j + 1]
            t[j] += t[j + 1]
    width = 0.5 * t[ORDER + 1]
    left[ORDER], left[ORDER + 1] = t[ORDER] - width, width
    t[ORDER], t[ORDER + 1] = t[ORDER] + width, width


@reordered
def _crossing(T: Buffer) -> Lanes:
    """The zeros of eight monotone polynomials in [-1, 1] whose ends differ in sign, by Newton's method in a bracket.

    1. The level of rounding: below it a value says nothing.
    2. Value and slope by Horner's rule; a value whose sign is not that of the slope lies before the zero: the bracket
       shrinks.
    3. Newton's step, or the middle of the bracket where the step leaves it; lanes that are done stay.

    Args:
        T: ORDER coefficients.
    """
    low, high, x, open_lanes, level = lanes(-1.0), lanes(1.0), lanes(0.0), lanes(1.0), lanes(0.0)
    # 1.
    for j in range(ORDER):
        level += 2 * EPS * magnitude(T[j])
    for _ in range(60):
        # 2.
        f, slope = T[ORDER - 1], (ORDER - 1.0) * T[ORDER - 1]
        for j in range(ORDER - 2, 0, -1):
            f = f * x + T[j]
            slope = slope * x + float(j) * T[j]
        f = f * x + T[0]
        before = f * T[1] < 0.0
        low, high = where(before, x, low), where(before, high, x)
        # 3.
        step = f / slope
        better = x - step
        # Below the rounding of its value a zero cannot be found better.
        open_lanes = where((magnitude(step) < LAST_CORRECTION) | (magnitude(f) <= level), 0.0, open_lanes)
        better = where((low < better) & (better < high), better, 0.5 * (low + high))
        x = where(open_lanes > 0.0, better, x)
        if not any_lane(open_lanes > 0.0):
            break
    return x
