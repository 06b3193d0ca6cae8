"""Steps with friction at their end, row by row, compiled: M a = load - f(qd + h a) by secants through rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled
from mafsil.mechanics.friction import SMOOTHING
from mafsil.mechanics.tolerances import NEGLIGIBLE_RATE
from mafsil.solvers.cholesky_loops import factor, solve


@compiled
def accelerations_by_secants(
    M: Floats, load: Floats, qd: Floats, viscous: Floats, positive: Floats, negative: Floats, gain: Floats, h: float,
    rounds: int, found: Floats, sound: NDArray[np.bool_],
) -> None:  # fmt: skip
    """Of every row the mean acceleration over the step; not sound where some matrix was not positive definite.

    1. Each friction is D w, w = gain qd, with the secant D of its curve at the rate found before.
    2. (M + h gain' D gain) a = load - gain' D gain qd.
    3. The rate at the end of the step is where the next secant is taken.

    Args:
        M: (b, n, n) mass matrices.
        load: (b, n) efforts without friction but for its offset.
        qd: (b, n) rates at the beginning of the step.
        viscous, positive, negative: (m,) of what has friction, as in `FrictionLaw`.
        gain: (m, n) rates of what has friction.
        h: length of the step [s].
        rounds: secants one after the other.
        found: (b, n), out.
        sound: (b,), out.
    """
    n, m = qd.shape[1], len(gain)
    S, after = np.empty((n, n)), np.empty(n)
    for row in range(len(qd)):
        sound[row] = True
        for i in range(n):
            after[i] = qd[row, i]
        for _ in range(rounds):
            a = found[row]
            for i in range(n):
                a[i] = load[row, i]
                for k in range(i + 1):
                    S[i, k] = M[row, i, k]
            for j in range(m):
                w, begun = 0.0, 0.0
                for i in range(n):
                    w += gain[j, i] * after[i]
                    begun += gain[j, i] * qd[row, i]
                share = 1.0 / SMOOTHING
                if abs(w) > NEGLIGIBLE_RATE * SMOOTHING:
                    share = np.tanh(w / SMOOTHING) / w
                D = viscous[j] + (positive[j] if w >= 0.0 else negative[j]) * share  # 1
                for i in range(n):
                    pulled = D * gain[j, i]
                    if pulled != 0.0:
                        a[i] -= pulled * begun  # 2
                        for k in range(i + 1):
                            S[i, k] += h * pulled * gain[j, k]
            if not factor(S, n):
                sound[row] = False
                break
            solve(S, n, a)
            for i in range(n):
                after[i] = qd[row, i] + h * a[i]  # 3
