"""Accelerations of joints that follow others, from a peer's own mass matrix and bias, for it knows no coupling."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, JointVector


def solve_coupled(M: Floats, load: JointVector) -> JointVector:
    """(n,) qdd of M qdd = load; infinite where M cannot be inverted, so that nothing agrees with it."""
    try:
        return np.linalg.solve(M, load).astype(np.float64, copy=False)
    except np.linalg.LinAlgError:
        return np.full_like(load, np.inf)
