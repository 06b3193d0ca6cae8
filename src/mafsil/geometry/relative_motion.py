"""Twists of frames that move relative to moving frames, and of the motion seen the other way round; any batch.

Vectors given in a frame that turns: their derivatives, and the accelerations of points from twists; any batch.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Vector3, Vector6, as_batch
from mafsil.geometry import pose, twist


def space(V_ab: ArrayLike, T_ab: ArrayLike, V_bc: ArrayLike) -> Vector6:
    """(*batch, 6) V_ac = V_ab + Ad(T_ab) V_bc: space twists, of T_ac = T_ab T_bc.

    Args:
        V_ab: (*batch, 6) twist of {b} relative to {a}, in {a}.
        T_ab: (*batch, 4, 4) where {b} is now.
        V_bc: (*batch, 6) twist of {c} relative to {b}, in {b}.
    """
    return as_batch("V_ab", V_ab, (6,)) + twist.transform(T_ab, V_bc)


def body(V_ab: ArrayLike, T_bc: ArrayLike, V_bc: ArrayLike) -> Vector6:
    """(*batch, 6) V_ac = Ad(T_cb) V_ab + V_bc: body twists, of T_ac = T_ab T_bc.

    Args:
        V_ab: (*batch, 6) twist of {b} relative to {a}, in {b}.
        T_bc: (*batch, 4, 4) where {c} is now.
        V_bc: (*batch, 6) twist of {c} relative to {b}, in {c}.
    """
    return twist.transform(pose.inverse(T_bc), V_ab) + as_batch("V_bc", V_bc, (6,))


def exchange_bodies(V_space: ArrayLike, V_body: ArrayLike) -> tuple[Vector6, Vector6]:
    """Space and body twist of T_ba from those of T_ab: the two bodies change places, and so do the twists.

    Args:
        V_space, V_body: (*batch, 6) of {b} relative to {a}, in {a} and in {b}.

    Returns:
        (*batch, 6) in {b}: -V_body; (*batch, 6) in {a}: -V_space.
    """
    return np.negative(as_batch("V_body", V_body, (6,))), np.negative(as_batch("V_space", V_space, (6,)))


def vector_rate(omega: ArrayLike, x: ArrayLike, dx: ArrayLike | None = None) -> Vector3:
    """(*batch, 3) = dx + omega x x: the derivative of a vector, in the axes of the rotating frame {b}.

    Of the unit vectors of {b} themselves it is omega x e_i. In the axes of {s} the same vector is R_sb times this.

    Args:
        omega: (*batch, 3) angular velocity of {b}, in {b} [rad/s].
        x: (*batch, 3) components of the vector in {b}, of any unit.
        dx: (*batch, 3) their time derivatives; None for a vector fixed in {b}.

    Reference: Lynch & Park, Modern Robotics, eq. 8.21; the transport theorem.
    """
    w, own = as_batch("omega", omega, (3,)), as_batch("x", x, (3,))
    turned = np.cross(w, own)
    return turned if dx is None else as_batch("dx", dx, (3,)) + turned


def point_acceleration(V: ArrayLike, dV: ArrayLike, point: ArrayLike = (0.0, 0.0, 0.0)) -> Vector3:
    """(*batch, 3) acceleration [m/s^2] of a point of a body, in the axes of its frame {b}.

    dv + omega x v at the origin: the derivative of a twist's components is not yet the acceleration of a point.

    Args:
        V, dV: (*batch, 6) body twist (omega, v) and the derivative of its components, in {b}.
        point: (*batch, 3) fixed in {b} [m]; its origin by default.

    Reference: Lynch & Park, Modern Robotics, sec. 8.2.1.
    """
    twist, rate, r = as_batch("V", V, (6,)), as_batch("dV", dV, (6,)), as_batch("point", point, (3,))
    omega, alpha = twist[..., :3], rate[..., :3]
    return rate[..., 3:] + np.cross(alpha, r) + np.cross(omega, twist[..., 3:] + np.cross(omega, r))
