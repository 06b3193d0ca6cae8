"""Mass properties of MJCF bodies: given, or from their geometry.

Mass and inertia as MuJoCo takes them: positive where a body moves, and of bodies that can be.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, frozen
from mafsil.errors import MafsilError
from mafsil.model.faults import MESH_WITHOUT_MASS, MISSING_ATTRIBUTE, NO_INERTIAL, TOO_BIG
from mafsil.model.inertia_check import STAND_IN, inertia_fault, mass_fault, principal_moments
from mafsil.model.link import Inertial, moved_inertial
from mafsil.model.mass_properties import unite_bodies
from mafsil.model.mechanism import Mechanism
from mafsil.model.mjcf.geom import Geom
from mafsil.model.mjcf.settings import Settings, read_pose
from mafsil.model.reading import LARGEST, Reading, written
from mafsil.model.xml_tree import Element

LEAST = 1e-15
"""mjMINVAL: least mass [kg] and moment [kg m^2] that MuJoCo takes for a moving body."""
BOUNDS = f' boundmass="{written(STAND_IN)}" boundinertia="{written(STAND_IN)}"'
"""Attributes of `compiler` that give bodies without mass, or with a moment of zero, as much as MuJoCo demands."""


@dataclass(frozen=True, eq=False, slots=True)
class Matters:
    """What decides about the mass of a body.

    Attributes:
        inertial: its element of that name, or None.
        T: (4, 4) pose in the body of the frame that this stands in.
        geoms: in the body's frame.
        moves: whether a joint lies between the world and the body.
    """

    inertial: Element | None
    T: PoseMatrix
    geoms: list[Geom]
    moves: bool


def inertial_of(reading: Reading, body: Element, name: str, parts: Matters, settings: Settings) -> Inertial | None:
    """Mass properties in the body frame, or None for a massless body.

    Args:
        reading, body, name: where it stands and what it is called.
        parts: what it holds.
        settings: in force for it.
    """
    rule = settings.inertiafromgeom
    if parts.inertial is not None and rule != "true":
        found = _read_inertial(reading, parts.inertial, name, settings, parts.T)
    elif rule == "false":
        found = None
    else:
        found = _from_geoms(reading, body, name, parts)
    if found is None:
        reading.report(NO_INERTIAL, body, link=name)
        return None
    largest = max(found.mass, float(np.abs(found.inertia).max()), float(np.abs(found.com).max()))
    if largest > LARGEST:
        reading.report(TOO_BIG, body, element="body", attribute="mass", text=f"{largest:g}", limit=LARGEST)
        return None
    bounded = _bound(found, settings)
    for fault in (mass_fault(bounded.mass, bounded.inertia), inertia_fault(bounded.mass, bounded.inertia)):
        if fault is not None:
            moments = ", ".join(f"{value:.4g}" for value in np.linalg.eigvalsh(bounded.inertia))
            reading.report(fault, parts.inertial or body, link=name, mass=bounded.mass, moments=moments)
    return bounded


def _from_geoms(reading: Reading, body: Element, name: str, parts: Matters) -> Inertial | None:
    """The geometries as one body; a mesh that gives no mass is an error, unless nothing moves the body."""
    bodies: list[Inertial | None] = []
    for geom in parts.geoms:
        if geom.matter is None:
            continue
        try:
            bodies.append(geom.matter.inertial(reading))
        except MafsilError as error:
            if not parts.moves:
                return None
            reading.report(MESH_WITHOUT_MASS, body, body=name, mesh=geom.matter.mesh, reason=error)
    return unite_bodies(*bodies)


def _read_inertial(
    reading: Reading, element: Element, name: str, settings: Settings, T_frame: PoseMatrix
) -> Inertial | None:
    mass = reading.number(element, "mass")
    T = frozen(T_frame @ read_pose(reading, element, settings))
    moments: Floats | None = None
    if "fullinertia" in element.attributes:
        six = reading.vector(element, "fullinertia", 6)
        if six is not None:
            xx, yy, zz, xy, xz, yz = six
            moments = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    elif "diaginertia" in element.attributes:
        three = reading.vector(element, "diaginertia", 3)
        moments = None if three is None else np.diag(three)
    else:
        reading.report(MISSING_ATTRIBUTE, element, element="inertial", attribute="diaginertia")
    if mass is None or moments is None:
        return None
    if mass < 0.0:
        fault = mass_fault(mass, moments)
        assert fault is not None
        reading.report(fault, element, link=name, mass=mass, moments="")
        return None
    moved = moved_inertial(Inertial(mass, inertia=frozen(moments)), T)
    return Inertial(mass, moved.com, frozen((moved.inertia + moved.inertia.T) / 2))


def _bound(inertial: Inertial, settings: Settings) -> Inertial:
    """Mass and principal moments raised to the compiler's bounds, then balanced if it says so."""
    mass = max(inertial.mass, settings.bound_mass) if settings.bound_mass > 0.0 else inertial.mass
    moments, axes = np.linalg.eigh(inertial.inertia)
    raised = np.maximum(moments, settings.bound_inertia) if settings.bound_inertia > 0.0 else moments
    if settings.balance and raised[0] + raised[1] < raised[2]:
        raised = np.full(3, raised.mean())
    if np.array_equal(raised, moments):
        return Inertial(mass, inertial.com, inertial.inertia)
    inertia = (axes * raised) @ axes.T
    return Inertial(mass, inertial.com, frozen((inertia + inertia.T) / 2))


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
