"""Links of a URDF file: mass properties and shapes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mafsil.arrays import Floats, frozen
from mafsil.model.asset_path import Assets
from mafsil.model.diagnostics import Repair, Severity
from mafsil.model.faults import MISSING_ELEMENT, NO_INERTIAL, ZERO_INERTIA
from mafsil.model.inertia_check import inertia_fault, mass_fault, nearest_physical
from mafsil.model.link import Inertial, Link
from mafsil.model.numbers import written
from mafsil.model.reading import Reading
from mafsil.model.urdf.origin import read_origin
from mafsil.model.urdf.shape import Materials, read_shapes
from mafsil.model.xml_tree import Element

MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def read_link(reading: Reading, element: Element, materials: Materials, assets: Assets) -> Link | None:
    """A link, or None if it has no name."""
    name = reading.name(element)
    inertial = _read_inertial(reading, element, name)
    visuals = read_shapes(reading, element.all("visual"), materials, assets)
    collisions = read_shapes(reading, element.all("collision"), materials, assets)
    return Link(name, inertial, visuals, collisions) if name else None


def _read_inertial(reading: Reading, link: Element, name: str) -> Inertial | None:
    element = reading.one(link, "inertial")
    if element is None:
        reading.report(NO_INERTIAL, link, link=name)
        return None
    without = reading.remove(element)
    mass = _read_mass(reading, element, without)
    moments = _read_moments(reading, element, without)
    T = read_origin(reading, element)
    if mass is None or moments is None:
        return None
    _judge(reading, element, name, mass, moments)
    R = T[:3, :3]
    turned = R @ moments @ R.T
    return Inertial(mass, frozen(T[:3, 3]), frozen((turned + turned.T) / 2))


def _read_mass(reading: Reading, inertial: Element, without: Repair) -> float | None:
    mass = reading.one(inertial, "mass")
    if mass is None:
        reading.report(MISSING_ELEMENT, inertial, None, without, element="mass", parent="inertial")
        return None
    return reading.number(mass, "value", fallback=without)


def _read_moments(reading: Reading, inertial: Element, without: Repair) -> Floats | None:
    element = reading.one(inertial, "inertia")
    if element is None:
        reading.report(MISSING_ELEMENT, inertial, None, without, element="inertia", parent="inertial")
        return None
    values = [reading.number(element, key, fallback=without) for key in MOMENTS]
    known = [value for value in values if value is not None]
    if len(known) < len(values):
        return None
    ixx, ixy, ixz, iyy, iyz, izz = known
    return np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])


def _judge(reading: Reading, inertial: Element, name: str, mass: float, moments: Floats) -> None:
    """Report mass properties that no body has, with the nearest that one can have."""
    if fault := mass_fault(mass, moments):
        element = inertial.first("mass") or inertial
        repair = reading.set_attribute(element, "value", written(-mass), guess=True) if mass < 0.0 else None
        reading.report(fault, element, "value", repair, link=name, mass=mass)
    if fault := inertia_fault(mass, moments):
        element = inertial.first("inertia") or inertial
        guess = fault.severity is Severity.ERROR
        repair = replace(_physical(reading, element, moments), guess=guess) if fault is not ZERO_INERTIA else None
        eigenvalues = ", ".join(f"{value:.4g}" for value in np.linalg.eigvalsh(moments))
        reading.report(fault, element, None, repair, link=name, moments=eigenvalues)


def _physical(reading: Reading, element: Element, moments: Floats) -> Repair:
    """The repair that writes the nearest physical inertia."""
    nearest = nearest_physical(moments)
    i, j = np.triu_indices(3)
    edits = tuple(
        reading.document.set_attribute(element, key, written(nearest[a, b]))
        for key, a, b in zip(MOMENTS, i, j, strict=True)
    )
    return Repair("robotfile.repair_inertia", edits)
