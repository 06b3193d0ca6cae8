"""A rigid link: mass, shapes and a name."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mafsil.arrays import Floats, Vector3, frozen
from mafsil.model.shape import Shape


@dataclass(frozen=True, eq=False, slots=True)
class Inertial:
    """Mass properties of a link, in the link frame {l}.

    Attributes:
        mass: [kg].
        com: (3,) centre of mass in {l} [m].
        inertia: (3, 3) rotational inertia about the centre of mass, in axes parallel to {l}; products with the
            minus sign inside (tensor convention) [kg m^2].
    """

    mass: float
    com: Vector3 = field(default_factory=lambda: frozen(np.zeros(3)))
    inertia: Floats = field(default_factory=lambda: frozen(np.zeros((3, 3))))


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
