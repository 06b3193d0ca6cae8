"""Screws S = (omega, v): axis, point and pitch, and the displacement along them; any batch.

A unit screw has |omega| = 1 (amount: an angle [rad]) or omega = 0 and |v| = 1 (amount: a distance [m]).

The path of a body point that a screw carries: a helix about the axis, a circle, or a straight line.

What kind of displacement it is: none, a translation, a rotation, a right- or left-handed screw, a half turn.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from math import inf, nan, pi

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Matrix3, PoseMatrix, Scalar, Vector3, Vector6, single
from mafsil.geometry import membership, pose
from mafsil.geometry.conditioned import (
    AmountLike,
    AxisLike,
    PartTurnLike,
    PoseLike,
    ScalarLike,
    UnitScrewLike,
    Vector3Like,
    Vector6Like,
    compile_function,
)
from mafsil.geometry.tolerances import SPECIAL
from mafsil.messages import say


@compile_function("screw.from_axis")
def from_axis(direction: AxisLike, point: Vector3Like, pitch: ScalarLike = 0.0) -> Vector6:
    """Unit screw of an axis: S = (s, -s x q + h s).

    Args:
        direction: (*batch, 3) along the axis, any length but zero.
        point: (*batch, 3) a point of the axis [m].
        pitch: (*batch) advance per angle [m/rad]; 0 is a pure rotation. For a pure translation use `from_direction`.

    Returns:
        (*batch, 6).

    Raises:
        InputError: a direction is zero.

    Reference: Lynch & Park, Modern Robotics, sec. 3.3.2.2.
    """
    ...


def from_direction(direction: ArrayLike) -> Vector6:
    """(*batch, 6) unit screw of infinite pitch (0, s), a translation along (*batch, 3) of any length but zero."""
    S = from_axis(direction, (0.0, 0.0, 0.0))
    S[..., 3:] = S[..., :3]
    S[..., :3] = 0.0
    return S


@compile_function("screw.pitch")
def pitch(S: Vector6Like) -> Scalar:
    """(*batch) pitch omega.v / |omega|^2 [m/rad] of (*batch, 6); infinite where omega is zero."""
    ...


@compile_function("screw.nearest_point")
def nearest_point(S: Vector6Like) -> Vector3:
    """(*batch, 3) point of the axis nearest to the origin, omega x v / |omega|^2 [m]; NaN where omega is zero."""
    ...


@compile_function("screw.normalise")
def normalise(V: Vector6Like) -> Vector6:
    """(*batch, 6) unit screw of twists (*batch, 6); zero for the zero twist."""
    ...


@compile_function("screw.magnitude")
def magnitude(V: Vector6Like) -> Scalar:
    """(*batch) |omega| of twists (*batch, 6), or |v| where omega is zero: the factor that `normalise` divides out."""
    ...


@compile_function("screw.motion")
def displacement(S: UnitScrewLike, amount: AmountLike) -> PoseMatrix:
    """exp([S] amount): rotation by, or translation along, a unit screw.

    Args:
        S: (*batch, 6) unit screw.
        amount: (*batch) angle [rad], or distance [m] where omega is zero.

    Returns:
        (*batch, 4, 4).

    Raises:
        InputError: S is not unit within `tolerance.UNIT`.

    Reference: Lynch & Park, Modern Robotics, prop. 3.25.
    """
    ...


@compile_function("screw.chasles")
def chasles(T: PoseLike) -> tuple[Vector6, Scalar]:
    """The one screw that makes a displacement: T = exp([S] amount) (Chasles and Mozzi).

    Rotations below `tolerance.TRANSLATION` count as none. The identity has S = 0 and amount 0; its axis is any line.

    Args:
        T: (*batch, 4, 4) displacement.

    Returns:
        S (*batch, 6) unit screw, amount (*batch) angle in [0, pi] [rad] or distance [m].
    """
    ...


@compile_function("screw.integral")
def integral(omega: Vector3Like, theta: AmountLike) -> Matrix3:
    """(*batch, 3, 3) G(theta) of a unit axis: exp([S] theta) has p = G v.

    Reference: Lynch & Park, Modern Robotics, eq. 3.87.
    """
    ...


@compile_function("screw.integral_inverse")
def integral_inverse(omega: Vector3Like, theta: PartTurnLike) -> Matrix3:
    """(*batch, 3, 3) G(theta)^-1; whole turns are refused, where det G = 2 theta (1 - cos theta) vanishes."""
    ...


@compile_function("spatial.reciprocal_product")
def reciprocal_product(S: Vector6Like, Z: Vector6Like) -> Scalar:
    """(*batch) omega_S . v_Z + v_S . omega_Z: zero for screws that do no work on each other."""
    ...


@dataclass(frozen=True, eq=False)
class Helix:
    """x(theta) = q + exp([w] theta)(x - q) + h theta w.

    Attributes:
        screw: (6,) unit screw.
        start: (3,) the point at theta = 0 [m].
        radius: distance from the axis [m]; 0 for translations.
        speed: length of path for each unit of theta, sqrt(radius^2 + h^2) [m/rad]; 1 for translations.
        lead: advance in one turn, 2 pi h [m]; infinite for translations.
    """

    screw: Vector6
    start: Vector3
    radius: float
    speed: float
    lead: float

    def at(self, theta: ArrayLike) -> Vector3:
        """(*batch, 3) the point after (*batch) theta [rad], or [m] of a translation."""
        return pose.act(displacement(self.screw, theta), self.start)

    def length(self, theta: float) -> float:
        """Length of the path to theta [m]."""
        return abs(theta) * self.speed


def helix(S: ArrayLike, point: ArrayLike) -> Helix:
    """The path of a point along a screw.

    Args:
        S: (6,) unit screw; `from_axis` makes one of axis, point and pitch.
        point: (3,) at the start [m].

    Raises:
        InputError: S is not of unit size.
    """
    unit = membership.require("unit_screw", "S", single("S", S, (6,)))
    start = single("point", point, (3,))
    omega, v = unit[:3], unit[3:]
    if not omega.any():
        return Helix(unit, start, 0.0, 1.0, float("inf"))
    h = float(omega @ v)
    radius = float(np.linalg.norm(np.cross(omega, start) + v - h * omega))
    return Helix(unit, start, radius, float(np.hypot(radius, h)), 2 * np.pi * h)


class DisplacementKind(Enum):
    """The kinds of displacements of a body, by Chasles."""

    IDENTITY = "identity"
    TRANSLATION = "translation"
    ROTATION = "rotation"
    RIGHT_HANDED = "right_handed"
    LEFT_HANDED = "left_handed"
    HALF_TURN = "half_turn"


@dataclass(frozen=True, eq=False)
class Displacement:
    """A displacement read as one screw motion.

    Attributes:
        kind: HALF_TURN is a screw by half a turn, whose handedness is undetermined; by half a turn without advance it
            is a ROTATION.
        direction: (3,) along the axis, or of the translation; NaN for the identity.
        point: (3,) point of the axis nearest to the origin [m]; NaN where there is no axis line.
        angle: in [0, pi] [rad].
        advance: along the direction [m].
        pitch: advance per angle [m/rad]; infinite for translations, NaN for the identity.
    """

    kind: DisplacementKind
    direction: Vector3
    point: Vector3
    angle: float
    advance: float
    pitch: float

    def explain(self, language: str | None = None) -> str:
        """The kind, its axis, angle and advance."""
        return say(
            f"geometry.kind_{self.kind.value}",
            language=language,
            direction=_text(self.direction),
            point=_text(self.point),
            angle=float(np.degrees(self.angle)),
            advance=self.advance,
            pitch=self.pitch,
        )


def classify(T: ArrayLike, *, angle: float = SPECIAL, distance: float = SPECIAL) -> Displacement:
    """The kind of one displacement.

    Args:
        T: (4, 4).
        angle: [rad] to none or to half a turn that counts as such.
        distance: [m] that counts as none.

    Raises:
        InputError: T is no pose, or a batch.
    """
    matrix = membership.require("pose", "T", single("T", T, (4, 4)))
    S, amount = chasles(matrix)
    turned = float(amount) if np.abs(S[:3]).max() > 0 else 0.0
    if turned <= angle:
        moved = float(np.linalg.norm(matrix[:3, 3]))
        if moved <= distance:
            return Displacement(DisplacementKind.IDENTITY, np.full(3, nan), np.full(3, nan), 0.0, 0.0, nan)
        return Displacement(DisplacementKind.TRANSLATION, matrix[:3, 3] / moved, np.full(3, nan), 0.0, moved, inf)
    advance = float(S[:3] @ matrix[:3, 3])
    if abs(advance) <= distance:
        kind, advance = DisplacementKind.ROTATION, 0.0
    elif pi - turned <= angle:
        kind = DisplacementKind.HALF_TURN
    else:
        kind = DisplacementKind.RIGHT_HANDED if advance > 0 else DisplacementKind.LEFT_HANDED
    return Displacement(kind, S[:3], nearest_point(S), turned, advance, advance / turned)


def _text(vector: Vector3) -> str:
    return "(" + ", ".join(f"{x:.4g}" if abs(x) > 5e-13 else "0" for x in vector) + ")"
