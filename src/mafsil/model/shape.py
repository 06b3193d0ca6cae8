"""Geometry attached to links: what is drawn and what collides."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias, cast

import numpy as np

from mafsil.arrays import LARGEST, PoseMatrix, frozen, number, single
from mafsil.fields import check_fields, or_none
from mafsil.model.placement import frozen_pose


def _three(name: str, value: Any) -> tuple[float, ...]:
    given = cast("tuple[Any, ...]", value)
    if type(given) is tuple and [type(x) for x in given] == [float] * 3 and all(abs(x) <= LARGEST for x in given):
        return given
    return tuple(single(name, value, (3,)).tolist())


@dataclass(frozen=True, slots=True)
class Box:
    """A box centred on its frame; `size` are the full edge lengths along x, y, z [m]."""

    size: tuple[float, float, float]
    __post_init__ = check_fields(size=_three)


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder centred on its frame, axis along z; full `length` [m]."""

    radius: float
    length: float
    __post_init__ = check_fields(radius=number, length=number)


@dataclass(frozen=True, slots=True)
class Capsule:
    """A cylinder with hemispherical ends, axis along z; `length` without the ends [m]."""

    radius: float
    length: float
    __post_init__ = check_fields(radius=number, length=number)


@dataclass(frozen=True, slots=True)
class Sphere:
    """A ball centred on its frame [m]."""

    radius: float
    __post_init__ = check_fields(radius=number)


@dataclass(frozen=True, slots=True)
class Mesh:
    """A surface in a file.

    Attributes:
        reference: the reference as written in the robot file, such as `package://arm/link1.stl`.
        path: the file it was resolved to, or None if it was not found or not allowed.
        scale: factors along x, y, z.
    """

    reference: str
    path: Path | None = None
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)
    __post_init__ = check_fields(scale=_three)


Geometry: TypeAlias = Box | Cylinder | Capsule | Sphere | Mesh
Colour: TypeAlias = tuple[float, float, float, float]
"""Red, green, blue, opacity in 0..1."""

SHELL: Colour = (0.90, 0.90, 0.88, 1.0)
HOUSING: Colour = (0.27, 0.31, 0.35, 1.0)
ACCENT: Colour = (0.86, 0.42, 0.14, 1.0)
OUTLINE = "outline"
"""Name of shapes of a robot that is only numbers: about its outline, fitted or estimated; a `radius=` replaces them."""


@dataclass(frozen=True, eq=False, slots=True)
class Shape:
    """A geometry placed in the frame of its link.

    Attributes:
        geometry: what it is.
        T_lg: (4, 4) pose of the geometry's frame {g} in the link frame {l}.
        name: optional name.
        colour: red, green, blue, opacity in 0..1, or None.
    """

    geometry: Geometry
    T_lg: PoseMatrix = field(default_factory=lambda: frozen(np.eye(4)))
    name: str = ""
    colour: Colour | None = None
    __post_init__ = check_fields(
        T_lg=frozen_pose,
        colour=or_none(lambda name, value: tuple(single(name, value, (4,)).tolist())),
    )
