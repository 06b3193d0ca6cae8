"""The compiled way back: from a zero of the determinant to the other joints, eight zeros at a time."""

from __future__ import annotations

from math import cos, sin
from typing import TYPE_CHECKING, NamedTuple

from mafsil.arrays import Booleans, Floats, Integers
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.ik.general.elimination_loops import reflect_column
from mafsil.ik.general.polish_loops import apply_joint, unit
from mafsil.kernels.loops.lanes import buffer, lanes, magnitude, part, put, spread, square_root, where
from mafsil.kernels.loops.loop import reordered

if TYPE_CHECKING:
    from mafsil.kernels.loops.lanes import Buffer, Lanes


class Loop(NamedTuple):
    """The closed chain of an arm and the order in which its joints are eliminated.

    Attributes:
        frames: (7, 3, 4) constants of the loop, see `close_loops`.
        prismatic: (6,) which joints are prismatic.
        order: (6,) coordinates a, b, c, d, e, f.
        left: (14, 27) constants of that order.
        twist: where the half angle of joint d is zero.
    """

    frames: Floats
    prismatic: Booleans
    order: Integers
    left: Floats
    twist: float


class Systems(NamedTuple):
    """What `eliminated` leaves of k poses: six equations, and the maps to a and b.

    Attributes:
        A: (k, 6, 27) the equations.
        Q, R: (k, 8, 15) and (k, 36) orthogonal and triangular factors.
    """

    A: Floats
    Q: Floats
    R: Floats


class Zeros(NamedTuple):
    """Zeros of the determinant.

    Attributes:
        c: (m,) values of joint c.
        rows, poses: (m,) which of the systems, and which of the displacements, each belongs to.
    """

    c: Floats
    rows: Integers
    poses: Integers


@reordered
def candidates(
    loop: Loop, P: Floats, systems: Systems, zeros: Zeros, turn: float, pick: int, turns: Floats, rank: Floats
) -> None:
    """All joints that go with zeros of the determinant, and how well each zero determines them.

    1. The equations at the zeros; the half angle of joint d is turned before.
    2. A triangulation of six by three of the equations times its cosine, and of those times its sine.
    3. The null vector of the six by six that is left, by reflections with exchanged columns: products of (c, s), the
       half angle of d, with (1, cos, sin) of e.
    4. The functions that c, d, e move give the products of a and b, by the orthogonal and the triangular factor.
    5. The joint f is what is left of the loop.

    Args:
        loop: of the arm.
        P: (k, 4, 4) displacements of the loop.
        systems: of the poses.
        zeros: m of them.
        turn: angle by which that half angle is turned before; at 0 and 90 degrees beyond it nothing can be found.
        pick: which null vector, see `_null_vector`.
        turns: (m', 12) cosine and sine of each joint, or length and zero; m' the next multiple of eight.
        rank: (m',) smallest pivot.
    """
    E, S, N, X, q = buffer(54), buffer(36), buffer(6), buffer(12), buffer(12)
    forward, triangle, middle = buffer(120), buffer(36), buffer(5)
    A, Q, R, order = systems.A, systems.Q, systems.R, loop.order
    for begin in range(0, len(zeros.c), 8):
        # 1.
        for l in range(8):
            i = min(begin + l, len(zeros.c) - 1)
            b, x, y = zeros.rows[i], cos(zeros.c[i]), sin(zeros.c[i])
            for r in range(6):
                for j in range(9):
                    put(E, 9 * r + j, l, A[b, r, j] + x * A[b, r, 9 + j] + y * A[b, r, 18 + j])
            for r in range(8):
                for j in range(15):
                    put(forward, 15 * r + j, l, Q[b, r, j])
            for r in range(36):
                put(triangle, r, l, R[b, r])
            for r in range(3):
                for j in range(4):
                    put(X, 4 * r + j, l, P[zeros.poses[i], r, j])
            put(q, 2 * order[2], l, x)
            put(q, 2 * order[2] + 1, l, y)
        # 2.
        _triangulate(E, cos(turn), sin(turn), S)
        # 3.
        spread(rank, begin, 1, _null_vector(S, pick, N))
        _middle_joints(N, order, loop.prismatic, loop.twist, turn, q, middle)
        # 4.
        _outer_joints(forward, triangle, loop.left, middle, order, loop.prismatic, q)
        # 5.
        _last_joint(X, loop.frames, order, loop.prismatic, q)
        for k in range(12):
            spread(turns, 12 * begin + k, 12, q[k])


@reordered
def _triangulate(E: Buffer, C: float, D: float, S: Buffer) -> None:
    """What is left of the equations times cosine, and times sine, of a half angle turned by (C, D): six by six.

    1. Coefficients of (c^2, c s, s^2) of the half angle become those of the turned one.
    2. Times cosine they belong to (c^3, c^2 s, c s^2), times sine to (c^2 s, c s^2, s^3): the cube comes first.
    3. Three reflections leave of each half three rows without its cube.
    """
    M = buffer(54)
    for half in range(2):
        for r in range(6):
            for j in range(3):
                at = 9 * r + j
                # 1.
                m0, m1, m2 = E[at], E[at + 3], E[at + 6]
                t0 = C * C * m0 + C * D * m1 + D * D * m2
                t1 = 2.0 * C * D * (m2 - m0) + (C * C - D * D) * m1
                t2 = D * D * m0 - C * D * m1 + C * C * m2
                # 2.
                M[at + (0 if half == 0 else 3)] = t0
                M[at + (3 if half == 0 else 6)] = t1
                M[at + (6 if half == 0 else 0)] = t2
        # 3.
        for k in range(3):
            reflect_column(M, k, 9, 9)
        for r in range(3):
            for j in range(6):
                S[6 * (3 * half + r) + j] = M[9 * (3 + r) + 3 + j]


@reordered
def _middle_joints(
    N: Buffer, order: Integers, prismatic: Booleans, twist: float, turn: float, q: Buffer, middle: Buffer
) -> None:
    """Joints d and e from the null vector.

    1. Of the three pairs that are (c, s) times a number the largest gives (c, s), and these the three numbers.
    2. Joint d: the double of the half angle, beyond `twist`.
    3. Joint e: the ratio of the numbers.

    Args:
        N: 6 places.
        order, prismatic, twist, turn: as for `candidates`.
        q: 12 places; those of d and e are filled.
        middle: 5 places: (c^2, c s, s^2) of d, and cos and sin, or length and its square, of e.
    """
    # 1.
    c, s, most = N[0], N[3], magnitude(N[0]) + magnitude(N[3])
    for j in range(1, 3):
        size = magnitude(N[j]) + magnitude(N[3 + j])
        c, s, most = where(size > most, N[j], c), where(size > most, N[3 + j], s), where(size > most, size, most)
    length = square_root(c * c + s * s)
    c, s = c / length, s / length
    one, cosine, sine = c * N[0] + s * N[3], c * N[1] + s * N[4], c * N[2] + s * N[5]
    c, s = c * cos(turn) - s * sin(turn), c * sin(turn) + s * cos(turn)
    # 2.
    d, e = 2 * order[3], 2 * order[4]
    if prismatic[order[3]]:
        ratio = s / where(c == 0.0, LEAST_DIVISOR, c)
        q[d], q[d + 1] = ratio - twist, 0.0
        c, s = lanes(1.0), ratio
    else:
        double, both = c * c - s * s, 2.0 * c * s
        q[d], q[d + 1] = double * cos(twist) - both * sin(twist), double * sin(twist) + both * cos(twist)
    middle[0], middle[1], middle[2] = c * c, c * s, s * s
    # 3.
    if prismatic[order[4]]:
        value = cosine / where(one == 0.0, LEAST_DIVISOR, one)
        q[e], q[e + 1] = value, 0.0
        middle[3], middle[4] = value, value * value
    else:
        length = square_root(cosine * cosine + sine * sine) * where(one > 0.0, lanes(1.0), -1.0) + LEAST_DIVISOR
        middle[3], middle[4] = cosine / length, sine / length
        unit(q, order[4], middle[3], middle[4])


@reordered
def _outer_joints(
    forward: Buffer, triangle: Buffer, left: Floats, middle: Buffer, order: Integers, prismatic: Booleans, q: Buffer
) -> None:
    """Joints a and b: the functions that c, d, e move, reflected, and the triangular system of the products.

    1. Products of (c^2, c s, s^2) of d with (1, cos, sin) of e, and these times (1, cos, sin) of c.
    2. The fourteen functions that c, d, e move, as combinations of these products.
    3. The right side: the functions by the orthogonal factor, and the constants.
    4. The products of a and b by the triangular factor, from the last.
    5. Cosine and sine of each joint, or its length, are among the products.
    """
    # 1.
    products, functions, x = buffer(27), buffer(14), buffer(8)
    c, s = q[2 * order[2]], q[2 * order[2] + 1]
    for j in range(3):
        for k in range(3):
            product, at = middle[j] if k == 0 else middle[j] * middle[2 + k], 3 * j + k
            products[at], products[9 + at], products[18 + at] = product, c * product, s * product
    # 2.
    for r in range(14):
        value = lanes(0.0)
        for j in range(27):
            value += left[r, j] * products[j]
        functions[r] = value
    # 3.
    for k in range(8):
        value = forward[15 * k + 14]
        for r in range(14):
            value += forward[15 * k + r] * functions[r]
        x[k] = value
    # 4.
    # Column by column, from the last.
    place = 36
    for k in range(7, -1, -1):
        place -= k + 1
        pivot = triangle[place + k]
        value = where(pivot == 0.0, 0.0, x[k] / pivot)
        x[k] = value
        for j in range(k):
            x[j] = x[j] - triangle[place + j] * value
    # 5.
    # Products (i, j) of a and b without the first: b1, b2, a1, a1 b1, a1 b2, a2, ...
    for k in range(2):
        cosine, sine = x[2 if k == 0 else 0], x[5 if k == 0 else 1]
        if prismatic[order[k]]:
            q[2 * order[k]], q[2 * order[k] + 1] = cosine, 0.0
        else:
            unit(q, order[k], cosine, sine)


@reordered
def _last_joint(X: Buffer, frames: Floats, order: Integers, prismatic: Booleans, q: Buffer) -> None:
    """Joint f from what is left of the loop, seen in its frame.

    1. The loop before it, F_0 Z_0 F_1 ... F_f, and after it, F_(f + 1) Z_(f + 1) ... F_6.
    2. x axis of the moved frame in the frame before it.
    """
    ends, f = buffer(24), order[5]
    # 1.
    for side in range(2):
        T, start = part(ends, 12 * side), 0 if side == 0 else f + 1
        for r in range(3):
            for j in range(4):
                T[4 * r + j] = frames[start, r, j]
        for k in range(start, f if side == 0 else 6):
            apply_joint(T, prismatic[k], q[2 * k], q[2 * k + 1], frames, k + 1)
    # 2.
    cosine, sine = lanes(0.0), lanes(0.0)
    for r in range(3):
        moved = X[4 * r] * ends[12] + X[4 * r + 1] * ends[13] + X[4 * r + 2] * ends[14]
        cosine += ends[4 * r] * moved
        sine += ends[4 * r + 1] * moved
    unit(q, f, cosine, sine)


@reordered
def _null_vector(S: Buffer, pick: int, N: Buffer) -> Lanes:
    """A null vector of eight matrices of six by six; their smallest pivot but one, relative to the largest.

    1. Reflections, before each of which the longest column is brought forward.
    2. The null vector of the triangular factor; two of them where a plane is requested.
    3. The columns' places restored.
    4. Of a plane, the vector that is a product.

    Args:
        S: 36 places, left triangular.
        pick: 0 for the null vector; 1 and -1 where two zeros are so close that the null space is a plane, for the two
            vectors in it that are products of the half angle of d with values of e, so that 2 x 3 minors vanish.
        N: 6 places, the vector.
    """
    order, z, V = buffer(6), buffer(12), buffer(12)
    for j in range(6):
        order[j] = float(j)
    # 1.
    for k in range(5):
        longest = lanes(0.0)
        for r in range(k, 6):
            longest += S[6 * r + k] * S[6 * r + k]
        for j in range(k + 1, 6):
            square = lanes(0.0)
            for r in range(k, 6):
                square += S[6 * r + j] * S[6 * r + j]
            longer = square > longest
            longest = where(longer, square, longest)
            for r in range(6):
                here, there = S[6 * r + k], S[6 * r + j]
                S[6 * r + k], S[6 * r + j] = where(longer, there, here), where(longer, here, there)
            here, there = order[k], order[j]
            order[k], order[j] = where(longer, there, here), where(longer, here, there)
        reflect_column(S, k, 6, 6)
    # 2.
    for v in range(2 if pick != 0 else 1):
        base = 6 * v
        z[base + 4], z[base + 5] = float(v), 1.0 - v
        if pick == 0:
            z[4] = where(S[28] == 0.0, 0.0, -S[29] / S[28])
        for r in range(3, -1, -1):
            total = lanes(0.0)
            for j in range(r + 1, 6):
                total -= S[6 * r + j] * z[base + j]
            z[base + r] = where(S[7 * r] == 0.0, 0.0, total / S[7 * r])
        # 3.
        for i in range(6):
            value = lanes(0.0)
            for j in range(6):
                value = where(order[j] == float(i), z[base + j], value)
            V[base + i] = value
    # 4.
    first, second = lanes(1.0), lanes(0.0)
    if pick != 0:
        most = lanes(0.0)
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            a = V[i] * V[3 + j] - V[j] * V[3 + i]
            b = V[i] * V[9 + j] + V[6 + i] * V[3 + j] - V[j] * V[9 + i] - V[6 + j] * V[3 + i]
            c = V[6 + i] * V[9 + j] - V[6 + j] * V[9 + i]
            size = magnitude(a) + magnitude(b) + magnitude(c)
            larger = size > most
            most = where(larger, size, most)
            square = b * b - 4.0 * a * c
            root = square_root(where(square > 0.0, square, 0.0))
            half = -0.5 * (b + where(b > 0.0, root, -root))
            first = where(larger, c if pick > 0 else half, first)
            second = where(larger, half if pick > 0 else a, second)
        for j in range(6):
            N[j] = first * V[j] + second * V[6 + j]
    else:
        for j in range(6):
            N[j] = V[j]
    return magnitude(S[28]) / (magnitude(S[0]) + LEAST_DIVISOR)
