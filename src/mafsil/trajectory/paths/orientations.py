"""Orientation laws over s in 0 .. 1, side by side: one axis, rotation vectors, angles, cosines, fixed, along the path.

Each says how a frame turns while its origin moves: R(s), its body rate and the derivative of that.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from mafsil.arrays import Floats, RotationMatrix, Vector3
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import euler, rotation
from mafsil.trajectory.paths.positions import PositionCurve
from mafsil.trajectory.paths.rotation_curves import RotationMotion, exponential, of_matrices, product, rotate_rows
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.tolerances import GIVEN, ROUNDING

LEAST_DETERMINANT = 1e-6
"""Of averaged direction cosines: below it no rotation is the nearest."""

LOOK = 257
"""Places at which the determinant and the gimbal lock are looked at."""


class OrientationLaw(Protocol):
    """An orientation over s in 0 .. 1."""

    @property
    def breaks(self) -> Floats:
        """(k + 1,) places between which it is smooth, 0 and 1 included."""
        ...

    def at(self, s: Floats) -> RotationMotion:
        """Rotation, body rate and its derivative at the places s."""
        ...


@dataclass(frozen=True, eq=False)
class FixedOrientation:
    """The same all along.

    Attributes:
        R: (3, 3) in {s}.
    """

    R: RotationMatrix

    @property
    def breaks(self) -> Floats:
        """0 and 1."""
        return np.array([0.0, 1.0])

    def at(self, s: Floats) -> RotationMotion:
        """The rotation, with rates of zero."""
        zero = np.zeros((*s.shape, 3))
        return RotationMotion(np.broadcast_to(self.R, (*s.shape, 3, 3)), zero, zero)


@dataclass(frozen=True, eq=False)
class RelativeAxis:
    """R = R_0 exp([k] s): one axis, fixed in the body and in space, at constant rate.

    Attributes:
        R: (3, 3) at s = 0.
        turn: (3,) k, axis times angle, in the body [rad].

    Reference: Lynch and Park, Modern Robotics, sec. 9.2.1.
    """

    R: RotationMatrix
    turn: Vector3

    @classmethod
    def between(cls, R_0: RotationMatrix, R_1: RotationMatrix, *, long: bool = False) -> RelativeAxis:
        """The short turn, at most pi, or the long one about the opposite axis.

        Raises:
            InputError: the long turn between equal orientations, whose axis is any.
        """
        k = rotation.log(R_0.T @ R_1)
        if long:
            size = float(np.linalg.norm(k))
            if size < GIVEN:
                raise InputError("trajectory.long_turn")
            k = k * (1.0 - 2 * np.pi / size)
        return cls(R_0, k)

    @property
    def breaks(self) -> Floats:
        """0 and 1."""
        return np.array([0.0, 1.0])

    def at(self, s: Floats) -> RotationMotion:
        """Rotation and constant rate."""
        w = np.broadcast_to(self.turn, (*s.shape, 3))
        return RotationMotion(self.R @ rotation.exp(s[..., None] * self.turn), w, np.zeros_like(w))


@dataclass(frozen=True, eq=False)
class SuccessiveAxes:
    """One relative axis after the other, each at constant rate: the rate jumps from leg to leg.

    Attributes:
        legs: their turns.
        knots: (k + 1,) places of their ends.
    """

    legs: tuple[RelativeAxis, ...]
    knots: Floats

    @property
    def breaks(self) -> Floats:
        """Ends of the legs."""
        return self.knots

    def at(self, s: Floats) -> RotationMotion:
        """Rotation and piecewise constant rate."""
        inside = np.clip(s, 0.0, 1.0)
        i = np.clip(np.searchsorted(self.knots, inside, side="right") - 1, 0, len(self.legs) - 1)
        R, turn = np.stack([leg.R for leg in self.legs]), np.stack([leg.turn for leg in self.legs])
        width = (self.knots[i + 1] - self.knots[i])[..., None]
        step = rotation.exp((inside - self.knots[i])[..., None] / width * turn[i])
        return RotationMotion(R[i] @ step, turn[i] / width, np.zeros_like(turn[i]))


@dataclass(frozen=True, eq=False)
class RotationVectors:
    """R = exp([K(s)]), the absolute rotation vector taken component by component.

    Attributes:
        K: (3) components over 0 .. 1 [rad].

    Reference: Craig, Introduction to Robotics, sec. 7.4.
    """

    K: PiecewisePolynomial

    @property
    def breaks(self) -> Floats:
        """The knots of the components."""
        return self.K.knots

    def at(self, s: Floats) -> RotationMotion:
        """Rotation, rate and its derivative."""
        return exponential(*self.K.at(np.clip(s, 0.0, 1.0)))


@dataclass(frozen=True, eq=False)
class EulerAngles:
    """Three angles taken component by component.

    Attributes:
        angles: (3) over 0 .. 1, in the order of the letters [rad].
        sequence: such as `ZYX` (body axes) or `xyz` (fixed axes).
    """

    angles: PiecewisePolynomial
    sequence: str

    @property
    def breaks(self) -> Floats:
        """The knots of the angles."""
        return self.angles.knots

    @cached_property
    def lock_distance(self) -> float:
        """How near the middle angle comes to gimbal lock [rad]; there the angles are no coordinates of the rotation."""
        middle = self.angles.at(np.linspace(0.0, 1.0, LOOK)).u[:, 1]
        if len(set(self.sequence.upper())) == 3:
            middle = middle + np.pi / 2
        return float(np.abs(middle - np.pi * np.round(middle / np.pi)).min())

    def at(self, s: Floats) -> RotationMotion:
        """Rotation, rate and its derivative, as the product of three turns about the axes."""
        motion = self.angles.at(np.clip(s, 0.0, 1.0))
        order = range(3) if self.sequence.isupper() else range(2, -1, -1)
        turns = [
            exponential(*(x[..., k, None] * np.eye(3)["XYZ".index(self.sequence[k].upper())] for x in motion))
            for k in order
        ]
        return product(product(turns[0], turns[1]), turns[2])


@dataclass(frozen=True, eq=False)
class DirectionCosines:
    """The nearest rotation to nine direction cosines taken component by component.

    Attributes:
        cosines: (9) over 0 .. 1, rows of the matrix one after the other.

    Raises:
        InputError: on the way the matrix loses its determinant, so that no rotation is the nearest.
    """

    cosines: PiecewisePolynomial

    def __post_init__(self) -> None:
        d = self.determinant(np.linspace(0.0, 1.0, LOOK))
        if d.min() < LEAST_DETERMINANT:
            raise InputError("trajectory.cosines", place=float(np.linspace(0.0, 1.0, LOOK)[d.argmin()]), value=d.min())

    @property
    def breaks(self) -> Floats:
        """The knots of the cosines."""
        return self.cosines.knots

    def determinant(self, s: Floats) -> Floats:
        """(*s,) of the matrix before it is projected; one for a rotation."""
        M = self.cosines.at(s).u
        return np.linalg.det(M.reshape(*M.shape[:-1], 3, 3))

    def at(self, s: Floats) -> RotationMotion:
        """Rotation of the polar decomposition M = R S, its rate and the derivative of that.

        With A = R' M' the skew part of R' M = S shows: vee(A - A^T) = (tr(S) - S) w; its derivative gives a.
        """
        M, M_1, M_2 = (x.reshape(*x.shape[:-1], 3, 3) for x in self.cosines.at(np.clip(s, 0.0, 1.0)))
        R = rotation.project(M)
        back = np.swapaxes(R, -1, -2)
        S, A = back @ M, back @ M_1
        S = (S + np.swapaxes(S, -1, -2)) / 2
        inertia = _trace(S) - S
        w: Vector3 = np.linalg.solve(inertia, _twice_skew(A)[..., None])[..., 0].astype(np.float64)
        W = rotation.hat(w)
        S_1, A_1 = A - W @ S, back @ M_2 - W @ A
        right = _twice_skew(A_1) - rotate_rows(_trace(S_1) - S_1, w)
        a: Vector3 = np.linalg.solve(inertia, right[..., None])[..., 0].astype(np.float64)
        return RotationMotion(R, w, a)


@dataclass(frozen=True, eq=False)
class AlongTangent:
    """The tool keeps its angle to the path: a frame of the tangent and a direction up, times a fixed rotation.

    Attributes:
        curve: of the origin.
        up: (3,) unit vector that is never along the tangent.
        offset: (3, 3) of the tool in the frame (tangent, up x tangent, the rest).
    """

    curve: PositionCurve
    up: Vector3
    offset: RotationMatrix

    @classmethod
    def from_start(cls, curve: PositionCurve, up: Vector3, R: RotationMatrix) -> AlongTangent:
        """With the orientation that the tool has at the start.

        Raises:
            InputError: somewhere the curve stands still or runs along `up`.
        """
        s = np.unique(np.concatenate([np.linspace(0.0, 1.0, LOOK), curve.breaks]))
        slope = curve.derivatives(s)[1]
        speed = np.linalg.norm(slope, axis=-1)
        across = np.linalg.norm(np.cross(up, slope), axis=-1)
        if (across <= 1e-6 * max(float(speed.max()), LEAST_DIVISOR)).any():
            raise InputError("trajectory.tangent", place=float(s[across.argmin()]), up=str(up))
        law = cls(curve, up, np.eye(3))
        return cls(curve, up, law.at(np.zeros(())).R.T @ R)

    @property
    def breaks(self) -> Floats:
        """Of the curve."""
        return self.curve.breaks

    def at(self, s: Floats) -> RotationMotion:
        """Rotation, rate and its derivative, from three derivatives of the curve."""
        _, p_1, p_2, p_3 = self.curve.derivatives(s)
        x = _unit((p_1, p_2, p_3))
        fixed = (np.broadcast_to(self.up, p_1.shape), np.zeros_like(p_1), np.zeros_like(p_1))
        y = _unit(_cross(fixed, x))
        z = _cross(x, y)
        F = of_matrices(*(np.stack(columns, axis=-1) for columns in zip(x, y, z, strict=True)))
        back = self.offset.T
        return RotationMotion(F.R @ self.offset, F.w @ back.T, F.a @ back.T)


Triple = tuple[Vector3, Vector3, Vector3]
"""A vector over s, and its two derivatives."""


def _cross(a: Triple, b: Triple) -> Triple:
    """a x b with derivatives."""
    return (
        np.cross(a[0], b[0]),
        np.cross(a[1], b[0]) + np.cross(a[0], b[1]),
        np.cross(a[2], b[0]) + 2 * np.cross(a[1], b[1]) + np.cross(a[0], b[2]),
    )


def _dot(u: Vector3, v: Vector3) -> Floats:
    """(*k, 1) scalar products of rows (*k, 3)."""
    return np.sum(u * v, axis=-1, keepdims=True)


def _unit(a: Triple) -> Triple:
    """a / |a| with derivatives."""
    n = np.sqrt(_dot(a[0], a[0]))
    n_1 = _dot(a[0], a[1]) / n
    n_2 = (_dot(a[1], a[1]) + _dot(a[0], a[2]) - n_1**2) / n
    u = a[0] / n
    u_1 = (a[1] - n_1 * u) / n
    return u, u_1, (a[2] - n_2 * u - 2 * n_1 * u_1) / n


def _trace(S: Floats) -> Floats:
    """tr(S) times the unit matrix."""
    return np.trace(S, axis1=-2, axis2=-1)[..., None, None] * np.eye(3)


def _twice_skew(A: Floats) -> Vector3:
    """The vector of A - A'."""
    return np.stack([A[..., 2, 1] - A[..., 1, 2], A[..., 0, 2] - A[..., 2, 0], A[..., 1, 0] - A[..., 0, 1]], axis=-1)


def nearest_rotation_vectors(R: RotationMatrix) -> Vector3:
    """(k, 3) rotation vectors of orientations, each the one of its 2 pi alternatives that is nearest the one before.

    Args:
        R: (k, 3, 3).
    """
    K = rotation.log(R)
    for i in range(1, len(K)):
        angle = float(np.linalg.norm(K[i]))
        before = K[i - 1]
        size = float(np.linalg.norm(before))
        if angle < ROUNDING:
            K[i] = before / size * 2 * np.pi * np.round(size / (2 * np.pi)) if size > 0.0 else K[i]
            continue
        axis = K[i] / angle
        K[i] = axis * (angle + 2 * np.pi * np.round((axis @ before - angle) / (2 * np.pi)))
    return K


def unwrapped_angles(R: RotationMatrix, sequence: str) -> Vector3:
    """(k, 3) Euler angles of orientations, each moved by whole turns as near as can be to the one before [rad]."""
    return np.unwrap(euler.to_euler(R, sequence), axis=0)
