"""Lists of arms with an offset wrist, compiled: from poses to solutions, and whether there are no others."""

from __future__ import annotations

from math import cos, sin
from typing import TYPE_CHECKING

import numpy as np

from mafsil.arrays import Floats, Integers
from mafsil.floating_point import EPS
from mafsil.ik.general.circle_loops import zeros_on_circles
from mafsil.ik.general.offset_wrist_loops import (
    NUMBERS,
    TERMS,
    Circle,
    OffsetArm,
    candidates,
    rounding,
    sample,
    shoulder_to_wrist,
)
from mafsil.ik.general.polish_loops import are_explained, polish
from mafsil.ik.tolerances import CLEAN, MATCHED
from mafsil.kernels.loops.entry import Held, open_held
from mafsil.kernels.loops.lanes import buffer, larger, magnitude, put, spread, square_root
from mafsil.kernels.loops.loop import reordered

if TYPE_CHECKING:
    from mafsil.kernels.loops.lanes import Buffer

DEPTH = 12
"""Times that a cell is halved, or narrowed down."""

MONOTONE, FLAT = 2.0, 0.0
"""What values of an equation show, beside their being convex, 1, or concave, -1."""

ROUNDING = 1e-13
"""Entries of R'R - 1 of poses that are taken as they are: others are brought to working precision first."""


@reordered
def solve_poses(
    held_arm: Held[OffsetArm],
    held_circle: Held[Circle],
    T: Floats,
    q: Floats,
    error: Floats,
    rows: Integers,
    count: Integers,
) -> int:
    """Proven lists of poses of the tip, one after the other; how many solutions they have together.

    Args:
        held_arm, held_circle: constants.
        T: (k, 4, 4) poses; of what is none, or is rounded, there is no list.
        q, error, rows: (16 k + 8, 6), (16 k + 8,) and (16 k + 8,) solutions, their errors in the loop, and which pose
            each belongs to.
        count: (k,) solutions of each pose; -1 where nothing is proven.
    """
    arm = open_held(held_arm)
    P, m = np.empty((len(T), 4, 4)), arm.middle
    for b in range(len(T)):
        if _is_pose(T[b]):
            for r in range(3):
                for c in range(4):
                    P[b, r, c] = T[b, r, 3] if c == 3 else 0.0
                    for j in range(3):
                        P[b, r, c] += T[b, r, j] * arm.home[j, c]
                shift = P[b, r, 3] - m[r]
                for j in range(3):
                    shift += P[b, r, j] * m[j]
                P[b, r, 3] = shift / arm.unit[0]
        else:
            P[b, 0, 0] = np.nan
    return solve_loops(held_arm, held_circle, P, q, error, rows, count)


@reordered
def _is_pose(T: Floats) -> bool:
    """Whether a matrix is a pose to working precision."""
    off, total = abs(T[3, 0]) + abs(T[3, 1]) + abs(T[3, 2]) + abs(T[3, 3] - 1.0), 0.0
    for i in range(3):
        total += abs(T[i, 3])
        for j in range(i + 1):
            dot = -1.0 if i == j else 0.0
            for r in range(3):
                dot += T[r, i] * T[r, j]
            off += abs(dot)
    volume = T[0, 0] * (T[1, 1] * T[2, 2] - T[1, 2] * T[2, 1]) - T[0, 1] * (T[1, 0] * T[2, 2] - T[1, 2] * T[2, 0])
    volume += T[0, 2] * (T[1, 0] * T[2, 1] - T[1, 1] * T[2, 0])
    # Comparisons with NaN are false.
    return off < ROUNDING and volume > 0.0 and total < 1e50


@reordered
def solve_loops(
    held_arm: Held[OffsetArm],
    held_circle: Held[Circle],
    P: Floats,
    q: Floats,
    error: Floats,
    rows: Integers,
    count: Integers,
) -> int:
    """Lists of many displacements of the loop, see `solve_poses`.

    1. The polynomials of all poses, and their zeros; those that rounding hides are looked at more closely.
    2. Zeros that are isolated, twice where each gives two solutions, lead to candidates, and these to solutions.
    3. A list is proven where each zero has a solution of its own.

    Args:
        held_arm, held_circle: constants.
        P: (k, 4, 4) displacements of the loop; NaN where there is none.
        q, error, rows, count: as for `solve_poses`.
    """
    # 1.
    arm, circle = open_held(held_arm), open_held(held_circle)
    k, nodes = len(P), circle.fourier.shape[0]
    moved, f, h, left = np.empty((k, 27)), np.empty((k, nodes)), np.empty((k, nodes)), np.empty((k, 2))
    zeros, number, certain = np.empty((k, 48)), np.empty(k, np.int64), np.empty(k, np.bool_)
    cells, hidden, close = np.empty((k, 24, 5)), np.empty(k, np.int64), np.empty((96, 2))
    sample(arm, circle, P, moved, f, h, left)
    zeros_on_circles(h, left[:, 0], circle.degree, circle.waves, circle.factors, zeros, number, certain, cells, hidden)
    # 2.
    values, sides, total = np.empty(16 * k), np.empty(16 * k), 0
    for b in range(k):
        count[b], extra = -1, 0
        if not ((certain[b] or hidden[b] > 0) and left[b, 0] <= CLEAN * left[b, 1]):
            continue
        if hidden[b] > 0:
            extra = _look_closer(arm, moved[b], cells[b], hidden[b], close)
        if extra >= 0:
            count[b] = _note_zeros(
                arm, zeros[b], number[b], cells[b], hidden[b], close[:extra], values[total:], sides[total:]
            )
        for i in range(max(0, count[b])):
            rows[total + i] = b
        total += max(0, count[b])
    turns = np.empty(((total + 7) // 8 * 8, 12))
    prismatic = np.zeros(6, np.bool_)
    candidates(arm, moved, rows[:total], values, sides, turns)
    polish(arm.frames, prismatic, P, rows[:total], turns, q, error)
    # 3.
    begin = kept = 0
    for b in range(k):
        end = begin + max(0, count[b])
        if not are_explained(values[begin:end], arm.order[5], prismatic, q[begin:end], error[begin:end], MATCHED):
            count[b] = -1
        for i in range(begin, end if count[b] >= 0 else begin):
            rows[kept], error[kept] = b, error[i]
            for j in range(6):
                q[kept, j] = q[i, j]
            kept += 1
        begin = end
    return kept


@reordered
def _note_zeros(
    arm: OffsetArm,
    zeros: Floats,
    number: int,
    cells: Floats,
    hidden: int,
    close: Floats,
    values: Floats,
    sides: Floats,
) -> int:
    """The zeros of one pose, twice where each gives two solutions; how many, -1 where these are too many.

    Args:
        arm: its constants.
        zeros, number, cells, hidden: as `zeros_on_circles` leaves them; the pairs that stand for cells are left out.
        close: (extra, 2) what is in these cells, see `_look_closer`.
        values, sides: (at least 16,) are filled; without a side that is known, 0.
    """
    copies, doubt, i, filled = 2 if arm.symmetric else 1, 0, 0, 0
    if copies * (number - 2 * max(0, hidden) + len(close)) > 16:
        return -1
    while i < number:
        if doubt < hidden and i == int(cells[doubt, 2]):
            doubt, i = doubt + 1, i + 2
            continue
        for copy in range(copies):
            values[filled], sides[filled] = zeros[i], (1.0 - 2.0 * copy) * (copies - 1)
            filled += 1
        i += 1
    for i in range(len(close)):
        for copy in range(copies):
            values[filled], sides[filled] = close[i, 0], 1.0 - 2.0 * copy if arm.symmetric else close[i, 1]
            filled += 1
    return filled


@reordered
def _look_closer(arm: OffsetArm, moved: Floats, cells: Floats, count: int, close: Floats) -> int:
    """Zeros in cells that are too narrow for the polynomial; how many, -1 where that stays in doubt.

    The equation is evaluated there itself, with the rounding of its own terms; where rho is real throughout a cell each
    of its roots has an equation of its own. That their product has the signs at the ends that were taken for granted
    keeps zeros near the ends from being counted twice, or not at all.

    Args:
        arm: its constants.
        moved: (27,) of the pose, see `sample`.
        cells: (most, 5) as `zeros_on_circles` leaves them.
        count: of cells.
        close: (96, 2) the zeros, and the side of the shoulder, 0 where that is not known.
    """
    numbers, terms, values, stack = buffer(NUMBERS), buffer(TERMS), np.empty((3, 8)), np.empty((2 * DEPTH, 3))
    for k in range(NUMBERS):
        numbers[k] = arm.numbers[k]
    found = 0
    for i in range(count):
        centre, width = cells[i, 0], cells[i, 1]
        _equation_at(arm, numbers, moved, centre, width, 0.0, terms, values)
        if (values[0, 0] < 0.0) != (cells[i, 3] < 0.0) or (values[0, 7] < 0.0) != (cells[i, 4] < 0.0):
            return -1
        if abs(values[0, 0]) <= values[1, 0] or abs(values[0, 7]) <= values[1, 7]:
            return -1
        real = True
        for l in range(8):
            real = real and values[2, l] > 0.0
        apart = real and not arm.symmetric
        for root in range(2 if apart else 1):
            side = 1.0 - 2.0 * root if apart else 0.0
            more = _zeros_of_cell(arm, numbers, moved, centre, width, side, terms, values, stack, close[found:])
            if more < 0:
                return -1
            found += more
    return found


@reordered
def _zeros_of_cell(
    arm: OffsetArm,
    numbers: Buffer,
    moved: Floats,
    centre: float,
    width: float,
    side: float,
    terms: Buffer,
    values: Floats,
    stack: Floats,
    close: Floats,
) -> int:
    """Zeros of the equation of one side in a cell; how many, -1 in doubt.

    1. Eight values: a part of the cell in which their differences have one sign is monotone, one in which second
       differences have one sign is convex, both beyond rounding; others are halved.
    2. Changes of sign are zeros, each narrowed down.
    3. Without one a convex part has none where it bends away from zero, or where the value nearest to zero stays beyond
       rounding and is not much smaller than the others; else it is looked at beside that value.

    Args:
        arm, numbers, moved, terms, values: as for `_equation_at`.
        centre, width: of the cell.
        side: 1 or -1; 0 for the product of both.
        stack: (2 DEPTH, 3) room for parts: centre, half the width, depth.
        close: (most, 2) the zeros and the side.
    """
    waiting, found = 1, 0
    stack[0, 0], stack[0, 1], stack[0, 2] = centre, width, 0.0
    while waiting > 0:
        waiting -= 1
        middle, half, depth = stack[waiting, 0], stack[waiting, 1], stack[waiting, 2]
        _equation_at(arm, numbers, moved, middle, half, side, terms, values)
        if abs(values[0, 0]) <= values[1, 0] or abs(values[0, 7]) <= values[1, 7]:
            return -1
        bend, changes, least = _shape(values), 0, 0
        for l in range(8):
            least = l if abs(values[0, l]) < abs(values[0, least]) else least
            changes += 1 if l < 7 and (values[0, l] < 0.0) != (values[0, l + 1] < 0.0) else 0
        most = max(abs(values[0, 0]), abs(values[0, 7]))
        if bend == FLAT or found + changes > len(close):
            # 1.
            if depth >= DEPTH or found + changes > len(close):
                return -1
            for part in range(2):
                stack[waiting, 0], stack[waiting, 1] = middle + half * (part - 0.5), 0.5 * half
                stack[waiting, 2] = depth + 1.0
                waiting += 1
        elif changes > 0:
            # 2.
            for l in range(7):
                if (values[0, l] < 0.0) != (values[0, l + 1] < 0.0):
                    close[found, 0], close[found, 1] = middle + half * (-1.0 + (2.0 * l + 1.0) / 7.0), side
                    found += 1
            for i in range(found - changes, found):
                close[i, 0] = _narrowed(arm, numbers, moved, close[i, 0], half / 7.0, side, terms, values)
        elif bend == MONOTONE or bend * values[0, least] < 0.0 or abs(values[0, least]) > 0.5 * most:
            # 3.
            if abs(values[0, least]) <= values[1, least]:
                return -1
        elif depth >= DEPTH:
            return -1
        else:
            stack[waiting, 0], stack[waiting, 1] = middle + half * (-1.0 + 2.0 * least / 7.0), half * 2.0 / 7.0
            stack[waiting, 2] = depth + 1.0
            waiting += 1
    return found


@reordered
def _shape(values: Floats) -> float:
    """What eight values show beyond rounding: `MONOTONE`, convex (1), concave (-1), or nothing (`FLAT`).

    Differences of one order have one sign, each larger than all of the next order: then none hides between the values.

    Args:
        values: as `_equation_at` leaves them.
    """
    steps, least, most, same = np.empty((4, 8)), np.empty(4), np.empty(4), np.empty(4, np.bool_)
    noise = 0.0
    for l in range(8):
        steps[0, l], noise = values[0, l], max(noise, values[1, l])
    for order in range(1, 4):
        least[order], most[order], same[order] = 1e300, 0.0, True
        for l in range(8 - order):
            steps[order, l] = steps[order - 1, l + 1] - steps[order - 1, l]
            least[order], most[order] = min(least[order], abs(steps[order, l])), max(most[order], abs(steps[order, l]))
            same[order] = same[order] and (steps[order, l] > 0.0) == (steps[order, 0] > 0.0)
    if same[1] and least[1] > most[2] + 6 * noise:
        return MONOTONE
    if same[2] and least[2] > most[3] + 12 * noise:
        return 1.0 if steps[2, 0] > 0.0 else -1.0
    return FLAT


@reordered
def _narrowed(
    arm: OffsetArm,
    numbers: Buffer,
    moved: Floats,
    middle: float,
    half: float,
    side: float,
    terms: Buffer,
    values: Floats,
) -> float:
    """A zero to a part in seven to the fourth of the cell about it that has a change of sign."""
    for _ in range(4):
        _equation_at(arm, numbers, moved, middle, half, side, terms, values)
        for l in range(7):
            if (values[0, l] < 0.0) != (values[0, l + 1] < 0.0):
                middle += half * (-1.0 + (2.0 * l + 1.0) / 7.0)
                break
        half /= 7.0
    return middle


@reordered
def _equation_at(
    arm: OffsetArm,
    numbers: Buffer,
    moved: Floats,
    centre: float,
    width: float,
    side: float,
    terms: Buffer,
    values: Floats,
) -> None:
    """The elbow's equation at eight values of the last joint about a centre.

    1. The point w and the direction of axis 5 at these values.
    2. The equation of a side, or the product of both, times M: where M is zero joint 1 is free, its zeros are kept.
    3. Its rounding: that of the equation's own terms, and that of M.

    Args:
        arm, numbers: its constants.
        moved: (27,) of the pose, see `sample`.
        centre, width: the values are at most that far from it.
        side: whose equation: 1 or -1, or 0 for the product of both, of a symmetric arm for the one that both share.
        terms: see `shoulder_to_wrist`.
        values: (3, 8) the equation times M, its rounding, and rho^2.
    """
    place, angles = buffer(6), buffer(2)
    # 1.
    for l in range(8):
        theta = centre + width * (-1.0 + 2.0 * l / 7.0)
        put(angles, 0, l, cos(theta))
        put(angles, 1, l, sin(theta))
    for k in range(2):
        for r in range(3):
            place[3 * k + r] = moved[9 * k + r] + angles[0] * moved[9 * k + 3 + r] + angles[1] * moved[9 * k + 6 + r]
    shoulder_to_wrist(numbers, place, terms)
    # 2.
    M, D, a, c = terms[0], terms[1], terms[2], terms[3]
    rho = square_root(larger(D, 0.0))
    product = side == 0.0 and not arm.symmetric
    value = a * a - D * c * c if product else (a if arm.symmetric else a + side * rho * c)
    # 3.
    off = rounding(numbers, place, terms, rho)
    if product:
        off *= 2.0 * magnitude(a) + 2.0 * rho * magnitude(c) + off
    off = off * M + 16 * EPS * magnitude(value) * square_root(M * (M + place[2] * place[2]))
    value *= M
    spread(values, 0, 1, value)
    spread(values, 8, 1, off)
    spread(values, 16, 1, D)
