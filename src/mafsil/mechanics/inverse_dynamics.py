"""Joint efforts that produce a motion: the recursion of Newton and Euler with 3-vectors in body frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import casadi as ca

from mafsil.mechanics.base_motion import BaseMotion, base_motion
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.placement import (
    Expression,
    Placement,
    constant,
    coordinate_efforts,
    joint_values,
    placements,
)


def inverse_dynamics(
    tree: BodyTree,
    q: Expression,
    qd: Expression,
    qdd: Expression,
    F_tip: Expression | None = None,
    base_twist: Expression | None = None,
    base_acceleration: Expression | None = None,
) -> Expression:
    """Tau (n,) [N m | N] with tau = M(q) qdd + c(q, qd) + g(q) + J' F_tip.

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

    Reference: Luh, Walker, Paul 1980; Lynch & Park, Modern Robotics, sec. 8.3, gives the same in twists.
    """
    steps = placements(tree, q)
    rates, accelerations = joint_values(tree, qd), joint_values(tree, qdd)
    base = base_motion(tree, base_twist, base_acceleration)
    moment, force = _loads(tree, *_outward(tree, steps, rates, accelerations, base))
    if F_tip is not None:
        _add_tip_wrench(tree, F_tip, moment, force)
    efforts = _inward(tree, steps, moment, force)
    with_armature = [
        effort + body.armature * qdd_i if body.armature else effort
        for effort, body, qdd_i in zip(efforts, tree.bodies, accelerations, strict=True)
    ]
    return coordinate_efforts(tree, with_armature)


def gravity_torque(tree: BodyTree, q: Expression) -> Expression:
    """g(q) (n,) [N m | N]: efforts that hold the robot still."""
    zero = ca.SX(tree.n, 1)
    return inverse_dynamics(tree, q, zero, zero)


def velocity_torque(tree: BodyTree, q: Expression, qd: Expression) -> Expression:
    """c(q, qd) (n,) [N m | N]: centrifugal and Coriolis efforts; arguments as in `inverse_dynamics`."""
    return inverse_dynamics(replace(tree, gravity=0.0 * tree.gravity), q, qd, ca.SX(tree.n, 1))


def _outward(
    tree: BodyTree,
    steps: Sequence[Placement],
    rates: Sequence[Expression],
    accelerations: Sequence[Expression],
    base: BaseMotion,
) -> tuple[list[Expression], list[Expression], list[Expression], list[Expression]]:
    """omega, alpha, acceleration of the origin, and U of each body, in its own frame."""
    omega, alpha, a = [base.omega], [base.alpha], [base.a - constant(tree.gravity)]
    U = [_point_acceleration(base.omega, base.alpha)]
    for i, body in tree.moving:
        p, step, qd, qdd = body.parent, steps[i], rates[i], accelerations[i]
        w_i = step.to_child(omega[p])
        turning = ca.cross(w_i, _along_z(step.omega * qd))
        w_i = w_i + _along_z(step.omega * qd)
        omega.append(w_i)
        alpha.append(step.to_child(alpha[p]) + turning + _along_z(step.omega * qdd))
        U.append(_point_acceleration(w_i, alpha[i]))
        a_i = step.to_child(a[p] + U[p] @ step.offset)
        if step.v:
            a_i = a_i + 2 * ca.cross(w_i, _along_z(step.v * qd)) + _along_z(step.v * qdd)
        a.append(a_i)
    return omega, alpha, a, U


def _loads(
    tree: BodyTree,
    omega: Sequence[Expression],
    alpha: Sequence[Expression],
    a: Sequence[Expression],
    U: Sequence[Expression],
) -> tuple[list[Expression], list[Expression]]:
    """Moment about the origin and force that each body's own motion needs."""
    moment, force = [ca.SX(3, 1)], [ca.SX(3, 1)]
    for i, body in tree.moving:
        h, inertia = constant(body.inertia.h), constant(body.inertia.I)
        spin = inertia @ omega[i]
        moment.append(inertia @ alpha[i] + ca.cross(omega[i], spin) + ca.cross(h, a[i]))
        force.append(body.inertia.mass * a[i] + U[i] @ h)
    return moment, force


def _inward(
    tree: BodyTree, steps: Sequence[Placement], moment: list[Expression], force: list[Expression]
) -> list[Expression]:
    """Efforts of the joints (base first); loads are passed on to the parents."""
    efforts: list[Expression] = [0.0] * len(tree.bodies)
    for i, body in reversed(tree.moving):
        step = steps[i]
        efforts[i] = step.omega * moment[i][2] + step.v * force[i][2]
        if body.parent:
            f = step.to_parent(force[i])
            force[body.parent] = force[body.parent] + f
            moment[body.parent] = moment[body.parent] + step.to_parent(moment[i]) + ca.cross(step.offset, f)
    return efforts


def _add_tip_wrench(tree: BodyTree, F_tip: Expression, moment: list[Expression], force: list[Expression]) -> None:
    R, p, body = constant(tree.tip.R), constant(tree.tip.p), tree.tip.body
    f = R @ F_tip[3:]
    force[body] = force[body] + f
    moment[body] = moment[body] + R @ F_tip[:3] + ca.cross(p, f)


def _point_acceleration(omega: Expression, alpha: Expression) -> Expression:
    """U (3, 3) with U r the acceleration that spin gives to a point at r: [alpha] + [omega]^2."""
    return ca.skew(alpha) + ca.skew(omega) @ ca.skew(omega)


def _along_z(x: Expression) -> Expression:
    return ca.vertcat(0, 0, x)
