"""Velocity efforts in two parts: what each joint's own rate asks for, and what two rates ask for together."""

from __future__ import annotations

from dataclasses import replace

import mafsil.expression as ex
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.inverse_dynamics import inverse_dynamics, velocity_torque
from mafsil.mechanics.placement import Expression


def centrifugal_torque(tree: BodyTree, q: Expression, qd: Expression) -> Expression:
    """(n,) [N m | N]: sum of Gamma_ijj qd_j^2, the velocity efforts of each rate alone, added up.

    Args:
        tree: the bodies.
        q, qd: (n,) coordinates [rad | m] and rates.

    Reference: Lynch & Park, Modern Robotics, sec. 8.1.1.
    """
    weightless, still = replace(tree, gravity=0.0 * tree.gravity), ex.zeros(tree.n, 1)
    total = ex.zeros(tree.n, 1)
    for j in range(tree.n):
        alone = ex.zeros(tree.n, 1)
        alone[j] = qd[j]
        total = total + inverse_dynamics(weightless, q, alone, still)
    return total


def coriolis_torque(tree: BodyTree, q: Expression, qd: Expression) -> Expression:
    """(n,) [N m | N]: sum over j < k of 2 Gamma_ijk qd_j qd_k, the rest of the velocity efforts.

    Args:
        tree: the bodies.
        q, qd: (n,) coordinates [rad | m] and rates.

    Reference: Lynch & Park, Modern Robotics, sec. 8.1.1.
    """
    return velocity_torque(tree, q, qd) - centrifugal_torque(tree, q, qd)
