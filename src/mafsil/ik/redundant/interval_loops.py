"""Interval arithmetic along one parameter, compiled: programs of values, intervals that hold them, and of their slopes.

Every value of a program is kept on a cell of half width r about a middle as its value m there, an interval [lo, hi]
that holds it on the whole cell, and an interval [dl, dh] that holds its slope. After each operation [lo, hi] is cut
down to m + [-r, r] [dl, dh], so errors shrink with the square of the cell (mean value form; Neumaier, Interval Methods
for Systems of Equations, 1990).
"""

from __future__ import annotations

from math import atan2, cos, floor, pi, sin, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled

Codes = NDArray[np.int32]

(ADD, SUB, MUL, DIV, NEG, SQRT, SIN, COS, FABS, FMIN, FMAX, LT, LE, NOT, IF, SIGN, ATAN2, SQ) = range(18)
"""Numbers of the operations."""

M, LO, HI, DLO, DHI = range(5)
"""Rows of a register: value at the middle, interval of the values on the cell, interval of the slopes."""

LANES = 16
"""Cells that are looked at together."""

BIG = 1e150
"""Stands for infinity: products of two stay finite."""


class Program(NamedTuple):
    """What depends on the parameter, of one branch.

    Attributes:
        code, first, second, target: (k,) operations, places of their arguments (negative: -1 - place in `values`) and
            of their results among the registers.
        ports: (2 n + 1) places of the outputs: two for each coordinate, then the least residual of a step.
        values: what does not depend on the parameter.
    """

    code: Codes
    first: Codes
    second: Codes
    target: Codes
    ports: Codes
    values: Floats


@compiled
def plain(op: int, a: float, b: float) -> float:
    """One operation on numbers: a table, in the order of the codes.

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
def product(al: float, ah: float, bl: float, bh: float) -> tuple[float, float]:
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
def evaluate(program: Program, radius: Floats, registers: Floats) -> None:
    """A program on all lanes.

    1. Arguments: registers, or values that do not depend on the parameter in all lanes. Operations with such a value
       on one side scale or shift intervals; the commonest have code of their own.
    2. The operation, end by end; slopes by the rules of differentiation with intervals in the place of numbers. Where
       an operation leaps or its slope is infinite on the cell, the slope is from -BIG to BIG.
    3. The interval is cut down to what value and slopes allow.

    Args:
        program: of a branch.
        radius: (LANES,) half widths of the cells.
        registers: (registers, 5, LANES); register 0 is the parameter.
    """
    values, first, second = program.values, program.first, program.second
    one, two = np.zeros((5, LANES)), np.zeros((5, LANES))
    for i in range(len(program.code)):
        op, z = program.code[i], registers[program.target[i]]
        # 1.
        x, y = one, two
        if first[i] >= 0:
            x = registers[first[i]]
        else:
            _spread(values[-1 - int(first[i])], one)
        if op < NEG or (op >= FMIN and op != NOT and op != SIGN and op != SQ):
            if second[i] >= 0:
                y = registers[second[i]]
            elif op == MUL:
                _scale(x, values[-1 - int(second[i])], z)
                continue
            elif op in (ADD, SUB):
                _shift(x, values[-1 - int(second[i])] if op == ADD else -values[-1 - int(second[i])], z)
                continue
            else:
                _spread(values[-1 - int(second[i])], two)
        # 2.
        if op == ADD:
            for k in range(5):
                for l in range(LANES):
                    z[k, l] = x[k, l] + y[k, l]
        elif op == SUB:
            _difference(x, y, z)
        elif op == MUL:
            _multiply(x, y, z)
        elif op == SQ:
            _square(x, z)
        elif op == DIV:
            _divide(x, y, z)
        elif op == NEG:
            for l in range(LANES):
                a, b, c, d = -x[HI, l], -x[LO, l], -x[DHI, l], -x[DLO, l]
                z[M, l], z[LO, l], z[HI, l], z[DLO, l], z[DHI, l] = -x[M, l], a, b, c, d
        elif op == SQRT:
            _root(x, z)
        elif op in (SIN, COS):
            _wave(x, z, op == COS)
        elif op in (FABS, FMIN, FMAX):
            _chosen(x, y, z, op)
        else:
            _decide(x, y, z, op)
        # 3.
        if op != NEG:
            for l in range(LANES):
                a, b = abs(z[DLO, l]), abs(z[DHI, l])
                rad = radius[l] * (a if a > b else b)
                low, high = z[M, l] - rad, z[M, l] + rad
                if low > z[LO, l]:
                    z[LO, l] = low
                if high < z[HI, l]:
                    z[HI, l] = high


@compiled
def _spread(value: float, out: Floats) -> None:
    for l in range(LANES):
        out[M, l], out[LO, l], out[HI, l] = value, value, value
        out[DLO, l], out[DHI, l] = 0.0, 0.0


@compiled
def _shift(x: Floats, k: float, z: Floats) -> None:
    for l in range(LANES):
        z[M, l], z[LO, l], z[HI, l], z[DLO, l], z[DHI, l] = (
            x[M, l] + k,
            x[LO, l] + k,
            x[HI, l] + k,
            x[DLO, l],
            x[DHI, l],
        )


@compiled
def _scale(x: Floats, k: float, z: Floats) -> None:
    if k >= 0.0:
        for j in range(5):
            for l in range(LANES):
                z[j, l] = k * x[j, l]
    else:
        for l in range(LANES):
            a, b, c, d = k * x[HI, l], k * x[LO, l], k * x[DHI, l], k * x[DLO, l]
            z[M, l], z[LO, l], z[HI, l], z[DLO, l], z[DHI, l] = k * x[M, l], a, b, c, d


@compiled
def _difference(x: Floats, y: Floats, z: Floats) -> None:
    for l in range(LANES):
        a, b, c, d = x[LO, l] - y[HI, l], x[HI, l] - y[LO, l], x[DLO, l] - y[DHI, l], x[DHI, l] - y[DLO, l]
        z[M, l], z[LO, l], z[HI, l], z[DLO, l], z[DHI, l] = x[M, l] - y[M, l], a, b, c, d


@compiled
def _multiply(x: Floats, y: Floats, z: Floats) -> None:
    for l in range(LANES):
        low, high = product(x[LO, l], x[HI, l], y[LO, l], y[HI, l])
        al, ah = product(x[DLO, l], x[DHI, l], y[LO, l], y[HI, l])
        bl, bh = product(x[LO, l], x[HI, l], y[DLO, l], y[DHI, l])
        z[M, l], z[LO, l], z[HI, l], z[DLO, l], z[DHI, l] = x[M, l] * y[M, l], low, high, al + bl, ah + bh


@compiled
def _square(x: Floats, z: Floats) -> None:
    for l in range(LANES):
        m, low, high = x[M, l], x[LO, l], x[HI, l]
        dl, dh = product(2 * low, 2 * high, x[DLO, l], x[DHI, l])
        a, b = low * low, high * high
        least = 0.0 if low <= 0.0 <= high else (a if a < b else b)
        z[M, l], z[LO, l], z[HI, l], z[DLO, l], z[DHI, l] = m * m, least, (a if a > b else b), dl, dh


@compiled
def _divide(x: Floats, y: Floats, z: Floats) -> None:
    for l in range(LANES):
        if y[LO, l] <= 0.0 <= y[HI, l]:
            z[M, l], z[LO, l], z[HI, l], z[DLO, l], z[DHI, l] = x[M, l] / y[M, l], -BIG, BIG, -BIG, BIG
            continue
        il, ih = 1.0 / y[HI, l], 1.0 / y[LO, l]
        low, high = product(x[LO, l], x[HI, l], il, ih)
        ql, qh = product(low, high, y[DLO, l], y[DHI, l])
        dl, dh = product(x[DLO, l] - qh, x[DHI, l] - ql, il, ih)
        z[M, l], z[LO, l], z[HI, l], z[DLO, l], z[DHI, l] = x[M, l] / y[M, l], low, high, dl, dh


@compiled
def _root(x: Floats, z: Floats) -> None:
    for l in range(LANES):
        m, low, high = sqrt(max(x[M, l], 0.0)), sqrt(max(x[LO, l], 0.0)), sqrt(max(x[HI, l], 0.0))
        if low > 0.0:
            dl, dh = product(x[DLO, l], x[DHI, l], 0.5 / high, 0.5 / low)
        elif x[DLO, l] == 0.0 and x[DHI, l] == 0.0:
            dl, dh = 0.0, 0.0
        else:
            dl, dh = (0.0 if x[DLO, l] >= 0.0 else -BIG), (0.0 if x[DHI, l] <= 0.0 else BIG)
        z[M, l], z[LO, l], z[HI, l], z[DLO, l], z[DHI, l] = m, low, high, dl, dh


@compiled
def _wave(x: Floats, z: Floats, cosine: bool) -> None:
    """Sine or cosine, of the parameter or what depends on it."""
    for l in range(LANES):
        shift = 0.5 * pi if cosine else 0.0
        low, high = x[LO, l] + shift, x[HI, l] + shift
        sl, sh = _sine_range(low, high)
        cl, ch = _sine_range(low + 0.5 * pi, high + 0.5 * pi)
        dl, dh = product(cl, ch, x[DLO, l], x[DHI, l])
        z[M, l] = cos(x[M, l]) if cosine else sin(x[M, l])
        z[LO, l], z[HI, l], z[DLO, l], z[DHI, l] = sl, sh, dl, dh


@compiled
def _sine_range(low: float, high: float) -> tuple[float, float]:
    a, b = sin(low), sin(high)
    down, up = min(a, b), max(a, b)
    if floor((high - 0.5 * pi) / (2 * pi)) > floor((low - 0.5 * pi) / (2 * pi)):
        up = 1.0
    if floor((high + 0.5 * pi) / (2 * pi)) > floor((low + 0.5 * pi) / (2 * pi)):
        down = -1.0
    return down, up


@compiled
def _chosen(x: Floats, y: Floats, z: Floats, op: int) -> None:
    """The larger or smaller of two, or the amount: one of them where that is sure, else either.

    1. The other of the two; of an amount it is minus the first.
    2. The smaller: the other where it surely lies below, either where the intervals meet.
    3. The larger likewise.
    """
    for l in range(LANES):
        m, low, high, dl, dh = x[M, l], x[LO, l], x[HI, l], x[DLO, l], x[DHI, l]
        # 1.
        if op == FABS:
            am, al, ah, bl, bh = -m, -high, -low, -dh, -dl
        else:
            am, al, ah, bl, bh = y[M, l], y[LO, l], y[HI, l], y[DLO, l], y[DHI, l]
        # 2.
        if op == FMIN:
            if low > ah:
                m, low, high, dl, dh = am, al, ah, bl, bh
            elif high >= al:
                m, low, high = min(m, am), min(low, al), min(high, ah)
                dl, dh = min(dl, bl), max(dh, bh)
        # 3.
        elif high < al:
            m, low, high, dl, dh = am, al, ah, bl, bh
        elif low <= ah:
            m, low, high = max(m, am), max(low, al), max(high, ah)
            dl, dh = min(dl, bl), max(dh, bh)
        z[M, l], z[LO, l], z[HI, l], z[DLO, l], z[DHI, l] = m, low, high, dl, dh


@compiled
def _decide(x: Floats, y: Floats, z: Floats, op: int) -> None:
    """Comparisons, and values that depend on them.

    1. A choice: the value where the condition surely holds, zero where it surely fails, else both, with any slope.
    2. A comparison: 1 or 0 where the intervals decide it, else both.
    3. A negation, likewise.
    4. A sign: those that the interval has.
    5. An angle: the whole circle.
    """
    for l in range(LANES):
        m = plain(op, x[M, l], y[M, l])
        # 1.
        if op == IF:
            if x[LO, l] > 0.0 or x[HI, l] < 0.0:
                low, high, dl, dh = y[LO, l], y[HI, l], y[DLO, l], y[DHI, l]
                m = y[M, l]
            elif x[LO, l] == 0.0 and x[HI, l] == 0.0:
                low, high, dl, dh = 0.0, 0.0, 0.0, 0.0
            else:
                low, high, dl, dh = min(0.0, y[LO, l]), max(0.0, y[HI, l]), -BIG, BIG
        # 2.
        elif op in (LT, LE):
            low = 1.0 if x[HI, l] < y[LO, l] or (op == LE and x[HI, l] <= y[LO, l]) else 0.0
            high = 0.0 if x[LO, l] > y[HI, l] or (op == LT and x[LO, l] >= y[HI, l]) else 1.0
            dl, dh = (0.0, 0.0) if low == high else (-BIG, BIG)
        # 3.
        elif op == NOT:
            low, high = 0.0, 1.0
            if x[LO, l] == 0.0 and x[HI, l] == 0.0:
                low = 1.0
            if x[LO, l] > 0.0 or x[HI, l] < 0.0:
                high = 0.0
            dl, dh = (0.0, 0.0) if low == high else (-BIG, BIG)
        # 4.
        elif op == SIGN:
            low = 1.0 if x[LO, l] > 0.0 else (0.0 if x[LO, l] == 0.0 else -1.0)
            high = -1.0 if x[HI, l] < 0.0 else (0.0 if x[HI, l] == 0.0 else 1.0)
            dl, dh = (0.0, 0.0) if low == high else (-BIG, BIG)
        # 5.
        else:
            low, high, dl, dh = -pi, pi, -BIG, BIG
        z[M, l], z[LO, l], z[HI, l], z[DLO, l], z[DHI, l] = m, low, high, dl, dh
