"""ScrewAxis: a unit screw with its frame, and the displacement along it, as a frozen value."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Scalar, Vector3
from mafsil.errors import InputError
from mafsil.geometry import membership
from mafsil.geometry import screw as functions
from mafsil.geometry import twist as twist_functions
from mafsil.geometry.values import labels
from mafsil.geometry.values.pose import Pose
from mafsil.geometry.values.twist import Twist
from mafsil.geometry.values.value import Value, factor_of


@dataclass(frozen=True, eq=False, repr=False)
class ScrewAxis(Value):
    """A unit screw S = (omega, v): |omega| = 1, or omega = 0 and |v| = 1 (pure translation, infinite pitch).

    Attributes:
        array: (*batch, 6).
        frame: letter of the frame, or None.
    """

    frame: str | None = None
    core: ClassVar[int] = 1

    @staticmethod
    def check_array(array: Any) -> Floats:
        """Refuse what is not of unit length within `tolerance.UNIT`."""
        return membership.require("unit_screw", "ScrewAxis", array)

    @classmethod
    def of(cls, direction: ArrayLike, point: ArrayLike, pitch: ArrayLike = 0.0, frame: str | None = None) -> ScrewAxis:
        """From a direction, a point of the axis [m] and a pitch [m/rad]; any batch."""
        return cls(functions.from_axis(direction, point, pitch), frame)

    @classmethod
    def translation(cls, direction: ArrayLike, frame: str | None = None) -> ScrewAxis:
        """Of infinite pitch, along (*batch, 3)."""
        return cls(functions.from_direction(direction), frame)

    @classmethod
    def of_twist(cls, V: Twist) -> tuple[ScrewAxis, Scalar]:
        """Instantaneous screw of a twist and its rate (*batch): V = S rate.

        Raises:
            InputError: the zero twist has no axis.
        """
        S, rate = functions.normalise(V.array), functions.magnitude(V.array)
        if np.any(np.asarray(rate) == 0):
            raise InputError("geometry.identity_log", name="V")
        return cls(S, V.frame), rate

    @classmethod
    def of_displacement(cls, T: Pose) -> tuple[ScrewAxis, Scalar]:
        """Screw of a displacement and its amount (*batch) [rad], or [m] of a translation: T = exp([S] amount).

        Raises:
            InputError: the identity has no screw axis.
        """
        S, amount = functions.chasles(T.array)
        if np.any(np.asarray(amount) == 0):
            raise InputError("geometry.identity_log", name="T")
        return cls(S, None if T.frames is None else T.frames[0]), amount

    @property
    def direction(self) -> Vector3:
        """(*batch, 3) unit direction of the axis, of the translation where omega is zero."""
        omega, v = self.array[..., :3], self.array[..., 3:]
        return np.where((omega == 0).all(-1, keepdims=True), v, omega)

    @property
    def point(self) -> Vector3:
        """(*batch, 3) point of the axis nearest to the origin [m]; NaN for translations, which have no axis line."""
        return functions.nearest_point(self.array)

    @property
    def pitch(self) -> Scalar:
        """(*batch) pitch [m/rad]; infinite for translations."""
        return functions.pitch(self.array)

    def displacement(self, amount: ArrayLike) -> Pose:
        """exp([S] amount), amount (*batch) [rad], or [m] for translations."""
        return Pose(functions.displacement(self.array, amount))

    def seen_from(self, T_ab: Pose) -> ScrewAxis:
        """S_a = Ad(T_ab) S_b of this screw S_b; the pitch stays."""
        frame = labels.carry_frame("seen_from", T_ab.frames, self.frame)
        return ScrewAxis(twist_functions.transform(T_ab.array, self.array), frame)

    def __neg__(self) -> ScrewAxis:
        """The same line, run through the other way: the pitch stays."""
        return ScrewAxis(-self.array, self.frame)

    def __mul__(self, rate: ArrayLike) -> Twist:
        """The twist of a motion along the screw at a rate (*batch)."""
        return Twist(self.array * factor_of("*", self, rate), self.frame)

    def __rmul__(self, rate: ArrayLike) -> Twist:
        return self * rate
