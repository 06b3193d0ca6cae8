"""The `limit` element of URDF: bounds of a joint, with the words of each version and the signs for no bound."""

from __future__ import annotations

from dataclasses import replace
from math import inf

from mafsil.model.faults import (
    BOUND_OF_NONE,
    EMPTY_RANGE,
    HALF_RANGE,
    INFINITE_BOUND,
    LIMITS_EQUAL,
    LIMITS_EXCHANGED,
    LIMITS_INVERTED,
    NEGATIVE_BOUND,
    NO_BOUND,
    NO_LIMIT,
    NO_RANGE,
    OPEN_RANGE,
    UNEVEN_ACCELERATION,
    UNUSED_RANGE,
    ZERO_BOUND,
)
from mafsil.model.limits import UNBOUNDED, Limits, bound_value
from mafsil.model.numbers import written
from mafsil.model.reading import Reading
from mafsil.model.urdf.vocabulary import WIDER_LIMITS
from mafsil.model.vocabulary import Version
from mafsil.model.xml_tree import Element

ACCELERATION = "drake:acceleration"
"""Attribute of `limit` by which Drake says how fast a joint may accelerate."""
_INFINITE = ("inf", "infinity")
NONE = -1.0
"""What Gazebo, and SDFormat up to 1.9, write where there is no limit of effort or speed."""


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
