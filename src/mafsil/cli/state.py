"""Numbers and joint coordinates as people type them: with a unit, as a fraction of pi, in degrees when marked.

Those of a robot with loops are numbers of its closed chain, or refused.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.cli.tolerances import TYPED
from mafsil.errors import InputError, ModelError
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.messages.visible import visible
from mafsil.model import JointKind, Mechanism
from mafsil.robot import Robot
from mafsil.typed_number import UNITS, read_number

if TYPE_CHECKING:
    import mafsil.parallel as parallel
    from mafsil.parallel import ClosedChain
else:
    parallel = lazily("mafsil.parallel")


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


def number(name: str, text: str) -> float:
    """A number, perhaps with a unit: `-0.2`, `30deg`, `120mm`, `pi/2`, `-2pi/3`.

    Args:
        name: of the argument, for the error.
        text: what was typed.

    Raises:
        InputError: it is no number, or the unit is not known.
    """
    return _read(name, text)[0]


def coordinate(name: str, text: str) -> tuple[float, bool]:
    """A joint coordinate, and whether its unit was written (so that `--degrees` must not touch it)."""
    return _read(name, text)


def angle(name: str, text: str, *, degrees: bool) -> float:
    """A number whose unit, if it has one, stands; a bare one is in degrees if that is asked.

    Args:
        name: of the argument, for the error.
        text: what was typed.
        degrees: whether bare numbers are degrees.
    """
    value, marked = coordinate(name, text)
    return value * pi / 180 if degrees and not marked else value


def count(name: str, text: str) -> int:
    """A whole number from 0 on.

    Raises:
        InputError: it is none.
    """
    if not (text.isascii() and text.isdigit() and len(text) < 10):
        raise InputError("cli.whole", name=name, text=visible(text))
    return int(text)


def _read(name: str, text: str) -> tuple[float, bool]:
    typed = read_number(text)
    if typed is None:
        raise InputError("cli.no_number", name=name, text=visible(text))
    if typed.unit not in UNITS:
        raise InputError("cli.no_unit", name=name, text=visible(text), known=", ".join(u for u in UNITS if u))
    return typed.value * UNITS[typed.unit], bool(typed.unit) or typed.is_angle


def typed_value(words: str) -> bool | float | str:
    """What is typed for a variable: true, false, a number, else a text.

    Args:
        words: as typed.
    """
    word = words.strip()
    if word in ("true", "false"):
        return word == "true"
    try:
        return float(word)
    except ValueError:
        return words


def require_open_chain(mechanism: Mechanism, command: str) -> None:
    """Refuse a robot with loops where only numbers of its open tree are known.

    Args:
        mechanism: any.
        command: that was typed.

    Raises:
        ModelError: it has loops.
    """
    if mechanism.loops:
        raise ModelError("cli.loops_open", robot=mechanism.name, command=command)


def chain_at(arm: Robot, q: JointVector) -> ClosedChain:
    """The closed chain of a robot with loops, where they are closed.

    Args:
        arm: with loops.
        q: (n,) coordinates.

    Raises:
        InputError: they leave a loop open.
    """
    chain = parallel.ClosedChain(arm)
    gap = float(chain.error(q))
    if gap <= TYPED * chain.size:
        return chain
    nearest = chain.close_loops(q, hold=chain.actuated) if len(chain.actuated) else chain.close_loops(q)
    nearest = nearest if nearest else chain.close_loops(q)
    if not nearest:
        raise InputError("cli.loops_never", robot=arm.name, gap=gap)
    raise InputError("cli.loops_gape", robot=arm.name, gap=gap, values=parse_numbers(nearest.q))


def parse_numbers(values: Floats) -> str:
    """Numbers as they may be typed."""
    return " ".join(f"{round(float(x), 9) + 0.0:.7g}" for x in values)
