"""A rigid link: mass, a name, and the shapes attached to it, which are drawn and collide."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path
from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import LARGEST, Floats, PoseMatrix, Vector3, as_batch, frozen, number, single
from mafsil.errors import InputError, ModelError
from mafsil.fields import check_fields, or_none, real
from mafsil.model.placement import frozen_pose, turned_tensor
from mafsil.model.tolerances import WRITTEN

Colour: TypeAlias = tuple[float, float, float, float]
"""Red, green, blue, opacity in 0..1."""
SHELL: Colour = (0.90, 0.90, 0.88, 1.0)
HOUSING: Colour = (0.27, 0.31, 0.35, 1.0)
ACCENT: Colour = (0.86, 0.42, 0.14, 1.0)
OUTLINE = "outline"
"""Name of shapes of a robot that is only numbers: about its outline, fitted or estimated; a `radius=` replaces them."""


def fixed_array(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Floats:
    """A read-only copy of a user's array of exactly this shape, finite."""
    array = as_batch(name, value, shape, finite=True)
    if array.shape != shape:
        raise InputError("input.shape", name=name, expected=shape, got=array.shape, hint="")
    return frozen(array)


@dataclass(frozen=True, eq=False, slots=True)
class Inertial:
    """Mass properties of a link, in the link frame {l}.

    Attributes:
        mass: [kg].
        com: (3,) centre of mass in {l} [m].
        inertia: (3, 3) rotational inertia about the centre of mass, in axes parallel to {l}; products with the
            minus sign inside (tensor convention) [kg m^2].

    Arrays are copied. Whether a body can have such an inertia is for the readers and `lint` to say.

    Raises:
        InputError: wrong shapes, NaN or infinities.
        ModelError: a negative mass, an inertia that is not symmetric.
    """

    mass: float
    com: Vector3 = field(default_factory=lambda: frozen(np.zeros(3)))
    inertia: Floats = field(default_factory=lambda: frozen(np.zeros((3, 3))))
    _numbers = check_fields(mass=real)

    def __post_init__(self) -> None:
        self._numbers()
        if not (isfinite(self.mass) and self.mass >= 0):
            raise ModelError("model.magnitude", name="mass", value=self.mass)
        com = fixed_array("com", self.com, (3,))
        inertia = fixed_array("inertia", self.inertia, (3, 3))
        if np.abs(inertia - inertia.T).max() > WRITTEN * np.abs(inertia).max():
            raise ModelError("model.asymmetric", inertia=inertia.tolist())
        object.__setattr__(self, "com", com)
        object.__setattr__(self, "inertia", inertia)


def moved_inertial(inertial: Inertial, T_ab: PoseMatrix) -> Inertial:
    """The same mass properties, given in {b}, expressed in {a}."""
    R, p = T_ab[:3, :3], T_ab[:3, 3]
    return Inertial(inertial.mass, frozen(R @ inertial.com + p), turned_tensor(inertial.inertia, R))


@dataclass(frozen=True, eq=False, slots=True)
class Link:
    """A rigid body of a mechanism.

    Attributes:
        name: unique among the links.
        inertial: mass properties, or None for a massless frame.
        visuals: what is drawn.
        collisions: what collides.
    """

    name: str
    inertial: Inertial | None = None
    visuals: tuple[Shape, ...] = ()
    collisions: tuple[Shape, ...] = ()

    @property
    def is_bare(self) -> bool:
        """Whether it has neither mass nor shape: a frame alone."""
        return self.inertial is None and not self.visuals and not self.collisions


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
