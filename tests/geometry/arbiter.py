"""Who is right where two libraries disagree: 50 digits decide, so that no tolerance has to be loosened."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import mpmath as mp
import numpy as np

EPS = 2.0**-52
LIMIT = 24 * EPS
"""Largest difference of numbers of the size of one that counts as agreement."""
DIGITS = 50
HEARD = 60
"""Disputes heard at most: half of them the worst, the others spread over the rest."""


@dataclass(frozen=True)
class Verdict:
    """The comparison of one function.

    Attributes:
        deviation: largest difference between the two.
        disputed: rows in which they differ by more than the limit.
        ours, theirs: largest errors against 50 digits over the disputes heard, zero if there is none.
        lost: disputes heard in which our error exceeds the limit, or in which theirs is the smaller one.
    """

    deviation: float
    disputed: int
    ours: float
    theirs: float
    lost: int


def settle(
    ours: np.ndarray, theirs: np.ndarray, exact: Callable[[int], np.ndarray], scale: np.ndarray | float = 1.0
) -> Verdict:
    """Compare two answers row by row and let 50 digits decide the disputes.

    Args:
        ours, theirs: (n, ...).
        exact: row number -> the right answer (...), of numbers with 50 digits (objects).
        scale: (n,) natural size of a row's numbers, 1 at least.
    """
    apart = np.abs(ours - theirs).reshape(len(ours), -1).max(-1) / np.maximum(scale, 1.0)
    rows = np.flatnonzero(~(apart <= LIMIT))
    worst = rows[np.argsort(-apart[rows])]
    heard = np.unique(np.concatenate([worst[: HEARD // 2], worst[:: max(1, 2 * len(worst) // HEARD)]]))
    size = np.broadcast_to(np.maximum(scale, 1.0), len(ours))
    errors = [_errors(ours[k], theirs[k], exact(int(k)), float(size[k])) for k in heard]
    lost = sum(mine > LIMIT or mine > other for mine, other in errors)
    mine, other = np.array(errors or [(0.0, 0.0)]).max(0)
    return Verdict(float(apart.max()), len(rows), float(mine), float(other), lost)


def _errors(ours: np.ndarray, theirs: np.ndarray, right: np.ndarray, size: float) -> tuple[float, float]:
    with mp.workdps(DIGITS):
        mine, other = (max(abs(mp.mpf(float(x)) - y) for x, y in zip(a.flat, right.flat, strict=True)) / size
                       for a in (ours, theirs))  # fmt: skip
    return float(mine), float(other)


def exact_exp3(r: np.ndarray) -> np.ndarray:
    """(3, 3) exp of a rotation vector."""
    with mp.workdps(DIGITS):
        x, y, z = (mp.mpf(float(a)) for a in r)
        s = mp.sqrt(x * x + y * y + z * z)
        W = mp.matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        a, b = (mp.sin(s) / s, 2 * (mp.sin(s / 2) / s) ** 2) if s else (mp.mpf(1), mp.mpf(0.5))
        return _array(mp.eye(3) + a * W + b * W * W)


def exact_project(M: np.ndarray) -> np.ndarray:
    """(3, 3) rotation nearest to a matrix of doubles with positive determinant."""
    with mp.workdps(DIGITS):
        return _array(_nearest(M))


def _nearest(M: np.ndarray) -> mp.matrix:
    """Polar factor by Newton's iteration, which doubles the digits each time."""
    X, step = mp.matrix(M.tolist()), mp.mpf(1)
    while step > mp.mpf(10) ** (-DIGITS // 2 - 2):
        Y = (X + (X**-1).T) / 2
        X, step = Y, mp.mnorm(Y - X, 1)
    return X


def exact_quaternion(R: np.ndarray) -> np.ndarray:
    """(4,) unit quaternion, w >= 0, of the rotation nearest to a matrix of doubles."""
    with mp.workdps(DIGITS):
        X = _nearest(R)
        K = [1 + X[0, 0] + X[1, 1] + X[2, 2]] + [1 + 2 * X[k, k] - X[0, 0] - X[1, 1] - X[2, 2] for k in range(3)]
        turn = [X[2, 1] - X[1, 2], X[0, 2] - X[2, 0], X[1, 0] - X[0, 1]]
        k = max(range(4), key=lambda j: K[j])
        q = [K[0], *turn] if k == 0 else [turn[k - 1], *(X[k - 1, j] + X[j, k - 1] for j in range(3))]
        q[k] = K[k]
        length = mp.sqrt(sum(x * x for x in q))
        return np.array([(-x if q[0] < 0 else x) / length for x in q], dtype=object)


def exact_log3(R: np.ndarray) -> np.ndarray:
    """(3,) principal log of the rotation nearest to a matrix of doubles."""
    with mp.workdps(DIGITS):
        w, *v = exact_quaternion(R)
        length = mp.sqrt(sum(x * x for x in v))
        angle = 2 * mp.atan2(length, w)
        return np.array([angle * x / length if length else mp.mpf(0) for x in v], dtype=object)


def exact_act(T: np.ndarray, x: np.ndarray) -> np.ndarray:
    """(3,) R x + p of doubles."""
    with mp.workdps(DIGITS):
        exact = np.vectorize(lambda a: mp.mpf(float(a)), otypes=[object])
        return exact(T[:3, :3]) @ exact(x) + exact(T[:3, 3])


def exact_exp6(V: np.ndarray) -> np.ndarray:
    """(4, 4) exp of (omega, v)."""
    with mp.workdps(DIGITS):
        T = np.array([[mp.mpf(int(i == j)) for j in range(4)] for i in range(4)], dtype=object)
        T[:3, :3] = exact_exp3(V[:3])
        T[:3, 3] = exact_left_jacobian3(V[:3]) @ np.array([mp.mpf(float(x)) for x in V[3:]], dtype=object)
        return T


def exact_log6(T: np.ndarray) -> np.ndarray:
    """(6,) principal log of a pose of doubles."""
    with mp.workdps(DIGITS):
        r = exact_log3(T[:3, :3])
        J = mp.matrix(_left_jacobian(r).tolist())
        v = mp.lu_solve(J, mp.matrix([mp.mpf(float(x)) for x in T[:3, 3]]))
        return np.array([*r, *v], dtype=object)


def exact_left_jacobian3(r: np.ndarray) -> np.ndarray:
    """(3, 3) left Jacobian of SO(3)."""
    with mp.workdps(DIGITS):
        return _left_jacobian([mp.mpf(float(a)) for a in r])


def _left_jacobian(r: object) -> np.ndarray:
    x, y, z = r  # type: ignore[misc]
    s = mp.sqrt(x * x + y * y + z * z)
    W = mp.matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    if s > mp.mpf(10) ** -12:
        b, c = 2 * (mp.sin(s / 2) / s) ** 2, (s - mp.sin(s)) / s**3
    else:
        b, c = mp.mpf(1) / 2 - s * s / 24, mp.mpf(1) / 6 - s * s / 120
    return _array(mp.eye(3) + b * W + c * W * W)


def _array(M: mp.matrix) -> np.ndarray:
    return np.array([[M[i, j] for j in range(M.cols)] for i in range(M.rows)], dtype=object)
