"""Joint coordinates from the words of the command line."""

from __future__ import annotations

from math import pi

import numpy as np

from mafsil.arrays import Floats
from mafsil.cli.numerals import coordinate, number
from mafsil.errors import InputError
from mafsil.model import JointKind, Mechanism


def joint_values(name: str, words: list[str], mechanism: Mechanism, *, degrees: bool) -> Floats:
    """(n,) coordinates or their rates, radians or metres.

    Args:
        name: of the argument, for errors.
        words: one per joint; a word with a unit keeps it, whatever `degrees` says.
        mechanism: whose joints they are.
        degrees: bare numbers of turning joints are degrees.

    Raises:
        InputError: not one finite number per joint; the sentence lists the joints.
    """
    _require_count(name, words, mechanism)
    values: list[float] = []
    for joint, word in zip(mechanism.coordinates, words, strict=True):
        value, marked = coordinate(f"{name}[{joint.name}]", word)
        turning = joint.kind is not JointKind.PRISMATIC
        values.append(value * pi / 180 if degrees and turning and not marked else value)
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


def _require_count(name: str, words: list[str], mechanism: Mechanism) -> None:
    if len(words) != mechanism.n:
        joints = ", ".join(mechanism.joint_names)
        facts = {"robot": mechanism.name, "expected": mechanism.n, "got": len(words), "joints": joints}
        raise InputError("cli.joint_count", name=name, **facts)


def _finite(name: str, values: list[float], mechanism: Mechanism) -> Floats:
    array = np.array(values, dtype=np.float64)
    for joint, value in zip(mechanism.joint_names, array, strict=True):
        if not np.isfinite(value):
            raise InputError("input.finite", name=name, value=value, index=joint)
    return array
