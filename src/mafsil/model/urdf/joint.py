"""Joints of a URDF file: type, axis, limits, mimic, friction, and the gears and rotors of simple transmissions.

A simple transmission is one joint, one actuator, one reduction. The inertia of its rotor is `motorInertia`, on the
motor's side, or stands in Drake's words; it is felt at the joint times the square of the reduction. The `limit` element
has other words in each version, and several signs for no bound.
"""

from __future__ import annotations

from dataclasses import replace
from difflib import get_close_matches
from math import inf, sqrt

from mafsil.arrays import Vector3, frozen
from mafsil.model.faults import (
    AXIS_NORMALISED,
    BOUND_OF_NONE,
    DEFAULT_AXIS,
    EMPTY_RANGE,
    FLOATING_BASE,
    HALF_RANGE,
    INFINITE_BOUND,
    LIMITS_EQUAL,
    LIMITS_EXCHANGED,
    LIMITS_INVERTED,
    MIMIC_ON_FIXED,
    MIMIC_ZERO,
    MISSING_ELEMENT,
    NEGATIVE_BOUND,
    NEGATIVE_DAMPING,
    NO_BOUND,
    NO_LIMIT,
    NO_RANGE,
    OPEN_RANGE,
    SAFETY_IGNORED,
    SEVERAL_FREEDOMS,
    TRANSMISSION_IGNORED,
    UNEVEN_ACCELERATION,
    UNKNOWN_TYPE,
    UNUSED_RANGE,
    ZERO_AXIS,
    ZERO_BOUND,
)
from mafsil.model.joint import Joint, JointKind, Mimic
from mafsil.model.limits import UNBOUNDED, Actuator, Friction, Limits, bound_value
from mafsil.model.mimics import Declared
from mafsil.model.reading import Reading, decimal, written
from mafsil.model.tolerances import NO_AXIS, WRITTEN
from mafsil.model.urdf.shape import read_origin
from mafsil.model.urdf.vocabulary import WIDER_LIMITS
from mafsil.model.vocabulary import Version
from mafsil.model.xml_tree import Element

ACCELERATION = "drake:acceleration"
"""Attribute of `limit` by which Drake says how fast a joint may accelerate."""
_INFINITE = ("inf", "infinity")
NONE = -1.0
"""What Gazebo, and SDFormat up to 1.9, write where there is no limit of effort or speed."""
KINDS = {
    "revolute": JointKind.REVOLUTE,
    "continuous": JointKind.REVOLUTE,
    "prismatic": JointKind.PRISMATIC,
    "fixed": JointKind.FIXED,
}
_MEANT = {
    "hinge": "revolute",
    "rotational": "revolute",
    "rotary": "revolute",
    "revolution": "revolute",
    "slide": "prismatic",
    "slider": "prismatic",
    "linear": "prismatic",
    "translational": "prismatic",
    "rigid": "fixed",
    "weld": "fixed",
}
LONGEST_WORD = 40
CLOSE = 0.8
"""Share of letters that a misspelt type has in common with what it means."""
_URDF_AXIS = frozen([1.0, 0.0, 0.0])


def read_joint(reading: Reading, element: Element, carried: frozenset[str], version: Version) -> Declared | None:
    """A joint, or None after an error that leaves nothing to go on with.

    Args:
        reading: of the file.
        element: the joint.
        carried: names of all links that are the child of a joint.
        version: of the file.
    """
    name = reading.name(element)
    kind = _read_kind(reading, element, name, carried)
    parent, child = _end(reading, element, "parent"), _end(reading, element, "child")
    T_pj = read_origin(reading, element)
    axis = _read_axis(reading, element, name, kind)
    wraps = element.get("type") == "continuous"
    limits = read_limits(reading, element, name, version, wraps=wraps) if kind is not JointKind.FIXED else Limits()
    mimic = _read_mimic(reading, element, name, kind)
    friction = _read_friction(reading, element, kind)
    if (safety := element.first("safety_controller")) is not None:
        reading.report(SAFETY_IGNORED, safety, joint=name)
    if not (name and parent and child):
        return None
    joint = Joint(name, kind, parent, child, T_pj, axis, 0.0, limits, wraps, True, mimic, None, friction)
    return Declared(joint, element)


def _read_kind(reading: Reading, element: Element, name: str, carried: frozenset[str]) -> JointKind:
    word = element.get("type")
    if word in KINDS:
        return KINDS[word]
    lowered = word.strip().lower()
    if lowered in ("floating", "planar"):
        parent = element.first("parent")
        at_root = parent is not None and parent.get("link") not in carried
        fault = FLOATING_BASE if at_root else SEVERAL_FREEDOMS
        reading.report(fault, element, "type", None, joint=name, kind=lowered)
        return JointKind.FIXED
    meant = _meant(lowered)
    repair = None if meant is None else reading.set_attribute(element, "type", meant)
    reading.report(UNKNOWN_TYPE, element, "type", repair, joint=name, kind=word, known=", ".join(KINDS))
    return KINDS[meant or "fixed"]


def _meant(word: str) -> str | None:
    """The type that a word means: another name for it, or the only one that it can be a misspelling of."""
    if word in KINDS:
        return word
    if word in _MEANT:
        return _MEANT[word]
    close = get_close_matches(word[:LONGEST_WORD], (*KINDS, *_MEANT), n=2, cutoff=CLOSE)
    meant = {_MEANT.get(found, found) for found in close}
    return meant.pop() if len(meant) == 1 else None


def _end(reading: Reading, joint: Element, tag: str) -> str:
    """The link named by `parent` or `child`."""
    element = reading.one(joint, tag)
    if element is None:
        reading.report(MISSING_ELEMENT, joint, None, None, element=tag, parent="joint")
        return ""
    return reading.reference(element, "link")


def _read_axis(reading: Reading, joint: Element, name: str, kind: JointKind) -> Vector3:
    element = reading.one(joint, "axis")
    if kind is JointKind.FIXED:
        if element is not None:
            reading.vector(element, "xyz", 3)
        return _URDF_AXIS
    if element is None:
        reading.report(DEFAULT_AXIS, joint, None, reading.append(joint, '<axis xyz="1 0 0"/>'), joint=name)
        return _URDF_AXIS
    if "xyz" not in element.attributes:
        repair = reading.set_attribute(element, "xyz", "1 0 0")
        reading.report(DEFAULT_AXIS, element, None, repair, joint=name)
        return _URDF_AXIS
    xyz = reading.vector(element, "xyz", 3)
    if xyz is None:
        return _URDF_AXIS
    largest = max(abs(x) for x in xyz)
    if largest < NO_AXIS:
        reading.report(ZERO_AXIS, element, "xyz", None, joint=name)
        return _URDF_AXIS
    scaled = [x / largest for x in xyz]
    length = sqrt(sum(x * x for x in scaled))
    if abs(length * largest - 1.0) > WRITTEN:
        unit = " ".join(written(x / length) for x in scaled)
        repair = reading.set_attribute(element, "xyz", unit)
        reading.report(AXIS_NORMALISED, element, "xyz", repair, joint=name, length=f"{length * largest:.6g}")
    return frozen([x / length for x in scaled])


def _read_mimic(reading: Reading, joint: Element, name: str, kind: JointKind) -> Mimic | None:
    element = reading.one(joint, "mimic")
    if element is None:
        return None
    leader = reading.reference(element, "joint")
    multiplier = reading.number(element, "multiplier", 1.0)
    offset = reading.number(element, "offset", 0.0)
    if kind is JointKind.FIXED:
        reading.report(MIMIC_ON_FIXED, element, joint=name)
        return None
    if multiplier == 0.0:
        reading.report(MIMIC_ZERO, element, "multiplier", joint=name)
    return Mimic(leader, multiplier or 0.0, offset or 0.0) if leader else None


def _read_friction(reading: Reading, joint: Element, kind: JointKind) -> Friction | None:
    element = reading.one(joint, "dynamics")
    if element is None:
        return None
    values: list[float] = []
    for key in ("damping", "friction"):
        value = reading.number(element, key, 0.0, fallback=reading.remove_attribute(element, key)) or 0.0
        if value < 0.0:
            repair = reading.set_attribute(element, key, written(-value), guess=True)
            reading.report(NEGATIVE_DAMPING, element, key, repair, attribute=key, value=value)
        values.append(value)
    viscous, coulomb = values
    return Friction(viscous, coulomb) if (viscous or coulomb) and kind is not JointKind.FIXED else None


def read_transmissions(reading: Reading, robot: Element, joints: list[Joint]) -> list[Joint]:
    """The joints with the gear ratios and the rotors' inertias of the simple transmissions."""
    known = {joint.name for joint in joints if joint.moves}
    actuators: dict[str, Actuator] = {}
    for element in robot.all("transmission"):
        name, actuator = _simple(element)
        if actuator is None or name not in known or name in actuators:
            reading.report(TRANSMISSION_IGNORED, element, name=element.get("name"))
        else:
            actuators[name] = actuator
    return [replace(joint, actuator=actuators.get(joint.name, joint.actuator)) for joint in joints]


def _simple(element: Element) -> tuple[str, Actuator | None]:
    """Joint and motor of a transmission, if it is simple and its numbers are none but good ones."""
    joints, actuators = element.all("joint"), element.all("actuator")
    if len(joints) != 1 or len(actuators) != 1:
        return "", None
    name, gears = joints[0].get("name"), actuators[0].all("drake:gear_ratio")
    places = [place for holder in (actuators[0], joints[0], element) for place in holder.all("mechanicalReduction")]
    words = [gears[0].get("value")] if gears else [place.text for place in places[:1]]
    rotors = [rotor.get("value") for rotor in actuators[0].all("drake:rotor_inertia")]
    rotors += [place.text for holder in (actuators[0], joints[0], element) for place in holder.all("motorInertia")]
    numbers = [decimal(word.strip()) for word in (*(words or ["1"]), *(rotors[:1] or ["0"]))]
    if any(fault is not None for _, fault in numbers):
        return name, None
    (ratio, _), (rotor, _) = numbers
    return name, None if ratio == 0.0 or rotor < 0.0 else Actuator(rotor, ratio)


def read_limits(reading: Reading, joint: Element, name: str, version: Version, *, wraps: bool) -> Limits:
    """The bounds of a joint; what the file does not give is infinite.

    Args:
        reading: takes the remarks.
        joint: the element.
        name: of the joint.
        version: of the file: from 1.2 on everything may be left out.
        wraps: whether it turns without end.
    """
    element = reading.one(joint, "limit")
    if element is None:
        if not wraps:
            reading.report(NO_LIMIT, joint, joint=name)
        return Limits()
    lower, upper = _read_range(reading, element, name, version, wraps=wraps)
    velocity, effort = (
        _read_bound(reading, element, key, name, needed=version < WIDER_LIMITS) for key in ("velocity", "effort")
    )
    jerk = _read_bound(reading, element, "jerk", name, needed=False)
    return Limits(lower, upper, velocity, _read_acceleration(reading, element, name), jerk, effort)


def _read_acceleration(reading: Reading, element: Element, name: str) -> float:
    """The smallest of the bounds of speeding up and slowing down, as a mechanism has one for both."""
    read = {
        key: _read_bound(reading, element, key, name, needed=False)
        for key in ("acceleration", "deceleration", ACCELERATION)
        if key in element.attributes
    }
    if len(set(read.values())) > 1:
        reading.report(UNEVEN_ACCELERATION, element, "deceleration", joint=name, value=min(read.values()))
    return min(read.values(), default=inf)


def _read_range(reading: Reading, element: Element, name: str, version: Version, *, wraps: bool) -> tuple[float, float]:
    """Position bounds; infinite where the file gives none."""
    given = [key for key in ("lower", "upper") if key in element.attributes]
    bounds = {key: _number(reading, element, key, name, -1.0 if key == "lower" else 1.0) for key in given}
    if None in bounds.values():
        return -inf, inf
    missing = (-inf, inf) if version >= WIDER_LIMITS else (0.0, 0.0)
    lower, upper = (
        bound_value(bounds.get(key, end) or 0.0) for key, end in zip(("lower", "upper"), missing, strict=True)
    )
    if wraps:
        if given and lower != upper and (lower, upper) != (-inf, inf):
            reading.report(UNUSED_RANGE, element, given[0], joint=name)
        return -inf, inf
    if not given:
        reading.report(NO_RANGE, element, joint=name)
        return -inf, inf
    if lower > upper:
        return _exchanged_range(reading, element, name, lower, upper, given)
    return _judged_range(reading, element, name, lower, upper, given)


def _exchanged_range(
    reading: Reading, element: Element, name: str, lower: float, upper: float, given: list[str]
) -> tuple[float, float]:
    """A lower bound above the upper one: exchanged where zero lies between them, as it does in nearly every robot.

    Otherwise a sign or a digit may be wrong as well, and the file is refused.
    """
    both = len(given) == 2
    repair = reading.swap_attributes(element, "lower", "upper") if both else None
    clear = both and upper <= 0.0 <= lower
    fault = LIMITS_EXCHANGED if clear else LIMITS_INVERTED
    repair = repair if clear or repair is None else replace(repair, guess=True)
    reading.report(fault, element, given[0], repair, joint=name, lower=lower, upper=upper)
    return (upper, lower) if clear else (-inf, inf)


def _judged_range(
    reading: Reading, element: Element, name: str, lower: float, upper: float, given: list[str]
) -> tuple[float, float]:
    """An ordered range, with remarks about an empty or a half one."""
    if lower == upper == 0.0:
        reading.report(EMPTY_RANGE, element, given[0], joint=name)
        return -inf, inf
    if lower == upper:
        reading.report(LIMITS_EQUAL, element, given[0], joint=name, value=lower)
    elif len(given) == 1:
        missing, end = ("upper", upper) if given[0] == "lower" else ("lower", lower)
        fault = HALF_RANGE if end == 0.0 else OPEN_RANGE
        reading.report(fault, element, given[0], joint=name, attribute=missing)
    return lower, upper


def _read_bound(reading: Reading, element: Element, key: str, name: str, *, needed: bool) -> float:
    """A magnitude; 0, -1 and missing mean unknown, which is infinite."""
    if key not in element.attributes:
        if needed:
            reading.report(NO_BOUND, element, None, joint=name, attribute=key)
        return inf
    value = _number(reading, element, key, name, 1.0)
    if value == 0.0:
        reading.report(ZERO_BOUND, element, key, joint=name, attribute=key)
    elif value == NONE:
        repair = reading.set_attribute(element, key, written(UNBOUNDED))
        reading.report(BOUND_OF_NONE, element, key, repair, joint=name, attribute=key)
    elif value is not None and value < 0.0:
        repair = reading.set_attribute(element, key, written(-value), guess=True)
        reading.report(NEGATIVE_BOUND, element, key, repair, joint=name, attribute=key, value=value)
    return bound_value(value) if value is not None and value > 0.0 else inf


def _number(reading: Reading, element: Element, key: str, name: str, outward: float) -> float | None:
    """A bound as it stands; an infinite one may be a word, which urdfdom refuses.

    Args:
        reading, element, key, name: where it stands.
        outward: sign of the infinity that means no bound.
    """
    word = element.attributes[key].strip().lower()
    if word.lstrip("+-") in _INFINITE and word.startswith("-") == (outward < 0.0):
        none = written(outward * UNBOUNDED)
        repair = reading.set_attribute(element, key, none)
        reading.report(INFINITE_BOUND, element, key, repair, joint=name, attribute=key, text=word, none=none)
        return outward * inf
    return reading.number(element, key, fallback=reading.remove_attribute(element, key), largest=inf)
