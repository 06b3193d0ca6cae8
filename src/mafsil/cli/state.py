"""Joint coordinates from the words of the command line."""

from __future__ import annotations

from collections.abc import Iterable
from math import pi

import numpy as np

from mafsil.arrays import Floats
from mafsil.cli.numerals import angle, coordinate, number
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.model import JointKind, Mechanism


def joint_values(name: str, words: list[str], mechanism: Mechanism, *, degrees: bool) -> Floats:
    """(n,) coordinates or their rates, radians or metres.

    Args:
        name: of the argument, for errors.
        words: one per joint; a word with a unit keeps it, whatever `degrees` says.
        mechanism: whose joints they are.
        degrees: bare numbers of revolute joints are degrees.

    Raises:
        InputError: not one finite number per joint; the sentence lists the joints.
    """
    _require_count(name, words, mechanism)
    values: list[float] = []
    for joint, word in zip(mechanism.coordinates, words, strict=True):
        turns = joint.kind is not JointKind.PRISMATIC
        values.append(angle(f"{name}[{joint.name}]", word, degrees=degrees and turns))
    return _finite(name, values, mechanism)


def efforts(name: str, words: list[str], mechanism: Mechanism) -> Floats:
    """(n,) efforts [N m | N].

    Raises:
        InputError: not one finite number per joint.
    """
    _require_count(name, words, mechanism)
    return _finite(name, [number(name, word) for word in words], mechanism)


def unit(kind: JointKind, *, degrees: bool) -> str:
    """Unit of a coordinate, as printed."""
    if kind is JointKind.PRISMATIC:
        return "m"
    return "°" if degrees else "rad"


def shown(value: float, kind: JointKind, *, degrees: bool) -> float:
    """A coordinate in the unit in which it is printed."""
    return value * 180 / pi if degrees and kind is not JointKind.PRISMATIC else value


def effort_unit(kind: JointKind) -> str:
    """Unit of an effort, as printed."""
    return "N" if kind is JointKind.PRISMATIC else "N m"


_UNITS = {
    JointKind.REVOLUTE: {"q": "rad", "qd": "rad/s", "qdd": "rad/s²", "effort": "N m", "M": "kg m²"},
    JointKind.PRISMATIC: {"q": "m", "qd": "m/s", "qdd": "m/s²", "effort": "N", "M": "kg"},
}


def units(mechanism: Mechanism) -> dict[str, str]:
    """Units of q, qd, qdd, efforts and the mass matrix: of all joints together, such as `N m | N`."""
    prismatic_joints = [joint.kind is JointKind.PRISMATIC for joint in mechanism.coordinates]
    revolute, prismatic = _UNITS[JointKind.REVOLUTE], _UNITS[JointKind.PRISMATIC]
    if not any(prismatic_joints):
        return revolute
    if all(prismatic_joints):
        return prismatic
    return {name: f"{revolute[name]} | {prismatic[name]}" for name in revolute} | {"M": "kg m² | kg m | kg"}


def with_units(mechanism: Mechanism, names: Iterable[str]) -> list[str]:
    """Headings with their units: `qd [rad/s]`; what is neither a coordinate nor a rate is an effort."""
    known = units(mechanism)
    return [f"{name} [{known.get(name, known['effort'])}]" for name in names]


def degrees_remarks(words: list[str], mechanism: Mechanism, *, degrees: bool) -> list[str]:
    """The question whether degrees were meant, where a bare angle is more than a whole turn; the values stay.

    Args:
        words: one per joint.
        mechanism: whose joints they are.
        degrees: bare angles are degrees: then there is nothing to ask.
    """
    angles = [
        (f"{joint.name} = {word}", word)
        for joint, word in zip(mechanism.coordinates, words, strict=True)
        if joint.kind is not JointKind.PRISMATIC
    ]
    return [] if degrees else angle_remarks(angles)


def angle_remarks(angles: Iterable[tuple[str, str]]) -> list[str]:
    """The same for pairs of what is printed and what was typed."""
    large = [shown for shown, word in angles if _more_than_a_turn(word)]
    return [say("cli.degrees_meant", angles=", ".join(large))] if large else []


def _more_than_a_turn(word: str) -> bool:
    value, marked = coordinate("", word)
    return not marked and abs(value) > 2 * pi


def _require_count(name: str, words: list[str], mechanism: Mechanism) -> None:
    if len(words) != mechanism.n:
        joints = ", ".join(mechanism.joint_names)
        details = {"robot": mechanism.name, "expected": mechanism.n, "got": len(words), "joints": joints}
        raise InputError("cli.joint_count", name=name, **details)


def _finite(name: str, values: list[float], mechanism: Mechanism) -> Floats:
    array = np.array(values, dtype=np.float64)
    for joint, value in zip(mechanism.joint_names, array, strict=True):
        if not np.isfinite(value):
            raise InputError("input.finite", name=name, value=value, index=joint)
    return array
