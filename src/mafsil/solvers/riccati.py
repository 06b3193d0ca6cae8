"""The algebraic Riccati equation of linear-quadratic control, in continuous time."""

from __future__ import annotations

from typing import Any

import numpy as np

from mafsil.arrays import Floats


def riccati(A: Floats, B: Floats, Q: Floats, R: Floats) -> Floats | None:
    """P (n, n) with A' P + P A - P B R^-1 B' P + Q = 0 and A - B R^-1 B' P stable; None if there is none.

    Args:
        A, B: (n, n), (n, m) of x' = A x + B u.
        Q, R: (n, n), (m, m) weights of x' Q x + u' R u; Q not negative, R positive.
    """
    import scipy.linalg

    library: Any = scipy.linalg  # its types leave this one out
    try:
        P = np.asarray(library.solve_continuous_are(A, B, Q, R), dtype=np.float64)
    except np.linalg.LinAlgError:
        return None
    return 0.5 * (P + P.T)
