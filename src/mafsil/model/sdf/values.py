"""Numbers, flags and poses of SDFormat, which stand as text between tags."""

from __future__ import annotations

from math import radians

import numpy as np

from mafsil.arrays import PoseMatrix, frozen
from mafsil.model.faults import SDF_CHOICE, SDF_QUATERNION
from mafsil.model.placement import pose_from_xyz_quaternion, pose_from_xyz_rpy, quaternion_length
from mafsil.model.reading import LARGEST, Reading
from mafsil.model.xml_tree import Element

_WORDS = {"true": True, "1": True, "false": False, "0": False}


def numbers(reading: Reading, element: Element | None, count: int, default: tuple[float, ...]) -> tuple[float, ...]:
    """`count` numbers between the tags of an element; the default if it is missing or empty, or after an error."""
    if element is None or not element.text:
        return default
    return reading.vector(_as_attribute(element), element.tag, count) or default


def number(reading: Reading, parent: Element, tag: str, default: float, *, infinite: bool = False) -> float:
    """One number in a child; limits may be infinite."""
    child = reading.one(parent, tag)
    if child is None:
        return default
    if infinite and (word := child.text.strip().lower().lstrip("+")) in ("inf", "-inf"):
        return float(word)
    largest = float("inf") if infinite else LARGEST
    value = reading.number(_as_attribute(child), tag, default, largest=largest) if child.text else default
    return default if value is None else value


def flag(reading: Reading, parent: Element, tag: str, *, default: bool) -> bool:
    """True or false in a child."""
    child = reading.one(parent, tag)
    if child is None:
        return default
    if child.text.lower() not in _WORDS:
        reading.report(SDF_CHOICE, child, None, None, element=tag, text=child.text, known=", ".join(_WORDS))
        return default
    return _WORDS[child.text.lower()]


def pose(reading: Reading, element: Element | None) -> PoseMatrix:
    """The pose (4, 4) between the tags of `pose`: x y z and roll pitch yaw, or a quaternion x y z w."""
    if element is None:
        return frozen(np.eye(4))
    quaternion = element.get("rotation_format") == "quat_xyzw"
    zero = (0.0,) * 6
    if quaternion:
        x, y, z, *q = numbers(reading, element, 7, (*zero, 1.0))
        return _from_quaternion(reading, element, (x, y, z), tuple(q))
    x, y, z, *rpy = numbers(reading, element, 6, zero)
    turn = radians(1.0) if element.get("degrees") in ("true", "1") else 1.0
    return frozen(pose_from_xyz_rpy((x, y, z), tuple(turn * angle for angle in rpy)))


def _from_quaternion(
    reading: Reading, element: Element, xyz: tuple[float, float, float], xyzw: tuple[float, ...]
) -> PoseMatrix:
    if not 1e-6 < quaternion_length(xyzw) < 1e6:
        reading.report(SDF_QUATERNION, element, None, None, text=element.text)
        return frozen(np.eye(4))
    return frozen(pose_from_xyz_quaternion(xyz, xyzw))


def _as_attribute(element: Element) -> Element:
    """The element with its text as an attribute of its own name, for the strict number reader."""
    return Element(
        element.tag, {element.tag: element.text}, element.line, element.column, element.start, element.close,
        file=element.file,
    )  # fmt: skip
