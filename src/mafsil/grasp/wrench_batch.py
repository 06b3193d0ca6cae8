"""Force closure of many grasps at once: a compiled simplex method on each, shared out over the cores.

Memory beyond input and answer is a few matrices for each core. Answers too near the boundary for floating point go to
the single test, with exact arithmetic.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil import threads
from mafsil.answer import Answer
from mafsil.arrays import Floats, as_batch, require_finite
from mafsil.errors import InputError
from mafsil.grasp import loops
from mafsil.grasp.closure import Closure, ClosureStatus, closure
from mafsil.grasp.enclosure import positive_weights
from mafsil.grasp.tolerances import SOLVER
from mafsil.messages import say

PART = 256
"""Sets handed to a core at once."""
_MEMBERS: NDArray[np.object_] = np.array([ClosureStatus.OPEN, ClosureStatus.CLOSED], dtype=np.object_)


@dataclass(frozen=True, eq=False, repr=False)
class WrenchClosureBatch(Answer, data="force_closure combination certificate"):
    """Verdicts on many sets of wrenches; true if all are closed.

    Attributes:
        status: (b,) members of `ClosureStatus`.
        wrenches: (b, m, n) the sets.
        force_closure: (b,) whether they are closed; marginal sets are not.
        combination: (b, n) x > 0 with A x = 0 and sum 1 where yes; NaN elsewhere.
        certificate: (b, m) y != 0 with A' y >= 0 where no; NaN elsewhere.
        rechecked: how many were too near the boundary and went to the single test.
    """

    status: NDArray[np.object_]
    wrenches: Floats
    force_closure: NDArray[np.bool_]
    combination: Floats
    certificate: Floats
    rechecked: int

    def __bool__(self) -> bool:
        return bool(self.force_closure.all())

    def __len__(self) -> int:
        return len(self.force_closure)

    def __iter__(self) -> Iterator[Closure]:
        return (self[i] for i in range(len(self)))

    def __getitem__(self, index: int) -> Closure:
        """One set's verdict with its margin."""
        return closure(self.wrenches[index])

    def explain(self, language: str | None = None) -> str:
        """How many sets are closed."""
        return say("grasp.batch", language=language, closed=int(self.force_closure.sum()), count=len(self))


def wrench_closures(A: ArrayLike) -> WrenchClosureBatch:
    """Force closure of a batch of wrench sets.

    Args:
        A: (b, m, n) wrenches in columns; sets with fewer columns are filled up by repeating some.

    Raises:
        InputError: not (b, m, n) finite numbers.
    """
    W = np.asarray(A)
    if W.ndim != 3:
        raise InputError("input.shape", name="A", expected="(b, m, n)", got=W.shape, hint="")
    W = np.ascontiguousarray(as_batch("A", W, W.shape[1:]))
    verdict, x, y = _spans(W)
    closed = verdict > 0
    status = _MEMBERS[closed.astype(np.intp)]
    doubtful = np.flatnonzero(verdict < 0)
    if len(doubtful):  # what is not finite always is
        require_finite("A", W)
    for k in doubtful:
        single = closure(W[k], margins=False)
        closed[k], status[k] = single.force_closure, single.status
        x[k] = np.nan if single.combination is None else single.combination
        y[k] = np.nan if single.certificate is None else single.certificate
    return WrenchClosureBatch(status, W, closed, x, y, len(doubtful))


def _spans(W: Floats) -> tuple[Floats, Floats, Floats]:
    """Verdicts 1, 0 or -1 (doubtful), and the proofs."""
    b, m, n = W.shape
    verdict, x, y = np.empty(b), np.empty((b, n)), np.empty((b, m))
    weights, positive_spans = positive_weights(n), loops.positive_span_loops.positive_spans

    def part(k: int) -> None:
        s = slice(k * PART, (k + 1) * PART)
        positive_spans((0,) * m, W[s], weights, SOLVER, x[s], y[s], verdict[s])

    threads.run(part, -(-b // PART), threads.available())
    return verdict, x, y
