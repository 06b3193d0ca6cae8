"""Legs that push along lines, in space: their rates for a twist of the platform, their wrench, and the way back.

Leg i pushes the platform with the force tau_i along the unit direction u_i through the point q_i:
F = G' tau with rows G_i = (q_i x u_i, u_i), and by virtual work the rates of the lengths are s' = G V.
Twists (omega, v) and wrenches (m, f) in {s} about its origin. Reference: Lynch & Park, Modern Robotics, sec. 7.2.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.parallel.tolerances import OPEN

ROUNDING = 1e-14
"""Share of the longest leg below which the length of another one is rounding."""


def line_matrix(points: ArrayLike, directions: ArrayLike) -> Floats:
    """(*batch, m, 6) rows (q_i x u_i, u_i) of lines.

    Args:
        points: (*batch, m, 3) a point on each line [m].
        directions: (*batch, m, 3) unit vectors.
    """
    q, u = as_batch("points", points, (3,)), as_batch("directions", directions, (3,))
    moments, u = np.broadcast_arrays(np.cross(q, u), u)
    return np.concatenate([moments, u], axis=-1)


def unit_vectors(d: Floats) -> tuple[Floats, Floats]:
    """Lengths (*batch, m) and unit directions (*batch, m, k) of leg vectors.

    Raises:
        InputError: a leg has length zero, so that it has no direction.
    """
    s = np.linalg.norm(d, axis=-1)
    without = s <= ROUNDING * s.max(axis=-1, keepdims=True, initial=0.0)
    if without.any():
        raise InputError("parallel.leg_zero", leg=int(np.argwhere(without)[0][-1]) + 1)
    return s, d / s[..., None]


def rates(G: Floats, V: ArrayLike) -> Floats:
    """(*batch, m) rates of the legs s' = G V for twists V (*batch, k)."""
    return np.einsum("...mk,...k->...m", G, as_batch("V", V, (G.shape[-1],)))


def resultant(G: Floats, forces: ArrayLike) -> Floats:
    """(*batch, k) wrench of the legs on the platform, F = G' tau, for forces tau (*batch, m) [N], pushing positive."""
    return np.einsum("...mk,...m->...k", G, as_batch("forces", forces, (G.shape[-2],)))


def forces_for(G: Floats, F: ArrayLike) -> Floats:
    """(*batch, m) forces of the legs with wrench F (*batch, k) on the platform, G' tau = F.

    A load F_load on the platform is carried by the forces for -F_load.

    Raises:
        InputError: G is singular in some row.
    """
    wrench = as_batch("F", F, (G.shape[-1],))
    tau = np.linalg.solve(np.swapaxes(require_regular(G), -1, -2), wrench[..., None])[..., 0]
    return np.asarray(tau, dtype=np.float64)


def require_regular(G: Floats) -> Floats:
    """Matrices (*batch, k, k), looked at.

    Raises:
        InputError: one is singular: its equations have no solution, or many.
    """
    singular = np.linalg.matrix_rank(G) < G.shape[-1]
    if singular.any():
        row = ", ".join(map(str, np.argwhere(singular)[0].tolist()))
        raise InputError("parallel.singular_row", row=row or "0", count=int(singular.sum()), rows=singular.size)
    return G


def require_rods(rods: Floats, lengths: Floats | float) -> None:
    """Refuse poses and angles that do not belong together.

    Args:
        rods: (*batch, m, k) from the ends of the cranks to the platform [m].
        lengths: (m,) that they have [m].

    Raises:
        InputError: a rod would be of another length.
    """
    wrong = np.linalg.norm(rods, axis=-1) - lengths
    off = np.abs(wrong) > OPEN * np.maximum(lengths, LEAST_DIVISOR)
    if off.any():
        *_, rod = np.argwhere(off)[0]
        raise InputError("parallel.rod_wrong", rod=int(rod) + 1, length=float(wrong[tuple(np.argwhere(off)[0])]))
