"""The Coriolis matrix with the Christoffel symbols of the mass matrix, without differentiation."""

from __future__ import annotations

import numpy as np

import mafsil.expression as ex
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.placement import Expression
from mafsil.mechanics.quantities.dynamics_derivatives import matrices
from mafsil.mechanics.quantity import LYNCH, Quantity, SecondMethod


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


CORIOLIS_MATRIX = Quantity(
    name="coriolis_matrix",
    symbol="C",
    title="Coriolis matrix of the Christoffel symbols: C qd = c, dM/dt - 2 C skew.",
    builder=coriolis_matrix,
    inputs=("q", "qd"),
    shape=("n", "n"),
    unit="N m s | N s",
    reference=LYNCH + "sec. 8.1.3, prop. 8.1",
    size=lambda arm: arm.inertia / arm.units,
    second=SecondMethod(
        "verification.christoffel", lambda book, s: np.einsum("bijk,bk->bij", book.christoffel_symbols(s.q), s.qd)
    ),
    needs_mass=True,
)

CHRISTOFFEL_SYMBOLS = Quantity(
    name="christoffel_symbols",
    symbol="Gamma",
    title="Christoffel symbols of the first kind: c_i = sum of Gamma_ijk qd_j qd_k.",
    builder=christoffel_symbols,
    inputs=("q",),
    shape=("n", "n", "n"),
    unit="kg m^2 | kg m | kg",
    reference=LYNCH + "eq. 8.12",
    size=lambda arm: arm.inertia / (arm.units[:, :, None] * arm.unit),
    second=SecondMethod("verification.christoffel", lambda book, s: book.christoffel_symbols(s.q)),
    needs_mass=True,
)
