"""The three-joint wrist behind every set of Euler angles: three revolute joints whose axes meet in one point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, RotationMatrix, Vector3, as_batch
from mafsil.geometry import euler, membership, rotation


@dataclass(frozen=True)
class Wrist:
    """Frames {0} fixed and {1}, {2}, {3} on the links, all parallel at zero angles.

    Attributes:
        axes: rows are the joint axes at zero, unit, the second orthogonal to its neighbours.
        middle_offset: middle joint angle [rad] that is called zero: another choice names another set of angles.
    """

    axes: tuple[tuple[float, float, float], ...]
    middle_offset: float = 0.0

    def __post_init__(self) -> None:
        membership.require("axis_triple", "axes", np.array(self.axes))

    @classmethod
    def of_sequence(cls, sequence: str) -> Wrist:
        """The wrist of a sequence such as `ZYX`; of fixed axes, the one that makes the same rotations."""
        axes = np.eye(3)[list(euler.sequence_named(sequence).body_axes)]
        return cls(tuple((float(x), float(y), float(z)) for x, y, z in axes))

    def link_rotations(self, angles: ArrayLike) -> tuple[RotationMatrix, RotationMatrix, RotationMatrix]:
        """R_01, R_12, R_23, each (*batch, 3, 3), of joint angles (*batch, 3) [rad]."""
        turned = self._move(as_batch("angles", angles, (3,)))
        first, second, third = (rotation.from_axis_angle(self.axes[k], turned[..., k]) for k in range(3))
        return first, second, third

    def rotation(self, angles: ArrayLike) -> RotationMatrix:
        """R_03 (*batch, 3, 3) of joint angles (*batch, 3) [rad]."""
        return euler.from_davenport(self._move(as_batch("angles", angles, (3,))), self.axes)

    def angles(self, R_03: ArrayLike) -> Vector3:
        """(*batch, 2, 3) both sets of joint angles [rad] that reach a rotation; every rotation is reached."""
        both = np.array(euler.to_davenport(R_03, self.axes))
        both[..., 1] = euler.wrap_symmetric(both[..., 1] - self.middle_offset)
        return both

    def with_middle_zero(self, offset: float) -> Wrist:
        """The same mechanism with the middle joint's zero moved by an angle [rad]."""
        return Wrist(self.axes, self.middle_offset + offset)

    def _move(self, angles: Floats) -> Floats:
        return angles + np.array([0.0, self.middle_offset, 0.0])
