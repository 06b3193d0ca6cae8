"""Composite bodies in motion: what all bodies behind a joint ask for together, relative to the joint's own frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from mafsil.mechanics.body_tree import BodyTree, RigidInertia
from mafsil.mechanics.mass_matrix import CompositeInertia
from mafsil.mechanics.placement import Expression, Placement, constant


@dataclass(frozen=True, slots=True)
class Motion:
    """Motion of the bodies, lists by body index, vectors (3,).

    Attributes:
        omega: angular velocity, in {i}.
        U: (3, 3) U r is the acceleration that spin gives a point at r of {i}: [alpha] + [omega]^2.
        a: acceleration of the origin of {i}, gravity as the base's upward acceleration, in {i}.
        gain: velocity of the origin of {i} less that of its parent's, in the parent's frame.
        lead: acceleration of the origin of {i} less that of its parent's, in the parent's frame.
        drift: omega_p x z, in {i}: how the parent turns the joint's axis.
        jump: angular and linear part of Psi'', in {i}.
    """

    omega: list[Expression]
    U: list[Expression]
    a: list[Expression]
    gain: list[Expression]
    lead: list[Expression]
    drift: list[Expression]
    jump: list[tuple[Expression, Expression]]


@dataclass(frozen=True, slots=True)
class CompositeMotion:
    """A composite body relative to the origin of {i}.

    Attributes:
        inertia: mass, h, I.
        p: (3,) linear momentum, velocities relative to the origin's.
        W: (3, 3) integral of v r' dm.
        moment, force: (3,) what the motion relative to the origin's acceleration needs, with outer wrenches.
    """

    inertia: CompositeInertia
    p: Expression
    W: Expression
    moment: Expression
    force: Expression

    def added(self, other: CompositeMotion) -> CompositeMotion:
        """Both as one."""
        return CompositeMotion(
            self.inertia.added(other.inertia),
            self.p + other.p,
            self.W + other.W,
            self.moment + other.moment,
            self.force + other.force,
        )

    def in_parent(self, step: Placement, gain: Expression, lead: Expression) -> CompositeMotion:
        """Relative to the parent's origin: velocities grow by `gain`, accelerations by `lead`."""
        mass, o = self.inertia.mass, step.offset
        h = step.to_parent(self.inertia.h)
        p = step.to_parent(self.p) + mass * gain
        force = step.to_parent(self.force) + mass * lead
        return CompositeMotion(
            self.inertia.in_parent(step),
            p,
            turned(self.W, step) + p @ o.T + gain @ h.T,
            step.to_parent(self.moment) + ca.cross(o, force) + ca.cross(h, lead),
            force,
        )

    def unit_acceleration(self, step: Placement) -> tuple[Expression, Expression]:
        """G S: the wrench per unit acceleration of the joint."""
        h, mass = ca.densify(self.inertia.h), self.inertia.mass
        moment = step.omega * self.inertia.I[:, 2] + step.v * ca.vertcat(h[1], -h[0], 0)
        return moment, step.omega * ca.vertcat(-h[1], h[0], 0) + step.v * ca.vertcat(0, 0, mass)

    def unit_rate_row(self, step: Placement) -> Expression:
        """B' S (3,): the joint's effort per angular change of the twist."""
        W, p = self.W, self.p
        turn = ca.vertcat(-W[2, 0], -W[2, 1], W[0, 0] + W[1, 1])
        return step.omega * turn + step.v * ca.vertcat(p[1], -p[0], 0)

    def rate_wrench(self, step: Placement, drift: Expression) -> tuple[Expression, Expression]:
        """B S + G Psi': half the wrench per unit rate of the joint."""
        W, p = self.W, self.p
        turn = ca.vertcat(-W[0, 2], -W[1, 2], W[0, 0] + W[1, 1])
        moment, force = self._demand(step.omega * drift, step.v * drift)
        return step.omega * turn + moment, step.omega * ca.vertcat(-p[1], p[0], 0) + force

    def shift_wrench(self, step: Placement, motion: Motion, i: int) -> tuple[Expression, Expression]:
        """2 B Psi' + G Psi'' + S x* F: the change of the wrench per displacement of the joint.

        With F = (moment + h x a, force + m a), the parts of w a x z in G Psi'' and of w z x (m a) in S x* F cancel.
        """
        w, v, z = step.omega, step.v, ca.SX(ca.DM([0, 0, 1]))
        xi, x = motion.jump[i][0], motion.jump[i][1] - w * ca.cross(motion.a[i], z)
        moment, force = self._demand(xi, x)
        drift, h, a = w * motion.drift[i], self.inertia.h, motion.a[i]
        spread = (self.W[0, 0] + self.W[1, 1] + self.W[2, 2]) * drift - self.W @ drift
        moment = moment + 2 * spread + w * (ca.cross(z, self.moment) + ca.cross(ca.cross(z, h), a))
        force = force + 2 * ca.cross(drift, self.p) + w * ca.cross(z, self.force)
        if v:
            moment = moment + v * ca.cross(z, self.force + self.inertia.mass * a)
        return moment, force

    def _demand(self, xi: Expression, x: Expression) -> tuple[Expression, Expression]:
        """G X (moment, force) of X = (xi, x)."""
        inertia = self.inertia
        return inertia.I @ xi + ca.cross(inertia.h, x), inertia.mass * x + ca.cross(xi, inertia.h)


def body_motion(
    tree: BodyTree, steps: Sequence[Placement], rates: Sequence[Expression], accelerations: Sequence[Expression]
) -> Motion:
    """Motion of all bodies, from the base outward; arguments as in `inverse_dynamics`, base first."""
    zero, z = ca.SX(3, 1), ca.SX(ca.DM([0, 0, 1]))
    motion = Motion([zero], [ca.SX(3, 3)], [constant(-tree.gravity)], [zero], [zero], [zero], [(zero, zero)])
    alpha = [zero]
    for i, body in tree.moving:
        p, step, qd, qdd = body.parent, steps[i], rates[i], accelerations[i]
        carried, spun = step.to_child(motion.omega[p]), step.to_child(alpha[p])
        drift = ca.cross(carried, z)
        axis = spin_acceleration(carried, spun) @ z
        gain, lead = ca.cross(motion.omega[p], step.offset), motion.U[p] @ step.offset
        a = step.to_child(motion.a[p] + lead)
        jump = step.v * axis + step.omega * ca.cross(a, z)
        if step.v:
            slide = 2 * drift * (step.v * qd) + z * (step.v * qdd)
            jump = jump + 2 * step.omega * step.v * qd * ca.cross(drift, z)
            gain, lead = gain + step.to_parent(z) * (step.v * qd), lead + step.to_parent(slide)
            a = a + slide
        omega = carried + z * (step.omega * qd)
        alpha.append(spun + drift * (step.omega * qd) + z * (step.omega * qdd))
        motion.omega.append(omega)
        motion.U.append(spin_acceleration(omega, alpha[i]))
        motion.a.append(a)
        motion.gain.append(gain)
        motion.lead.append(lead)
        motion.drift.append(drift)
        motion.jump.append((step.omega * axis, jump))
    return motion


def composites(
    tree: BodyTree, steps: Sequence[Placement], motion: Motion, F_tip: Expression | None = None
) -> list[CompositeMotion]:
    """The composite body behind every joint, base (its own alone) first.

    Args:
        tree: the bodies.
        steps: their placements.
        motion: of the bodies.
        F_tip: (6,) wrench (m, f) the tip exerts on the world, in {tip}; None for none.
    """
    own = [_own(body.inertia, motion.omega[i], motion.U[i]) for i, body in enumerate(tree.bodies)]
    if F_tip is not None:
        own[tree.tip.body] = _with_tip_wrench(tree, own[tree.tip.body], F_tip)
    for i, body in reversed(tree.moving):
        if body.parent:
            own[body.parent] = own[body.parent].added(own[i].in_parent(steps[i], motion.gain[i], motion.lead[i]))
    return own


def spin_acceleration(omega: Expression, alpha: Expression) -> Expression:
    """U (3, 3) = [alpha] + [omega]^2."""
    return ca.skew(alpha) + ca.skew(omega) @ ca.skew(omega)


def turned(W: Expression, step: Placement) -> Expression:
    """R W R' for any (3, 3) W, R the rotation from {i} to its parent: by double angles about z, then the constant."""
    c, s = step.cosine, step.sine
    swing = s * (s * (W[1, 1] - W[0, 0]) - c * (W[0, 1] + W[1, 0]))
    cross = c * (s * (W[0, 0] - W[1, 1]) + c * (W[0, 1] + W[1, 0]))
    rows = ca.vertcat(
        ca.horzcat(W[0, 0] + swing, cross - W[1, 0], c * W[0, 2] - s * W[1, 2]),
        ca.horzcat(cross - W[0, 1], W[1, 1] - swing, s * W[0, 2] + c * W[1, 2]),
        ca.horzcat(c * W[2, 0] - s * W[2, 1], s * W[2, 0] + c * W[2, 1], W[2, 2]),
    )
    return step.R @ rows @ step.R.T


def _own(inertia: RigidInertia, omega: Expression, U: Expression) -> CompositeMotion:
    h, second = constant(inertia.h), constant(inertia.I.trace() / 2 * _EYE - inertia.I)
    spread = U @ second
    return CompositeMotion(
        CompositeInertia(ca.SX(inertia.mass), h, constant(inertia.I)),
        ca.cross(omega, h),
        ca.skew(omega) @ second,
        ca.vertcat(spread[2, 1] - spread[1, 2], spread[0, 2] - spread[2, 0], spread[1, 0] - spread[0, 1]),
        U @ h,
    )


def _with_tip_wrench(tree: BodyTree, own: CompositeMotion, F_tip: Expression) -> CompositeMotion:
    R, p = constant(tree.tip.R), constant(tree.tip.p)
    f = R @ F_tip[3:]
    return CompositeMotion(own.inertia, own.p, own.W, own.moment + R @ F_tip[:3] + ca.cross(p, f), own.force + f)


_EYE = ca.DM.eye(3).full()
