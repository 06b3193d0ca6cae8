"""Loops in lanes that only the tests call."""

from __future__ import annotations

from mafsil.kernels.loops.lanes import (
    any_lane,
    buffer,
    get,
    lane_bits,
    lanes,
    looked_up,
    magnitude,
    part,
    put,
    rounded_down,
    seen,
    spread,
    square_root,
    where,
)  # fmt: skip
from mafsil.kernels.loops.loop import reordered
from mafsil.solvers.angle_loops import angle_of


@reordered
def arithmetic(x, y, out):
    """Every operation once, of rows x and y of eight numbers, into the rows of out."""
    a, b = seen(x)[0], seen(y)[0]
    results = seen(out)
    results[0] = a + b * 2.0 - 1.0 / b
    results[1] = square_root(magnitude(a)) / b
    results[2] = where((a > b) & ~(a < 0.0) | (b >= 3.0), a, -b)
    total = lanes(0.5)
    total += a
    total *= b
    total -= 1.0
    total /= 2.0
    results[3] = total
    some = buffer(3)
    for i in range(3):
        some[i] = float(i)
    put(some, 1, 5, 7.5)
    later = part(some, 1)
    results[4] = later[0] + some[2]
    out[5, 0] = get(some, 1, 5)
    spread(out, 6 * 8, 1, a)
    return lane_bits(a > b), any_lane(a == b)


@reordered
def angles(cosines, sines, out):
    """The angle of each column."""
    seen(out)[0] = angle_of(seen(cosines)[0], seen(sines)[0])


@reordered
def table(x, numbers, out):
    """Each column rounded down, and what stands in a table at its magnitude."""
    a, results = seen(x)[0], seen(out)
    results[0] = rounded_down(a)
    results[1] = looked_up(numbers, magnitude(a))
