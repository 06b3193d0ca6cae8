"""Letters for masses, centres of mass and inertias of an arm's links, each in the frame {i} of the table."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats
from mafsil.derivation.arm import NOTHING, SymbolicArm
from mafsil.derivation.matrices import ZERO, Entries, Row
from mafsil.derivation.polynomial import Polynomial, constant, symbol
from mafsil.derivation.tolerances import ROUNDOFF
from mafsil.errors import ModelError
from mafsil.model import Inertial, JointKind, Mechanism
from mafsil.model.appearance import part_of
from mafsil.model.exponentials import chain_to_tip
from mafsil.model.mass_properties import combine_bodies


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicBody:
    """What a joint carries up to the next one.

    Attributes:
        mass: m_i, or zero.
        com: (3,) in {i}.
        inertia: (3, 3) about the centre of mass, in the axes of {i}.
        armature: inertia of the motor, seen at the joint.
    """

    mass: Polynomial
    com: Row
    inertia: Entries
    armature: Polynomial


@dataclass(frozen=True, slots=True, eq=False)
class Bodies:
    """All bodies, gravity, and the numbers behind the letters.

    Attributes:
        links: in the order of the table's rows.
        gravity: (3,) in {s}.
        letters: number of every letter.
    """

    links: tuple[SymbolicBody, ...]
    gravity: Row
    letters: dict[str, float]


def symbolic_bodies(arm: SymbolicArm) -> Bodies:
    """Letters for everything that has mass.

    Args:
        arm: in letters.

    Raises:
        ModelError: a moving joint beside the chain to the tip carries mass.
    """
    letters: dict[str, float] = {}
    flat = _is_flat(arm)
    found = [_body(arm, i, inertial, flat, letters) for i, inertial in enumerate(_inertials(arm), start=1)]
    return Bodies(tuple(found), _gravity(arm.mechanism, letters), letters)


def _inertials(arm: SymbolicArm) -> list[tuple[Inertial | None, float]]:
    """Of every row: mass properties of the rigid part in {i}, and the motor's inertia."""
    mechanism = arm.mechanism
    chain = [joint for joint in chain_to_tip(mechanism) if joint.kind is not JointKind.FIXED]
    heads, home = part_of(mechanism), _home(mechanism)
    places = [mechanism.link_names.index(joint.child) for joint in chain]
    for k, link in enumerate(mechanism.links):
        if heads[k] not in (0, *places) and link.inertial is not None and link.inertial.mass:
            raise ModelError("derivation.branch", link=link.name, tip=mechanism.tip)
    T_s = np.array(arm.table.base)
    found: list[tuple[Inertial | None, float]] = []
    for row, joint, place in zip(arm.table.rows, chain, places, strict=True):
        T_s = T_s @ row.transform(arm.table.convention)
        parts = [
            (link.inertial, np.linalg.inv(T_s) @ home[k])
            for k, link in enumerate(mechanism.links)
            if heads[k] == place and link.inertial is not None and link.inertial.mass
        ]
        armature = 0.0 if joint.actuator is None else joint.actuator.reflected_inertia
        found.append((combine_bodies(parts) if parts else None, armature))
    return found


def _home(mechanism: Mechanism) -> list[Floats]:
    """Poses of all links in {s} at zero coordinates."""
    poses = [np.asarray(mechanism.T_sb)]
    for joint, parent in zip(mechanism.joints, mechanism.parents, strict=True):
        poses.append(poses[parent] @ joint.T_pj)
    return poses


def _is_flat(arm: SymbolicArm) -> bool:
    """All axes turning and parallel: only the moments about them count."""
    return all(row.row.kind == "R" and not row.alpha and row.alpha_quarters % 2 == 0 for row in arm.rows[1:]) and (
        arm.rows[0].row.kind == "R"
    )


def _body(
    arm: SymbolicArm, i: int, properties: tuple[Inertial | None, float], flat: bool, letters: dict[str, float]
) -> SymbolicBody:
    inertial, armature = properties
    motor = _letter(f"I_{i}m", armature, letters, 0.0)
    if inertial is None:
        return SymbolicBody(ZERO, (ZERO, ZERO, ZERO), ((ZERO,) * 3,) * 3, motor)
    mass = _letter(f"m{i}", inertial.mass, letters, 0.0)
    return SymbolicBody(
        mass, _com(arm, i, np.array(inertial.com), flat, letters), _inertia(i, inertial.inertia, flat, letters), motor
    )


def _com(arm: SymbolicArm, i: int, com: Floats, flat: bool, letters: dict[str, float]) -> Row:
    """One letter r_i along x, the link's own length where they are equal, three letters otherwise."""
    com = np.where(np.abs(com) < NOTHING, 0.0, com)
    length = arm.letters.get(f"L{i}")
    if flat:
        com[2] = 0.0
    if not com[1:].any():
        if length is not None and abs(com[0] - length) < NOTHING:
            return symbol(f"L{i}"), ZERO, ZERO
        return _letter(f"r{i}", float(com[0]), letters, 0.0), ZERO, ZERO
    x, y, z = (_letter(f"r_{i}{axis}", float(value), letters, 0.0) for axis, value in zip("xyz", com, strict=True))
    return x, y, z


def _inertia(i: int, inertia: Floats, flat: bool, letters: dict[str, float]) -> Entries:
    roundoff = ROUNDOFF * float(np.abs(inertia).max())
    if flat:
        moment = _letter(f"I{i}", float(inertia[2, 2]), letters, roundoff)
        return ((ZERO, ZERO, ZERO), (ZERO, ZERO, ZERO), (ZERO, ZERO, moment))
    names = ("xx", "xy", "xz", "yy", "yz", "zz")
    places = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
    entries = {
        place: _letter(f"I_{i}{name}", float(inertia[place]), letters, roundoff)
        for name, place in zip(names, places, strict=True)
    }
    return tuple(tuple(entries[min(r, c), max(r, c)] for c in range(3)) for r in range(3))


def _gravity(mechanism: Mechanism, letters: dict[str, float]) -> Row:
    """(0, 0, -g) and the like: one letter times a direction in numbers."""
    size = float(np.linalg.norm(mechanism.gravity))
    if size == 0.0:
        return ZERO, ZERO, ZERO
    letters["g"] = size
    x, y, z = (symbol("g") * constant(round(float(c), 15)) for c in mechanism.gravity / size)
    return x, y, z


def _letter(name: str, value: float, letters: dict[str, float], roundoff: float) -> Polynomial:
    if abs(value) <= roundoff:
        return ZERO
    letters[name] = value
    return symbol(name)
