"""Mass properties in the short form in which tables are printed, and invented ones for textbook arms."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np

from mafsil.arrays import Vector3, frozen
from mafsil.model.link import Inertial
from mafsil.model.mechanism import Mechanism
from mafsil.model.placement import frame_along, turned_tensor

Six = tuple[float, float, float, float, float, float]
Three = tuple[float, float, float]

ALUMINIUM = 2700.0
"""[kg/m^3]"""


def inertial(mass: float, com: Three, moments: Six | Three) -> Inertial:
    """Mass properties from numbers of a table.

    Args:
        mass: [kg].
        com: (3,) centre of mass [m].
        moments: xx, yy, zz, xy, xz, yz (products zero if left out) about the centre of mass [kg m^2].
    """
    xx, yy, zz, xy, xz, yz = (*moments, 0.0, 0.0, 0.0)[:6]
    return Inertial(mass, frozen(com), frozen([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))


def with_rods(mechanism: Mechanism, radius: float = 0.05) -> Mechanism:
    """The same arm with invented masses: every moving link a solid aluminium cylinder along its length.

    The cylinder leads from the link's frame to the next joint or the tip; where these coincide, the link is a ball.

    Args:
        mechanism: a serial arm.
        radius: of the cylinders and balls [m].
    """
    after = [joint.T_pj[:3, 3] for joint in mechanism.joints[1:]] + [mechanism.T_lt[:3, 3]]
    moving = (replace(link, inertial=_rod(end, radius)) for link, end in zip(mechanism.links[1:], after, strict=True))
    note = f"masses invented: solid aluminium cylinders and balls, radius {radius} m"
    provenance = replace(mechanism.provenance, notes=(*mechanism.provenance.notes, note))
    return replace(mechanism, links=(mechanism.links[0], *moving), provenance=provenance)


def _rod(end: Vector3, radius: float) -> Inertial:
    """Solid cylinder from the origin to `end`, or a ball at the origin."""
    length = float(np.linalg.norm(end))
    if length < radius:
        ball = ALUMINIUM * 4 / 3 * pi * radius**3
        return Inertial(ball, frozen(end / 2), frozen(0.4 * ball * radius**2 * np.eye(3)))
    mass = ALUMINIUM * pi * radius**2 * length
    across = mass * (3 * radius**2 + length**2) / 12
    R = frame_along(end / length)
    return Inertial(mass, frozen(end / 2), turned_tensor(np.diag([across, across, mass * radius**2 / 2]), R))
