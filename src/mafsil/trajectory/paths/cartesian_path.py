"""Paths of a frame in space: the straight line, turning about one axis, and the screw motion."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, Vector6, as_batch, cross, require_finite
from mafsil.errors import InputError
from mafsil.geometry import pose, rotation

Interpolation = Literal["straight", "screw"]


@dataclass(frozen=True, eq=False)
class CartesianPath:
    """From one pose to another, over the parameter s in 0 .. 1.

    straight: p = p_0 + s (p_1 - p_0), R = R_0 exp(s log(R_0' R_1));  screw: T = T_0 exp(s log(T_0^-1 T_1))

    Attributes:
        T_start, T_goal: (4, 4) in {s}.
        interpolation: `straight` moves the origin on a line; `screw` moves the frame about one screw axis.

    Raises:
        InputError: a wrong shape, a number that is not finite, an unknown interpolation.

    Reference: Lynch and Park, Modern Robotics, sec. 9.2.1.
    """

    T_start: PoseMatrix
    T_goal: PoseMatrix
    interpolation: Interpolation = "straight"

    def __post_init__(self) -> None:
        for name in ("T_start", "T_goal"):
            object.__setattr__(self, name, require_finite(name, as_batch(name, getattr(self, name), (4, 4))))
        if self.interpolation not in ("straight", "screw"):
            raise InputError("input.choice", name="interpolation", value=self.interpolation, known="straight, screw")

    @property
    def length(self) -> float:
        """Length of the way of the origin [m]: of a straight one the distance, of a screw the arc about its axis."""
        return float(np.linalg.norm(self._screw[3:] if self.interpolation == "screw" else self._chord))

    @property
    def angle(self) -> float:
        """Angle between the orientations [rad]."""
        return float(np.linalg.norm(self._turn))

    @property
    def breaks(self) -> Floats:
        """0 and 1: it is smooth throughout."""
        return np.array([0.0, 1.0])

    @property
    def corners(self) -> Floats:
        """None."""
        return np.zeros(0)

    def poses(self, s: ArrayLike) -> PoseMatrix:
        """(*s, 4, 4) in {s}."""
        along = np.asarray(s, dtype=np.float64)[..., None]
        if self.interpolation == "screw":
            return self.T_start @ pose.exp(along * self._screw)
        T = np.zeros((*along.shape[:-1], 4, 4))
        T[..., :3, :3] = self.T_start[:3, :3] @ rotation.exp(along * self._turn)
        T[..., :3, 3] = self.T_start[:3, 3] + along * self._chord
        T[..., 3, 3] = 1.0
        return T

    def twists(self, s: ArrayLike) -> tuple[Vector6, Vector6]:
        """Body twist by the path parameter, and its derivative: (*s, 6) each.

        straight: V = (w, R' d), dV/ds = (0, -w x R' d);  screw: V constant.
        """
        T = self.poses(s)
        V, slope = np.zeros((*T.shape[:-2], 6)), np.zeros((*T.shape[:-2], 6))
        if self.interpolation == "screw":
            V[...] = self._screw
            return V, slope
        V[..., :3] = self._turn
        V[..., 3:] = self._chord @ T[..., :3, :3]
        slope[..., 3:] = -cross(V[..., :3], V[..., 3:])
        return V, slope

    @cached_property
    def _chord(self) -> Floats:
        return self.T_goal[:3, 3] - self.T_start[:3, 3]

    @cached_property
    def _turn(self) -> Floats:
        return rotation.log(self.T_start[:3, :3].T @ self.T_goal[:3, :3])

    @cached_property
    def _screw(self) -> Floats:
        return pose.error(self.T_start, self.T_goal)
