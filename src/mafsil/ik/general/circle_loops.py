"""All zeros of a real trigonometric polynomial on the circle, isolated with a proof where rounding allows one.

f(t) = a_0 + sum_k a_k cos k t + b_k sin k t, on cells with a Taylor expansion about the middle of each: a cell without
zeros has |f_0| > sum |f_j|, one with f monotone |f_1| > sum j |f_j|; the others are halved until rounding stops it.
"""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false
from __future__ import annotations

from functools import lru_cache
from math import cos, pi, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.solvers.loops import compiled

CELLS = 48
"""Of the circle."""

ORDER = 13
"""Taylor terms of a cell: what is left is (8 pi / 48)^13 / 13! = 4e-14, and 7e-12 of degree twelve."""

DEPTH = 14
"""Halvings of a cell."""

MOST = 48
"""Zeros that are looked at."""

START = 0.1234
"""Where the first cell begins: no angle that arms prefer."""


@lru_cache(maxsize=4)
def harmonics(degree: int) -> tuple[Floats, Floats]:
    """(2, degree + 1, CELLS) cos and sin of k times the middle of each cell; (ORDER, degree + 1) Taylor factors."""
    half = np.pi / CELLS
    k, j = np.arange(degree + 1), np.arange(ORDER)[:, None]
    angle = k[:, None] * (START + (2 * np.arange(CELLS) + 1) * half)
    sign = np.where(j // 2 % 2 == 0, 1.0, -1.0)
    factorial = np.cumprod(np.maximum(j, 1), axis=0)
    return np.stack([np.cos(angle), np.sin(angle)]), sign * (k * half) ** j / factorial


def zeros_of(coefficients: Floats, dust: Floats) -> tuple[Floats, NDArray[np.int64], NDArray[np.bool_]]:
    """Zeros of many polynomials: (k, MOST) zeros, (k,) their number, (k,) whether it is proven that these are all.

    Args:
        coefficients: (k, 2, degree + 1) of cos and sin.
        dust: (k,) what the samples have of higher harmonics that must be zero: rounding.
    """
    k = len(coefficients)
    zeros, number, certain = np.empty((k, MOST)), np.empty(k, dtype=np.int64), np.empty(k, dtype=np.bool_)
    zeros_on_circles(coefficients, dust, *harmonics(coefficients.shape[2] - 1), zeros, number, certain)
    return zeros, number, certain


@compiled
def zeros_on_circles(coefficients, dust, waves, factors, zeros, number, certain):
    """Zeros of many polynomials.

    Args:
        coefficients: (k, 2, degree + 1) of cos and sin.
        dust: (k,) what the samples have of higher harmonics that must be zero: rounding.
        waves, factors: as `harmonics` makes them.
        zeros: (k, most); only the first `number` count.
        number: (k,) of zeros.
        certain: (k,) whether it is proven that all are simple and that there are no others.
    """
    degree, half, most = coefficients.shape[2] - 1, pi / CELLS, zeros.shape[1]
    w_t, w_stack = np.empty((ORDER + 2, CELLS)), np.empty((64, ORDER + 3))
    for b in range(len(coefficients)):
        total = missing = 0.0
        for k in range(degree + 1):
            size = abs(coefficients[b, 0, k]) + abs(coefficients[b, 1, k])
            total += size
            # The Taylor expansion ends: by how much it misses.
            missing += size * abs(factors[ORDER - 1, k]) * k * half / ORDER
        rounding = 64 * 2.2e-16 * total + 8 * dust[b]
        noise, steep = rounding + missing, rounding * degree + missing * ORDER / half
        count = 0
        sure = total < 1e300
        if not total > 100 * dust[b]:
            number[b], certain[b] = 0, False
            continue
        _expanded(coefficients[b], degree, waves, factors, w_t)
        # Signs at ends that neighbours share are found once: a zero there is counted once, on whichever side.
        first = coefficients[b, 0, 0]
        for k in range(1, degree + 1):
            first += coefficients[b, 0, k] * cos(k * START) + coefficients[b, 1, k] * sin(k * START)
        last = first
        for cell in range(CELLS):
            if abs(w_t[0, cell]) > w_t[ORDER, cell] + noise:
                last = w_t[0, cell]
                continue
            t = w_stack[0]
            for j in range(ORDER):
                t[j] = w_t[j, cell]
            t[ORDER], t[ORDER + 1] = START + (2 * cell + 1) * half, half
            depth = 1
            while depth > 0:
                depth -= 1
                t = w_stack[depth]
                rest = slope = 0.0
                for j in range(1, ORDER):
                    rest += abs(t[j])
                    slope += j * abs(t[j])
                slope -= abs(t[1])
                if abs(t[0]) > rest + noise:
                    last = t[0]
                    continue
                width = t[ORDER + 1]
                low, high = last, first
                if cell < CELLS - 1 or depth > 0:
                    high = 0.0
                    for j in range(ORDER):
                        high += t[j]
                if abs(t[1]) > slope + steep * width:
                    last = high
                    if (low < 0.0) != (high < 0.0):
                        sure = sure and count < most
                        zeros[b, min(count, most - 1)] = t[ORDER] + width * _crossing(t, low < 0.0)
                        count += 1
                    continue
                if rest < 4 * noise or width < half * 0.5**DEPTH:
                    # Rounding hides what happens here: the places of a pair of zeros, if it is one.
                    sure, last = False, high
                    centre = -t[1] / (2 * t[2]) if abs(t[2]) > 0.5 * abs(t[1]) else 0.0
                    lift = t[0] + 0.5 * t[1] * centre
                    apart = min(2.0, sqrt((abs(lift) + noise) / (abs(t[2]) + 1e-300)))
                    for side in (-1.0, 1.0):
                        zeros[b, min(count, most - 1)] = t[ORDER] + width * (centre + side * apart)
                        count += 1
                    continue
                _halved(t, w_stack[depth + 1])
                depth += 2
        # No zero at all is believed only where rounding is far below: there is no solution that would confirm it.
        number[b], certain[b] = min(count, most), sure and (count > 0 or total > 1e5 * dust[b])


@compiled
def _expanded(coefficients, degree, waves, factors, w_t):
    """Taylor coefficients of all cells side by side, and below them the sum of all but the first."""
    for j in range(ORDER + 1):
        for cell in range(CELLS):
            w_t[j, cell] = coefficients[0, 0] if j == 0 else 0.0
    for k in range(1, degree + 1):
        a, b = coefficients[0, k], coefficients[1, k]
        for parity in range(2):
            for cell in range(CELLS):
                w_t[ORDER + 1, cell] = a * waves[0, k, cell] + b * waves[1, k, cell]
            for j in range(parity, ORDER, 2):
                factor = factors[j, k]
                for cell in range(CELLS):
                    w_t[j, cell] += factor * w_t[ORDER + 1, cell]
            a, b = b, -a
    for j in range(1, ORDER):
        for cell in range(CELLS):
            w_t[ORDER, cell] += abs(w_t[j, cell])


@compiled
def _halved(t, left):
    """The right half in place of the whole, and the left half."""
    for j in range(ORDER):
        scaled = t[j] * 0.5**j
        left[j], t[j] = scaled, scaled
    for i in range(ORDER - 1):
        for j in range(ORDER - 2, i - 1, -1):
            left[j] -= left[j + 1]
            t[j] += t[j + 1]
    width = 0.5 * t[ORDER + 1]
    left[ORDER], left[ORDER + 1] = t[ORDER] - width, width
    t[ORDER], t[ORDER + 1] = t[ORDER] + width, width


@compiled
def _crossing(t, rises):
    """The zero of a monotone polynomial in [-1, 1] whose ends differ in sign, by Newton's method inside a bracket."""
    low, high, x = -1.0, 1.0, 0.0
    for _ in range(60):
        f = slope = 0.0
        for j in range(ORDER - 1, 0, -1):
            f = f * x + t[j]
            slope = slope * x + j * t[j]
        f = f * x + t[0]
        if (f < 0.0) == rises:
            low = x
        else:
            high = x
        step = f / slope
        better = x - step
        if abs(step) < 1e-13:
            return x
        x = better if low < better < high else 0.5 * (low + high)
    return x
