"""Accelerations of a moving frame: rates of twists from a pose and its two derivatives, and of body points; any batch.

dV_s = vee(Tddot T^-1 - [V_s]^2), dV_b = vee(T^-1 Tddot - [V_b]^2), dV_s = Ad(T) dV_b. Like V_s, dV_s is no acceleration
of one body point; `of_point` gives those.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Matrix4, Vector3, Vector6, as_batch
from mafsil.geometry import pose, twist


def space_from_pose_rates(T: ArrayLike, Tdot: ArrayLike, Tddot: ArrayLike) -> Vector6:
    """(*batch, 6) dV_s/dt (alpha_s, dv_s) [rad/s^2, m/s^2].

    Args:
        T: (*batch, 4, 4) pose T_sb.
        Tdot: (*batch, 4, 4) its derivative [1/s, m/s].
        Tddot: (*batch, 4, 4) its second derivative; last rows are not read.

    Raises:
        InputError: Tdot is no velocity of T.
    """
    V_s = twist.space_from_pose_rate(T, Tdot)
    W = pose.hat(V_s)
    return pose.vee(_without_last_row(Tddot) @ pose.inverse(T) - W @ W)


def body_from_pose_rates(T: ArrayLike, Tdot: ArrayLike, Tddot: ArrayLike) -> Vector6:
    """(*batch, 6) dV_b/dt (alpha_b, dv_b), alpha_b = R' alpha_s; arguments as `space_from_pose_rates`."""
    V_b = twist.body_from_pose_rate(T, Tdot)
    W = pose.hat(V_b)
    return pose.vee(pose.inverse(T) @ _without_last_row(Tddot) - W @ W)


def pose_second_rate(T: ArrayLike, V_b: ArrayLike, dV_b: ArrayLike) -> Matrix4:
    """(*batch, 4, 4) Tddot = T ([dV_b] + [V_b]^2).

    Args:
        T: (*batch, 4, 4).
        V_b: (*batch, 6) body twist.
        dV_b: (*batch, 6) its derivative.
    """
    W = pose.hat(V_b)
    return np.asarray(T, dtype=np.float64) @ (pose.hat(dV_b) + W @ W)


def of_point(V: ArrayLike, dV: ArrayLike, point: ArrayLike) -> Vector3:
    """Acceleration of the body point that is at a place now: alpha x x + dv + omega x (omega x x + v).

    Args:
        V: (*batch, 6) twist in a frame.
        dV: (*batch, 6) its derivative in the same frame.
        point: (*batch, 3) coordinates of the body point there [m].

    Returns:
        (*batch, 3) [m/s^2], in the axes of the frame. For the origin of {b} in its own axes (V_b, dV_b, zero) this
        is dv_b + omega_b x v_b, not dv_b.
    """
    V, dV, x = as_batch("V", V, (6,)), as_batch("dV", dV, (6,)), as_batch("point", point, (3,))
    omega = V[..., :3]
    velocity = np.cross(omega, x) + V[..., 3:]
    return np.cross(dV[..., :3], x) + dV[..., 3:] + np.cross(omega, velocity)


def _without_last_row(Tddot: ArrayLike) -> Floats:
    matrix = np.array(as_batch("Tddot", Tddot, (4, 4)))
    matrix[..., 3, :] = 0.0
    return matrix
