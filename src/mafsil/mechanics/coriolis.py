"""The Coriolis matrix with the Christoffel symbols of the mass matrix, without differentiation."""

from __future__ import annotations

import mafsil.expression as ex
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.derivatives import matrices
from mafsil.mechanics.placement import Expression


def coriolis_matrix(tree: BodyTree, q: Expression, qd: Expression) -> Expression:
    """C(q, qd) (n, n) with C qd = c(q, qd) and dM/dt - 2 C skew.

    c_i = sum of Gamma_ijk qd_j qd_k is quadratic in the rates and Gamma symmetric in j, k, so half its derivative by
    the rates, which is its derivative at half the rates, is the matrix of the Christoffel symbols,
    C_ij = sum of Gamma_ijk qd_k.

    Args:
        tree: the bodies.
        q, qd: (n,) joint coordinates [rad | m] and rates.

    Reference: Lynch & Park, Modern Robotics, sec. 8.1.3 and prop. 8.1; Singh, Wensing & Echeandia 2022.
    """
    return matrices(tree, q, qd / 2, ex.zeros(tree.n, 1))[1]


def christoffel_symbols(tree: BodyTree, q: Expression) -> Expression:
    """Gamma (n n, n), first kind: row i n + j, column k holds Gamma_ijk, with c_i = sum of Gamma_ijk qd_j qd_k.

    C is linear in the rates, so Gamma_ijk is C_ij of a unit rate of joint k.

    Args:
        tree: the bodies.
        q: (n,) joint coordinates [rad | m].

    Reference: Lynch & Park, Modern Robotics, eq. 8.12.
    """
    unit = ex.eye(tree.n)
    columns = [ex.vec(coriolis_matrix(tree, q, unit[:, k]).T) for k in range(tree.n)]
    return ex.horzcat(*columns) if columns else ex.zeros(0, 0)
