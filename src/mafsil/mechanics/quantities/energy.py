"""Kinetic and potential energy of all bodies.

Equations of motion by Lagrange: energies differentiated, nothing shared with the recursion of Newton and Euler.
"""

from __future__ import annotations

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.placement import Expression, constant, joint_values, placements, world_placements
from mafsil.mechanics.quantity import LYNCH, Quantity, SecondMethod, States
from mafsil.mechanics.textbook import Textbook, along, gradient, repeat_states


def kinetic_energy(tree: BodyTree, q: Expression, qd: Expression) -> Expression:
    """K (1,) = sum of (m v.v + omega . I omega) / 2 + v . (omega x h) over the bodies, plus armatures [J].

    Args:
        tree: the bodies.
        q, qd: (n,) coordinates [rad | m] and rates.
    """
    steps = placements(tree, q)
    rates = joint_values(tree, steps, qd)
    omega, v, energy = [ex.zeros(3, 1)], [ex.zeros(3, 1)], ex.Expression(0)
    for i, body in tree.moving:
        step, p = steps[i], body.parent
        about_axis = ex.vertcat(0, 0, step.omega * rates[i])
        along_axis = ex.vertcat(0, 0, step.v * rates[i])
        omega.append(step.to_child(omega[p]) + about_axis)
        v.append(step.to_child(v[p] + ex.cross(omega[p], step.offset)) + along_axis)
        h, inertia = constant(body.inertia.h), constant(body.inertia.I)
        spin = ex.dot(omega[i], inertia @ omega[i]) + body.inertia.mass * ex.dot(v[i], v[i])
        energy = energy + spin / 2 + ex.dot(v[i], ex.cross(omega[i], h)) + body.armature * rates[i] ** 2 / 2
    return energy


def potential_energy(tree: BodyTree, q: Expression) -> Expression:
    """P (1,) = - sum of m g . p_com over the bodies, zero height at the origin of {s} [J].

    Args:
        tree: the bodies with their true inertias (`lumped` or `in_chosen_frames`, not `regrouped`).
        q: (n,) joint coordinates [rad | m].
    """
    R, p = world_placements(tree, placements(tree, q))
    gravity, base_height = constant(tree.gravity), tree.R_s0.T @ tree.p_s0 @ tree.gravity
    energy = ex.Expression(0)
    for i, body in enumerate(tree.bodies):
        lever = body.inertia.mass * p[i] + R[i] @ constant(body.inertia.h)
        energy = energy - ex.dot(gravity, lever) - body.inertia.mass * base_height
    return energy


KINETIC_ENERGY = Quantity(
    name="kinetic_energy",
    symbol="K",
    title="Kinetic energy of all links and armatures.",
    builder=kinetic_energy,
    inputs=("q", "qd"),
    shape=(),
    unit="J",
    reference=LYNCH + "sec. 8.1.3",
    size=lambda arm: np.array(arm.moment),
    second=SecondMethod("verification.sum_over_links", lambda book, s: book.kinetic_energy(s.q, s.qd)),
    needs_mass=True,
)
POTENTIAL_ENERGY = Quantity(
    name="potential_energy",
    symbol="P",
    title="Potential energy of all links in gravity; zero height at the origin of {s}.",
    builder=potential_energy,
    inputs=("q",),
    shape=(),
    unit="J",
    reference=LYNCH + "sec. 8.1",
    size=lambda arm: np.array(arm.moment),
    second=SecondMethod("verification.sum_over_links", lambda book, s: book.potential_energy(s.q)),
    regrouped=False,
    needs_mass=True,
)


def euler_lagrange(lagrangian: Expression, q: Expression, qd: Expression, qdd: Expression) -> Expression:
    """Generalized forces f (n,) = d/dt dL/dqd - dL/dq of any system.

    Its pairing with a displacement, f . dq, is work, with a rate, f . qd, power: f_i has the unit of energy per q_i.

    Args:
        lagrangian: L(q, qd) = K - P, an expression of q and qd.
        q, qd, qdd: (n,) symbols of generalized coordinates, rates and accelerations.

    Reference: Lynch & Park, Modern Robotics, eq. 8.1.
    """
    momentum = ex.gradient(lagrangian, qd)
    return ex.jtimes(momentum, qd, qdd) + ex.jtimes(momentum, q, qd) - ex.gradient(lagrangian, q)


def lagrange_torque(tree: BodyTree, q: Expression, qd: Expression, qdd: Expression) -> Expression:
    """tau (n,) [N m | N] of a motion, from L = K - P.

    Args:
        tree: the bodies with their true inertias (`lumped` or `in_chosen_frames`).
        q, qd, qdd: (n,) symbols (derivatives are taken by them).

    Reference: Lynch & Park, Modern Robotics, sec. 8.1.2.
    """
    return euler_lagrange(kinetic_energy(tree, q, qd) - potential_energy(tree, q), q, qd, qdd)


def mass_matrix_of(kinetic: Expression, qd: Expression) -> Expression:
    """M (n, n), m_ij the derivative of K by qd_i and qd_j."""
    return ex.hessian(kinetic, qd)[0]


def christoffel_of(M: Expression, q: Expression) -> list[Expression]:
    """Gamma[i] (n, n) with entries Gamma_ijk = (dm_ij/dq_k + dm_ik/dq_j - dm_jk/dq_i) / 2.

    Args:
        M: (n, n) mass matrix, an expression of q.
        q: (n,) symbols.

    Reference: Lynch & Park, Modern Robotics, eq. 8.12.
    """
    n = q.shape[0]
    slope = [ex.jacobian(M[i, :].T, q) for i in range(n)]
    gamma: list[Expression] = []
    for i in range(n):
        along = ex.vertcat(*(slope[j][:, i].T for j in range(n)))
        gamma.append((slope[i] + slope[i].T - along) / 2)
    return gamma


def _by_complex_step(book: Textbook, s: States) -> Floats:
    """M qdd + (dM/dt) qd - dK/dq + dP/dq, all by the complex step."""
    momentum_rate = np.einsum("bij,bj->bi", along(book.mass_matrix, s.q, s.qd), s.qd)
    slope = gradient(lambda q: book.kinetic_energy(q, repeat_states(s.qd, len(q))), s.q)
    weight = gradient(book.potential_energy, s.q)
    return np.einsum("bij,bj->bi", book.mass_matrix(s.q), s.qdd) + momentum_rate - slope + weight


LAGRANGE_TORQUE = Quantity(
    name="lagrange_torque",
    symbol="tau",
    title="Joint efforts of a motion from the energies, by Lagrange's equations: a second `inverse_dynamics`.",
    builder=lagrange_torque,
    inputs=("q", "qd", "qdd"),
    shape=("n",),
    unit="N m | N",
    reference=LYNCH + "sec. 8.1.2",
    size=lambda arm: arm.effort,
    second=SecondMethod("verification.lagrange", _by_complex_step),
    regrouped=False,
    needs_mass=True,
)
