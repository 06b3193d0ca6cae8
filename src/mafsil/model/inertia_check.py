"""Whether mass properties can belong to a body, the nearest that can, inertias made possible, and what a joint moves.

A table may give a robot's motion rightly by inertias that no body has: `possible_inertias` moves what is too little
between links without changing any motion. A turn about a joint axis a does not change omega - (a . omega) a, so
delta (1 - a a') may be taken from the link on one side of a revolute joint and given to the link on the other. Across a
prismatic or a fixed joint omega is the same on both sides, and any direction will do. What stands still takes and gives
everything. A joint moves matter of its own where a rate of this joint alone gives energy to links fixed behind it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from mafsil.arrays import Floats, Vector3, Vector6, frozen
from mafsil.errors import ModelError, ModelWarning, warn
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
from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import Inertial, Link
from mafsil.model.mass_properties import require_physical
from mafsil.model.mechanism import Mechanism
from mafsil.model.tolerances import PRINTED

NO_ENERGY = 1e-12
"""Share of the energy of a rotation about any axis there below which it is rounding."""
ROUNDING = 1e-12
"""Share of the largest second moment by which one may be negative after a shift: what rounding leaves."""
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


def possible_inertias(mechanism: Mechanism) -> tuple[Mechanism, tuple[str, ...], dict[str, float]]:
    """The mechanism with inertias that bodies can have where a shift along joint axes gives such.

    Args:
        mechanism: any.

    Returns:
        The mechanism, the links whose inertia was shifted, and those whose inertia no body has still, each with what
        it lacks as a share of its largest second moment.
    """
    shifts = _Shifts(mechanism, {link.name: _second_moments(link) for link in mechanism.links})
    for link in mechanism.links:
        if link.name in shifts.moving and _lack(shifts.moments[link.name]) > ROUNDING:
            shifts.mend(link.name)
    lacks = {name: _lack(S) for name, S in shifts.moments.items() if name in shifts.moving}
    links = [_with_moments(link, shifts.moments) if link.name in shifts.touched else link for link in mechanism.links]
    touched = tuple(link.name for link in mechanism.links if link.name in shifts.touched)
    return replace(mechanism, links=tuple(links)), touched, {name: x for name, x in lacks.items() if x > ROUNDING}


@dataclass(slots=True)
class _Shifts:
    """Second moments of all links, which may be moved across joints."""

    mechanism: Mechanism
    moments: dict[str, Floats]
    touched: set[str]
    moving: set[str]

    def __init__(self, mechanism: Mechanism, moments: dict[str, Floats]) -> None:
        self.mechanism, self.moments, self.touched, self.moving = mechanism, moments, set(), set()
        for joint in mechanism.joints:
            if joint.moves or joint.parent in self.moving:
                self.moving.add(joint.child)

    def mend(self, name: str) -> None:
        """Give a link what it lacks along the axis of one of its joints, if its neighbour can spare it."""
        for neighbour, axis, R in self._neighbours(name):
            delta = _lacking(self.moments[name], axis)
            if delta is None:
                continue
            given = delta * np.outer(axis, axis)
            rest = self.moments[neighbour] - R @ given @ R.T
            if neighbour in self.moving and _lack(rest) > ROUNDING:
                continue
            self.moments[name] = self.moments[name] + given
            self.touched.add(name)
            if neighbour in self.moving:
                self.moments[neighbour] = rest
                self.touched.add(neighbour)
            return

    def _neighbours(self, name: str) -> Iterator[tuple[str, Vector3, Floats]]:
        """Links on the other side of a joint, the direction in this link, and the rotation into the neighbour."""
        for joint in self.mechanism.joints:
            R = np.asarray(joint.T_pj[:3, :3])
            if joint.child == name:
                yield joint.parent, self._direction(joint, name, np.eye(3)), R
            elif joint.parent == name:
                yield joint.child, self._direction(joint, name, R), R.T

    def _direction(self, joint: Joint, name: str, R: Floats) -> Vector3:
        if joint.kind is JointKind.REVOLUTE:
            return R @ joint.axis
        _, axes = np.linalg.eigh(self.moments[name])
        return axes[:, 0]


def _second_moments(link: Link) -> Floats:
    """(3, 3) tr(I)/2 1 - I, which no body has negative."""
    inertia = np.zeros((3, 3)) if link.inertial is None else np.asarray(link.inertial.inertia)
    return np.eye(3) * np.trace(inertia) / 2 - inertia


def _with_moments(link: Link, moments: Mapping[str, Floats]) -> Link:
    S = moments[link.name]
    body = Inertial(0.0) if link.inertial is None else link.inertial
    inertia = np.eye(3) * np.trace(S) - S
    return replace(link, inertial=Inertial(body.mass, body.com, frozen((inertia + inertia.T) / 2)))


def _lacking(S: Floats, axis: Vector3) -> float | None:
    """The least delta for which S + delta a a' is not negative; None if none is enough."""
    lowest, axes = np.linalg.eigh(S)
    along = axes.T @ axis
    if lowest[1] < 0.0 or along[0] == 0.0:
        return None
    # det(S + delta a a') = det(S) (1 + delta a' S^-1 a), multiplied out so that zero moments do no harm
    rest = lowest[1] * lowest[2] * along[0] ** 2 + lowest[0] * (lowest[2] * along[1] ** 2 + lowest[1] * along[2] ** 2)
    whole = lowest[0] * lowest[1] * lowest[2]
    delta = float(-whole / rest if rest > 0.0 else -lowest[0] / along[0] ** 2)
    return delta if _lack(S + delta * np.outer(axis, axis)) <= ROUNDING else None


def _lack(S: Floats) -> float:
    """By how much the lowest second moment is negative, as a share of the largest."""
    values = np.linalg.eigvalsh(S)
    largest = float(np.abs(values).max())
    return max(0.0, -float(values[0]) / largest) if largest else 0.0


def warned_of_impossible(mechanism: Mechanism) -> Mechanism:
    """The mechanism itself; its numbers are taken as they are.

    Links without mass and inertia are no matter, and inertia without mass stands for a lumped measurement.

    Args:
        mechanism: as its maker described it.

    Warns:
        ModelWarning: for every link whose moments are negative or violate the triangle inequality; the sentence names
            the link and the numbers.
    """
    for link in mechanism.links:
        body = link.inertial
        if body is None or body.mass == 0.0:
            continue
        try:
            require_physical(body)
        except ModelError as error:
            moments = error.details["moments"]
            warn(ModelWarning("serial.impossible_moments", robot=mechanism.name, link=link.name, moments=moments))
    return mechanism


def joints_that_move_matter(mechanism: Mechanism) -> frozenset[str]:
    """Names of the moving joints whose own rate moves mass or rotational inertia between them and the next joints.

    Where all do, the mass matrix is positive definite everywhere: the first joint that moves gives energy.

    Args:
        mechanism: any; motors count too.
    """
    bodies = {link.name: link.inertial for link in mechanism.links}
    found: set[str] = set()
    carrier: dict[str, tuple[int, Floats]] = {}
    for k, joint in enumerate(mechanism.joints):
        if joint.moves:
            carrier[joint.child] = (k, np.eye(4))
        elif joint.parent in carrier:
            first, T = carrier[joint.parent]
            carrier[joint.child] = (first, T @ joint.T_pj)
        if joint.moves and joint.actuator is not None and joint.actuator.reflected_inertia > 0:
            found.add(joint.name)
        body = bodies[joint.child]
        if joint.child in carrier and body is not None:
            first, T = carrier[joint.child]
            if _moves(mechanism.joints[first].screw, body, T):
                found.add(mechanism.joints[first].name)
    return frozenset(found)


def _moves(screw: Vector6, body: Inertial, T: Floats) -> bool:
    """Whether a twist (omega, v) gives a body energy; T is the pose of the body's link where the twist is written."""
    omega, v = np.asarray(screw[:3]), np.asarray(screw[3:])
    com = T[:3, :3] @ body.com + T[:3, 3]
    speed, rate = v + np.cross(omega, com), T[:3, :3].T @ omega
    most = body.mass * (v @ v + omega @ omega * (com @ com)) + omega @ omega * np.trace(body.inertia)
    return bool(body.mass * speed @ speed + rate @ body.inertia @ rate > NO_ENERGY * most)
