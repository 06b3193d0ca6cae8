"""Whether mass properties can belong to a body, and the nearest that can."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.model.diagnostics import Fault
from mafsil.model.faults import (
    MASSLESS_INERTIA,
    NEGATIVE_MASS,
    NEGATIVE_MOMENT,
    NOT_POSITIVE,
    TRIANGLE,
    ZERO_INERTIA,
    ZERO_MASS,
)
from mafsil.model.tolerances import PRINTED

GROSS = 0.5
"""Share of the largest moment beyond which a negative one is a mistake; published robots reach 0.4."""
NOTHING = 1e-15
"""Inertia that is roundoff of a CAD export, far below that of a milligram [kg m^2]."""


def mass_fault(mass: float, inertia: Floats) -> Fault | None:
    """What is wrong with a mass [kg] beside an inertia (3, 3) [kg m^2]."""
    if mass < 0.0:
        return NEGATIVE_MASS
    if mass == 0.0:
        return MASSLESS_INERTIA if np.any(inertia) else ZERO_MASS
    return None


def inertia_fault(mass: float, inertia: Floats) -> Fault | None:
    """What is wrong with a rotational inertia (3, 3) about the centre of mass [kg m^2].

    Moments must be positive and satisfy the triangle inequality: the largest is at most the sum of the others.
    """
    if np.abs(inertia).max() <= NOTHING:
        return ZERO_INERTIA if mass > 0.0 else None
    least, middle, largest = np.linalg.eigvalsh(inertia)
    if least < -GROSS * abs(largest):
        return NEGATIVE_MOMENT
    if least < -PRINTED * largest:
        return NOT_POSITIVE
    return TRIANGLE if largest - middle - least > PRINTED * largest else None


def nearest_physical(inertia: Floats) -> Floats:
    """The inertia (3, 3) of the nearest distribution of non-negative mass.

    Second moments S = tr(I)/2 1 - I must not be negative; negative ones become zero and I = tr(S) 1 - S.
    """
    second = np.eye(3) * np.trace(inertia) / 2 - inertia
    values, axes = np.linalg.eigh(second)
    clipped = (axes * np.maximum(values, 0.0)) @ axes.T
    return np.eye(3) * np.trace(clipped) - clipped
