"""Twists of frames that move relative to moving frames, and of the motion seen the other way round; any batch."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Vector6, as_batch
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


def exchanged(V_space: ArrayLike, V_body: ArrayLike) -> tuple[Vector6, Vector6]:
    """Space and body twist of T_ba from those of T_ab: the two bodies change places, and so do the twists.

    Args:
        V_space, V_body: (*batch, 6) of {b} relative to {a}, in {a} and in {b}.

    Returns:
        (*batch, 6) in {b}: -V_body; (*batch, 6) in {a}: -V_space.
    """
    return np.negative(as_batch("V_body", V_body, (6,))), np.negative(as_batch("V_space", V_space, (6,)))
