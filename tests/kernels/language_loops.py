"""Every construct of the loop language, in loops that only the tests call."""

from __future__ import annotations

from math import asin, atan2, ceil, copysign, cos, exp, floor, fmod, hypot, isfinite, log, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

from mafsil.kernels.loops import Held, compiled, hold, inlined, open_held, reordered

assert reordered
assert hold
FACTOR, PAIR = 3, (2.0, 5.0, -1.0, 4.0, 0.5)
TABLE = np.array([[1.0, -2.0], [0.5, 4.0]])


class Point(NamedTuple):
    """A named tuple."""

    x: float
    row: Any
    k: int


@inlined
def square(x):
    return x * x


def plain(x):
    """Not decorated: not a loop."""
    return x


@compiled
def numbers(a, b, m, n):
    whole = m // n, m % n, m & n, m | n, m ^ n, m << 3, m >> 1, -m, ~m, abs(m), m**3, m // 3, m % 3
    real = a + b, a - b, a * b, a / b, -a, a**2, a // b, a % b, abs(b), a * m, m / n, 2.0**m
    return whole, real, (m < n, a <= b < 2.0, m == 3 or a > b, not m > 1, m in (1, 7), m not in (2, 3), True & (a > 0))


@compiled
def powers(a):
    return a**-2, a**3, a**7, abs(a) ** 0.5, hypot(a, 0.3)


@compiled
def functions(a, b):
    return (
        sqrt(abs(a)), sin(a), cos(a), exp(min(a, 50.0)), log(abs(a) + 1.0), atan2(a, b), asin(0.3), fmod(a, b),
        floor(a), ceil(a), round(a), int(a), float(3), copysign(a, b), isfinite(a), np.floor(a), np.rint(a),
        np.nextafter(a, b), min(a, b, 0.5), max(a, b), max(2, 3), np.isnan(a), complex(a, b), bool(a),
    )  # fmt: skip


@compiled
def widened(n):
    s, found = 0, False
    for k in range(n):
        s += 0.5 * k
        found = found or k > 2
    for k in range(n, 0, -2):
        if k == 3:
            continue
        if k < 1:
            break
        s -= k
    while s > 1.0:
        s = s / 2 if s > 3.0 else s - 1
    return s, found


@compiled
def arrays(a, i):
    out, small, bits = np.zeros((2, len(a))), np.empty(3), np.ones(4, np.bool_)
    out[0], out[1, :] = a, 2.0
    out[1, 1:3] = a[:2]
    small[:] = 7
    small[-1] += FACTOR
    bits[i] = False
    order = np.arange(5)
    order[:3] = order[:3][::-1].copy()
    joined = np.concatenate((out[:1], out, out[1:]))
    total = 0.0
    for x in a[1:]:
        total += x
    for x in PAIR:
        total *= x
    for x, y in ((1.0, a[0]), (2.0, a[1])):
        total += x * y
    return out, small, bits, order, joined, total, a[i], a[-1], out.shape, out.T[1].copy(), TABLE[1, i % 2]


@compiled
def whole_arrays(a, b):
    made = a * b + 2.0 - b / a
    made += 1.0
    return (
        made,
        made.sum(),
        made.max(),
        np.argmin(made),
        np.argmax(np.abs(b - made)),
        np.full(2, 3).sum(),
        a.view(np.int64)[0],
        a.reshape(2, -1 + 3),
    )


@compiled
def tuples(p: Point, k: int):
    q = Point(square(p.x), p.row[1:], k=p.k + 1)
    three = (p.x, q.x, 2.0)
    if k > 0:
        q = p
    x, (y, z) = three[k], (three[1], q.row[0])
    return q, x + y + z, len(three)


@compiled
def complexes(z, w):
    return z * w, z / w, z + 1.0, z - w, abs(z), z.conjugate(), z.real, z == w, -z


@compiled
def held(value: Held[Point], k: int) -> float:
    p = open_held(value)
    p.row[k] = 2.0 * p.x
    return p.row.sum() + p.k


@compiled
def views(a):
    return a[1:], a


@compiled
def too_much(n):
    return np.empty((n, n)).sum()


@compiled
def sets(x):
    for k in {1, 2}:
        x += k
    return x


@compiled
def two_kinds(x):
    y = 1.0
    if x > 0:
        y = np.empty(2)
    return y


def doubled(a, out):
    """Counted by an array."""
    for k in range(len(a)):
        out[k] = 2.0 * a[k]


def doubled_in_groups(a, out):
    """Counted by a constant."""
    for k in range(64):
        out[k] = 2.0 * a[k]
