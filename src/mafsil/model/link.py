"""A rigid link: mass, shapes and a name."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, Vector3, as_batch, frozen
from mafsil.errors import InputError, ModelError
from mafsil.fields import check_fields, real
from mafsil.model.placement import turned_tensor
from mafsil.model.shape import Shape
from mafsil.model.tolerances import WRITTEN


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
