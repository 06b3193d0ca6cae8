"""Functions of the language of compiled loops, each for some of its words; run compiled and as Python."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.kernels.loop_compiler import Record, Rows, Singles, Whole

SHIFT, COUNT = 0.25, 3


class Point(Record):
    """Numbers of both kinds."""

    x: float
    count: int


class Cloud(Record):
    """Points, one of them alone, and an array."""

    points: Rows[Point]
    first: Point
    numbers: Floats
    size: int
    total: float


def arithmetic(x: Floats, i: Whole, out: Floats, whole: Whole) -> None:
    """Real and whole operations; constants, negative ones too."""
    a, b = x[0], x[1]
    out[0], out[1], out[2], out[3] = a + b, a - b, a * b, a / b
    out[4], out[5], out[6] = -a, (a - 2) * 3.5, abs(b) + SHIFT
    out[7], out[8], out[9] = min(a, b), max(a, b), np.sqrt(abs(a))
    out[10], out[11], out[12] = np.rint(a), i[0] / i[1], np.inf if a > b else -1.5
    out[13], out[14] = float(i[0]), 2 * np.pi
    p, q = i[0], i[1]
    whole[0], whole[1], whole[2], whole[3] = p + q, p - q, p * q, p // q
    whole[4], whole[5], whole[6], whole[7] = p % q, -p, abs(p), int(a)
    whole[8], whole[9], whole[10] = (p & 7) << 2, (p & 63) >> 1, (p & 3) | 8
    whole[11] = 1 if 0 < p <= q else 0
    whole[12] = 1 if not a < b else 0
    whole[13] = 1 if a == b or (a != b and p > 0) else 0


def squared(x: Floats, out: Floats) -> None:
    """A power of two is one product, whatever the mathematics library makes of it."""
    out[0] = (x[0] - 2) ** 2


def singles(x: Singles, y: Floats, out: Singles) -> float:
    """Sums of single precision stay in single precision; with a real number they become real."""
    total = np.float32(0.0)
    for j in range(8):
        total += x[j] * x[j]
        out[j] = np.float32(y[j]) - x[j]
    return total + y[0]


def control(x: Floats, n: int, out: Floats) -> int:
    """Loops with breaks and continues, loops in loops, results from the middle."""
    steps = 0
    for k in range(n):
        if x[k] < -0.5:
            continue
        if x[k] > 0.9:
            break
        steps += 1
        for j in range(k, n, 2):
            out[k] += x[j]
    while steps < 100:
        steps += COUNT
        if steps % 7 == 0:
            return -steps
    return steps


def views(x: Floats, n: int, out: Floats) -> bool:
    """Rows of arrays, arrays of the function itself, calls of others, conditions that must not be looked at."""
    own, places = np.empty(COUNT), np.empty(4, np.int64)
    for i in range(COUNT):
        own[i] = 0.0
        places[i] = i * i
    for i in range(n):
        row = x[COUNT * i :] if i % 2 == 0 else own
        add(row, own)
    for i in range(COUNT):
        out[i] = own[i] + places[i]
    return n > 0 and x[n - 1] > 0.0


def add(row: Floats, out: Floats) -> None:
    """Element by element."""
    for i in range(COUNT):
        out[i] += row[i]


def recorded(cloud: Cloud) -> int:
    """Fields read and written, of a record, of one it leads to and of rows of them."""
    seen = 0
    for i in range(cloud.size):
        point = cloud.points[i]
        cloud.total += point.x
        point.count, cloud.points[i].x = i + cloud.first.count, point.x * 2.0
        cloud.numbers[i] += cloud.points[i].x
        seen += point.count
    cloud.total += cloud.first.x
    cloud.first.count = seen
    return seen
