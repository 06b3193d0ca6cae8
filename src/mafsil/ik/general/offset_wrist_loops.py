"""Arms with an offset wrist, compiled: the polynomial of the last joint, and the way back from its zeros."""

from __future__ import annotations

from math import cos, sin
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mafsil.arrays import Floats, Integers
from mafsil.floating_point import EPS, LEAST_DIVISOR
from mafsil.ik.general.elimination_loops import harmonics_of
from mafsil.ik.general.polish_loops import unit
from mafsil.kernels.loops.lanes import buffer, lanes, larger, magnitude, put, seen, spread, square_root, where
from mafsil.kernels.loops.loop import reordered

if TYPE_CHECKING:
    from mafsil.kernels.loops.lanes import Buffer, Lanes


TERMS, NUMBERS = 21, 17
"""Room for what `shoulder_to_wrist` gives, and the numbers of an arm."""


class OffsetArm(NamedTuple):
    """Constants of an arm as it is seen, from its base or from its tip.

    Attributes:
        home: (4, 4) inverse of the tip's home pose.
        middle, unit: (3,) and (1,) origin and unit of length of the loop.
        frames: (7, 3, 4) constants of the loop, see `loop_frames`.
        numbers: (17,) cosine and sine between axes 1 and 2; distance of these; place of w along axis 2; cosine and
            sine between axes 2 and 4; cosine between axes 4 and 5; w from axis 3 along axis 4 and across it; distance
            of axes 2 and 3; whether these have one sense, 1, or not, -1; and at home, in the plane of axes 2 and 3:
            the direction of axis 4, the place of axis 3; and where joint 4 begins.
        vectors: (13, 3) for w, the direction of axis 5, and a direction across it: three each, that are constant and go
            with cosine and sine of the last joint; the frame of axis 1 by rows, and its origin.
        order: (6,) coordinates of the joints.
        backwards: whether the arm is seen from its tip.
        symmetric: whether each zero gives two solutions.
    """

    home: Floats
    middle: Floats
    unit: Floats
    frames: Floats
    numbers: Floats
    vectors: Floats
    order: Integers
    backwards: bool
    symmetric: bool


class Circle(NamedTuple):
    """Where the polynomial is sampled, and how its zeros are isolated.

    Attributes:
        cosines, sines: (1, nodes) of the nodes.
        fourier: (nodes, nodes) columns of harmonics.
        degree: of the polynomial.
        waves, factors: see `circle_loops.harmonics`.
    """

    cosines: Floats
    sines: Floats
    fourier: Floats
    degree: int
    waves: Floats
    factors: Floats


@reordered
def sample(arm: OffsetArm, circle: Circle, P: Floats, moved: Floats, f: Floats, h: Floats, left: Floats) -> None:
    """The polynomials of many poses as samples and harmonics, eight nodes at a time.

    1. What the last joint turns, moved by the pose, in the frame of axis 1.
    2. The elbow's equation a + c rho, and a alone where c is zero: the product over both roots without denominator.

    Args:
        arm, circle: constants.
        P: (k, 4, 4) displacements of the loop.
        moved: (k, 27) components of w, of the direction of axis 5, and of that across it, three of each.
        f, h, left: as f, h and roundoff of `determinants`.
    """
    groups, terms, place, numbers = f.shape[1] // 8, buffer(TERMS), buffer(6), buffer(NUMBERS)
    x_all, y_all, f_all = seen(circle.cosines), seen(circle.sines), seen(f)
    for k in range(NUMBERS):
        numbers[k] = arm.numbers[k]
    for b in range(len(P)):
        # 1.
        _move(arm, P[b], moved[b])
        # 2.
        for g in range(groups):
            x, y = x_all[g], y_all[g]
            for k in range(2):
                for r in range(3):
                    place[3 * k + r] = moved[b, 9 * k + r] + x * moved[b, 9 * k + 3 + r] + y * moved[b, 9 * k + 6 + r]
            shoulder_to_wrist(numbers, place, terms)
            M, D, a, c = terms[0], terms[1], terms[2], terms[3]
            f_all[b * groups + g] = M * a if arm.symmetric else M * M * (a * a - D * c * c)
        harmonics_of(f, b, circle.fourier, circle.degree, h, left)


@reordered
def _move(arm: OffsetArm, P: Floats, moved: Floats) -> None:
    """The vectors of an arm moved by a displacement, or by its inverse, and seen from the frame of axis 1.

    Args:
        arm: its constants.
        P: (4, 4) the displacement.
        moved: (27,) components, see `sample`.
    """
    R, t, vectors = np.empty((3, 3)), np.empty(3), arm.vectors
    for r in range(3):
        t[r] = 0.0
        for c in range(3):
            R[r, c], shift = 0.0, P[c, 3]
            for j in range(3):
                R[r, c] += vectors[9 + r, j] * (P[c, j] if arm.backwards else P[j, c])
            if arm.backwards:
                shift = -(P[0, c] * P[0, 3] + P[1, c] * P[1, 3] + P[2, c] * P[2, 3])
            t[r] += vectors[9 + r, c] * (shift - vectors[12, c])
    for i in range(9):
        for r in range(3):
            value = t[r] if i == 0 else 0.0
            for j in range(3):
                value += R[r, j] * vectors[i, j]
            moved[3 * i + r] = value


@reordered
def shoulder_to_wrist(numbers: Buffer, place: Buffer, terms: Buffer) -> None:
    """The elbow's equation at values of the last joint, free of the wrist's root: numbers x + y rho as pairs (x, y).

    1. M, the square of the distance of w from axis 1, and rho^2 = D: rho is w along the normal of axes 1 and 2, and eta
       w along their plane. With them cosine and sine of joint 1 are (eta w_x + rho w_y, eta w_y - rho w_x) / M.
    2. The direction z of axis 5 in the plane of axes 2 and 3 is (u, v), and G its square; axis 4 makes kappa with it.
    3. W = (rho - a, Z) is w from axis 2. S and C are its products with (u, v) and with that turned by a right angle,
       p and s the same of the forearm (v1, v2). K is |W|^2 and the square of the forearm without that of the upper arm.
    4. Times its conjugate K G - 2 kappa p +- 2 s root(G - kappa^2) is G (K (K G - 4 kappa p) + 4 (kappa^2 |W|^2
       |forearm|^2 - s^2)): G is left out.

    Args:
        numbers: of the arm.
        place: w and z.
        terms: M, D, and pairs: the equation, (1 / M, eta), u, v, kappa, K, p, s, G; and Z.
    """
    # 1.
    wx, wy, wz, zx, zy, zz = place[0], place[1], place[2], place[3], place[4], place[5]
    cosine, sine, offset = numbers[0], numbers[1], numbers[2]
    M = wx * wx + wy * wy
    inverse, eta = 1.0 / larger(M, LEAST_DIVISOR), (numbers[3] - cosine * wz) / sine
    D = M - eta * eta
    # 2.
    dot, cross = (zx * wx + zy * wy) * inverse, (zy * wx - zx * wy) * inverse
    u0, u1, v0, v1 = eta * cross, dot, cosine * eta * dot - sine * zz, -cosine * cross
    k0 = (numbers[6] - numbers[4] * (sine * eta * dot + cosine * zz)) / numbers[5]
    k1 = numbers[4] * sine * cross / numbers[5]
    G0, G1 = u0 * u0 + v0 * v0 + D * (u1 * u1 + v1 * v1), 2.0 * (u0 * u1 + v0 * v1)
    # 3.
    Z, along, across = cosine * eta - sine * wz, numbers[7], numbers[8]
    forearm = along * along + across * across
    W0, W1 = offset * offset + D + Z * Z, -2.0 * offset
    K0 = W0 + forearm - numbers[9] * numbers[9]
    S0, S1 = D * u1 - offset * u0 + Z * v0, u0 - offset * u1 + Z * v1
    C0, C1 = Z * u0 + offset * v0 - D * v1, Z * u1 + offset * v1 - v0
    p0, p1, s0, s1 = (
        along * S0 + across * C0,
        along * S1 + across * C1,
        along * C0 - across * S0,
        along * C1 - across * S1,
    )
    # 4.
    kk0, kk1 = k0 * k0 + D * k1 * k1, 2.0 * k0 * k1
    x0 = K0 * G0 + D * W1 * G1 - 4.0 * (k0 * p0 + D * k1 * p1)
    x1 = K0 * G1 + W1 * G0 - 4.0 * (k0 * p1 + k1 * p0)
    a = K0 * x0 + D * W1 * x1 + 4.0 * (forearm * (kk0 * W0 + D * kk1 * W1) - s0 * s0 - D * s1 * s1)
    c = K0 * x1 + W1 * x0 + 4.0 * (forearm * (kk0 * W1 + kk1 * W0) - 2.0 * s0 * s1)
    terms[0], terms[1], terms[2], terms[3], terms[4], terms[5] = M, D, a, c, inverse, eta
    terms[6], terms[7], terms[8], terms[9], terms[10], terms[11] = u0, u1, v0, v1, k0, k1
    terms[12], terms[13], terms[14], terms[15], terms[16], terms[17] = K0, W1, p0, p1, s0, s1
    terms[18], terms[19], terms[20] = G0, G1, Z


@reordered
def rounding(numbers: Buffer, place: Buffer, terms: Buffer, rho: Lanes) -> Lanes:
    """By how much rounding may move the elbow's equation: each of its factors is off by EPS times its own terms.

    Args:
        numbers, place, terms: as `shoulder_to_wrist` leaves them.
        rho: root of what is positive of its square.
    """
    M, eta, Z, offset = terms[0], terms[5], terms[20], numbers[2]
    forearm = numbers[7] * numbers[7] + numbers[8] * numbers[8]
    W = offset * offset + M + eta * eta + Z * Z + 2.0 * magnitude(offset) * rho
    wrist, lengths = (magnitude(numbers[6]) + magnitude(numbers[4])) / numbers[5], W + forearm + numbers[9] * numbers[9]
    kappa = magnitude(terms[10]) + rho * magnitude(terms[11])
    K = magnitude(terms[12]) + rho * magnitude(terms[13])
    p, s = magnitude(terms[14]) + rho * magnitude(terms[15]), magnitude(terms[16]) + rho * magnitude(terms[17])
    G, product = magnitude(terms[18]) + rho * magnitude(terms[19]), square_root(forearm * W)
    total = K * (2.0 * G * lengths + K) + 4.0 * (kappa * p * lengths + K * kappa * product + K * p * wrist)
    total += 4.0 * (kappa * forearm * W * (2.0 * wrist + kappa) + 2.0 * s * product)
    return 16 * EPS * (total + magnitude(terms[3]) * (M + eta * eta) / larger(rho, LEAST_DIVISOR))


@reordered
def candidates(arm: OffsetArm, moved: Floats, rows: Integers, zeros: Floats, sides: Floats, turns: Floats) -> None:
    """All joints that go with values of the last one, eight at a time.

    1. The elbow's equation there, and the root rho that solves it, unless it is known which.
    2. The root of the wrist has the sign that makes K G - 2 kappa p - 2 s root zero: so axis 4 is known.

    Args:
        arm: its constants.
        moved: as `sample` leaves it.
        rows: (m,) which pose each belongs to.
        zeros, sides: (m,) values of the last joint, and the sign of rho, 0 where it is not known.
        turns: (m', 12) cosine and sine of each joint; m' the next multiple of eight.
    """
    numbers, place, terms, given, q = buffer(NUMBERS), buffer(9), buffer(TERMS), buffer(30), buffer(12)
    for k in range(NUMBERS):
        numbers[k] = arm.numbers[k]
    for begin in range(0, len(rows), 8):
        # 1.
        for l in range(8):
            i = min(begin + l, len(rows) - 1)
            for k in range(27):
                put(given, k, l, moved[rows[i], k])
            put(given, 27, l, cos(zeros[i]))
            put(given, 28, l, sin(zeros[i]))
            put(given, 29, l, sides[i])
        x, y = given[27], given[28]
        for k in range(3):
            for r in range(3):
                place[3 * k + r] = given[9 * k + r] + x * given[9 * k + 3 + r] + y * given[9 * k + 6 + r]
        shoulder_to_wrist(numbers, place, terms)
        rho = square_root(larger(terms[1], 0.0))
        likely = where(terms[2] * terms[3] > 0.0, lanes(-1.0), 1.0)
        rho *= where(given[29] == 0.0, likely, given[29])
        # 2.
        u, v, kappa = terms[6] + rho * terms[7], terms[8] + rho * terms[9], terms[10] + rho * terms[11]
        K, p, s = terms[12] + rho * terms[13], terms[14] + rho * terms[15], terms[16] + rho * terms[17]
        G = larger(u * u + v * v, LEAST_DIVISOR)
        root = square_root(larger(G - kappa * kappa, 0.0))
        root = where((K * G - 2.0 * kappa * p) * s < 0.0, -root, root)
        _joints(arm, place, terms, rho, (kappa * u - root * v) / G, (kappa * v + root * u) / G, q)
        unit(q, arm.order[5], x, y)
        for k in range(12):
            spread(turns, 12 * begin + k, 12, q[k])


@reordered
def _joints(arm: OffsetArm, place: Buffer, terms: Buffer, rho: Lanes, k0: Lanes, k1: Lanes, q: Buffer) -> None:
    """The first five joints from the direction (k0, k1) of axis 4 in the plane of axes 2 and 3.

    1. Joint 1, and the frame (y, n, t) of axis 2 and of that plane.
    2. The elbow, W less the forearm: joint 2 turns it there, joints 2 and 3 together turn axis 4. Seen along y, angles
       in (n, t) run backwards.
    3. Axis 4 in space: seen from it joint 4 has turned axis 5, seen from axis 5 joint 5 has turned it.
    """
    numbers, order = arm.numbers, arm.order
    wx, wy, inverse, eta = place[0], place[1], terms[4], terms[5]
    # 1.
    c, s = (eta * wx + rho * wy) * inverse, (eta * wy - rho * wx) * inverse
    unit(q, order[0], c, s)
    c, s = q[2 * order[0]], q[2 * order[0] + 1]
    y0, y1, y2 = numbers[1] * c, numbers[1] * s, numbers[0]
    # 2.
    e0, e1 = rho - numbers[2] - numbers[7] * k0 + numbers[8] * k1, terms[20] - numbers[7] * k1 - numbers[8] * k0
    unit(q, order[1], numbers[13] * e0 + numbers[14] * e1, numbers[14] * e0 - numbers[13] * e1)
    c2, s2 = q[2 * order[1]], q[2 * order[1] + 1]
    both, turned = numbers[11] * k0 + numbers[12] * k1, numbers[12] * k0 - numbers[11] * k1
    unit(q, order[2], both * c2 + turned * s2, numbers[10] * (turned * c2 - both * s2))
    # 3.
    f0 = numbers[4] * y0 + numbers[5] * (numbers[0] * c * k1 - s * k0)
    f1 = numbers[4] * y1 + numbers[5] * (numbers[0] * s * k1 + c * k0)
    f2 = numbers[4] * y2 - numbers[5] * numbers[1] * k1
    z0, z1, z2, x0, x1, x2 = place[3], place[4], place[5], place[6], place[7], place[8]
    a = z0 * y0 + z1 * y1 + z2 * y2 - numbers[4] * (z0 * f0 + z1 * f1 + z2 * f2)
    b = z0 * (f1 * y2 - f2 * y1) + z1 * (f2 * y0 - f0 * y2) + z2 * (f0 * y1 - f1 * y0)
    unit(q, order[3], a * numbers[15] + b * numbers[16], b * numbers[15] - a * numbers[16])
    a = f0 * x0 + f1 * x1 + f2 * x2
    b = f0 * (z1 * x2 - z2 * x1) + f1 * (z2 * x0 - z0 * x2) + f2 * (z0 * x1 - z1 * x0)
    unit(q, order[4], a, -b)
