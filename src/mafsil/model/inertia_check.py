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
STAND_IN = 1e-12
"""A mass [kg] and moments [kg m^2] as small as this are none: our writers put them where a format demands some."""
CLEAR = 1e-9
"""Share of the largest moment by which an inertia is clear of what readers refuse, rounding included."""
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


def principal_moments(inertia: Floats) -> tuple[Floats, Floats] | None:
    """Principal moments (3,) that a body has, to the last bit, and their axes (3, 3), for an inertia (3, 3).

    None where the tensor is so clear of what no body has that it may be written as it is; beyond it those of the
    nearest body.
    """
    moments, axes = np.linalg.eigh(inertia)
    least, middle, largest = moments
    if least > CLEAR * largest and largest - middle - least < -CLEAR * largest:
        return None
    if largest - middle - least > CLEAR * largest:
        moments, axes = np.linalg.eigh(nearest_physical(inertia))
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    least, middle = np.maximum(moments[:2], 0.0)
    return np.array([least, middle, min(moments[2], least + middle)]), axes
