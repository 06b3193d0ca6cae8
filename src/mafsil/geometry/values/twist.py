"""Twist: a spatial velocity (omega, v) with its frame, as a frozen value."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Scalar, Vector3, as_batch
from mafsil.geometry import twist as functions
from mafsil.geometry import wrench as wrench_functions
from mafsil.geometry.values import labels
from mafsil.geometry.values.pose import Pose
from mafsil.geometry.values.value import Linear, operands
from mafsil.geometry.values.wrench import Wrench


@dataclass(frozen=True, eq=False, repr=False)
class Twist(Linear):
    """Spatial velocity of a body, angular part first.

    Attributes:
        array: (*batch, 6) (omega [rad/s], v [m/s]).
        frame: letter of the frame, or None.
    """

    core: ClassVar[int] = 1

    @staticmethod
    def check_array(array: Any) -> Floats:
        """Six numbers each."""
        return as_batch("twist", array, (6,))

    @classmethod
    def of(cls, omega: ArrayLike, v: ArrayLike, frame: str | None = None) -> Twist:
        """From its halves (*batch, 3)."""
        halves = np.broadcast_arrays(as_batch("omega", omega, (3,)), as_batch("v", v, (3,)))
        return cls(np.concatenate(halves, axis=-1), frame)

    @property
    def omega(self) -> Vector3:
        """(*batch, 3) angular velocity [rad/s]."""
        return self.array[..., :3]

    @property
    def v(self) -> Vector3:
        """(*batch, 3) velocity of the body point at the frame's origin [m/s]."""
        return self.array[..., 3:]

    def seen_from(self, T_ab: Pose) -> Twist:
        """V_a = Ad(T_ab) V_b of this twist V_b."""
        return Twist(
            functions.transform(T_ab.array, self.array), labels.carry_frame("seen_from", T_ab.frames, self.frame)
        )

    def point_velocity(self, point: ArrayLike) -> Vector3:
        """(*batch, 3) velocity [m/s] of the body point at (*batch, 3) [m]."""
        return functions.point_velocity(self.array, point)

    def power(self, wrench: Wrench) -> Scalar:
        """(*batch) V . F [W]; both must be in one frame."""
        if not isinstance(cast(object, wrench), Wrench):
            raise operands("power", self, wrench)
        labels.same("power", self.frame, wrench.frame)
        return wrench_functions.power(self.array, wrench.array)

    def bracket(self, other: Twist) -> Twist:
        """Lie bracket ad(V) W."""
        right = self.match_units("bracket", other)
        frame = labels.same("bracket", self.frame, right.frame)
        return Twist(functions.bracket(self.array, right.array), frame)
