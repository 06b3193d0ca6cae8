"""Eight complex numbers side by side: pairs of lanes (re, im), and small linear systems of them by elimination.

A buffer holds number k in its places 2 k (real parts) and 2 k + 1 (imaginary parts).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from mafsil.kernels.loops.lanes import magnitude, where
from mafsil.kernels.loops.loop import compiled, inlined

if TYPE_CHECKING:
    from mafsil.kernels.loops.lanes import Buffer, Lanes

    Complex: TypeAlias = tuple[Lanes, Lanes]

UNKNOWNS, COLUMNS = 6, 8
"""Of a system: rows of a matrix with two right sides beside it."""


@inlined
def number(r: Buffer, k: int) -> Complex:
    """Number k of a buffer."""
    return r[2 * k], r[2 * k + 1]


@inlined
def keep(r: Buffer, k: int, a: Complex) -> None:
    """Number k of a buffer set."""
    r[2 * k], r[2 * k + 1] = a[0], a[1]


@inlined
def plus(a: Complex, b: Complex) -> Complex:
    """A + b."""
    return a[0] + b[0], a[1] + b[1]


@inlined
def minus(a: Complex, b: Complex) -> Complex:
    """A - b."""
    return a[0] - b[0], a[1] - b[1]


@inlined
def scale_complex(share: Lanes | float, a: Complex) -> Complex:
    """A real number times a."""
    return a[0] * share, a[1] * share


@inlined
def times(a: Complex, b: Complex) -> Complex:
    """A b."""
    return a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]


@inlined
def plus_times(s: Complex, a: Complex, b: Complex) -> Complex:
    """S + a b."""
    return s[0] + a[0] * b[0] - a[1] * b[1], s[1] + a[0] * b[1] + a[1] * b[0]


@inlined
def minus_times(s: Complex, a: Complex, b: Complex) -> Complex:
    """S - a b."""
    return s[0] - a[0] * b[0] + a[1] * b[1], s[1] - a[0] * b[1] - a[1] * b[0]


@inlined
def inverse_of(a: Complex) -> Complex:
    """1 / a; of zero, no number."""
    over = 1.0 / (a[0] * a[0] + a[1] * a[1])
    return a[0] * over, -a[1] * over


@inlined
def extent(a: Complex) -> Lanes:
    """|re a| + |im a|: as good as the absolute value for the choice of a pivot, and no square root."""
    return magnitude(a[0]) + magnitude(a[1])


@compiled
def solve_in_lanes(M: Buffer) -> None:
    """Two right sides become solutions: systems of six complex equations, one in each lane.

    1. Column by column, each lane brings its largest entry below the diagonal up, a comparison and an exchange a row.
    2. The rows below lose their entry of that column.
    3. Back from the last row. Lanes whose matrix is singular get infinities or no numbers.

    Args:
        M: (6, 8) numbers by rows, matrices and right sides; spent, the last two columns are the solutions.
    """
    for c in range(UNKNOWNS):
        # 1.
        top = COLUMNS * c
        size = extent(number(M, top + c))
        for i in range(c + 1, UNKNOWNS):
            low = COLUMNS * i
            other = extent(number(M, low + c))
            larger = other > size
            size = where(larger, other, size)
            for j in range(2 * c, 2 * COLUMNS):
                a, b = M[2 * top + j], M[2 * low + j]
                M[2 * top + j], M[2 * low + j] = where(larger, b, a), where(larger, a, b)
        # 2.
        over = inverse_of(number(M, top + c))
        keep(M, top + c, over)
        for i in range(c + 1, UNKNOWNS):
            low = COLUMNS * i
            factor = times(number(M, low + c), over)
            for j in range(c + 1, COLUMNS):
                keep(M, low + j, minus_times(number(M, low + j), factor, number(M, top + j)))
    # 3.
    for c in range(UNKNOWNS - 1, -1, -1):
        top = COLUMNS * c
        first, second = number(M, top + UNKNOWNS), number(M, top + UNKNOWNS + 1)
        for i in range(c + 1, UNKNOWNS):
            entry = number(M, top + i)
            first = minus_times(first, entry, number(M, COLUMNS * i + UNKNOWNS))
            second = minus_times(second, entry, number(M, COLUMNS * i + UNKNOWNS + 1))
        over = number(M, top + c)
        keep(M, top + UNKNOWNS, times(first, over))
        keep(M, top + UNKNOWNS + 1, times(second, over))
