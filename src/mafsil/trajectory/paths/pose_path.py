"""Paths of a frame: their protocol, a curve with an orientation law, and what of a path the frame has to keep to."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Literal, Protocol, get_args, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, Vector6, cross
from mafsil.errors import InputError
from mafsil.geometry import pose, rotation
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


PathTask = Literal["pose", "axis", "position"]
STRICTER: dict[PathTask, tuple[PathTask, ...]] = {"pose": (), "axis": ("pose",), "position": ("axis", "pose")}
"""What asks for more: a motion that keeps to it keeps to less, too."""


def require_task(task: str) -> None:
    """Refuse a task that is none.

    Raises:
        InputError: it is not one of PathTask.
    """
    if task not in get_args(PathTask):
        raise InputError("input.choice", name="task", value=task, known=", ".join(get_args(PathTask)))


def path_error(T: PoseMatrix, target: PoseMatrix, task: PathTask) -> Floats:
    """What is left of the way, as far as it counts.

    Args:
        T: (*batch, 4, 4) of the frame in {s}.
        target: (*batch, 4, 4) desired.
        task: `pose`: the body twist to the target; `axis`: the turn of z about x and y of the frame, and the way in
            {s}; `position`: the way in {s}.

    Returns:
        (*batch, m) rotations [rad], then distances [m].
    """
    if task == "pose":
        return pose.error(T, target)
    way = target[..., :3, 3] - T[..., :3, 3]
    if task == "position":
        return way
    z = np.einsum("...ji,...j->...i", T[..., :3, :3], target[..., :3, 2])
    across = np.stack([-z[..., 1], z[..., 0]], axis=-1)
    length = np.linalg.norm(across, axis=-1, keepdims=True)
    angle = np.arctan2(length, z[..., 2:])
    return np.concatenate([across * np.where(length > 1e-8, angle / np.maximum(length, 1e-8), 1.0), way], axis=-1)


def path_rates(
    T: PoseMatrix, J: Floats, J_rate: Floats, rate: Floats, path: TipPath, s: ArrayLike, task: PathTask
) -> tuple[Floats, Floats, Floats, Floats]:
    """The equations A q' = b of moving along a path, and their derivatives by s.

    Args:
        T: (*batch, 4, 4) of the frame in {s}; its turn is free where it does not count.
        J, J_rate: (*batch, 6, n) body Jacobian and its derivative.
        rate: (*batch, n) q'.
        path: of the frame.
        s: (*batch,) places on it.
        task: what counts.

    Returns:
        A (*batch, m, n), b (*batch, m), A' (*batch, m, n) and b' (*batch, m).
    """
    V, V_slope = path.twists(s)
    if task == "pose":
        return J, V, J_rate, V_slope
    R, R_path = T[..., :3, :3], path.poses(s)[..., :3, :3]
    A, b = _equations(R, J, R_path, V, task)
    turn = multiply_rows(J[..., :3, :], rate)
    # p' = R v and its derivative R (w x v + v'), in {s}; b moves with the frame of the path.
    A_rate = R @ (rotation.hat(turn) @ J[..., 3:, :] + J_rate[..., 3:, :])
    b_slope = multiply_rows(R_path, cross(V[..., :3], V[..., 3:]) + V_slope[..., 3:])
    if task == "position":
        return A, b, A_rate, b_slope
    # The turn of the path, seen in the frame: w_b = R' R_path w, w_b' = -turn x w_b + R' R_path w'.
    into = np.swapaxes(R, -1, -2) @ R_path
    slope = multiply_rows(into, V_slope[..., :3]) - cross(turn, multiply_rows(into, V[..., :3]))
    return (
        A,
        b,
        np.concatenate([J_rate[..., :2, :], A_rate], axis=-2),
        np.concatenate([slope[..., :2], b_slope], axis=-1),
    )


def path_equations(T: PoseMatrix, J: Floats, path: TipPath, s: ArrayLike, task: PathTask) -> tuple[Floats, Floats]:
    """The equations A q' = b of moving along a path: those of `path_rates` without derivatives.

    Args:
        T: (*batch, 4, 4) of the frame in {s}; its turn is free where it does not count.
        J: (*batch, 6, n) body Jacobian.
        path: of the frame.
        s: (*batch,) places on it.
        task: what counts.

    Returns:
        A (*batch, m, n) and b (*batch, m).
    """
    V = path.twists(s)[0]
    return (J, V) if task == "pose" else _equations(T[..., :3, :3], J, path.poses(s)[..., :3, :3], V, task)


def _equations(R: Floats, J: Floats, R_path: Floats, V: Floats, task: PathTask) -> tuple[Floats, Floats]:
    """Of position, or of position and one axis."""
    A, b = R @ J[..., 3:, :], multiply_rows(R_path, V[..., 3:])
    if task == "position":
        return A, b
    across = multiply_rows(np.swapaxes(R, -1, -2), multiply_rows(R_path, V[..., :3]))[..., :2]
    return np.concatenate([J[..., :2, :], A], axis=-2), np.concatenate([across, b], axis=-1)


def multiply_rows(A: Floats, x: Floats) -> Floats:
    """A x of matrices (*batch, m, n) and vectors (*batch, n)."""
    return (A @ x[..., None])[..., 0]
