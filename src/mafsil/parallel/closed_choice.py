"""Which rows of loops are independent, and which driven joints decide, once for a mechanism.

Compiled code of fixed size cannot look for the rank of the loops at each state. Rows are chosen at configurations
anywhere on the motion; every compiled result comes with a number, its doubt, that says whether they do at its state.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, Integers
from mafsil.parallel.closed_kernels import Rows
from mafsil.parallel.tolerances import RANK
from mafsil.solvers import decompositions

REMAINDERS = (0.2, 0.02, 2e-3)
"""Shares of a row that must be left beside the rows before it for it to be taken, one pass after the other: the first
rows that are well apart, so that the choice is the same at nearly all configurations."""

MOST = 0.75
"""Share of the states at which that has to be so: a few may happen to be nearly singular."""


def independent_rows(M: Floats, J: Floats) -> Rows | None:
    """Rows of loops that span all others, the same at most states; None where no such rows are found.

    1. Rows in kinetic energy, W = J L'^-1 with M = L L', and their rank; states of less than the largest are singular.
    2. A row is taken if at most of the other states enough of it is left beside those taken before.

    Args:
        M: (k, n, n) mass matrices of the tree.
        J: (k, m, n) rows of the loops.
    """
    try:
        W = np.swapaxes(np.linalg.solve(np.linalg.cholesky(M), np.swapaxes(J, -1, -2)), -1, -2)
    except np.linalg.LinAlgError:
        return None
    # 1
    values = np.linalg.svd(W, compute_uv=False)
    ranks = (values > RANK * values[:, :1]).sum(axis=1)
    rank = int(ranks.max(initial=0))
    W = W[ranks == rank]
    W = W / np.maximum(np.linalg.norm(W, axis=-1).max(axis=-1), RANK)[:, None, None]
    length = np.linalg.norm(W, axis=-1)
    # 2
    taken: list[int] = []
    for share in REMAINDERS:
        for k in range(W.shape[1]):
            left = np.linalg.norm(W[:, k], axis=-1)
            apart = left > share * np.maximum(length[:, k], share)
            if len(taken) < rank and apart.mean() >= MOST:
                along = np.where(apart, 1.0 / np.where(apart, left, 1.0), 0.0)[:, None] * W[:, k]
                W = W - (W @ along[..., None]) * along[:, None, :]
                taken.append(k)
    return tuple(sorted(taken)) if len(taken) == rank else None


def deciding_joints(J: Floats, driven: Integers, freedoms: int) -> Rows | None:
    """Which driven joints decide the efforts of all: as many as freedoms or as driven; None where they do not.

    Args:
        J: (k, m, n) rows of the loops.
        driven: (a,) coordinates of the driven joints.
        freedoms: of the mechanism.
    """
    if not len(driven) or not freedoms:
        return None
    allowed = np.eye(J.shape[-1]) - decompositions.pinv(J, RANK) @ J
    across = np.swapaxes(allowed[..., driven], -1, -2)
    rows = independent_rows(np.broadcast_to(np.eye(J.shape[-1]), (len(J), *allowed.shape[1:])), across)
    return rows if rows is not None and len(rows) == min(freedoms, len(driven)) else None
