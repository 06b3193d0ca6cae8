"""All dyads through five poses: four bilinear equations in two points of the plane, by an eigenvalue problem.

In homogeneous coordinates four bilinear equations in P^2 x P^2 have six common roots. Two of them are always the
circular points (1, +-i, 0) in both places, so that at most four dyads are left, as Burmester found.

1. The moving pivot is q = Q (x, 1, y) with a generic rotation Q, so that points at infinity are none in x and y.
2. Each equation times each coordinate of p: 12 equations in 6 monomials p_i p_l, times x and times 1. They are linear
   in y: a Sylvester matrix of twelve rows.
3. The left null space of the columns with x leaves a pencil of size six: its eigenvalues are y, and its eigenvectors
   are p p^T, from which p is read. q spans the null space of the four rows p^T M_j.
4. Real candidates are polished by Newton's method on the four equations in homogeneous coordinates, and kept if they
   solve them and are no circular points; double roots are kept once.

Burmester's curves of four poses: all fixed pivots (centre points) and moving pivots (circle points) of dyads.

Four poses give three bilinear equations p^T M_j q = 0. A fixed pivot p has a moving one if the three rows p^T M_j
depend on each other: det [M_2^T p, M_3^T p, M_4^T p] = 0, a circular cubic. The pole of the first two poses lies on it
(there the first row vanishes), so that a line through the pole meets the curve in two more points, by a quadratic.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Booleans, Floats, whole
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.mobility.synthesis.dyads import PoseConditions, checked_poses, in_plane
from mafsil.mobility.tolerances import APART, COMPLEX, SINGULAR_PENCIL, SOLVED

MONOMIALS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
_PLACE = {pair: k for k, pair in enumerate(MONOMIALS)} | {(b, a): k for k, (a, b) in enumerate(MONOMIALS)}
_NEWTON_STEPS = 8


def _generic_rotation() -> Floats:
    """A rotation without special directions: of a quaternion of square roots of primes."""
    w, x, y, z = np.sqrt([2.0, 3.0, 5.0, 7.0]) / np.sqrt(17.0)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


_Q = _generic_rotation()


@dataclass(frozen=True, eq=False)
class PointPairs:
    """Pairs of points (fixed p, moving q) that solve the equations of batches of poses.

    Attributes:
        p, q: (*batch, 6, 3) homogeneous, of length one; NaN where `real` is false.
        real: (*batch, 6) which of the places hold a dyad.
        infinite: (*batch,) whether infinitely many solve them, so that the list is not complete.
    """

    p: Floats
    q: Floats
    real: Booleans
    infinite: Booleans


def five_pose_pairs(M: Floats) -> PointPairs:
    """All real dyads of the forms (*batch, 4, 3, 3) of five poses; numbered steps in the module's text."""
    M = M / np.maximum(np.linalg.norm(M, axis=(-1, -2), keepdims=True), LEAST_DIVISOR)
    X, Y0, Y1 = _sylvester(M @ _Q)  # 1, 2
    left = np.swapaxes(np.linalg.svd(X)[0][..., 6:], -1, -2)  # 3
    K0, K1 = left @ Y0, left @ Y1
    infinite = _singular_everywhere(K0, K1)
    safe = np.where(infinite[..., None, None], np.eye(6), K1)
    _, vectors = np.linalg.eig(-np.linalg.solve(safe, np.where(infinite[..., None, None], np.eye(6), K0)))
    p = _real_scaled(_factor(vectors))
    q = _real_scaled(_null_vector(np.einsum("...ki,...jil->...kjl", p, M)))
    p, q, good = _polish(p, q, M)  # 4
    return PointPairs(p, q, good & ~infinite[..., None], infinite)


def _sylvester(M: Floats) -> tuple[Floats, Floats, Floats]:
    """(*batch, 12, 6) the columns with x, those without, and what y adds to them."""
    blocks = [np.zeros((*M.shape[:-3], 4, 3, 6)) for _ in range(3)]
    for i in range(3):
        for times in range(3):
            for block, column in zip(blocks, range(3), strict=True):
                block[..., times, _PLACE[i, times]] += M[..., i, column]
    X, Y0, Y1 = (block.reshape(*M.shape[:-3], 12, 6) for block in blocks)
    return X, Y0, Y1


def _singular_everywhere(K0: Floats, K1: Floats) -> Booleans:
    """(*batch,) whether det(K0 + y K1) vanishes for all y, by its least singular values at generic places."""
    worst = np.zeros(K0.shape[:-2])
    for y in (0.3819, -1.2720, 2.6180):
        s = np.linalg.svd(K0 + y * K1, compute_uv=False)
        worst = np.maximum(worst, s[..., -1] / np.maximum(s[..., 0], LEAST_DIVISOR))
    return np.asarray(worst < SINGULAR_PENCIL, dtype=np.bool_)


def _factor(vectors: NDArray[Any]) -> NDArray[Any]:
    """(*batch, 6, 3) p of the eigenvectors p p^T in the columns of (*batch, 6, 6): the longest of its columns."""
    rows = np.swapaxes(vectors, -1, -2)
    S = np.stack([np.stack([rows[..., _PLACE[i, k]] for k in range(3)], axis=-1) for i in range(3)], axis=-2)
    longest = np.argmax(np.linalg.norm(S, axis=-2), axis=-1)
    return np.take_along_axis(S, longest[..., None, None], axis=-1)[..., 0]


def _null_vector(rows: NDArray[Any]) -> NDArray[Any]:
    """(*batch, 3) the vector that rows (*batch, m, 3) send to zero, or most nearly."""
    return np.conj(np.linalg.svd(rows)[2][..., -1, :])


def _real_scaled(v: NDArray[Any]) -> NDArray[Any]:
    """(*batch, 3) complex vectors of length one whose largest entry is real."""
    largest = np.take_along_axis(v, np.argmax(np.abs(v), axis=-1)[..., None], axis=-1)
    scaled = v * np.conj(largest) / np.maximum(np.abs(largest), LEAST_DIVISOR)
    return scaled / np.maximum(np.linalg.norm(scaled, axis=-1, keepdims=True), LEAST_DIVISOR)


def _polish(p: NDArray[Any], q: NDArray[Any], M: Floats) -> tuple[Floats, Floats, Booleans]:
    """The real pairs after Newton's method, and which they are."""
    with np.errstate(invalid="ignore"):
        likely = (np.abs(np.imag(p)).max(axis=-1) < COMPLEX) & (np.abs(np.imag(q)).max(axis=-1) < COMPLEX)
    forms = np.broadcast_to(M[..., None, :, :, :], (*likely.shape, 4, 3, 3))[likely]
    u, v = np.real(p)[likely], np.real(q)[likely]
    for _ in range(_NEWTON_STEPS):
        before = u, v
        u, v = _newton_step(u, v, forms)
        if max(np.abs(u - before[0]).max(initial=0.0), np.abs(v - before[1]).max(initial=0.0)) < SOLVED:
            break
    r = np.einsum("ai,ajik,ak->aj", u, forms, v)
    x: Floats = np.full(p.shape, np.nan)
    y: Floats = np.full(q.shape, np.nan)
    good: Booleans = likely.copy()
    x[likely], y[likely], good[likely] = u, v, np.abs(r).max(axis=-1) < SOLVED
    for k in range(1, len(MONOMIALS)):
        twin = np.zeros(good.shape[:-1], dtype=np.bool_)
        for m in range(k):
            near = _apart(x[..., k, :], x[..., m, :]) + _apart(y[..., k, :], y[..., m, :]) < APART
            twin |= near & good[..., m]
        good[..., k] &= ~twin
    x[~good], y[~good] = np.nan, np.nan
    return x, y, good


def _newton_step(x: Floats, y: Floats, forms: Floats) -> tuple[Floats, Floats]:
    """One step on the four equations, across x and across y, which stay of length one."""
    by_x = np.einsum("...jik,...k->...ji", forms, y)
    by_y = np.einsum("...jik,...i->...jk", forms, x)
    r = np.einsum("...ji,...i->...j", by_x, x)
    zero = np.zeros_like(x)[..., None, :]
    top = np.concatenate([by_x, by_y], axis=-1)
    rows = [top, np.concatenate([x[..., None, :], zero], -1), np.concatenate([zero, y[..., None, :]], -1)]
    step = (
        np.linalg.pinv(np.concatenate(rows, axis=-2), rcond=1e-14)
        @ np.concatenate([r, np.zeros((*r.shape[:-1], 2))], axis=-1)[..., None]
    )
    x, y = x - step[..., :3, 0], y - step[..., 3:, 0]
    return x / np.linalg.norm(x, axis=-1, keepdims=True), y / np.linalg.norm(y, axis=-1, keepdims=True)


def _apart(a: Floats, b: Floats) -> Floats:
    """(*batch,) sine of the angle between vectors (*batch, 3) of length one."""
    return np.linalg.norm(a - b * np.sum(a * b, axis=-1, keepdims=True), axis=-1)


@dataclass(frozen=True, eq=False)
class BurmesterCurves:
    """Points of both curves that belong together, two or none for each line through the pole.

    Attributes:
        centre_points: (k, 2) fixed pivots, in the order of the lines; infinite along their direction where far off [m].
        circle_points: (k, 2) moving pivots in the first pose, in the world, likewise [m].
        p, q: (k, 3) the same homogeneous, of size one.
    """

    centre_points: Floats
    circle_points: Floats
    p: Floats
    q: Floats


def burmester_curves(poses: ArrayLike, samples: int = 181) -> BurmesterCurves:
    """Centre-point and circle-point curve of four poses.

    Args:
        poses: (4, 3) poses (x, y, phi) of the coupler [m, rad].
        samples: lines through the pole of the first two poses.

    Raises:
        InputError: not four poses, or two of them coincide.

    Reference: L. Burmester, Lehrbuch der Kinematik, 1888; as a cubic: J. M. McCarthy, Geometric Design of Linkages.
    """
    given = PoseConditions.of(checked_poses(poses, 4, 4))
    return curves_of(given, whole("samples", samples, 3, 100_000))


def curves_of(given: PoseConditions, samples: int) -> BurmesterCurves:
    """The curves of four checked poses.

    Args:
        given: four poses.
        samples: lines through the pole.
    """
    p, q = curve_pairs(given.M, samples)
    centre, circle = (in_plane(points, given.middle, given.size) for points in (p, q))
    return BurmesterCurves(centre, circle, p, q)


def curve_pairs(M: Floats, samples: int) -> tuple[Floats, Floats]:
    """Fixed and moving points (k, 3), (k, 3) of the dyads of forms (3, 3, 3), the first of which has rank two.

    Args:
        M: of four poses, or of four orientations about one point.
        samples: lines through the pole.
    """
    start = np.linalg.svd(M[0].T)[2][-1]  # the pole, homogeneous: M[0]^T start = 0
    angle = np.linspace(0.0, np.pi, samples, endpoint=False) + 0.5 * np.pi / samples
    first, second = np.linalg.svd(start[None])[2][1:]
    Q = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * second
    last, plus, minus = (_cubic(M, shift * start + Q) for shift in (0.0, 1.0, -1.0))
    square, linear = (plus + minus) / 2 - last, (plus - minus) / 2
    inside = linear**2 - 4 * square * last
    root = np.sqrt(np.maximum(inside, 0.0))
    stable = -(linear + np.copysign(root, linear)) / 2
    above, below = np.stack([stable, last], axis=-1), np.stack([square, stable], axis=-1)
    real = (inside >= 0.0)[:, None] & (np.maximum(np.abs(above), np.abs(below)) > 0.0)
    # Without a division: a root at infinity is the pole itself.
    p = (above[..., None] * start + below[..., None] * Q[:, None])[real]
    p /= np.linalg.norm(p, axis=-1, keepdims=True)
    q = np.linalg.svd(np.einsum("ai,jik->ajk", p, M))[2][:, -1, :]
    return p, q


def block_of(given: PoseConditions) -> tuple[Floats, Floats]:
    """(1, 3), (1, 3) the pair whose fixed pivot is at infinity: the one coupler point with four places on a line.

    At infinity the cubic is (x^2 + y^2) (a x + b y), with a and b its values at (1, 0, 0) and (0, 1, 0).
    """
    a, b = _cubic(given.M, np.eye(3)[:2]).tolist()
    p = np.array([-b, a, 0.0]) / max(float(np.hypot(a, b)), LEAST_DIVISOR)
    rows = np.einsum("i,jik->jk", p, given.M)
    return p[None], np.linalg.svd(rows)[2][-1:]


def _cubic(M: Floats, p: Floats) -> Floats:
    """(k,) the determinant of the three rows p^T M_j at points (k, 3)."""
    return np.linalg.det(np.einsum("ai,jik->ajk", p, M))
