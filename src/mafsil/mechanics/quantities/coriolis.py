"""The Coriolis matrix with the Christoffel symbols of the mass matrix, without differentiation.

Velocity efforts in two parts: what each joint's own rate asks for, and what two rates ask for together.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.placement import Expression
from mafsil.mechanics.quantities.dynamics_derivatives import matrices
from mafsil.mechanics.quantities.inverse_dynamics import inverse_dynamics, velocity_torque
from mafsil.mechanics.quantity import LYNCH, Quantity, SecondMethod, States
from mafsil.mechanics.textbook import Textbook


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


def _of_single_rates(book: Textbook, s: States) -> Floats:
    return np.einsum("bijj,bj->bi", book.christoffel_symbols(s.q), s.qd**2)


def _of_pairs(book: Textbook, s: States) -> Floats:
    Gamma = book.christoffel_symbols(s.q)
    return np.einsum("bijk,bj,bk->bi", Gamma, s.qd, s.qd) - np.einsum("bijj,bj->bi", Gamma, s.qd**2)


CENTRIFUGAL_TORQUE = Quantity(
    name="centrifugal_torque",
    symbol="c_centrifugal",
    title="Centrifugal efforts: the sum of Gamma_ijj qd_j^2.",
    builder=centrifugal_torque,
    inputs=("q", "qd"),
    shape=("n",),
    unit="N m | N",
    reference=LYNCH + "sec. 8.1.1",
    size=lambda arm: arm.effort,
    second=SecondMethod("verification.christoffel", _of_single_rates),
    needs_mass=True,
)
CORIOLIS_TORQUE = Quantity(
    name="coriolis_torque",
    symbol="c_Coriolis",
    title="Coriolis efforts: the sum of 2 Gamma_ijk qd_j qd_k over j < k.",
    builder=coriolis_torque,
    inputs=("q", "qd"),
    shape=("n",),
    unit="N m | N",
    reference=LYNCH + "sec. 8.1.1",
    size=lambda arm: arm.effort,
    second=SecondMethod("verification.christoffel", _of_pairs),
    needs_mass=True,
)
