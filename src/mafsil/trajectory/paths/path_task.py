"""What of a path a frame has to keep to: its whole pose, its position and one axis, or its position alone."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, cross
from mafsil.errors import InputError
from mafsil.geometry import pose, rotation
from mafsil.trajectory.paths import TipPath

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
