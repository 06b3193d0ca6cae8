"""Newton's method on the loop of six joints in lanes, compiled: candidates become solutions, each noted once."""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING

import numpy as np

from mafsil.arrays import Booleans, Floats, Integers
from mafsil.ik.tolerances import CLOSED, LAST_CORRECTION, NO_BETTER, SAME
from mafsil.kernels.loops.lanes import buffer, get, lane_bits, lanes, magnitude, put, spread, square_root, where
from mafsil.kernels.loops.loop import reordered
from mafsil.solvers.angle_loops import angle_of

if TYPE_CHECKING:
    from mafsil.kernels.loops.lanes import Buffer, Lanes


STEPS = 40
"""Newton steps of a candidate at most: near a fold each halves the distance only."""
LONGEST = 0.6
"""Newton step [rad | unit of length]."""


@reordered
def polish(
    frames: Floats, prismatic: Booleans, P: Floats, rows: Integers, turns: Floats, q: Floats, size: Floats
) -> None:
    """Newton's method on candidates, eight at a time; the largest errors that remain [rad, unit of length].

    1. Free lanes take the next candidates.
    2. The loop F_0 Z_0 F_1 Z_1 ... Z_5 F_6, its axes on the way, and its error.
    3. Lanes that are done give back what they have.
    4. A Newton step of the others, of `LONGEST` at most.
    5. When no lane is left, angles from cosines and sines.

    Args:
        frames: (7, 3, 4) constants F_k.
        prismatic: (6,) which joints are prismatic.
        P: (k, 4, 4) displacements of the loop.
        rows: (m,) which of them each candidate belongs to.
        turns: (m', 12) candidates: cosine and sine of each joint, or length and zero; changed; m' is the next multiple
            of eight.
        q: (m', 6) what became of them, angles in [-pi, pi].
        size: (m',) the errors.
    """
    X, T, J, Q, T0, errors, counts = buffer(12), buffer(12), buffer(42), buffer(12), buffer(12), buffer(1), buffer(1)
    item = np.full(8, -1)
    for r in range(3):
        for c in range(4):
            T0[4 * r + c] = frames[0, r, c]
    errors[0], counts[0] = 1e300, 0.0
    following, active, vacant = 0, 0, 255
    while True:
        # 1.
        for l in range(8):
            if (vacant >> l) & 1 and following < len(rows):
                item[l], active = following, active | (1 << l)
            # Lanes that never had one repeat the first: nothing is computed from what is not there.
            if (vacant >> l) & 1 and (following < len(rows) or (item[l] < 0 and len(rows) > 0)):
                i = max(item[l], 0)
                for r in range(3):
                    for c in range(4):
                        put(X, 4 * r + c, l, P[int(rows[i]), r, c])
                for k in range(12):
                    put(Q, k, l, turns[i, k])
                put(errors, 0, l, 1e300)
                put(counts, 0, l, 0.0)
                following += 1 if following < len(rows) else 0
        if active == 0:
            break
        # 2.
        for k in range(12):
            T[k] = T0[k]
        for k in range(6):
            for r in range(3):
                J[7 * r + k], J[7 * (3 + r) + k] = T[4 * r + 2], T[4 * r + 3]
            apply_joint(T, prismatic[k], Q[2 * k], Q[2 * k + 1], frames, k + 1)
        error, before, count = _loop_error(T, X, J), errors[0], counts[0]
        errors[0], counts[0] = error, count + 1.0
        # 3.
        done = (
            (error < NO_BETTER) | (count >= STEPS - 1.0) | ((error < CLOSED) & (error > 0.5 * before)) | (error > 1e6)
        )
        vacant = lane_bits(done) & active
        for l in range(8):
            if (vacant >> l) & 1:
                size[item[l]] = get(errors, 0, l)
                for k in range(12):
                    turns[item[l], k] = get(Q, k, l)
        active &= ~vacant
        # 4.
        if active != 0:
            _columns(prismatic, T, J)
            _solve(J)
            longest = lanes(0.0)
            for k in range(6):
                longest = where(magnitude(J[7 * k + 6]) > longest, magnitude(J[7 * k + 6]), longest)
            shrink = where(longest > LONGEST, LONGEST / longest, 1.0)
            for k in range(6):
                step, c, s = shrink * J[7 * k + 6], Q[2 * k], Q[2 * k + 1]
                if prismatic[k]:
                    Q[2 * k] = c + step
                else:
                    cosine, sine = small_rotation(step)
                    Q[2 * k], Q[2 * k + 1] = c * cosine - s * sine, s * cosine + c * sine
    # 5.
    for begin in range(0, len(rows), 8):
        for l in range(8):
            i = min(begin + l, len(rows) - 1)
            for k in range(12):
                put(Q, k, l, turns[i, k])
        for k in range(6):
            value = Q[2 * k] if prismatic[k] else angle_of(Q[2 * k], Q[2 * k + 1])
            spread(q, 6 * begin + k, 6, value)


@reordered
def _loop_error(T: Buffer, X: Buffer, J: Buffer) -> Lanes:
    """The largest error of a loop, 1e300 if it is none; its components into the last column.

    Half the axis of X T^-1, which is its sine for small angles, and the displacement.

    1. Half the axis of X T^-1 and the trace, and the displacement; the largest of their parts.
    2. A trace below 1 is a rotation of more than a right angle, whose sine says too little: the error is 1 at least.
    """
    size, trace, total = lanes(0.0), lanes(0.0), lanes(0.0)
    # 1.
    for r in range(3):
        u, v = 4 * ((r + 1) % 3), 4 * ((r + 2) % 3)
        turn = lanes(0.0)
        for c in range(3):
            turn += T[u + c] * X[v + c] - T[v + c] * X[u + c]
            trace += T[4 * r + c] * X[4 * r + c]
        turn = 0.5 * turn
        way = X[4 * r + 3] - T[4 * r + 3]
        J[7 * r + 6], J[7 * (3 + r) + 6] = turn, way
        size = where(magnitude(turn) > size, magnitude(turn), size)
        size = where(magnitude(way) > size, magnitude(way), size)
        total += magnitude(turn) + magnitude(way)
    # 2.
    size = where((trace < 1.0) & (size < 1.0), 1.0, size)
    # The sum tells NaN, which the maximum may pass over.
    return where(total + magnitude(trace) < 1e6, size, 1e300)


@reordered
def _columns(prismatic: Booleans, T: Buffer, J: Buffer) -> None:
    """Columns (axis, velocity of the tip) from (axis, a point of it)."""
    for k in range(6):
        z0, z1, z2 = J[k], J[7 + k], J[14 + k]
        if prismatic[k]:
            J[k], J[7 + k], J[14 + k] = 0.0, 0.0, 0.0
            J[21 + k], J[28 + k], J[35 + k] = z0, z1, z2
        else:
            d0, d1, d2 = T[3] - J[21 + k], T[7] - J[28 + k], T[11] - J[35 + k]
            J[21 + k], J[28 + k], J[35 + k] = z1 * d2 - z2 * d1, z2 * d0 - z0 * d2, z0 * d1 - z1 * d0


@reordered
def _solve(M: Buffer) -> None:
    """Six linear equations in place by exchanged rows; the solution in the last column.

    1. The row of the largest pivot is brought forward, lane by lane.
    2. Elimination below it; a pivot that rounding has left for zero is bounded.
    3. The unknowns, from the last.
    """
    for k in range(6):
        # 1.
        for r in range(k + 1, 6):
            larger = magnitude(M[7 * r + k]) > magnitude(M[7 * k + k])
            for c in range(k, 7):
                here, there = M[7 * k + c], M[7 * r + c]
                M[7 * k + c], M[7 * r + c] = where(larger, there, here), where(larger, here, there)
        # 2.
        pivot = M[7 * k + k]
        inverse = 1.0 / where(magnitude(pivot) > LAST_CORRECTION, pivot, LAST_CORRECTION)
        for c in range(k + 1, 7):
            M[7 * k + c] = M[7 * k + c] * inverse
        for r in range(k + 1, 6):
            factor = M[7 * r + k]
            for c in range(k + 1, 7):
                M[7 * r + c] = M[7 * r + c] - factor * M[7 * k + c]
    # 3.
    for k in range(5, -1, -1):
        total = M[7 * k + 6]
        for c in range(k + 1, 6):
            total -= M[7 * k + c] * M[7 * c + 6]
        M[7 * k + 6] = total


@reordered
def note_new(
    rows: Integers, q: Floats, size: Floats, prismatic: Booleans, found: Integers, q_out: Floats, size_out: Floats
) -> None:
    """Closed candidates that are new are written down.

    Args:
        rows: (m,) place of each in the lists.
        q, size: (m, 6) candidates, their angles in [-pi, pi], and (m,) their errors.
        prismatic: (6,) which joints are prismatic.
        found: (k,) lengths of the lists.
        q_out, size_out: (k, most, 6) and (k, most) the lists.
    """
    for i in range(len(rows)):
        if not size[i] < CLOSED:
            continue
        b = rows[i]
        new = found[b] < q_out.shape[1]
        for j in range(found[b]):
            new = new and _differ(q, i, q_out[b], j, prismatic)
        if new:
            for k in range(6):
                q_out[b, found[b], k] = q[i, k]
            size_out[b, found[b]] = size[i]
            found[b] += 1


@reordered
def are_explained(zeros: Floats, joint: int, prismatic: Booleans, q: Floats, size: Floats, tolerance: float) -> bool:
    """Whether each zero of one pose has led to a solution of its own with that value of the joint.

    Args:
        zeros: (m,) of the joint.
        joint: whose value the zeros are.
        prismatic: (6,) which joints are prismatic.
        q, size: (m', 6) solutions, m' >= m, their angles in [-pi, pi], and (m',) their errors.
        tolerance: difference from its zero up to which a solution explains it [rad].
    """
    for i in range(len(zeros)):
        away = q[i, joint] - zeros[i]
        away -= 2 * pi * np.floor(away / (2 * pi) + 0.5)
        if not (size[i] < CLOSED and abs(away) < tolerance):
            return False
        for j in range(i):
            if not _differ(q, i, q, j, prismatic):
                return False
    return True


@reordered
def _differ(q: Floats, i: int, others: Floats, j: int, prismatic: Booleans) -> bool:
    """Whether two solutions are not the same."""
    for k in range(6):
        d = abs(q[i, k] - others[j, k])
        if not prismatic[k] and d > pi:
            d = 2 * pi - d
        if d > SAME:
            return True
    return False


@reordered
def apply_joint(T: Buffer, prismatic: bool, c: Lanes, s: Lanes, frames: Floats, k: int) -> None:
    """T Z F_k in place of T: the joint moves about z by an angle, or along z.

    Args:
        T: twelve places, (3, 4) by rows.
        prismatic: whether the joint is prismatic.
        c, s: cosine and sine of the angle, or length and zero.
        frames: (7, 3, 4) constants of the loop.
        k: which of them.
    """
    for r in range(3):
        x, y, z, p = T[4 * r], T[4 * r + 1], T[4 * r + 2], T[4 * r + 3]
        if prismatic:
            p += c * z
        else:
            x, y = c * x + s * y, c * y - s * x
        T[4 * r] = x * frames[k, 0, 0] + y * frames[k, 1, 0] + z * frames[k, 2, 0]
        T[4 * r + 1] = x * frames[k, 0, 1] + y * frames[k, 1, 1] + z * frames[k, 2, 1]
        T[4 * r + 2] = x * frames[k, 0, 2] + y * frames[k, 1, 2] + z * frames[k, 2, 2]
        T[4 * r + 3] = p + x * frames[k, 0, 3] + y * frames[k, 1, 3] + z * frames[k, 2, 3]


@reordered
def unit(turns: Buffer, k: int, c: Lanes, s: Lanes) -> None:
    """Cosine and sine of a joint from multiples of both; angle zero where there are none.

    Args:
        turns: places 2 k and 2 k + 1 are filled.
        k: the joint.
        c, s: multiples of cosine and sine.
    """
    length = square_root(c * c + s * s)
    turns[2 * k] = where(length > 0.0, c / length, 1.0)
    turns[2 * k + 1] = where(length > 0.0, s / length, 0.0)


@reordered
def small_rotation(step: Lanes) -> tuple[Lanes, Lanes]:
    """Cosine and sine of an angle of at most 0.6 rad, by their series: what is left out is below 1e-17."""
    x = step * step
    c = 1.0 - x / 182.0
    s = 1.0 - x / 210.0
    for k in range(12, 0, -2):
        c = 1.0 - x * c * (1.0 / (k * (k - 1.0)))
        s = 1.0 - x * s * (1.0 / (k * (k + 1.0)))
    return c, step * s
