"""Joint efforts that produce a motion: the recursion of Newton and Euler with 3-vectors in body frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.composite_motion import CompositeInertia
from mafsil.mechanics.placement import Expression, coordinate_efforts, joint_accelerations, placements
from mafsil.mechanics.quantities.link_motion import BodyMotion, outward_motion
from mafsil.mechanics.quantity import LYNCH, Quantity, SecondMethod, States
from mafsil.mechanics.textbook import Textbook, gradient
from mafsil.mechanics.wrench import Wrench, transmitted_wrenches


def inverse_dynamics(
    tree: BodyTree,
    q: Expression,
    qd: Expression,
    qdd: Expression,
    F_tip: Expression | None = None,
    base_twist: Expression | None = None,
    base_acceleration: Expression | None = None,
    inertias: Sequence[CompositeInertia] | None = None,
) -> Expression:
    """tau (n,) [N m | N] with tau = M(q) qdd + c(q, qd) + g(q) + J' F_tip.

    Outward, with z the joint axis and U = [alpha] + [omega]^2 so that a point fixed at r in {i} accelerates by a + U r:
        omega_i = R' omega_p + z w qd
        alpha_i = R' alpha_p + z w qdd + omega_i x z w qd
        a_i     = R' (a_p + U_p r_i) + z v qdd + 2 omega_i x z v qd
    Inward, with m, h, I the inertia about the origin of {i}:
        f_i     = m a_i + U_i h + sum of R f_child
        m_i     = I alpha_i + omega_i x I omega_i + h x a_i + sum of (R m_child + r_child x R f_child)
        tau_i   = w z . m_i + v z . f_i + armature qdd
    Gravity enters as the base's acceleration -g.

    Args:
        tree: the bodies.
        q, qd, qdd: (n,) coordinates [rad | m] and time derivatives.
        F_tip: (6,) wrench (m, f) the tip exerts on the world, in {tip} [N m, N]; None for none.
        base_twist, base_acceleration: (6,) true motion of a carried base, see `base_motion`; None for a fixed base.
        inertias: of the bodies (base first), where they are not the tree's own numbers.

    Reference: Luh, Walker, Paul 1980; Lynch & Park, Modern Robotics, sec. 8.3, gives the same in twists.
    """
    steps = placements(tree, q)
    motion = outward_motion(tree, steps, qd, qdd, base_twist, base_acceleration, fall=tree.gravity)
    needs = _needs(tree, motion, inertias)
    if F_tip is not None:
        _add_tip_wrench(tree, F_tip, needs)
    F = transmitted_wrenches([body.parent for body in tree.bodies], needs, lambda i, wrench: wrench.in_parent(steps[i]))
    accelerations = joint_accelerations(tree, steps, qd, qdd)
    efforts = [
        wrench.along(step) + body.armature * rate if body.armature else wrench.along(step)
        for wrench, step, body, rate in zip(F, steps, tree.bodies, accelerations, strict=True)
    ]
    return coordinate_efforts(tree, steps, efforts)


def gravity_torque(tree: BodyTree, q: Expression) -> Expression:
    """g(q) (n,) [N m | N]: efforts that hold the robot still."""
    zero = ex.zeros(tree.n, 1)
    return inverse_dynamics(tree, q, zero, zero)


def velocity_torque(tree: BodyTree, q: Expression, qd: Expression) -> Expression:
    """c(q, qd) (n,) [N m | N]: centrifugal and Coriolis efforts; arguments as in `inverse_dynamics`."""
    return inverse_dynamics(replace(tree, gravity=0.0 * tree.gravity), q, qd, ex.zeros(tree.n, 1))


def _needs(tree: BodyTree, motion: BodyMotion, inertias: Sequence[CompositeInertia] | None) -> list[Wrench]:
    """What each body's own motion needs; the base's is nobody's concern."""
    own = [CompositeInertia.of(body.inertia) for body in tree.bodies] if inertias is None else inertias
    return [
        Wrench.zero(),
        *(
            Wrench.of_motion(own[i], motion.omega[i], motion.alpha[i], motion.a[i], motion.spin[i])
            for i, _ in tree.moving
        ),
    ]


def _add_tip_wrench(tree: BodyTree, F_tip: Expression, needs: list[Wrench]) -> None:
    needs[tree.tip.body] = needs[tree.tip.body] + Wrench.at(tree.tip, F_tip)


def _by_virtual_work(book: Textbook, s: States) -> Floats:
    """Virtual work on a resting base, the recursion in matrices on one that is carried."""
    if s.base_twist is None:
        return book.virtual_work(s.q, s.qd, s.qdd, s.tip_wrench)
    return book.newton_euler(s.q, s.qd, s.qdd, s.tip_wrench, s.base_twist, s.base_acceleration).tau


INVERSE_DYNAMICS = Quantity(
    name="inverse_dynamics",
    symbol="tau",
    title="Joint efforts that produce a motion: tau = M qdd + c + g + J' F_tip.",
    builder=inverse_dynamics,
    inputs=("q", "qd", "qdd"),
    optional=("tip_wrench", "base_twist", "base_acceleration"),
    shape=("n",),
    unit="N m | N",
    reference="Luh, Walker, Paul 1980; " + LYNCH + "sec. 8.3",
    size=lambda arm: arm.effort,
    second=SecondMethod("verification.virtual_work", _by_virtual_work),
    needs_mass=True,
)

VELOCITY_TORQUE = Quantity(
    name="velocity_torque",
    symbol="c",
    title="Centrifugal and Coriolis efforts c(q, qd).",
    builder=velocity_torque,
    inputs=("q", "qd"),
    shape=("n",),
    unit="N m | N",
    reference=LYNCH + "sec. 8.1",
    size=lambda arm: arm.effort,
    second=SecondMethod(
        "verification.virtual_work", lambda book, s: book.virtual_work(s.q, s.qd, np.zeros_like(s.qd), weight=0.0)
    ),
    needs_mass=True,
)

GRAVITY_TORQUE = Quantity(
    name="gravity_torque",
    symbol="g",
    title="Efforts g(q) that hold the robot still against gravity.",
    builder=gravity_torque,
    inputs=("q",),
    shape=("n",),
    unit="N m | N",
    reference=LYNCH + "sec. 8.1",
    size=lambda arm: arm.effort,
    second=SecondMethod("verification.potential", lambda book, s: gradient(book.potential_energy, s.q)),
    needs_mass=True,
)
