"""Kinetic and potential energy of all bodies."""

from __future__ import annotations

import numpy as np

import mafsil.expression as ex
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.placement import Expression, constant, joint_values, placements, world_placements
from mafsil.mechanics.quantity import LYNCH, Quantity, SecondMethod


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
