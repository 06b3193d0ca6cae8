"""Interval arithmetic along one parameter, compiled: programs of values, intervals that hold them, and of their slopes.

Every value of a program is kept on a cell of half width r about a middle as its value m there, an interval [lo, hi]
that holds it on the whole cell, and an interval [dl, dh] that holds its slope. After each operation [lo, hi] is cut
down to m + [-r, r] [dl, dh], so errors shrink with the square of the cell (mean value form; Neumaier, Interval Methods
for Systems of Equations, 1990).
"""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false
from __future__ import annotations

from math import atan2, cos, floor, pi, sin, sqrt

import numpy as np

from mafsil.solvers.loops import compiled

(ADD, SUB, MUL, DIV, NEG, SQRT, SIN, COS, FABS, FMIN, FMAX, LT, LE, NOT, IF, SIGN, ATAN2, SQ) = range(18)
"""Numbers of the operations."""

LANES = 16
"""Cells that are looked at together."""

BIG = 1e150
"""Stands for infinity: products of two stay finite."""


@compiled
def plain(op, a, b):
    """One operation on numbers.

    Args:
        op: which.
        a, b: its arguments; the second is not used by operations of one.
    """
    if op == ADD:
        return a + b
    if op == SUB:
        return a - b
    if op == MUL:
        return a * b
    if op == DIV:
        return a / b
    if op == NEG:
        return -a
    if op == SQRT:
        return sqrt(max(a, 0.0))
    if op == SIN:
        return sin(a)
    if op == COS:
        return cos(a)
    if op == FABS:
        return abs(a)
    if op == FMIN:
        return min(a, b)
    if op == FMAX:
        return max(a, b)
    if op == LT:
        return 1.0 if a < b else 0.0
    if op == LE:
        return 1.0 if a <= b else 0.0
    if op == NOT:
        return 1.0 if a == 0.0 else 0.0
    if op == IF:
        return b if a != 0.0 else 0.0
    if op == SIGN:
        return 1.0 if a > 0 else (-1.0 if a < 0 else 0.0)
    if op == SQ:
        return a * a
    return atan2(a, b)


@compiled
def product(al, ah, bl, bh):
    """The interval of products.

    Args:
        al, ah: ends of one interval.
        bl, bh: of the other.
    """
    p, q, s, t = al * bl, al * bh, ah * bl, ah * bh
    u, v = (p if p < q else q), (s if s < t else t)
    x, y = (p if p > q else q), (s if s > t else t)
    return (u if u < v else v), (x if x > y else y)


@compiled
def evaluated(code, first, second, target, values, radius, room):
    """A program on all lanes.

    1. Operations without a parameter on one side scale or shift intervals; the commonest have code of their own.
    2. Others are done end by end, slopes by the rules of differentiation with intervals in the place of numbers.
    3. Where an operation leaps or its slope is infinite on the cell, the slope is from -BIG to BIG.

    Args:
        code, first, second, target: (k,) operations, places of their arguments (negative: -1 - place in `values`) and
            of their results.
        values: what does not depend on the parameter.
        radius: (LANES,) half widths of the cells.
        room: (registers, 5, LANES) m, lo, hi, dl, dh; register 0 is the parameter.
    """
    one, two = np.zeros((5, LANES)), np.zeros((5, LANES))
    for i in range(len(code)):
        op, z = code[i], room[target[i]]
        x, y = one, two
        if first[i] >= 0:
            x = room[first[i]]
        else:
            _spread(values[-1 - first[i]], one)
        if op < NEG or (op >= FMIN and op != NOT and op != SIGN and op != SQ):
            if second[i] >= 0:
                y = room[second[i]]
            elif op == MUL:
                _scaled(x, values[-1 - second[i]], z)
                continue
            elif op in (ADD, SUB):
                _shifted(x, values[-1 - second[i]] if op == ADD else -values[-1 - second[i]], z)
                continue
            else:
                _spread(values[-1 - second[i]], two)
        if op == ADD:
            for k in range(5):
                for l in range(LANES):
                    z[k, l] = x[k, l] + y[k, l]
        elif op == SUB:
            _difference(x, y, z)
        elif op == MUL:
            _multiplied(x, y, z)
        elif op == SQ:
            _squared(x, z)
        elif op == DIV:
            _divided(x, y, z)
        elif op == NEG:
            for l in range(LANES):
                a, b, c, d = -x[2, l], -x[1, l], -x[4, l], -x[3, l]
                z[0, l], z[1, l], z[2, l], z[3, l], z[4, l] = -x[0, l], a, b, c, d
        elif op == SQRT:
            _rooted(x, z)
        elif op in (SIN, COS):
            _waved(x, z, op == COS)
        elif op in (FABS, FMIN, FMAX):
            _chosen(x, y, z, op)
        else:
            _decided(x, y, z, op)
        if op != NEG:
            for l in range(LANES):
                a, b = abs(z[3, l]), abs(z[4, l])
                rad = radius[l] * (a if a > b else b)
                low, high = z[0, l] - rad, z[0, l] + rad
                if low > z[1, l]:
                    z[1, l] = low
                if high < z[2, l]:
                    z[2, l] = high


@compiled
def _spread(value, out):
    for l in range(LANES):
        out[0, l], out[1, l], out[2, l] = value, value, value
        out[3, l], out[4, l] = 0.0, 0.0


@compiled
def _shifted(x, k, z):
    for l in range(LANES):
        z[0, l], z[1, l], z[2, l], z[3, l], z[4, l] = x[0, l] + k, x[1, l] + k, x[2, l] + k, x[3, l], x[4, l]


@compiled
def _scaled(x, k, z):
    if k >= 0.0:
        for j in range(5):
            for l in range(LANES):
                z[j, l] = k * x[j, l]
    else:
        for l in range(LANES):
            a, b, c, d = k * x[2, l], k * x[1, l], k * x[4, l], k * x[3, l]
            z[0, l], z[1, l], z[2, l], z[3, l], z[4, l] = k * x[0, l], a, b, c, d


@compiled
def _difference(x, y, z):
    for l in range(LANES):
        a, b, c, d = x[1, l] - y[2, l], x[2, l] - y[1, l], x[3, l] - y[4, l], x[4, l] - y[3, l]
        z[0, l], z[1, l], z[2, l], z[3, l], z[4, l] = x[0, l] - y[0, l], a, b, c, d


@compiled
def _multiplied(x, y, z):
    for l in range(LANES):
        low, high = product(x[1, l], x[2, l], y[1, l], y[2, l])
        al, ah = product(x[3, l], x[4, l], y[1, l], y[2, l])
        bl, bh = product(x[1, l], x[2, l], y[3, l], y[4, l])
        z[0, l], z[1, l], z[2, l], z[3, l], z[4, l] = x[0, l] * y[0, l], low, high, al + bl, ah + bh


@compiled
def _squared(x, z):
    for l in range(LANES):
        m, low, high = x[0, l], x[1, l], x[2, l]
        dl, dh = product(2 * low, 2 * high, x[3, l], x[4, l])
        a, b = low * low, high * high
        least = 0.0 if low <= 0.0 <= high else (a if a < b else b)
        z[0, l], z[1, l], z[2, l], z[3, l], z[4, l] = m * m, least, (a if a > b else b), dl, dh


@compiled
def _divided(x, y, z):
    for l in range(LANES):
        if y[1, l] <= 0.0 <= y[2, l]:
            z[0, l], z[1, l], z[2, l], z[3, l], z[4, l] = x[0, l] / y[0, l], -BIG, BIG, -BIG, BIG
            continue
        il, ih = 1.0 / y[2, l], 1.0 / y[1, l]
        low, high = product(x[1, l], x[2, l], il, ih)
        ql, qh = product(low, high, y[3, l], y[4, l])
        dl, dh = product(x[3, l] - qh, x[4, l] - ql, il, ih)
        z[0, l], z[1, l], z[2, l], z[3, l], z[4, l] = x[0, l] / y[0, l], low, high, dl, dh


@compiled
def _rooted(x, z):
    for l in range(LANES):
        m, low, high = sqrt(max(x[0, l], 0.0)), sqrt(max(x[1, l], 0.0)), sqrt(max(x[2, l], 0.0))
        if low > 0.0:
            dl, dh = product(x[3, l], x[4, l], 0.5 / high, 0.5 / low)
        elif x[3, l] == 0.0 and x[4, l] == 0.0:
            dl, dh = 0.0, 0.0
        else:
            dl, dh = (0.0 if x[3, l] >= 0.0 else -BIG), (0.0 if x[4, l] <= 0.0 else BIG)
        z[0, l], z[1, l], z[2, l], z[3, l], z[4, l] = m, low, high, dl, dh


@compiled
def _waved(x, z, cosine):
    """Sine or cosine, of the parameter or what depends on it."""
    for l in range(LANES):
        shift = 0.5 * pi if cosine else 0.0
        low, high, sl, sh = x[1, l] + shift, x[2, l] + shift, 0.0, 0.0
        sl, sh = _sine_range(low, high)
        cl, ch = _sine_range(low + 0.5 * pi, high + 0.5 * pi)
        dl, dh = product(cl, ch, x[3, l], x[4, l])
        z[0, l] = cos(x[0, l]) if cosine else sin(x[0, l])
        z[1, l], z[2, l], z[3, l], z[4, l] = sl, sh, dl, dh


@compiled
def _sine_range(low, high):
    a, b = sin(low), sin(high)
    down, up = min(a, b), max(a, b)
    if floor((high - 0.5 * pi) / (2 * pi)) > floor((low - 0.5 * pi) / (2 * pi)):
        up = 1.0
    if floor((high + 0.5 * pi) / (2 * pi)) > floor((low + 0.5 * pi) / (2 * pi)):
        down = -1.0
    return down, up


@compiled
def _chosen(x, y, z, op):
    """The larger or smaller of two, or the amount: one of them where that is sure, else either."""
    for l in range(LANES):
        m, low, high, dl, dh = x[0, l], x[1, l], x[2, l], x[3, l], x[4, l]
        if op == FABS:
            am, al, ah, bl, bh = -m, -high, -low, -dh, -dl
        else:
            am, al, ah, bl, bh = y[0, l], y[1, l], y[2, l], y[3, l], y[4, l]
        if op == FMIN:
            if low > ah:
                m, low, high, dl, dh = am, al, ah, bl, bh
            elif high >= al:
                m, low, high = min(m, am), min(low, al), min(high, ah)
                dl, dh = min(dl, bl), max(dh, bh)
        elif high < al:
            m, low, high, dl, dh = am, al, ah, bl, bh
        elif low <= ah:
            m, low, high = max(m, am), max(low, al), max(high, ah)
            dl, dh = min(dl, bl), max(dh, bh)
        z[0, l], z[1, l], z[2, l], z[3, l], z[4, l] = m, low, high, dl, dh


@compiled
def _decided(x, y, z, op):
    """Comparisons, and values that depend on them."""
    for l in range(LANES):
        m = plain(op, x[0, l], y[0, l])
        if op == IF:
            if x[1, l] > 0.0 or x[2, l] < 0.0:
                low, high, dl, dh = y[1, l], y[2, l], y[3, l], y[4, l]
                m = y[0, l]
            elif x[1, l] == 0.0 and x[2, l] == 0.0:
                low, high, dl, dh = 0.0, 0.0, 0.0, 0.0
            else:
                low, high, dl, dh = min(0.0, y[1, l]), max(0.0, y[2, l]), -BIG, BIG
        elif op in (LT, LE):
            low = 1.0 if x[2, l] < y[1, l] or (op == LE and x[2, l] <= y[1, l]) else 0.0
            high = 0.0 if x[1, l] > y[2, l] or (op == LT and x[1, l] >= y[2, l]) else 1.0
            dl, dh = (0.0, 0.0) if low == high else (-BIG, BIG)
        elif op == NOT:
            low, high = 0.0, 1.0
            if x[1, l] == 0.0 and x[2, l] == 0.0:
                low = 1.0
            if x[1, l] > 0.0 or x[2, l] < 0.0:
                high = 0.0
            dl, dh = (0.0, 0.0) if low == high else (-BIG, BIG)
        elif op == SIGN:
            low = 1.0 if x[1, l] > 0.0 else (0.0 if x[1, l] == 0.0 else -1.0)
            high = -1.0 if x[2, l] < 0.0 else (0.0 if x[2, l] == 0.0 else 1.0)
            dl, dh = (0.0, 0.0) if low == high else (-BIG, BIG)
        else:
            low, high, dl, dh = -pi, pi, -BIG, BIG
        z[0, l], z[1, l], z[2, l], z[3, l], z[4, l] = m, low, high, dl, dh
