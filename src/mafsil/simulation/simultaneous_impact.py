"""The impact of a point on several rigid surfaces at once: Moreau's law, and friction of most dissipation.

The velocity v of the point changes by G P, P the impulse of all surfaces; surface i exerts p_i n_i and f_i across it.

1. Compression, without friction: the least p_i >= 0 after which no n_i . v is negative.
2. Friction of compression: of all |f_i| <= mu_i p_i those after which the kinetic energy is least.
3. Restitution (Moreau): p grows to what gives back e_i of each speed, n_i . v+ >= b_i = -e_i n_i . v-, and = b_i where
   p_i > 0. Where friction has changed these speeds, it grows by as much of that as gives back no more energy.
4. Friction of restitution, as in 2, bounded by what has been added to p_i.

1 and 3 are nearest points of polyhedra in the norm of the kinetic energy (-e v- with the largest e is in that of 3), 2
and 4 minima of convex functions of the velocity: each velocity exists, it is the only one, and no order of the surfaces
enters. Surfaces that the point leaves take no part. Energy never grows: without friction it changes by
sum p_i n_i . (v+ + v-) / 2 = -sum (1 - e_i) p_i |n_i . v-| / 2; 2 and 4 take some, and 3 gives back no more than it
would without friction. Afterwards the point may close with a surface that it was leaving: that is the next impact.

Reference: Moreau, Unilateral contact and dry friction in finite freedom dynamics, 1988.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mafsil.arrays import Floats
from mafsil.simulation.point_contact import tangents
from mafsil.solvers.bounded_least_squares import least_distance
from mafsil.solvers.bracketed_root import bracketed_root

SWEEPS = 2_000
"""Over the surfaces, until friction does not change any more."""
SETTLED = 1e-15
"""Share of the velocity below which a sweep has changed nothing."""


class Struck(NamedTuple):
    """What an impact on several surfaces does.

    Attributes:
        velocity: (r,) after it [m/s].
        normal: (k,) impulses along the normals [N s].
        across: (k, r) impulses of friction [N s].
    """

    velocity: Floats
    normal: Floats
    across: Floats


def after_impacts(G: Floats, normals: Floats, friction: Floats, velocity: Floats, restitution: Floats) -> Struck:
    """The velocity of a point after an impact on several surfaces at once, and the impulses.

    Args:
        G: (r, r) change of velocity for an impulse [1/kg].
        normals: (k, r) units, out of the surfaces.
        friction: (k,) mu.
        velocity: (r,) before, away from none of them [m/s].
        restitution: (k,) e.
    """
    C: Floats = np.linalg.cholesky(G).astype(np.float64, copy=False)
    rates = normals @ velocity
    change, held = least_distance(normals @ C, -rates)
    whole, normal = least_distance(normals @ C, -rates - restitution * np.minimum(rates, 0.0))
    returned = C @ (whole - change)
    v = velocity + C @ change
    if not friction.any():
        return Struck(v + returned, normal, np.zeros_like(normals))
    least, added = np.minimum(held, normal), np.maximum(normal - held, 0.0)
    rubbed, first = _rub(G, normals, v, friction * least)
    part = _share(C, returned, v, rubbed)
    after, second = _rub(G, normals, rubbed + part * returned, friction * part * added)
    return Struck(after, held + part * (normal - held), first + second)


def _share(C: Floats, returned: Floats, v: Floats, rubbed: Floats) -> float:
    """How much of a change of velocity, at most 1, gives no more energy to one velocity than all of it to another.

    Args:
        C: (r, r) of G = C C'.
        returned: (r,) change [m/s].
        v: (r,) to which all of it is added [m/s].
        rubbed: (r,) to which the part is added [m/s].
    """
    x, y, z = np.linalg.solve(C, np.stack([returned, v, rubbed], axis=1)).T
    square, given, slope = float(x @ x), float(x @ x / 2.0 + x @ y), float(x @ z)
    if slope + square / 2.0 <= given:
        return 1.0
    return 2.0 * given / (slope + float(np.sqrt(slope * slope + 2.0 * square * given))) if given > 0.0 else 0.0


def _rub(G: Floats, normals: Floats, v: Floats, most: Floats) -> tuple[Floats, Floats]:
    """Velocity (r,) and impulses (k, r) of friction after which the kinetic energy is least.

    Args:
        G: (r, r).
        normals: (k, r).
        v: (r,) before [m/s].
        most: (k,) largest impulses [N s].
    """
    across = np.zeros_like(normals)
    size = float(np.abs(v).max())
    planes = {int(i): tangents(normals[i]) for i in np.flatnonzero(most > 0.0)}
    for _ in range(SWEEPS if len(v) > 1 else 0):
        before = v
        for i, T in planes.items():
            without = v - G @ across[i]
            across[i] = T @ _least_energy(T.T @ G @ T, T.T @ without, float(most[i]))
            v = without + G @ across[i]
        if float(np.abs(v - before).max()) <= SETTLED * size:
            break
    return v, across


def _least_energy(A: Floats, v: Floats, most: float) -> Floats:
    """(m,) f with |f| <= most for which f' A f / 2 + f' v is least.

    Args:
        A: (m, m) positive definite.
        v: (m,).
        most: > 0.
    """
    values, axes = np.linalg.eigh(A)
    w = axes.T @ v

    def excess(shift: float) -> float:
        return float(np.linalg.norm(w / (values + shift))) - most

    if excess(0.0) <= 0.0:
        return -axes @ (w / values)
    # At |w| / most the force is short enough, whatever A is.
    top = float(np.linalg.norm(w)) / most
    shift = top * bracketed_root(lambda share: excess(share * top), 0.0, 1.0)
    f = -axes @ (w / (values + shift))
    return f * (most / float(np.linalg.norm(f)))
