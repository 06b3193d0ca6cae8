"""A path of the tip with the tool turned about its axis, from a moved base, or a part of it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, RotationMatrix, Vector3, Vector6
from mafsil.geometry import rotation
from mafsil.trajectory.paths import TipPath
from mafsil.trajectory.paths.pose_path import turned_angle


@dataclass(frozen=True, eq=False)
class TurnedToolPath:
    """T(s) R_z(angle): the same way of the tool's axis, everything about it turned.

    Attributes:
        path: of the tip.
        tool_turn: about its z axis [rad].
    """

    path: TipPath
    tool_turn: float

    @property
    def length(self) -> float:
        """Length of the way of the origin [m]."""
        return self.path.length

    @property
    def angle(self) -> float:
        """By how much the frame turns on the way [rad]."""
        return self.path.angle

    @property
    def breaks(self) -> Floats:
        """Those of the path."""
        return self.path.breaks

    @property
    def corners(self) -> Floats:
        """Those of the path."""
        return self.path.corners

    @property
    def _turn(self) -> RotationMatrix:
        return rotation.rot_z(self.tool_turn)

    def poses(self, s: ArrayLike) -> PoseMatrix:
        """(*s, 4, 4) in {s}."""
        T = self.path.poses(s).copy()
        T[..., :3, :3] = T[..., :3, :3] @ self._turn
        return T

    def twists(self, s: ArrayLike) -> tuple[Vector6, Vector6]:
        """Body twist by s, and its derivative: (*s, 6) each, seen in the turned frame."""
        V, slope = self.path.twists(s)
        return self._seen(V), self._seen(slope)

    def _seen(self, V: Vector6) -> Vector6:
        return np.concatenate([V[..., :3] @ self._turn, V[..., 3:] @ self._turn], axis=-1)


@dataclass(frozen=True, eq=False)
class MovedBasePath:
    """The path as a base sees it that was moved by `shift`: its origin at p - shift.

    Attributes:
        path: of the tip, in {s} of the base where it was.
        shift: (3,) of the base [m].
    """

    path: TipPath
    shift: Vector3

    @property
    def length(self) -> float:
        """Length of the way of the origin [m]."""
        return self.path.length

    @property
    def angle(self) -> float:
        """By how much the frame turns on the way [rad]."""
        return self.path.angle

    @property
    def breaks(self) -> Floats:
        """Those of the path."""
        return self.path.breaks

    @property
    def corners(self) -> Floats:
        """Those of the path."""
        return self.path.corners

    def poses(self, s: ArrayLike) -> PoseMatrix:
        """(*s, 4, 4) in {s} of the moved base."""
        T = self.path.poses(s).copy()
        T[..., :3, 3] -= self.shift
        return T

    def twists(self, s: ArrayLike) -> tuple[Vector6, Vector6]:
        """Body twist by s, and its derivative: (*s, 6) each, those of the path."""
        return self.path.twists(s)


@dataclass(frozen=True, eq=False)
class PathPart:
    """The part of a path between two places, over s in 0 .. 1 again.

    Attributes:
        path: of the tip.
        begin, end: of its s, begin < end.
    """

    path: TipPath
    begin: float
    end: float

    @property
    def length(self) -> float:
        """Length of the way of the origin [m]: that of a fine chain of chords."""
        p = self.path.poses(np.linspace(self.begin, self.end, 1001))[:, :3, 3]
        return float(np.linalg.norm(np.diff(p, axis=0), axis=1).sum())

    @property
    def angle(self) -> float:
        """By how much the frame turns on the way [rad]."""
        ends = self.begin + (self.end - self.begin) * self.breaks
        return float(sum(turned_angle(self.path, a, b) for a, b in pairwise(ends.tolist())))

    @property
    def breaks(self) -> Floats:
        """0, the breaks of the path within the part, and 1."""
        inner = self._inside(self.path.breaks)
        return np.concatenate([[0.0], inner, [1.0]])

    @property
    def corners(self) -> Floats:
        """Corners of the path within the part."""
        return self._inside(self.path.corners)

    def _inside(self, places: Floats) -> Floats:
        share = (places - self.begin) / (self.end - self.begin)
        return share[(share > 1e-12) & (share < 1.0 - 1e-12)]

    def _along(self, s: ArrayLike) -> Floats:
        return self.begin + (self.end - self.begin) * np.asarray(s, dtype=np.float64)

    def poses(self, s: ArrayLike) -> PoseMatrix:
        """(*s, 4, 4) in {s}."""
        return self.path.poses(self._along(s))

    def twists(self, s: ArrayLike) -> tuple[Vector6, Vector6]:
        """Body twist by s, and its derivative: (*s, 6) each."""
        V, slope = self.path.twists(self._along(s))
        share = self.end - self.begin
        return V * share, slope * share**2
