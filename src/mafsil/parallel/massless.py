"""Accelerations of closed chains whose tree has a singular mass matrix: of joints that move no mass by themselves.

1. Motions that the loops allow, N, and the shortest acceleration that they ask for.
2. The mass of those motions, N' M N, and the force on them. Where all have mass, the joints without were only parts of
   what the loops hold together: the acceleration is as well defined as with mass everywhere.
3. Along motions without mass a force gives an infinite acceleration, and no force leaves what is preferred.
4. Forces of the loops: the shortest.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.parallel.tolerances import RANK


def accelerations_without_mass(
    M: Floats, h: Floats, J: Floats, gamma: Floats, tau: Floats, prefer: Floats
) -> tuple[Floats, Floats, int]:
    """Accelerations (n,), forces of the loops (m,), and the rank of the loops, -1 where motions have no mass.

    Args:
        M: (n, n) mass matrix.
        h: (n,) bias forces.
        J: (m, n) rows of the loops.
        gamma: (m,) their bias.
        tau: (n,) efforts.
        prefer: (n,) along motions without mass and without a force on them.
    """
    # 1.
    U, s, Vt = np.linalg.svd(J)
    rank = int((s > RANK * max(float(s.max(initial=0.0)), np.finfo(np.float64).tiny)).sum())
    N = Vt[rank:].T
    across = Vt[:rank].T @ ((U[:, :rank].T @ -gamma) / s[:rank])
    # 2.
    given = tau - h - M @ across
    mass, directions = np.linalg.eigh(N.T @ M @ N)
    force = directions.T @ (N.T @ given)
    heavy = mass > RANK * max(float(np.abs(np.diag(M)).max(initial=0.0)), np.finfo(np.float64).tiny)
    along = np.where(heavy, force / np.where(heavy, mass, 1.0), directions.T @ (N.T @ prefer))
    size = float(np.abs(tau).max(initial=0.0) + np.abs(h).max(initial=0.0) + np.abs(M @ across).max(initial=0.0))
    # 3.
    pushed = ~heavy & (np.abs(force) > RANK * size)
    qdd = across + N @ (directions @ np.where(pushed, 0.0, along))
    away = N @ (directions @ np.where(pushed, force, 0.0))
    infinite = np.abs(away) > RANK * max(float(np.abs(away).max(initial=0.0)), np.finfo(np.float64).tiny)
    # 4.
    held = U[:, :rank] @ ((Vt[:rank] @ (M @ qdd + h - tau)) / s[:rank])
    return np.where(infinite, np.copysign(np.inf, away), qdd), held, rank if heavy.all() else -1
