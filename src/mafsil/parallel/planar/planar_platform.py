"""A body of the plane held by three distances, as by three legs RPR: all its poses, through a polynomial of degree six.

With P = p + R b_1 - a_1, A_i = a_i - a_1, B_i = b_i - b_1 and w_i = R B_i - A_i the differences of the equations
|P + w_i|^2 = s_i^2 are linear: P . w_i = k_i. Cramer's rule gives P, and |P|^2 = s_1^2 becomes with the half angle
t = tan(phi / 2) a polynomial of degree eight that 1 + t^2 divides: the sextic.

1. Its values at points of the circle phi, as N_x^2 + N_y^2 - s_1^2 D^2: a trigonometric polynomial of degree three.
2. Its coefficients by the discrete Fourier transform; zeros as eigenvalues, also phi = pi, where t is infinite.
3. From phi to P; where D = 0 too, P is where a line and a circle meet, or the sextic says nothing about P.
4. Newton's method on (x, y, phi) with the three distances.
5. A leg of length zero pins the body, and Newton's method finds no slope: another leg gives the angle.

Reference: Gosselin, Sefrioui, Richard, Polynomial solutions to the direct kinematic problem of planar three-degree-of-
freedom parallel manipulators, Mech. Mach. Theory 27, 1992.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Booleans, Floats, Integers
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.mobility.spaces.planar_positions import wrap_angle
from mafsil.solvers.local_dimension import SPLIT, multiplicity
from mafsil.solvers.null_ways import FINEST, Equations, solved_in_planes

DEGREE = 3
SAMPLES = 8
NEAR_CIRCLE = 3e-3
"""Zeros exp(i phi) this near to the unit circle are tried as real angles: triple ones split by 1e-5."""
POLISH = 40
FITS = 1e-11
"""Error of a distance, over the size, of a pose that is kept: double poses stop at 1e-13."""
SAME = 1e-6
"""Poses that differ by less are one: a double one splits by 1e-8."""
FLAT = 1e-5
"""Sine of the angle of both lines below which P is sought where one of them meets the circle."""
ROUNDING = 1e-15
"""Steps and errors below it are rounding, lengths over the size."""
SINGULAR = 1e-6
"""Determinant of the lines over their lengths below which poses are looked at; and singular values that count as zero:
double poses stand at the root of rounding."""
VANISHING = 1e-12
"""Coefficients below this share of what they are made of are zero: the sextic vanishes."""


def resultant(a: Floats, b: Floats, s: Floats, phi: Floats) -> Floats:
    """(k, m) N_x^2 + N_y^2 - s_1^2 D^2 at angles phi (m,), for ends (k, 3, 2), (k, 3, 2) and lengths (k, 3)."""
    D, N = _cramer(a[:, None], b[:, None], s[:, None], phi[None])
    return (N**2).sum(axis=-1) - s[:, None, 0] ** 2 * D**2


def _cramer(a: Floats, b: Floats, s: Floats, phi: Floats) -> tuple[Floats, Floats]:
    """D (*batch,) and N (*batch, 2) with P = N / D."""
    w, k = _linear(a, b, s, phi)
    D = w[..., 0, 0] * w[..., 1, 1] - w[..., 0, 1] * w[..., 1, 0]
    N_x = k[..., 0] * w[..., 1, 1] - k[..., 1] * w[..., 0, 1]
    N_y = k[..., 1] * w[..., 0, 0] - k[..., 0] * w[..., 1, 0]
    return D, np.stack([N_x, N_y], axis=-1)


def _linear(a: Floats, b: Floats, s: Floats, phi: Floats) -> tuple[Floats, Floats]:
    """W (*batch, 2, 2) and k (*batch, 2) with w_i . P = k_i."""
    A, B = a[..., 1:, :] - a[..., :1, :], b[..., 1:, :] - b[..., :1, :]
    c, z = np.cos(phi)[..., None], np.sin(phi)[..., None]
    turned = np.stack([c * B[..., 0] - z * B[..., 1], z * B[..., 0] + c * B[..., 1]], axis=-1)
    lengths = s[..., 1:] ** 2 - s[..., :1] ** 2 - (A**2).sum(axis=-1) - (B**2).sum(axis=-1)
    return turned - A, lengths / 2 + (A * turned).sum(axis=-1)


def circle_coefficients(a: Floats, b: Floats, s: Floats) -> NDArray[np.complex128]:
    """(k, 7) c_-3 ... c_3 of the elimination as a sum of c_n exp(i n phi)."""
    phi = 2 * np.pi * np.arange(SAMPLES) / SAMPLES
    c = np.fft.fft(resultant(a, b, s, phi), axis=-1) / SAMPLES
    return np.concatenate([c[:, -DEGREE:], c[:, : DEGREE + 1]], axis=1)


def sextic(a: Floats, b: Floats, s: Floats) -> Floats:
    """(k, 7) coefficients of the sextic in t = tan(phi / 2), ascending, the largest of absolute value one.

    With exp(i phi) = (1 + i t) / (1 - i t) the sum of c_n exp(i n phi) times (1 + t^2)^3 is a polynomial in t.
    """
    found = np.zeros((len(s), 2 * DEGREE + 1), dtype=np.complex128)
    for n, column in enumerate(circle_coefficients(a, b, s).T):
        term = np.ones(1, dtype=np.complex128)
        for factor in [[1, 1j]] * n + [[1, -1j]] * (2 * DEGREE - n):
            term = np.convolve(term, factor)
        found += column[:, None] * term
    largest = np.abs(found.real).max(axis=1, keepdims=True)
    with np.errstate(invalid="ignore"):
        return found.real / np.where(largest > 0, largest, 1.0)


def all_poses(a: Floats, b: Floats, s: Floats) -> tuple[Floats, Integers, Booleans]:
    """All real poses (x, y, phi) for ends (k, 3, 2), (k, 3, 2) and lengths (k, 3), of size about one.

    Returns:
        (k, n, 3) isolated poses by ascending phi in (-pi, pi], NaN beyond their number; (k, n) multiplicities; (k,)
        whether there are poses besides that form a curve: the sextic vanishes, or both w_i do, so that P is any point
        of a circle, or the poses around one close.
    """
    c = circle_coefficients(a, b, s)
    size = np.abs(resultant(a, b, s, 2 * np.pi * np.arange(SAMPLES) / SAMPLES)).max(axis=1)
    natural = ((a**2).sum(axis=(1, 2)) + (b**2).sum(axis=(1, 2)) + (s**2).sum(axis=1)) ** 3
    vanishes = size <= VANISHING * natural
    # 2.
    angles = _angles(np.where(vanishes[:, None], np.eye(2 * DEGREE + 1)[DEGREE], c))
    # 3.
    P = _places(a, b, s, angles)
    phi = np.repeat(angles, 2, axis=1)
    x = np.concatenate([_origin(a[:, None], b[:, None], P, phi), phi[..., None]], axis=-1)
    # 4.
    x = _polish(a[:, None], b[:, None], s[:, None], x)
    # 5.
    if (s <= VANISHING).any():
        x = np.concatenate([x, _pin(a, b, s)], axis=1)
    x = _sorted_distinct(a, b, s, x)
    curve, angle = translates(a, b, s)
    with np.errstate(invalid="ignore"):
        x[curve[:, None] & (np.abs(wrap_angle(x[..., 2] - angle[:, None])) < NEAR_CIRCLE)] = np.nan
    several, around = _several(a, b, s, x)
    order = np.argsort(x[..., 2], axis=1)
    x, several = np.take_along_axis(x, order[..., None], axis=1), np.take_along_axis(several, order, axis=1)
    return x, several, np.asarray(vanishes | curve | around, dtype=np.bool_)


def _several(a: Floats, b: Floats, s: Floats, x: Floats) -> tuple[Integers, Booleans]:
    """(k, n) multiplicities of poses, (k,) whether a curve goes through one; of poses in x that are one, one is left.

    Where the lines of the legs nearly meet in a point the pose is made exact, and its neighbourhood looked at.
    """
    d, turned = leg_vectors(a[:, None], b[:, None], x)
    rows = np.concatenate([d, (turned[..., 0] * d[..., 1] - turned[..., 1] * d[..., 0])[..., None]], axis=-1)
    several, around = np.isfinite(x[..., 2]).astype(np.intp), np.zeros(len(x), dtype=np.bool_)
    lengths = np.linalg.norm(rows, axis=-1).prod(axis=-1)
    with np.errstate(invalid="ignore"):
        suspect = np.abs(np.linalg.det(rows)) < SINGULAR * lengths
    for k in np.flatnonzero(suspect.any(axis=1)).tolist():
        equations, kept = _equations(a[k], b[k], s[k]), list[Floats]()
        for j in np.flatnonzero(suspect[k]).tolist():
            exact = solved_in_planes(equations, x[k, j, None], np.zeros((1, 0, 3)), 1.0, closed=0.0)[0][0]
            several[k, j] = multiplicity(equations, exact, SINGULAR, FINEST)
            around[k] |= several[k, j] == 0
            again = any(np.abs(exact - one).max() < SPLIT ** (1 / max(several[k, j], 1)) for one in kept)
            if again or not several[k, j]:
                x[k, j], several[k, j] = np.nan, 0
            else:
                x[k, j] = exact
                kept.append(exact)
    return several, around


def _equations(a: Floats, b: Floats, s: Floats) -> Equations:
    """(|d|^2 - s^2) / 2 of poses (k, 3) of one platform, for `solvers.local_dimension`."""

    def equations(x: Floats) -> tuple[Floats, Floats]:
        d, turned = leg_vectors(a[None], b[None], x)
        moment = turned[..., 0] * d[..., 1] - turned[..., 1] * d[..., 0]
        return ((d**2).sum(axis=-1) - s**2) / 2, np.concatenate([d, moment[..., None]], axis=-1)

    return equations


def translates(a: Floats, b: Floats, s: Floats) -> tuple[Booleans, Floats]:
    """(k,) whether three equal legs are parallel at some angle, so that the body goes round on a circle; the angle.

    Legs of length zero hold it where they are.
    """
    A, B = a[:, 1:] - a[:, :1], b[:, 1:] - b[:, :1]
    cosine = (A * B).sum(axis=(1, 2))
    sine = (B[..., 0] * A[..., 1] - B[..., 1] * A[..., 0]).sum(axis=1)
    phi = np.arctan2(sine, cosine)
    w, k = _linear(a, b, s, phi)
    size = np.maximum(np.abs(A).max(axis=(1, 2)), s.max(axis=1))
    flat = (np.abs(w).max(axis=(1, 2)) < SAME * size) & (np.abs(k).max(axis=1) < SAME * size**2)
    return np.asarray(flat & (s[:, 0] > FITS * size), dtype=np.bool_), phi


def _angles(c: NDArray[np.complex128]) -> Floats:
    """(k, 6) real zeros phi of sums of c_n exp(i n phi), NaN for complex ones; double ones apart by rounding."""
    leading = np.abs(c[:, -1:]) > 1e-14 * np.abs(c).max(axis=1, keepdims=True)
    monic = c[:, :-1] / np.where(leading, c[:, -1:], 1e-14 * np.abs(c).max(axis=1, keepdims=True))
    companion = np.zeros((len(c), 2 * DEGREE, 2 * DEGREE), dtype=np.complex128)
    companion[:, 1:, :-1] = np.eye(2 * DEGREE - 1)
    companion[:, :, -1] = -monic
    z = np.linalg.eigvals(companion)
    with np.errstate(divide="ignore", invalid="ignore"):
        real = np.abs(np.log(np.abs(z))) < NEAR_CIRCLE
    return np.where(real, np.angle(z), np.nan)


def _places(a: Floats, b: Floats, s: Floats, phi: Floats) -> Floats:
    """(k, 12, 2) two candidates P for each angle (k, 6)."""
    A, B, S = a[:, None], b[:, None], s[:, None]
    w, right = _linear(A, B, S, phi)
    D, N = _cramer(A, B, S, phi)
    lengths = np.linalg.norm(w, axis=-1)
    scale = np.maximum(lengths.max(axis=-1), LEAST_DIVISOR)
    flat = np.abs(D) <= FLAT * scale**2
    with np.errstate(divide="ignore", invalid="ignore"):
        regular = N / D[..., None]
    # The longer of the two lines w . P = k meets the circle |P| = s_1 in two points at most.
    longer = np.take_along_axis(w, lengths.argmax(axis=-1)[..., None, None], axis=-2)[..., 0, :]
    k = np.take_along_axis(right, lengths.argmax(axis=-1)[..., None], axis=-1)
    u = longer / scale[..., None]
    foot = k / scale[..., None]
    half = np.sqrt(np.maximum(S[..., :1] ** 2 - foot**2, 0.0))
    across = np.stack([-u[..., 1], u[..., 0]], axis=-1)
    first = np.where(flat[..., None], foot * u + half * across, regular)
    second = np.where(flat[..., None], foot * u - half * across, np.nan)
    return np.stack([first, second], axis=-2).reshape(len(s), 2 * phi.shape[1], 2)


def _pin(a: Floats, b: Floats, s: Floats) -> Floats:
    """(k, 12, 3) candidates of rows whose leg i has length zero, so that R b_i + p = a_i; NaN for other legs.

    Leg j keeps |R B_j - A_j| = s_j about there: A_j . R B_j = (|A_j|^2 + |B_j|^2 - s_j^2) / 2.
    """
    found: list[Floats] = []
    for i, j in ((0, 1), (0, 2), (1, 2), (1, 0), (2, 0), (2, 1)):
        A, B = a[:, j] - a[:, i], b[:, j] - b[:, i]
        size = np.linalg.norm(A, axis=-1) * np.linalg.norm(B, axis=-1)
        with np.errstate(divide="ignore", invalid="ignore"):
            cosine: Floats = ((A**2).sum(axis=-1) + (B**2).sum(axis=-1) - s[:, j] ** 2) / (2 * size)
            half = np.arccos(np.where(np.abs(np.abs(cosine) - 1) < VANISHING, np.sign(cosine), cosine))
        half = np.where(s[:, i] <= VANISHING, half, np.nan)
        middle = np.arctan2(A[:, 1], A[:, 0]) - np.arctan2(B[:, 1], B[:, 0])
        for phi in (middle + half, middle - half):
            c, z, end = np.cos(phi), np.sin(phi), b[:, i]
            place = a[:, i] - np.stack([c * end[:, 0] - z * end[:, 1], z * end[:, 0] + c * end[:, 1]], axis=-1)
            found.append(np.concatenate([place, phi[:, None]], axis=-1))
    return np.stack(found, axis=1)


def _origin(a: Floats, b: Floats, P: Floats, phi: Floats) -> Floats:
    """P = P - R b_1 + a_1 [m]."""
    c, z = np.cos(phi), np.sin(phi)
    first = b[..., 0, :]
    return (
        P + a[..., 0, :] - np.stack([c * first[..., 0] - z * first[..., 1], z * first[..., 0] + c * first[..., 1]], -1)
    )


def leg_vectors(a: Floats, b: Floats, x: Floats) -> tuple[Floats, Floats]:
    """d_i = p + R b_i - a_i (*batch, 3, 2) for poses (*batch, 3), and R b_i."""
    c, z = np.cos(x[..., 2, None]), np.sin(x[..., 2, None])
    turned = np.stack([c * b[..., 0] - z * b[..., 1], z * b[..., 0] + c * b[..., 1]], axis=-1)
    return x[..., None, :2] + turned - a, turned


def _polish(a: Floats, b: Floats, s: Floats, x: Floats) -> Floats:
    """Newton's method on (|d|^2 - s^2) / 2, all candidates at once; candidates that go astray are judged later."""
    x = x.copy()
    live = np.isfinite(x).all(axis=-1)
    a, b, s = (np.broadcast_to(each, (*live.shape, *each.shape[2:]))[live] for each in (a, b, s))
    y = x[live]
    moving = np.arange(len(y))
    for _ in range(POLISH):
        d, turned = leg_vectors(a[moving], b[moving], y[moving])
        miss = ((d**2).sum(axis=-1) - s[moving] ** 2) / 2
        moment = turned[..., 0] * d[..., 1] - turned[..., 1] * d[..., 0]
        rows = np.concatenate([d, moment[..., None]], axis=-1)
        inverse = np.cross(np.roll(rows, -1, axis=-2), np.roll(rows, -2, axis=-2))
        with np.errstate(divide="ignore", invalid="ignore"):
            step = (inverse * miss[..., None]).sum(axis=-2) / (rows[..., 0, :] * inverse[..., 0, :]).sum(-1)[..., None]
        step[~(np.abs(miss).max(axis=-1) > ROUNDING)] = 0.0
        y[moving] -= step
        moving = moving[~(np.abs(step).max(axis=-1) < ROUNDING)]
        if not len(moving):
            break
    x[live] = y
    return x


def _sorted_distinct(a: Floats, b: Floats, s: Floats, x: Floats) -> Floats:
    """Rows that fit and differ, by ascending angle; NaN behind them."""
    d, _ = leg_vectors(a[:, None], b[:, None], x)
    error = np.abs(np.linalg.norm(d, axis=-1) - s[:, None]).max(axis=-1)
    phi = np.full(x.shape[:2], np.nan)
    turned = np.isfinite(x[..., 2])
    phi[turned] = wrap_angle(x[..., 2][turned])
    x = np.concatenate([x[..., :2], np.where(phi < -np.pi + 1e-9, np.pi, phi)[..., None]], axis=-1)
    x[~(error < FITS * np.maximum(1.0, s.max(axis=1))[:, None])] = np.nan
    order = np.argsort(x[..., 2], axis=1)
    x = np.take_along_axis(x, order[..., None], axis=1)
    for j in range(1, x.shape[1]):
        with np.errstate(invalid="ignore"):
            turn = np.abs(x[:, :j, 2] - x[:, j : j + 1, 2])
            same = (np.minimum(turn, 2 * np.pi - turn) < SAME) & (
                np.abs(x[:, :j, :2] - x[:, j : j + 1, :2]) < SAME
            ).all(-1)
        x[same.any(axis=1), j] = np.nan
    return np.take_along_axis(x, np.argsort(x[..., 2], axis=1)[..., None], axis=1)
