"""Velocity efforts in two parts: what each joint's own rate asks for, and what two rates ask for together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.placement import Expression
from mafsil.mechanics.quantities.inverse_dynamics import inverse_dynamics, velocity_torque
from mafsil.mechanics.quantity import LYNCH, Quantity, SecondMethod
from mafsil.mechanics.states import States
from mafsil.mechanics.textbook import Textbook


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
