"""Parallel robots in TOML files: a kind, and the numbers of its class.

    kind = "stewart"
    base_radius = 2.0
    platform_radius = 1.0
    base_angles = [-15, 15, 105, 135, 225, 255]         # degrees
    platform_angles = [-45, 45, 75, 165, 195, 285]

or `base` and `platform`, six places each; `3rpr`, `3rrr`, `delta`, `five_bar` and `cable` have the names of the
attributes of `PlanarThreeRPR`, `PlanarThreeRRR`, `DeltaRobot`, `FiveBar` and `CableRobot`, `spherical` those of
`SphericalPlatform` with the angles of its links, `first` and `second`, in degrees. Robots on rods have those of the
arguments of the function that makes them: `rotary_delta`, `linear_delta`, `hexapod_on_rods`, `five_bar_on_rods`,
`planar_on_rods`, `h4`; their `angles` are degrees.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING, fields
from inspect import Parameter, signature
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from mafsil.arrays import real_array, single
from mafsil.errors import FileError, InputError
from mafsil.parallel.cables.cable_robot import CableRobot
from mafsil.parallel.legs import rod_library
from mafsil.parallel.legs.rod_robot import RodRobot
from mafsil.parallel.planar.five_bar import FiveBar
from mafsil.parallel.planar.planar_legs import PlanarThreeRPR, PlanarThreeRRR
from mafsil.parallel.platforms.delta import DeltaRobot
from mafsil.parallel.platforms.spherical_platform import SphericalPlatform
from mafsil.parallel.platforms.stewart import StewartPlatform
from mafsil.toml_source import read_toml

_OfAttributes = (
    StewartPlatform | PlanarThreeRPR | PlanarThreeRRR | DeltaRobot | FiveBar | CableRobot | SphericalPlatform
)
ParallelRobot = _OfAttributes | RodRobot

KINDS: dict[str, type[_OfAttributes]] = {
    "stewart": StewartPlatform,
    "3rpr": PlanarThreeRPR,
    "3rrr": PlanarThreeRRR,
    "delta": DeltaRobot,
    "five_bar": FiveBar,
    "cable": CableRobot,
    "spherical": SphericalPlatform,
}
ON_RODS: dict[str, Callable[..., RodRobot]] = {
    each.__name__: each
    for each in (
        rod_library.rotary_delta, rod_library.linear_delta, rod_library.hexapod_on_rods, rod_library.five_bar_on_rods,
        rod_library.planar_on_rods, rod_library.h4,
    )
}  # fmt: skip
"""Robots on rods by the function that makes them."""
CIRCLES = ("base_radius", "platform_radius", "base_angles", "platform_angles")
"""Another way to describe a platform on six legs: two circles, angles in degrees."""
DEGREES = {"angles", "first", "second"}
"""Keys of angles."""
HEADING = ("kind", "name")


def read_parallel(path: str | PathLike[str]) -> ParallelRobot:
    """The parallel robot in a TOML file.

    Args:
        path: of the file.

    Raises:
        FileError: missing, unreadable, malformed, an unknown kind, unknown or missing keys, numbers that make no robot.
    """
    data = read_toml(path)
    return parse_parallel(data, Path(path).name)


def parse_parallel(data: dict[str, Any], source: str) -> ParallelRobot:
    """The parallel robot in plain data.

    Args:
        data: as read from TOML.
        source: name for errors.

    Raises:
        FileError: as `read_parallel`.
    """
    kind = data.get("kind")
    if not isinstance(kind, str) or kind not in KINDS | ON_RODS:
        raise FileError("parallel.file_kind", path=source, given=repr(kind), known=", ".join((*KINDS, *ON_RODS)))
    numbers = {key: value for key, value in data.items() if key not in HEADING}
    circles = kind == "stewart" and any(key in numbers for key in CIRCLES)
    keys, needed = (CIRCLES, CIRCLES) if circles else _keys_of(kind)
    for key in numbers:
        if key not in keys:
            raise FileError("mobility.file_key", path=source, place="", name=key, known=", ".join((*HEADING, *keys)))
    for key in needed:
        if key not in numbers:
            raise FileError("mobility.file_missing", path=source, place=kind, name=key)
    try:
        for key in DEGREES & numbers.keys():
            numbers[key] = np.radians(real_array(key, numbers[key]))
        if kind in ON_RODS:
            return ON_RODS[kind](**numbers)
        return _on_circles(numbers) if circles else KINDS[kind](**numbers)
    except InputError as error:
        raise FileError("mobility.file_joint", path=source, place=kind, reason=error.message()) from None


def _keys_of(kind: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The keys that a kind of robot may have, and those that it needs."""
    if kind in ON_RODS:
        arguments = signature(ON_RODS[kind]).parameters
        return tuple(arguments), tuple(name for name, each in arguments.items() if each.default is Parameter.empty)
    known = fields(KINDS[kind])
    return (
        tuple(each.name for each in known),
        tuple(each.name for each in known if each.default is each.default_factory is MISSING),
    )


def _on_circles(numbers: dict[str, Any]) -> StewartPlatform:
    angles = [np.radians(single(name, numbers[name], (6,))) for name in CIRCLES[2:]]
    return StewartPlatform.on_circles(numbers["base_radius"], numbers["platform_radius"], *angles)
