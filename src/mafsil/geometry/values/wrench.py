"""Wrench: a moment and a force (m, f) with their frame, as a frozen value."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Scalar, Vector3, as_batch
from mafsil.geometry import wrench as functions
from mafsil.geometry.values import labels
from mafsil.geometry.values.pose import Pose
from mafsil.geometry.values.value import Linear


@dataclass(frozen=True, eq=False, repr=False)
class Wrench(Linear):
    """Spatial force, moment first; any (m, f), pure couples and sums included.

    Attributes:
        array: (*batch, 6) (m [N m], f [N]).
        frame: letter of the frame, or None.
    """

    core: ClassVar[int] = 1

    @staticmethod
    def check_array(array: Any) -> Floats:
        """Six numbers each."""
        return as_batch("wrench", array, (6,))

    @classmethod
    def of(cls, moment: ArrayLike, force: ArrayLike, frame: str | None = None) -> Wrench:
        """From its halves (*batch, 3)."""
        halves = np.broadcast_arrays(as_batch("moment", moment, (3,)), as_batch("force", force, (3,)))
        return cls(np.concatenate(halves, axis=-1), frame)

    @classmethod
    def from_force(cls, point: ArrayLike, force: ArrayLike, frame: str | None = None) -> Wrench:
        """Of a force (*batch, 3) [N] at a point (*batch, 3) [m]."""
        return cls(functions.from_force(point, force), frame)

    @classmethod
    def from_couple(cls, moment: ArrayLike, frame: str | None = None) -> Wrench:
        """Of a pure couple (*batch, 3) [N m]."""
        return cls(functions.from_couple(moment), frame)

    @property
    def moment(self) -> Vector3:
        """(*batch, 3) moment about the frame's origin [N m]."""
        return self.array[..., :3]

    @property
    def force(self) -> Vector3:
        """(*batch, 3) force [N]."""
        return self.array[..., 3:]

    @property
    def pitch(self) -> Scalar:
        """(*batch) m.f / |f|^2 [m]."""
        return functions.pitch(self.array)

    def seen_from(self, T_ab: Pose) -> Wrench:
        """F_a = Ad(T_ba)' F_b of this wrench F_b."""
        frame = labels.carry_frame("seen_from", T_ab.frames, self.frame)
        return Wrench(functions.transform(T_ab.inverse().array, self.array), frame)
