"""Newton's method on solutions that are nearly right, whole turns near others and into limits, and verification."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil import threads
from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import pose
from mafsil.ik.tolerances import (
    EXACT_POSE,
    LEAST_DAMPING,
    NO_COST,
    NO_STEP,
    ON_LIMIT,
    REFINED_DAMPING,
    SAME,
    WHOLE_TURN,
)
from mafsil.lazy_module import lazily
from mafsil.robot import Robot

if TYPE_CHECKING:
    import mafsil.ik.refine_loops as refine_loops
else:
    refine_loops = lazily("mafsil.ik.refine_loops")


TURN = 2 * np.pi
PART = 64
"""Rows that one thread refines at a time."""


def pose_errors(robot: Robot, q: JointVector, T_sd: PoseMatrix, mask: NDArray[np.bool_]) -> Floats:
    """(k, 6) twists from the reached to the requested pose, in the reached frame, zero in components that do not count.

    Args:
        robot: any arm; its tip is asked for.
        q: (k, n) coordinates.
        T_sd: (4, 4) requested pose, or (k, 4, 4).
        mask: (6) components that count.
    """
    T = robot.forward_kinematics(q) if len(q) else np.zeros((0, 4, 4))
    return task_error(T, np.broadcast_to(T_sd, T.shape), mask)


def task_error(T: PoseMatrix, T_sd: PoseMatrix, mask: NDArray[np.bool_]) -> Floats:
    """(k, 6) the part of the error that a task asks for, rotation vector and displacement in the reached frame.

    Args:
        T: (k, 4, 4) reached poses.
        T_sd: (k, 4, 4) requested poses.
        mask: (6) components that count.
    """
    error = np.zeros((len(T), 6))
    error[:, 3:] = ((T_sd - T)[:, :3, 3][:, None, :] @ T[:, :3, :3])[:, 0]
    if mask[:3].all():
        error[:, :3] = pose.error(T, T_sd)[:, :3]
    elif mask[:3].any():
        # Only the direction of the tip's z axis counts: the shortest turn that brings it there.
        z = (T_sd[:, None, :3, 2] @ T[:, :3, :3])[:, 0]
        axis = np.stack([-z[:, 1], z[:, 0], np.zeros(len(z))], axis=1)
        sine = np.linalg.norm(axis, axis=1)
        angle = np.arctan2(sine, z[:, 2])
        error[:, :3] = axis * np.where(sine > EXACT_POSE, angle / np.maximum(sine, LEAST_DIVISOR), 1.0)[:, None]
        error[:, 0] += np.where((sine <= EXACT_POSE) & (z[:, 2] < 0), np.pi, 0.0)
    error[:, 3:] *= mask[3:]
    return error


def residuals(error: Floats) -> Floats:
    """(k,) the larger of angle [rad] and distance [m]."""
    return np.maximum(np.linalg.norm(error[:, :3], axis=1), np.linalg.norm(error[:, 3:], axis=1))


def refine_rows(
    robot: Robot,
    q: JointVector,
    T_sd: PoseMatrix,
    mask: NDArray[np.bool_],
    *,
    steps: int = 8,
    locked: tuple[int, ...] | NDArray[np.bool_] = (),
) -> tuple[JointVector, Floats]:
    """Newton steps of least norm that never make the error larger, of rows of one pose or of many; see `refine_loops`.

    Args:
        robot: whose joints are sought; its tip is asked for.
        q: (k, n) starts.
        T_sd: (4, 4) requested pose, or (k, 4, 4) one of each row.
        mask: (6) components of the error that count.
        steps: most steps.
        locked: coordinates that stay, of all rows, or (k, n) which stay of each.

    Returns:
        (k, n) and (k,) residuals.
    """
    if not q.size:
        return q.copy(), residuals(pose_errors(robot, q, T_sd, mask))
    given = ~locked if isinstance(locked, np.ndarray) else np.array([i not in locked for i in range(robot.n)])
    moving = np.ascontiguousarray(np.broadcast_to(given, q.shape))
    goals = np.broadcast_to(T_sd, (len(q), 4, 4)).reshape(-1, 16)
    refined, size, counting = np.array(q, order="C"), np.empty(len(q)), mask.astype(np.float64)
    # Held here while the loop has their addresses.
    poses, jacobians = robot.kernel("forward_kinematics"), robot.kernel("jacobian_body")
    entries = poses.addresses.few, jacobians.addresses.few

    def part(k: int) -> None:
        of = slice(k * PART, (k + 1) * PART)
        refine_loops.refine(*entries, refined[of], goals[of], counting, moving[of], steps, size[of])

    threads.run(part, -(-len(q) // PART), threads.available())
    return refined, size


def least_squares(
    robot: Robot, q: JointVector, T_sd: PoseMatrix, mask: NDArray[np.bool_], *, steps: int = 60
) -> tuple[JointVector, Floats]:
    """The nearest configurations in the sense of least squares, turns [rad] and distances [m] weighed alike.

    Damped Gauss-Newton steps (Levenberg, 1944) from every start: the poses need not be the arm's own.

    Args:
        robot: whose joints are sought; its tip is asked for.
        q: (k, n) starts.
        T_sd: (4, 4) requested pose, or (k, 4, 4) one of each row.
        mask: (6) components of the error that count.
        steps: most steps.

    Returns:
        (k, n) and (k,) residuals, the larger of angle and distance.
    """
    T_sd = np.broadcast_to(T_sd, (len(q), 4, 4))
    q, error, unit = q.copy(), pose_errors(robot, q, T_sd, mask), np.eye(robot.n)
    cost, damping = (error**2).sum(axis=1), np.full(len(q), REFINED_DAMPING)
    moving = np.arange(len(q))
    for _ in range(steps):
        if not len(moving):
            break
        J = robot.jacobian_body(q[moving]) * mask[:, None]
        normal = J.transpose(0, 2, 1) @ J
        scale = np.maximum(np.trace(normal, axis1=1, axis2=2), LEAST_DIVISOR)
        normal = normal + (damping[moving] * scale)[:, None, None] * unit
        downhill = J.transpose(0, 2, 1) @ error[moving, :, None]
        step = np.asarray(np.linalg.solve(normal, downhill)[:, :, 0], dtype=np.float64)
        length = np.abs(step).max(axis=1, keepdims=True)
        trial = q[moving] + step * np.minimum(1.0, 0.5 / np.maximum(length, LEAST_DIVISOR))
        trial_error = pose_errors(robot, trial, T_sd[moving], mask)
        trial_cost = (trial_error**2).sum(axis=1)
        better = trial_cost < cost[moving]
        rows = moving[better]
        q[rows], error[rows], cost[rows] = trial[better], trial_error[better], trial_cost[better]
        damping[moving] = np.where(better, np.maximum(damping[moving] / 16, LEAST_DAMPING), damping[moving] * 16)
        # Steps that small, and damping that large, change nothing that is seen.
        moving = moving[(np.abs(step).max(axis=1) > NO_STEP) & (damping[moving] < 1e4) & (cost[moving] > NO_COST)]
    return q, residuals(error)


def distinct(q: JointVector, revolute: NDArray[np.bool_], tolerance: float = SAME) -> list[int]:
    """Indices of the first of each group of rows that are equal up to whole turns.

    Args:
        q: (k, n) coordinates.
        revolute: (n) which of them are angles.
        tolerance: difference that still counts as equal [rad | m].
    """
    kept: list[int] = []
    for i in range(len(q)):
        d: Floats = q[kept] - q[i]
        d = np.where(revolute, (d + np.pi) % (2 * np.pi) - np.pi, d)
        if not len(kept) or np.abs(d).max(axis=1).min() > tolerance:
            kept.append(i)
    return kept


def wound_near(
    q: JointVector, q0: JointVector, lower: Floats, upper: Floats, revolute: NDArray[np.bool_]
) -> JointVector:
    """Revolute joints moved by whole turns as near to `q0` as possible, into the limits where that can be done.

    Args:
        q, q0: (*batch, n) coordinates.
        lower, upper: (n,) limits.
        revolute: (n) which coordinates are angles.
    """
    moved = q - np.where(revolute, TURN * np.round((q - q0) / TURN), 0.0)
    up = np.where(revolute & (moved < lower), np.ceil((lower - moved) / TURN - WHOLE_TURN), 0.0)
    down = np.where(revolute & (moved > upper), np.ceil((moved - upper) / TURN - WHOLE_TURN), 0.0)
    shifted = moved + TURN * (up - down)
    return np.where((shifted >= lower - ON_LIMIT) & (shifted <= upper + ON_LIMIT), shifted, moved)
