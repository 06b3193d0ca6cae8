"""Solutions judged, compiled: their errors, and their angles wound into the limits."""

from __future__ import annotations

from math import asin, pi, sqrt

from mafsil.arrays import Booleans, Floats, Integers
from mafsil.ik.tolerances import ON_LIMIT
from mafsil.ik.winding_loops import wound_angle
from mafsil.kernels.loops.loop import compiled


@compiled
def judge_solutions(
    reached: Floats,
    T: Floats,
    rows: Integers,
    q0: Floats,
    lower: Floats,
    upper: Floats,
    revolute: Booleans,
    q: Floats,
    residual: Floats,
    within: Booleans,
) -> None:
    """Errors of solutions, and their angles moved by whole turns as near to `q0` as the limits allow, in place.

    1. The distance, and the angle between the rotations: half the axis of R R_d^T has its sine for a length; where
       the trace is small the angle is large, and only that is said.
    2. The turn nearest to `q0`; if it is beyond a limit, the first turn within; if there is none, the nearest.

    Args:
        reached: (m, 4, 4) poses of the solutions.
        T: (k, 4, 4) requested poses.
        rows: (m,) which of them each solution belongs to.
        q0: (n,) values to which angles are wound.
        lower, upper: (n,) limits.
        revolute: (n,) which coordinates are angles.
        q: (m, n) solutions.
        residual: (m,) the larger of angle [rad] and distance [m].
        within: (m,) whether a solution is within the limits.
    """
    for i in range(len(q)):
        # 1.
        A, B = reached[i], T[rows[i]]
        square = length = trace = 0.0
        for r in range(3):
            u, v = (r + 1) % 3, (r + 2) % 3
            axis = 0.0
            for c in range(3):
                axis += A[u, c] * B[v, c] - A[v, c] * B[u, c]
                trace += A[r, c] * B[r, c]
            square += 0.25 * axis * axis
            length += (A[r, 3] - B[r, 3]) ** 2
        angle = asin(min(1.0, sqrt(square))) if trace > 1.0 else 0.5 * pi
        residual[i] = max(angle, sqrt(length))
        if not square + length < 1e300:
            residual[i] = 1e300
        # 2.
        inside = True
        for k in range(q.shape[1]):
            x, low, high = q[i, k], lower[k], upper[k]
            if revolute[k]:
                x = wound_angle(x, q0[k], low, high)
                q[i, k] = x
            inside = inside and low - ON_LIMIT <= x <= high + ON_LIMIT
        within[i] = inside
