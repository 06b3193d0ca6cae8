"""Files in millimetres and degrees: lengths of a job in metres, angles beside coordinates and poses in radians."""

from __future__ import annotations

from math import pi
from typing import Any, TypeVar, cast

import msgspec

from mafsil.job.constraint_table import PathConstraints
from mafsil.job.contact_tables import Door, Guide, Hole, Surface
from mafsil.job.description import (
    Bounds,
    Collision,
    Grasp,
    Job,
    Obstacle,
    Part,
    Pose,
    SceneFile,
    Step,
    Tolerance,
    Tool,
    Track,
)
from mafsil.job.language.statements import JobFile, MovableFrame, Pattern, Placed
from mafsil.job.other_robot import OtherPlace
from mafsil.job.part import keys_of
from mafsil.job.signals import PathOutput
from mafsil.job.variation_table import Normal, VariationTable

File = TypeVar("File", JobFile, SceneFile)
MILLIMETRE, DEGREE = 1e-3, pi / 180.0
LENGTHS: dict[type[Part], tuple[str, ...]] = {
    Pose: ("position",),
    Placed: ("position", "look_at"),
    OtherPlace: ("position",),
    MovableFrame: ("velocity",),
    Pattern: ("pitch",),
    Grasp: ("size", "offset", "com"),
    Obstacle: ("box", "sphere", "cylinder", "capsule", "cone", "radius", "size", "base"),
    Collision: ("clearance", "self_clearance"),
    Tolerance: ("position",),
    PathConstraints: ("tolerance",),
    Step: ("blend", "clearance", "tip_speed", "tip_acceleration"),
    PathOutput: ("distance",),
    Surface: ("point", "sphere", "cylinder"),
    Hole: ("mouth", "clearance", "depth", "chamfer", "peg"),
    Door: ("hinge",),
    Guide: ("point",),
    Tool: ("com", "size", "centre"),
    Track: ("range", "speed", "acceleration"),
    Bounds: ("tip_speed", "tip_acceleration"),
    VariationTable: ("bound", "payload_offset"),
}
"""Lengths, also per time, of each table and those derived from it; coordinates of joints are converted elsewhere."""
ANGLES: dict[type[Part], tuple[str, ...]] = {
    Bounds: ("tip_angular_speed",),
    MovableFrame: ("angular_speed",),
    Step: ("tip_angular_speed", "joint_speed", "joint_acceleration"),
}
"""Angles per time; those of poses, joints and tolerances are converted where they are used."""


def angle_unit(job: Job) -> float:
    """Of angles in the file [rad]."""
    return DEGREE if job.angles == "degrees" else 1.0


def length_unit(job: Job) -> float:
    """Of coordinates of prismatic joints in the file; other lengths are metres already [m]."""
    return MILLIMETRE if job.lengths == "millimetres" else 1.0


def in_si(file: File, data: dict[str, Any]) -> File:
    """The same file with all lengths in metres and angles in radians; coordinates and poses stay as they are.

    Args:
        file: as it was read.
        data: its tables: only keys that stand there are converted, defaults are in these units already.
    """
    if file.lengths == "millimetres":
        file = _scale(file, data, LENGTHS, MILLIMETRE)
    return _scale(file, data, ANGLES, DEGREE) if file.angles == "degrees" else file


def _scale(value: Any, given: Any, table: dict[type[Part], tuple[str, ...]], unit: float) -> Any:
    """What a table names, in all tables inside a value."""
    if isinstance(value, Part):
        named = {name for kind, names in table.items() if isinstance(value, kind) for name in names}
        fields = keys_of(type(value))
        changed = {
            fields[key]: _in_unit(getattr(value, fields[key]), unit)
            if key in named
            else _scale(getattr(value, fields[key]), inner, table, unit)
            for key, inner in given.items()
        }
        return msgspec.structs.replace(value, **changed)
    if isinstance(value, tuple):
        pairs = zip(cast("tuple[Any, ...]", value), given, strict=True)
        return tuple(_scale(each, inner, table, unit) for each, inner in pairs)
    if isinstance(value, dict):
        return {name: _scale(each, given[name], table, unit) for name, each in cast("dict[str, Any]", value).items()}
    return value


def _in_unit(value: Any, unit: float) -> Any:
    if isinstance(value, tuple):
        return tuple(unit * each for each in cast("tuple[float, ...]", value))
    if isinstance(value, Normal):
        return Normal(mean=unit * value.mean, deviation=unit * value.deviation)
    return unit * value
