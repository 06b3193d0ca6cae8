"""The same motions and forces with lengths counted in another unit, 1 old unit = k new ones; any batch.

p, v, pitches, translations and moments are multiplied by k; rotations, angular velocities, angles and forces are not.
Ad' = D Ad D^-1 with D = diag(1, 1, 1, k, k, k). A norm that mixes omega and v changes with the unit.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Matrix6, PoseMatrix, Vector6, as_batch, positive
from mafsil.errors import InputError
from mafsil.geometry.values.pose import METRES


def factor(unit: str, target: str) -> float:
    """How many target units a unit has, 1000 mm in a m.

    Args:
        unit, target: `m`, `mm`, `cm`, `km`, `in` or `ft`.

    Raises:
        InputError: an unknown unit.
    """
    for name in (unit, target):
        if name not in METRES:
            raise InputError("input.choice", name="unit", value=name, known=", ".join(METRES))
    return METRES[unit] / METRES[target]


def pose(T: ArrayLike, k: float) -> PoseMatrix:
    """(*batch, 4, 4) with p multiplied by k."""
    matrix = np.array(as_batch("T", T, (4, 4)))
    matrix[..., :3, 3] *= positive("k", k)
    return matrix


def twist(V: ArrayLike, k: float) -> Vector6:
    """(*batch, 6) (omega, k v); of a unit screw likewise, its pitch is multiplied by k."""
    return as_batch("V", V, (6,)) * np.repeat([1.0, positive("k", k)], 3)


def wrench(F: ArrayLike, k: float) -> Vector6:
    """(*batch, 6) (k m, f): forces keep their unit, so that power is multiplied by k, such as N mm/s."""
    return as_batch("F", F, (6,)) * np.repeat([positive("k", k), 1.0], 3)


def adjoint(Ad: ArrayLike, k: float) -> Matrix6:
    """(*batch, 6, 6) D Ad D^-1, which carries twists whose lengths are in the new unit."""
    D = np.repeat([1.0, positive("k", k)], 3)
    return as_batch("Ad", Ad, (6, 6)) * (D[:, None] / D)
