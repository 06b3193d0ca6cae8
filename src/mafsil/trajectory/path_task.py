"""What of a path a frame has to keep to: its whole pose, its position and one axis, or its position alone."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix
from mafsil.geometry import pose
from mafsil.trajectory.paths import TipPath

PathTask = Literal["pose", "axis", "position"]


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
    T: PoseMatrix, J: Floats, J_rate: Floats, rate: Floats, path: TipPath, s: float, task: PathTask
) -> tuple[Floats, Floats, Floats, Floats]:
    """The equations A q' = b of moving along a path, and their derivatives by s.

    Args:
        T: (4, 4) of the frame in {s}; its turn is free where it does not count.
        J, J_rate: (6, n) body Jacobian and its derivative.
        rate: (n,) q'.
        path: of the frame.
        s: place on it.
        task: what counts.

    Returns:
        A (m, n), b (m,), A' (m, n) and b' (m,).
    """
    V, V_slope = path.twists(s)
    if task == "pose":
        return J, V, J_rate, V_slope
    R, R_path = T[:3, :3], path.poses(s)[:3, :3]
    turn = J[:3] @ rate
    # p' = R v and its derivative R (w x v + v'), in {s}; b moves with the frame of the path.
    A, A_rate = R @ J[3:], R @ (np.cross(turn, J[3:], axisb=0, axisc=0) + J_rate[3:])
    b, b_slope = R_path @ V[3:], R_path @ (np.cross(V[:3], V[3:]) + V_slope[3:])
    if task == "position":
        return A, b, A_rate, b_slope
    # The turn of the path, seen in the frame: w_b = R' R_path w, w_b' = -turn x w_b + R' R_path w'.
    across = R.T @ (R_path @ V[:3])
    slope = R.T @ (R_path @ V_slope[:3]) - np.cross(turn, across)
    return (
        np.concatenate([J[:2], A]),
        np.concatenate([across[:2], b]),
        np.concatenate([J_rate[:2], A_rate]),
        np.concatenate([slope[:2], b_slope]),
    )


def path_equations(T: PoseMatrix, J: Floats, path: TipPath, s: ArrayLike, task: PathTask) -> tuple[Floats, Floats]:
    """The equations A q' = b of moving along a path, at many places: those of `path_rates` without derivatives.

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
    if task == "pose":
        return J, V
    R, R_path = T[..., :3, :3], path.poses(s)[..., :3, :3]
    A, b = R @ J[..., 3:, :], (R_path @ V[..., 3:, None])[..., 0]
    if task == "position":
        return A, b
    across = (np.swapaxes(R, -1, -2) @ (R_path @ V[..., :3, None]))[..., :2, 0]
    return np.concatenate([J[..., :2, :], A], axis=-2), np.concatenate([across, b], axis=-1)
