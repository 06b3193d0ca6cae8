"""Twist (omega, v), Wrench (m, f) and ScrewAxis as frozen values with their frame.

A screw axis is a unit screw, and the displacement along it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Scalar, Vector3, as_batch
from mafsil.errors import InputError
from mafsil.geometry import membership
from mafsil.geometry import screw as screw_functions
from mafsil.geometry import twist as twist_functions
from mafsil.geometry import wrench as wrench_functions
from mafsil.geometry.values.pose import Pose
from mafsil.geometry.values.value import Linear, Value, carry_frame, common_frame, factor_of, operands


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
            twist_functions.transform(T_ab.array, self.array), carry_frame("seen_from", T_ab.frames, self.frame)
        )

    def point_velocity(self, point: ArrayLike) -> Vector3:
        """(*batch, 3) velocity [m/s] of the body point at (*batch, 3) [m]."""
        return twist_functions.point_velocity(self.array, point)

    def power(self, wrench: Wrench) -> Scalar:
        """(*batch) V . F [W]; both must be in one frame."""
        if not isinstance(cast(object, wrench), Wrench):
            raise operands("power", self, wrench)
        common_frame("power", self.frame, wrench.frame)
        return wrench_functions.power(self.array, wrench.array)

    def bracket(self, other: Twist) -> Twist:
        """Lie bracket ad(V) W."""
        right = self.match_units("bracket", other)
        frame = common_frame("bracket", self.frame, right.frame)
        return Twist(twist_functions.bracket(self.array, right.array), frame)


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
        return cls(wrench_functions.from_force(point, force), frame)

    @classmethod
    def from_couple(cls, moment: ArrayLike, frame: str | None = None) -> Wrench:
        """Of a pure couple (*batch, 3) [N m]."""
        return cls(wrench_functions.from_couple(moment), frame)

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
        return wrench_functions.pitch(self.array)

    def seen_from(self, T_ab: Pose) -> Wrench:
        """F_a = Ad(T_ba)' F_b of this wrench F_b."""
        frame = carry_frame("seen_from", T_ab.frames, self.frame)
        return Wrench(wrench_functions.transform(T_ab.inverse().array, self.array), frame)


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
        return cls(screw_functions.from_axis(direction, point, pitch), frame)

    @classmethod
    def translation(cls, direction: ArrayLike, frame: str | None = None) -> ScrewAxis:
        """Of infinite pitch, along (*batch, 3)."""
        return cls(screw_functions.from_direction(direction), frame)

    @classmethod
    def of_twist(cls, V: Twist) -> tuple[ScrewAxis, Scalar]:
        """Instantaneous screw of a twist and its rate (*batch): V = S rate.

        Raises:
            InputError: the zero twist has no axis.
        """
        S, rate = screw_functions.normalise(V.array), screw_functions.magnitude(V.array)
        if np.any(np.asarray(rate) == 0):
            raise InputError("geometry.identity_log", name="V")
        return cls(S, V.frame), rate

    @classmethod
    def of_displacement(cls, T: Pose) -> tuple[ScrewAxis, Scalar]:
        """Screw of a displacement and its amount (*batch) [rad], or [m] of a translation: T = exp([S] amount).

        Raises:
            InputError: the identity has no screw axis.
        """
        S, amount = screw_functions.chasles(T.array)
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
        return screw_functions.nearest_point(self.array)

    @property
    def pitch(self) -> Scalar:
        """(*batch) pitch [m/rad]; infinite for translations."""
        return screw_functions.pitch(self.array)

    def displacement(self, amount: ArrayLike) -> Pose:
        """exp([S] amount), amount (*batch) [rad], or [m] for translations."""
        return Pose(screw_functions.displacement(self.array, amount))

    def seen_from(self, T_ab: Pose) -> ScrewAxis:
        """S_a = Ad(T_ab) S_b of this screw S_b; the pitch stays."""
        frame = carry_frame("seen_from", T_ab.frames, self.frame)
        return ScrewAxis(twist_functions.transform(T_ab.array, self.array), frame)

    def __neg__(self) -> ScrewAxis:
        """The same line, run through the other way: the pitch stays."""
        return ScrewAxis(-self.array, self.frame)

    def __mul__(self, rate: ArrayLike) -> Twist:
        """The twist of a motion along the screw at a rate (*batch)."""
        return Twist(self.array * factor_of("*", self, rate), self.frame)

    def __rmul__(self, rate: ArrayLike) -> Twist:
        return self * rate
