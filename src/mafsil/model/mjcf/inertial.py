"""Mass properties of MJCF bodies: given, or from their geometry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, frozen
from mafsil.errors import MafsilError
from mafsil.model.faults import MESH_WITHOUT_MASS, MISSING_ATTRIBUTE, NO_INERTIAL, TOO_BIG
from mafsil.model.inertia_check import inertia_fault, mass_fault
from mafsil.model.link import Inertial, moved_inertial
from mafsil.model.mass_properties import unite_bodies
from mafsil.model.mjcf.geom import Geom
from mafsil.model.mjcf.orientation import read_pose
from mafsil.model.mjcf.settings import Settings
from mafsil.model.numbers import LARGEST
from mafsil.model.reading import Reading
from mafsil.model.xml_tree import Element


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
