"""Force closure of many grasps at once: a compiled simplex method on each, shared out over the cores.

Memory beyond input and answer is a few matrices for each core. Answers too near the boundary for floating point go to
the single test, with exact arithmetic.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil import threads
from mafsil.arrays import Floats, gate, require_finite
from mafsil.errors import InputError
from mafsil.grasp.closure import closure
from mafsil.grasp.enclosure import positive_weights

PART = 256
"""Grasps handed to a core at once."""
DOUBT = 1e-7
"""Optima and sizes within it of a wrong verdict are asked of the single test."""


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
    W = np.ascontiguousarray(gate("A", W, W.shape[1:]))
    verdict, x, y = _spans(W)
    closed = verdict > 0
    doubtful = np.flatnonzero(verdict < 0)
    if len(doubtful):  # what is not finite always is
        require_finite("A", W)
    for k in doubtful:
        single = closure(W[k], margins=False)
        closed[k] = single.force_closure
        x[k] = np.nan if single.combination is None else single.combination
        y[k] = np.nan if single.certificate is None else single.certificate
    return BatchClosure(closed, x, y, len(doubtful))


def _spans(W: Floats) -> tuple[Floats, Floats, Floats]:
    """Verdicts 1, 0 or -1 (doubtful), and the proofs."""
    from mafsil.solvers.positive_span_loops import positive_spans

    b, m, n = W.shape
    verdict, x, y = np.empty(b), np.empty((b, n)), np.empty((b, m))
    weights = positive_weights(n)

    def part(k: int) -> None:
        s = slice(k * PART, (k + 1) * PART)
        positive_spans((0,) * m, W[s], weights, DOUBT, x[s], y[s], verdict[s])

    threads.run(part, -(-b // PART), threads.available())
    return verdict, x, y
