"""The five ways in which MJCF writes a rotation."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, frozen
from mafsil.model.faults import NO_ROTATION
from mafsil.model.mjcf.settings import Settings
from mafsil.model.placement import (
    frame_along,
    rotation_from_quaternion,
    rotation_x,
    rotation_y,
    rotation_z,
    screw_motion,
)
from mafsil.model.reading import Reading
from mafsil.model.tolerances import NO_LENGTH
from mafsil.model.xml_tree import Element

_WAYS = {"quat": 4, "axisangle": 4, "euler": 3, "xyaxes": 6, "zaxis": 3}
_ABOUT = {"x": rotation_x, "y": rotation_y, "z": rotation_z}


def read_pose(reading: Reading, element: Element, settings: Settings) -> PoseMatrix:
    """The pose (4, 4) in `pos` and one of quat, axisangle, euler, xyaxes, zaxis; identity where nothing is given."""
    T = np.eye(4)
    position = reading.vector(element, "pos", 3, (0.0, 0.0, 0.0))
    T[:3, 3] = position or (0.0, 0.0, 0.0)
    way = next((way for way in _WAYS if way in element.attributes), None)
    if way is not None:
        numbers = reading.vector(element, way, _WAYS[way])
        if numbers is not None:
            R = _rotation(way, np.array(numbers), settings)
            if R is None:
                reading.report(
                    NO_ROTATION, element, way, element=element.tag, attribute=way, text=element.get(way)
                )  # fmt: skip
            else:
                T[:3, :3] = R
    return frozen(T)


def _rotation(way: str, numbers: Floats, settings: Settings) -> Floats | None:
    """Rotation matrix (3, 3), or None if the numbers are none."""
    match way:
        case "quat":
            unit = _unit(numbers)
            return None if unit is None else rotation_from_quaternion(unit)
        case "axisangle":
            axis = _unit(numbers[:3])
            angle = float(numbers[3]) * settings.degree
            return None if axis is None else screw_motion(np.concatenate([axis, np.zeros(3)]), angle)[:3, :3]
        case "euler":
            return rotation_from_euler(numbers * settings.degree, settings.eulerseq)
        case "xyaxes":
            return _from_axes(numbers[:3], numbers[3:])
        case _:
            z = _unit(numbers)
            return None if z is None else frame_along(z)


def rotation_from_euler(angles: Floats, sequence: str) -> Floats:
    """Turns one after the other: about the moving axis for a small letter, about the fixed one for a capital."""
    R = np.eye(3)
    for angle, letter in zip(angles, sequence, strict=True):
        turn = _ABOUT[letter.lower()](float(angle))[:3, :3]
        R = R @ turn if letter.islower() else turn @ R
    return R


def _from_axes(x: Floats, y: Floats) -> Floats | None:
    unit_x = _unit(x)
    if unit_x is None:
        return None
    unit_y = _unit(y - unit_x * (unit_x @ y))
    return None if unit_y is None else np.column_stack([unit_x, unit_y, np.cross(unit_x, unit_y)])


def _unit(vector: Floats) -> Floats | None:
    largest = np.abs(vector).max()
    if largest < NO_LENGTH:
        return None
    scaled = vector / largest
    return scaled / np.linalg.norm(scaled)
