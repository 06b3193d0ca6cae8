"""The Coriolis matrix with the Christoffel symbols of the mass matrix."""

from __future__ import annotations

import casadi as ca

from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.inverse_dynamics import velocity_torque
from mafsil.mechanics.placement import Expression


def coriolis_matrix(tree: BodyTree, q: Expression, qd: Expression) -> Expression:
    """C(q, qd) (n, n) with C qd = c(q, qd) and dM/dt - 2 C skew.

    c_i = sum of Gamma_ijk qd_j qd_k is quadratic in the rates and Gamma symmetric in j, k, so half its derivative by
    the rates is the matrix of the Christoffel symbols, C_ij = sum of Gamma_ijk qd_k.

    Args:
        tree: the bodies.
        q: (n,) joint coordinates [rad | m].
        qd: (n,) rates, symbols (the derivative is taken by them).

    Reference: Lynch & Park, Modern Robotics, sec. 8.1.3 and prop. 8.1.
    """
    return ca.densify(ca.jacobian(velocity_torque(tree, q, qd), qd)) / 2
