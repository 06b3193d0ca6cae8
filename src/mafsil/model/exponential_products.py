"""Forward kinematics as products of exponentials with the home pose anywhere in the chain, and its inverse.

T = exp([S_1] q_1) ... exp([S_k] q_k) home exp([B_k+1] q_k+1) ... exp([B_n] q_n) for every k: k = n is the space form,
k = 0 the body form. T^-1 = exp(-[B_n] q_n) ... exp(-[B_1] q_1) home^-1.

Screws and home pose of an arm, read from its mechanism: its product-of-exponentials description.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, Vector6, as_batch, whole
from mafsil.errors import ModelError
from mafsil.model.exponentials import Screws, chain_to_tip
from mafsil.model.loading import RobotLike, as_mechanism, of_mechanism
from mafsil.model.mechanism import Mechanism
from mafsil.model.placement import adjoint, inverse, screw_motion


def mixed_product(robot: RobotLike, q: ArrayLike, k: int) -> PoseMatrix:
    """(4, 4) tip pose with the home pose after the k-th exponential; the same for every k.

    Args:
        robot: a chain of n joints.
        q: (n,) its coordinates [rad | m].
        k: 0 .. n exponentials in {s} stand before the home pose.

    Raises:
        InputError: not one finite number per joint, or no such k.
        ModelError: a joint of the chain mimics another.
    """
    axes, values = _given(robot, q)
    place = whole("k", k, 0, len(values))
    T = np.eye(4)
    for S, value in zip(axes.S_s[:place], values[:place], strict=True):
        T = T @ screw_motion(S, float(value))
    T = T @ axes.home
    for B, value in zip(axes.S_b[place:], values[place:], strict=True):
        T = T @ screw_motion(B, float(value))
    return T


def inverse_product(robot: RobotLike, q: ArrayLike) -> PoseMatrix:
    """(4, 4) pose T_ts of {s} seen from the tip, as a product: no matrix of a configuration is inverted.

    Args:
        robot: a chain of n joints.
        q: (n,) its coordinates [rad | m].
    """
    axes, values = _given(robot, q)
    T = np.eye(4)
    for B, value in zip(axes.S_b[::-1], values[::-1], strict=True):
        T = T @ screw_motion(B, -float(value))
    return T @ inverse(axes.home)


def _given(robot: RobotLike, q: ArrayLike) -> tuple[Screws, Floats]:
    axes = screws(as_mechanism(robot))
    return axes, as_batch("q", q, (len(axes.S_s),), finite=True)


@of_mechanism
def screws(mechanism: Mechanism) -> Screws:
    """Screw axes of the joints between base and tip, and the home pose.

    Args:
        mechanism: its chain to the tip may have fixed joints; branches beside the chain are left out. The order is
            that of the chain, which for an arm without branches is that of q.

    Raises:
        ModelError: a joint of the chain mimics another: its motion is no screw of its own.
    """
    T_sl = mechanism.T_sb
    columns: list[Vector6] = []
    for joint in chain_to_tip(mechanism):
        if joint.mimic is not None:
            raise ModelError("screws.mimic", joint=joint.name, leader=joint.mimic.leader)
        T_sl = T_sl @ joint.T_pj
        if joint.moves:
            columns.append(adjoint(T_sl) @ joint.screw)
    home = T_sl @ mechanism.T_lt
    S_s = np.reshape(columns, (-1, 6))
    return Screws(S_s, S_s @ adjoint(inverse(home)).T, home)
