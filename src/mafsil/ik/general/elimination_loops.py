"""The compiled elimination: from poses to determinants that are trigonometric polynomials of one joint.

Eight poses, or eight nodes of the circle, side by side.
"""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

from mafsil.arrays import Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.kernels.loops.lanes import buffer, lanes, magnitude, put, seen, spread, square_root, where
from mafsil.kernels.loops.loop import reordered

if TYPE_CHECKING:
    from mafsil.kernels.loops.lanes import Buffer, Lanes


@reordered
def eliminate(
    P: Floats,
    before: Floats,
    lines: int,
    after: Floats,
    products: Floats,
    left: Floats,
    unit: Floats,
    A: Floats,
    Q: Floats,
    R: Floats,
) -> None:
    """Six equations in c, d, e for eight poses at a time, and the linear map that gives a and b from these.

    1. The fourteen functions of nine lines moved by the pose, and from them the coefficients C of the products of a
       and b.
    2. Householder reflections of the eight columns of these products.
    3. The orthogonal factor: its first eight columns belong to the products of a and b, the others span the left null
       space.
    4. The products of the latter with `left` are the six equations.

    Args:
        P: (k, 4, 4) displacements of the loop.
        before, lines, after, products, left, unit: constants of an elimination order.
        A: (k', 6, 27) coefficients of the six equations, k' the next multiple of eight.
        Q: (k', 8, 15) products of the first columns with the fourteen functions, and with the constants, negative.
        R: (k', 36) the triangular factor, column by column, each with its diagonal entry at the end.
    """
    X, S, C, w, scale, diagonal = buffer(12), buffer(126), buffer(126), buffer(14), buffer(8), buffer(8)
    for begin in range(0, len(P), 8):
        for l in range(8):
            b = min(begin + l, len(P) - 1)
            for r in range(3):
                for c in range(4):
                    put(X, 4 * r + c, l, P[b, r, c])
        # 1.
        _lines(X, before, lines, after, S)
        for r in range(14):
            for c in range(9):
                total = lanes(0.0)
                for k in range(9):
                    total += S[9 * r + k] * products[k, c]
                # Column by column; the first is the constant.
                C[14 * c + r] = total
        # 2.
        for k in range(8):
            head, square = C[14 * (k + 1) + k], lanes(0.0)
            for r in range(k, 14):
                square += C[14 * (k + 1) + r] * C[14 * (k + 1) + r]
            norm = square_root(square)
            alpha = where(head > 0.0, -norm, norm)
            C[14 * (k + 1) + k] = head - alpha
            factor = where(norm == 0.0, 0.0, 1.0 / (norm * magnitude(head - alpha)))
            scale[k], diagonal[k] = factor, alpha
            for c in range(k + 2, 9):
                dot = lanes(0.0)
                for r in range(k, 14):
                    dot += C[14 * (k + 1) + r] * C[14 * c + r]
                dot *= factor
                for r in range(k, 14):
                    C[14 * c + r] = C[14 * c + r] - dot * C[14 * (k + 1) + r]
        place = 0
        for k in range(8):
            for j in range(k + 1):
                spread(R, 36 * begin + place, 36, C[14 * (k + 1) + j] if j < k else diagonal[k])
                place += 1
        # 3.
        for c in range(14):
            for r in range(14):
                w[r] = 1.0 if r == c else 0.0
            for k in range(min(c, 7), -1, -1):
                dot = lanes(0.0)
                for r in range(k, 14):
                    dot += C[14 * (k + 1) + r] * w[r]
                dot *= scale[k]
                for r in range(k, 14):
                    w[r] = w[r] - dot * C[14 * (k + 1) + r]
            constant = lanes(0.0)
            for r in range(14):
                constant += w[r] * C[r]
            if c < 8:
                for r in range(14):
                    spread(Q, 120 * begin + 15 * c + r, 120, w[r])
                spread(Q, 120 * begin + 15 * c + 14, 120, -constant)
            else:
                # 4.
                for j in range(27):
                    total = lanes(0.0)
                    for r in range(14):
                        total += w[r] * left[r, j]
                    if j < 9 and j % 3 == 0:
                        total -= constant * unit[j // 3]
                    spread(A, 162 * begin + 27 * (c - 8) + j, 162, total)


@reordered
def _lines(X: Buffer, before: Floats, lines: int, after: Floats, S: Buffer) -> None:
    """The fourteen functions of nine lines moved by a pose.

    1. A line of the loop's beginning, a point and a direction, moved by the pose.
    2. The same seen from the loop's end: p and l.
    3. The functions p, p . p, l, p . l, p x l, and (p . p) l - 2 (p . l) p.

    Reference:
        M. Raghavan, B. Roth, Inverse kinematics of the general 6R manipulator and related linkages, J. Mech. Des.
        115(3), 1993.
    """
    p, l = buffer(3), buffer(3)
    for k in range(9):
        i, j = k // lines, k % lines
        # 1.
        for r in range(3):
            point, way = X[4 * r + 3], lanes(0.0)
            for c in range(3):
                point += X[4 * r + c] * before[j, c]
                way += X[4 * r + c] * before[j, 3 + c]
            S[9 * r + k], S[9 * (4 + r) + k] = point, way
        # 2.
        for r in range(3):
            point, way = lanes(after[i, r, 3]), lanes(0.0)
            for c in range(3):
                point += after[i, r, c] * S[9 * c + k]
                way += after[i, r, c] * S[9 * (4 + c) + k]
            p[r], l[r] = point, way
        # 3.
        pp = p[0] * p[0] + p[1] * p[1] + p[2] * p[2]
        pl = p[0] * l[0] + p[1] * l[1] + p[2] * l[2]
        S[9 * 3 + k], S[9 * 7 + k] = pp, pl
        for r in range(3):
            u, v = (r + 1) % 3, (r + 2) % 3
            S[9 * r + k], S[9 * (4 + r) + k] = p[r], l[r]
            S[9 * (8 + r) + k] = p[u] * l[v] - p[v] * l[u]
            S[9 * (11 + r) + k] = pp * l[r] - 2.0 * pl * p[r]


@reordered
def determinants(
    A: Floats,
    cosines: Floats,
    sines: Floats,
    weights: Floats,
    fourier: Floats,
    degree: int,
    f: Floats,
    h: Floats,
    roundoff: Floats,
) -> None:
    """The determinants of the twelve equations at nodes of joint c, eight nodes at a time, and their harmonics.

    1. The equations at the nodes, as coefficients of the half angle of joint d.
    2. Two orthogonal triangulations of six by three, of the equations multiplied by its cosine and by its sine.
    3. One of the six by six that is left; the sign is that of a fixed number of reflections.
    4. Harmonics of the samples; those beyond the degree must be zero, and say how large their rounding is.

    Args:
        A: (k', 6, 27) coefficients.
        cosines, sines, weights: (k, nodes), or (1, nodes) for all; nodes are a multiple of eight.
        fourier: (nodes, nodes) columns of harmonics, cosines first.
        degree: of the polynomials.
        f: (k, nodes) the determinants times their weights.
        h: (k, nodes) a_0, a_1, ..., b_1, b_2, ..., and the rest.
        roundoff: (k, 2) 1.5 times the root mean square of those that must be zero, and the sum of the sizes of the
            others.
    """
    groups, rows = f.shape[1] // 8, len(cosines)
    M, K = buffer(54), buffer(36)
    x_all, y_all, w_all, f_all = seen(cosines), seen(sines), seen(weights), seen(f)
    for b in range(len(f)):
        for g in range(groups):
            at = min(b, rows - 1) * groups + g
            x, y, out = x_all[at], y_all[at], w_all[at]
            # One place that calls the reflections, so that they are compiled once.
            for part in range(3):
                columns = 9 if part < 2 else 6
                if part < 2:
                    # 1. The second half starts with the last block.
                    for r in range(6):
                        for j in range(9):
                            source = j if part == 0 else (6 + j if j < 3 else j - 3)
                            M[9 * r + j] = A[b, r, source] + x * A[b, r, 9 + source] + y * A[b, r, 18 + source]
                else:
                    for r in range(6):
                        for j in range(6):
                            M[9 * r + j] = K[6 * r + j]
                # 2. and 3.
                for k in range(3 if part < 2 else 5):
                    out *= reflect_column(M, k, 9, columns)
                if part < 2:
                    for r in range(3):
                        for j in range(6):
                            K[6 * (3 * part + r) + j] = M[9 * (3 + r) + 3 + j]
            f_all[b * groups + g] = out * M[9 * 5 + 5]
        # 4.
        harmonics_of(f, b, fourier, degree, h, roundoff)


@reordered
def harmonics_of(f: Floats, b: int, fourier: Floats, degree: int, h: Floats, roundoff: Floats) -> None:
    """Harmonics of the samples of one polynomial, see `determinants`.

    Args:
        f, fourier, degree, h, roundoff: as there.
        b: which of the polynomials.
    """
    groups = f.shape[1] // 8
    h_all, waves = seen(h), seen(fourier)
    for g in range(groups):
        total = lanes(0.0)
        for l in range(8 * groups):
            total += f[b, l] * waves[l * groups + g]
        h_all[b * groups + g] = total
    square = size = 0.0
    for i in range(8 * groups):
        if i <= 2 * degree:
            size += abs(h[b, i])
        else:
            square += h[b, i] * h[b, i]
    roundoff[b, 0], roundoff[b, 1] = 1.5 * sqrt(square / (8 * groups - 2 * degree - 1)), size


@reordered
def reflect_column(M: Buffer, k: int, stride: int, columns: int) -> Lanes:
    """One Householder step of six rows in place; the new diagonal entry.

    1. The column from the diagonal down becomes (alpha, 0, ...), alpha of the sign that does not cancel; the mirror's
       normal is their difference.
    2. The other columns are mirrored: twice their part along the normal is taken from them.

    Args:
        M: places by rows.
        k: the step.
        stride: from row to row.
        columns: how many there are.
    """
    # 1.
    square = lanes(0.0)
    for r in range(k, 6):
        square += M[stride * r + k] * M[stride * r + k]
    norm, x = square_root(square), M[stride * k + k]
    alpha = where(x > 0.0, -norm, norm)
    head = x - alpha
    M[stride * k + k] = head
    # 2.
    beta = 1.0 / (norm * magnitude(head) + LEAST_DIVISOR)
    for j in range(k + 1, columns):
        dot = lanes(0.0)
        for r in range(k, 6):
            dot += M[stride * r + k] * M[stride * r + j]
        dot *= beta
        for r in range(k, 6):
            M[stride * r + j] = M[stride * r + j] - dot * M[stride * r + k]
    M[stride * k + k] = alpha
    return alpha
