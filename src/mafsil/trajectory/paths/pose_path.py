"""The protocol of paths of a frame, and the path that is made of a curve of its origin and an orientation law."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, Vector6, cross
from mafsil.trajectory.paths.orientations import OrientationLaw
from mafsil.trajectory.paths.positions import PositionCurve
from mafsil.trajectory.paths.rotation_curves import rotate_rows
from mafsil.trajectory.splines.piecewise import NODES, WEIGHTS
from mafsil.trajectory.tolerances import FEW_ROUNDINGS, GIVEN


@runtime_checkable
class TipPath(Protocol):
    """A frame that moves over s in 0 .. 1: geometry without time."""

    @property
    def length(self) -> float:
        """Length of the way of its origin [m]."""
        ...

    @property
    def angle(self) -> float:
        """By how much it turns on the way [rad]."""
        ...

    @property
    def breaks(self) -> Floats:
        """(k + 1,) places between which it is smooth, 0 and 1 included."""
        ...

    @property
    def corners(self) -> Floats:
        """(k,) breaks at which the twist jumps: there it can be passed only at rest."""
        ...

    def poses(self, s: ArrayLike) -> PoseMatrix:
        """(*s, 4, 4) in {s}."""
        ...

    def twists(self, s: ArrayLike) -> tuple[Vector6, Vector6]:
        """Body twist by s, and its derivative: (*s, 6) each."""
        ...


@dataclass(frozen=True, eq=False)
class PosePath:
    """The origin on a curve, the axes by an orientation law.

    T = (R(s), p(s)),  V = (w, R' p_1),  dV/ds = (a, R' p_2 - w x R' p_1)

    Attributes:
        position: curve of the origin.
        orientation: law of the axes.
    """

    position: PositionCurve
    orientation: OrientationLaw

    @property
    def length(self) -> float:
        """Length of the way of the origin [m]."""
        return self.position.length

    @property
    def angle(self) -> float:
        """Integral of the turning rate [rad]."""
        return self._angle

    @cached_property
    def _angle(self) -> float:
        return float(sum(turned_angle(self, a, b) for a, b in pairwise(self.breaks)))

    @property
    def breaks(self) -> Floats:
        """Those of the curve and of the law."""
        return self._breaks

    @cached_property
    def _breaks(self) -> Floats:
        return merge_breaks(self.position.breaks, self.orientation.breaks)

    @property
    def corners(self) -> Floats:
        """Breaks where the twist jumps."""
        return self._corners

    @cached_property
    def _corners(self) -> Floats:
        return jumps(self)

    def poses(self, s: ArrayLike) -> PoseMatrix:
        """(*s, 4, 4) in {s}."""
        along = np.asarray(s, dtype=np.float64)
        T = np.zeros((*along.shape, 4, 4))
        T[..., :3, :3] = self.orientation.at(along).R
        T[..., :3, 3] = self.position.derivatives(along)[0]
        T[..., 3, 3] = 1.0
        return T

    def twists(self, s: ArrayLike) -> tuple[Vector6, Vector6]:
        """Body twist by the path parameter, and its derivative: (*s, 6) each."""
        along = np.asarray(s, dtype=np.float64)
        R, w, a = self.orientation.at(along)
        _, p_1, p_2, _ = self.position.derivatives(along)
        back = np.swapaxes(R, -1, -2)
        v = rotate_rows(back, p_1)
        return np.concatenate([w, v], axis=-1), np.concatenate([a, rotate_rows(back, p_2) - cross(w, v)], axis=-1)


def merge_breaks(*breaks: Floats) -> Floats:
    """Increasing places of several lists, each of them once."""
    places = np.unique(np.concatenate(breaks))
    apart = np.concatenate([[True], np.diff(places) > FEW_ROUNDINGS])
    places = places[apart]
    places[-1] = 1.0
    return places


def jumps(path: TipPath, tolerance: float = GIVEN) -> Floats:
    """(k,) inner breaks at which the twist jumps by more than a share of its size.

    Args:
        path: any.
        tolerance: of the jump, relative to the largest twist at the breaks.
    """
    inner = path.breaks[1:-1]
    if not len(inner):
        return inner
    before, after = path.twists(np.nextafter(inner, 0.0))[0], path.twists(np.nextafter(inner, 1.0))[0]
    gap = np.abs(after - before).max(axis=-1)
    return inner[gap > tolerance * max(1e-12, float(np.abs(before).max()), float(np.abs(after).max()))]


def turned_angle(path: TipPath, a: float, b: float) -> float:
    """Integral of the angular rate over a smooth stretch, by Gauss and Legendre [rad].

    Args:
        path: of a frame.
        a, b: ends of the stretch, with no break of the path between them.
    """
    w = path.twists(a + (b - a) * (NODES + 1.0) / 2)[0][:, :3]
    return float((np.linalg.norm(w, axis=-1) * WEIGHTS).sum() * (b - a) / 2)
