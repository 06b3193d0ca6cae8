"""A surface that does not give way: its signed distance, its normal, its friction, and how an impact ends."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Vector3, as_batch, not_negative, positive, single
from mafsil.control.contact.shaped_environment import round_normal, round_normal_rate
from mafsil.errors import InputError
from mafsil.fields import between, checked


@dataclass(frozen=True, eq=False, slots=True)
class RigidSurface:
    """A plane, a sphere or a cylinder that the tip's origin cannot enter: it only pushes.

    What it does to the tip is a force along its normal and one of friction across it, at most `friction` times as
    large: a tip that it can hold sticks, another one slides, and friction is against the sliding.

    Attributes:
        point: (3,) on the plane, in the middle of the sphere, on the axis of the cylinder, in {s} [m].
        restitution: from 0 (it stays) to 1: square root of the share of the normal work that an impact gives back;
            without friction, and where the tip slides all the time, speed along the normal after over that before.
        normal: (3,) of a plane, out of it, towards the arm.
        radius: of a sphere or a cylinder [m].
        axis: (3,) of a cylinder.
        hollow: whether the tip is inside and touches the inner side.
        friction: Coulomb's coefficient mu, of sticking and of sliding.

    Raises:
        InputError: a wrong shape, neither or both of normal and radius, a restitution outside 0 to 1, friction below 0.
    """

    point: Vector3
    restitution: float = 0.0
    normal: Vector3 | None = None
    radius: float | None = None
    axis: Vector3 | None = None
    hollow: bool = False
    friction: float = 0.0
    _numbers = checked(restitution=between(0.0, 1.0), friction=not_negative)

    def __post_init__(self) -> None:
        if (self.normal is None) == (self.radius is None):
            raise InputError("simulation.rigid_form")
        object.__setattr__(self, "point", single("point", self.point, (3,)))
        for name in ("normal", "axis"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, _unit(name, getattr(self, name)))
        if self.radius is not None:
            positive("radius", self.radius)
        self._numbers()

    @classmethod
    def plane(cls, point: ArrayLike, normal: ArrayLike, *, restitution: float = 0.0, friction: float = 0.0) -> Self:
        """A plane.

        Args:
            point, normal: (3,) on it, and out of it towards the arm; in {s} [m, 1].
            restitution, friction: as of the class.
        """
        out = single("normal", normal, (3,))
        return cls(single("point", point, (3,)), restitution, normal=out, friction=friction)

    @classmethod
    def sphere(
        cls, centre: ArrayLike, radius: float, *, restitution: float = 0.0, hollow: bool = False, friction: float = 0.0
    ) -> Self:
        """A sphere, touched from outside, or with `hollow` from inside.

        Args:
            centre: (3,) in {s} [m].
            radius: [m].
            restitution, friction: as of the class.
            hollow: whether the tip is inside.
        """
        return cls(single("centre", centre, (3,)), restitution, radius=radius, hollow=hollow, friction=friction)

    @classmethod
    def cylinder(
        cls,
        point: ArrayLike,
        axis: ArrayLike,
        radius: float,
        *,
        restitution: float = 0.0,
        hollow: bool = False,
        friction: float = 0.0,
    ) -> Self:
        """A cylinder without ends, touched from outside, or with `hollow` from inside.

        Args:
            point, axis: (3,) on its axis, and along it; in {s} [m, 1].
            radius: [m].
            restitution, friction: as of the class.
            hollow: whether the tip is inside.
        """
        at, along = single("point", point, (3,)), single("axis", axis, (3,))
        return cls(at, restitution, radius=radius, axis=along, hollow=hollow, friction=friction)

    def distance(self, p: Vector3) -> Floats:
        """(*batch,) from points p (*batch, 3) in {s} to the surface [m]; negative inside."""
        p = as_batch("p", p, (3,))
        if self.normal is not None:
            return np.asarray((p - self.point) @ self.normal)
        return -round_normal(p, self.point, self.radius or inf, self.axis, self.hollow)[1]

    def outward(self, p: Vector3) -> Vector3:
        """(*batch, 3) normal at points p (*batch, 3)."""
        p = as_batch("p", p, (3,))
        if self.normal is not None:
            return np.broadcast_to(self.normal, p.shape)
        return round_normal(p, self.point, self.radius or inf, self.axis, self.hollow)[0]

    def outward_rate(self, p: Vector3, velocity: Vector3) -> Vector3:
        """(*batch, 3) of the normal at points p (*batch, 3) that move [1/s]."""
        p, velocity = as_batch("p", p, (3,)), as_batch("velocity", velocity, (3,))
        if self.normal is not None:
            return np.zeros_like(p)
        return round_normal_rate(p, velocity, self.point, self.axis, self.hollow)


def _unit(name: str, value: ArrayLike) -> Vector3:
    vector = single(name, value, (3,))
    length = float(np.linalg.norm(vector))
    if not length > 0.0:
        raise InputError("control.no_normal")
    return vector / length
