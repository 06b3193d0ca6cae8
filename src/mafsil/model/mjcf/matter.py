"""Mass and inertia as MuJoCo takes them: positive where a body moves, and of bodies that can be."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats
from mafsil.model.inertia_check import STAND_IN, principal_moments
from mafsil.model.link import Inertial
from mafsil.model.mechanism import Mechanism
from mafsil.model.numbers import written

LEAST = 1e-15
"""mjMINVAL: least mass [kg] and moment [kg m^2] that MuJoCo takes for a moving body."""
BOUNDS = f' boundmass="{written(STAND_IN)}" boundinertia="{written(STAND_IN)}"'
"""Attributes of `compiler` that give bodies without mass, or with a moment of zero, as much as MuJoCo demands."""


def inertial_element(inertial: Inertial) -> str:
    """Mass properties; near the border of what a body can have by principal moments that MuJoCo takes."""
    place = f'      <inertial pos="{numbers(inertial.com)}" mass="{written(inertial.mass)}"'
    principal = principal_moments(np.asarray(inertial.inertia))
    if principal is None:
        (ixx, ixy, ixz), (_, iyy, iyz), (_, _, izz) = inertial.inertia
        return f'{place} fullinertia="{numbers([ixx, iyy, izz, ixy, ixz, iyz])}"/>'
    three, axes = principal
    return f'{place} diaginertia="{numbers(three)}"{orientation(axes)}/>'


def weighs(mechanism: Mechanism) -> dict[str, bool]:
    """For each link whether it, or something fixed to it, has as much mass and inertia as MuJoCo demands."""
    found = {link.name: _is_heavy(link.inertial) for link in mechanism.links}
    for joint in reversed(mechanism.joints):
        if not joint.moves:
            found[joint.parent] |= found[joint.child]
    return found


def idle_joints(mechanism: Mechanism) -> list[str]:
    """Moving joints beyond which there is neither mass nor inertia, nor a rotor that they turn."""
    loaded = {link.name for link in mechanism.links if link.inertial is not None and _has_matter(link.inertial)}
    idle: list[str] = []
    for joint in reversed(mechanism.joints):
        turns = joint.actuator is not None and joint.actuator.reflected_inertia > 0.0
        if joint.child in loaded:
            loaded.add(joint.parent)
        elif joint.moves and not turns:
            idle.append(joint.name)
    return idle[::-1]


def orientation(R: Floats) -> str:
    """Axes, where they are not those of the body; axes of right angles are exact."""
    return "" if np.array_equal(R, np.eye(3)) else f' xyaxes="{numbers(R[:, :2].T.reshape(-1))}"'


def numbers(values: ArrayLike) -> str:
    """Numbers in the shortest form that reads back as the same doubles."""
    return " ".join(written(float(value)) for value in np.asarray(values, dtype=np.float64).reshape(-1))


def _has_matter(inertial: Inertial) -> bool:
    return inertial.mass > 0.0 or bool(inertial.inertia.any())


def _is_heavy(inertial: Inertial | None) -> bool:
    return inertial is not None and min(inertial.mass, *np.linalg.eigvalsh(inertial.inertia)) > 2 * LEAST
