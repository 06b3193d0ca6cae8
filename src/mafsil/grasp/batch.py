"""Force closure of many grasps at once: one simplex method, run on all of them in step.

x = w + z with fixed positive w turns "x > 0 with A x = 0" into phase one of the simplex method for z >= 0,
A z = -A w: an optimum of zero gives x, any other gives the certificate y. Grasps that are done leave; those left
share every array operation. Chunks bound the memory.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, gate, require_finite
from mafsil.errors import InputError
from mafsil.grasp.closure import closure

CHUNK = 512
"""Grasps in step: their matrices stay in the cache."""
ENTERING = 1e-9
PIVOT = 1e-9
DOUBT = 1e-7
"""Optima and sizes within it of a wrong verdict are asked of the single test, with exact arithmetic."""


@dataclass(frozen=True, eq=False)
class BatchClosure:
    """Verdicts on many grasps.

    Attributes:
        force_closure: (b,) verdicts; marginal grasps are no.
        combination: (b, n) x > 0 with A x = 0 and sum 1 where yes; NaN elsewhere.
        certificate: (b, m) y != 0 with A' y >= 0 where no; NaN elsewhere.
        asked_again: how many were too near the boundary and went to the single test.
    """

    force_closure: NDArray[np.bool_]
    combination: Floats
    certificate: Floats
    asked_again: int


def closures(A: ArrayLike) -> BatchClosure:
    """Force closure of a batch of wrench sets.

    Args:
        A: (b, m, n) wrenches in columns; sets with fewer columns are filled up by repeating some.

    Raises:
        InputError: not (b, m, n) finite numbers.
    """
    W = np.asarray(A)
    if W.ndim != 3:
        raise InputError("input.shape", name="A", expected="(b, m, n)", got=W.shape, hint="")
    W = require_finite("A", gate("A", W, W.shape[1:]))
    b, m, n = W.shape
    closed, x, y = np.zeros(b, bool), np.full((b, n), np.nan), np.full((b, m), np.nan)
    asked = 0
    for start in range(0, b, CHUNK):
        part = slice(start, min(start + CHUNK, b))
        closed[part], x[part], y[part], doubt = _chunk(W[part])
        for k in np.flatnonzero(doubt) + start:
            single = closure(W[k], margins=False)
            closed[k] = single.force_closure
            x[k] = np.nan if single.combination is None else single.combination
            y[k] = np.nan if single.certificate is None else single.certificate
            asked += 1
    return BatchClosure(closed, x, y, asked)


def _chunk(W: Floats) -> tuple[NDArray[np.bool_], Floats, Floats, NDArray[np.bool_]]:
    n = W.shape[2]
    rows = np.abs(W).max(axis=2, keepdims=True)
    rows[rows == 0] = 1.0
    A = W / rows
    sizes = np.sqrt(np.einsum("bmn,bmn->bn", A, A))
    sizes[sizes == 0] = 1.0
    A /= sizes[:, None, :]
    weights = np.random.default_rng(1986).uniform(0.5, 1.5, n)
    right = -(A @ weights)
    signs = np.where(right < 0, -1.0, 1.0)
    A *= signs[:, :, None]
    z, prices, value, full, stopped = _phase_one(A, np.abs(right))
    x = z + weights
    y = -(prices * signs) / rows[:, :, 0]
    closed = (value <= DOUBT) & full
    tight = x.sum(axis=1) > 1.0 / DOUBT
    doubt = ((value > 0.01 * DOUBT) & (value < 100 * DOUBT)) | ((value <= DOUBT) & (tight | ~full)) | stopped
    x /= sizes
    x /= x.sum(axis=1, keepdims=True)
    y /= np.maximum(np.linalg.norm(y, axis=1, keepdims=True), 1e-300)
    x[~closed], y[closed] = np.nan, np.nan
    return closed, x, y, doubt


def _phase_one(A: Floats, b: Floats) -> tuple[Floats, Floats, Floats, NDArray[np.bool_], NDArray[np.bool_]]:
    """Min sum of artificials, A z + s = b >= 0, for all grasps in step.

    Returns:
        z (g, n), prices (g, m), optimum (g,), whether all artificials left the basis, whether the steps ran out.
    """
    g, m, n = A.shape
    inverse = np.broadcast_to(np.eye(m), (g, m, m)).copy()
    basis = np.broadcast_to(np.arange(n, n + m), (g, m)).copy()
    level = b.copy()
    prices = np.ones((g, m))
    going = np.arange(g)
    for _ in range(20 * (m + n)):
        B, part = inverse[going], A[going]
        cost = (basis[going] >= n).astype(float)
        price = np.einsum("gm,gmk->gk", cost, B)
        gain = np.einsum("gm,gmn->gn", price, part)
        enter = gain.argmax(axis=1)
        each = np.arange(len(going))
        prices[going] = price
        on = gain[each, enter] > ENTERING
        if not on.any():
            return _finish(A, basis, level, prices, np.zeros(g, bool))
        going, enter, B, part = going[on], enter[on], B[on], part[on]
        each = np.arange(len(going))
        column = np.einsum("gmk,gk->gm", B, part[each, :, enter])
        now = level[going]
        ratio = np.where(column > PIVOT, np.maximum(now, 0.0) / np.where(column > PIVOT, column, 1.0), np.inf)
        leave = ratio.argmin(axis=1)
        step = ratio[each, leave]
        pivot_row = B[each, leave] / column[each, leave][:, None]
        B -= column[:, :, None] * pivot_row[:, None, :]
        B[each, leave] = pivot_row
        now -= column * step[:, None]
        now[each, leave] = step
        inverse[going], level[going] = B, now
        basis[going, leave] = enter
    stopped = np.zeros(g, bool)
    stopped[going] = True
    return _finish(A, basis, level, prices, stopped)


def _finish(
    A: Floats, basis: NDArray[np.int64], level: Floats, prices: Floats, stopped: NDArray[np.bool_]
) -> tuple[Floats, Floats, Floats, NDArray[np.bool_], NDArray[np.bool_]]:
    g, m, n = A.shape
    artificial = basis >= n
    z = np.zeros((g, n + m))
    np.put_along_axis(z, basis, np.maximum(level, 0.0), axis=1)
    value = np.where(artificial, np.maximum(level, 0.0), 0.0).sum(axis=1)
    broken = ~np.isfinite(level).all(axis=1)
    return z[:, :n], prices, value, ~artificial.any(axis=1), stopped | broken
