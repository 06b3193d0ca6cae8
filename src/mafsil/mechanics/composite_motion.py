"""Composite bodies in motion: what all bodies behind a joint ask for together, relative to the joint's own frame.

Inertia of bodies as expressions: of one body, of all bodies behind a joint, seen from other frames.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mafsil.expression as ex
from mafsil.mechanics.body_tree import BodyTree, RigidInertia
from mafsil.mechanics.placement import Expression, Placement, constant


@dataclass(frozen=True, slots=True)
class Motion:
    """Motion of the bodies, lists by body index, vectors (3,).

    Attributes:
        omega: angular velocity, in {i}.
        U: (3, 3) U r is the acceleration that spin gives a point at r of {i}: [alpha] + [omega]^2.
        a: acceleration of the origin of {i}, gravity as the base's upward acceleration, in {i}.
        gain: twice the velocity of the origin of {i} less that of its parent's, in the parent's frame.
        drift: omega_p x z, in {i}: how the parent turns the joint's axis.
        jump: angular and linear part of Psi'', in {i}.
    """

    omega: list[Expression]
    U: list[Expression]
    a: list[Expression]
    gain: list[Expression]
    drift: list[Expression]
    jump: list[tuple[Expression, Expression]]


@dataclass(frozen=True, slots=True)
class CompositeMotion:
    """A composite body relative to the origin of {i}.

    Attributes:
        inertia: mass, h, I.
        p: (3,) twice the linear momentum, velocities relative to the origin's.
        W: (3, 3) twice the integral of v r' dm.
        moment, force: (3,) what the motion needs, with outer wrenches.
    """

    inertia: CompositeInertia
    p: Expression
    W: Expression
    moment: Expression
    force: Expression

    def add(self, other: CompositeMotion) -> CompositeMotion:
        """Both as one."""
        return CompositeMotion(
            self.inertia.add(other.inertia),
            self.p + other.p,
            self.W + other.W,
            self.moment + other.moment,
            self.force + other.force,
        )

    def in_parent(self, step: Placement, gain: Expression) -> CompositeMotion:
        """Relative to the parent's origin: twice the velocities grow by `gain`."""
        o, h = step.offset, step.to_parent(self.inertia.h)
        p, force = step.to_parent(self.p) + self.inertia.mass * gain, step.to_parent(self.force)
        return CompositeMotion(
            self.inertia.in_parent(step),
            p,
            rotate_matrix(self.W, step) + p @ o.T + gain @ h.T,
            step.to_parent(self.moment) + ex.cross(o, force),
            force,
        )

    def unit_rate_row(self, step: Placement) -> Expression:
        """2 B' S (3,): the joint's effort per angular change of the twist."""
        W, p = self.W, self.p
        moment_of_spin = ex.vertcat(-W[2, 0], -W[2, 1], W[0, 0] + W[1, 1])
        return step.omega * moment_of_spin + step.v * ex.vertcat(p[1], -p[0], 0)

    def rate_wrench(self, step: Placement, drift: Expression) -> tuple[Expression, Expression]:
        """2 (B S + G Psi'): the wrench per unit rate of the joint."""
        W, p = self.W, self.p
        moment_of_spin = ex.vertcat(-W[0, 2], -W[1, 2], W[0, 0] + W[1, 1])
        moment, force = self._demand(2 * step.omega * drift, 2 * step.v * drift)
        return step.omega * moment_of_spin + moment, step.omega * ex.vertcat(-p[1], p[0], 0) + force

    def shift_wrench(self, step: Placement, motion: Motion, i: int) -> tuple[Expression, Expression]:
        """2 B Psi' + G Psi'' + S x* F: the change of the wrench per displacement of the joint."""
        w, v, z, W = step.omega, step.v, ex.Expression([0, 0, 1]), self.W
        moment, force = self._demand(*motion.jump[i])
        x, y = w * motion.drift[i][0], w * motion.drift[i][1]
        spread = ex.vertcat(
            (W[1, 1] + W[2, 2]) * x - W[0, 1] * y, (W[0, 0] + W[2, 2]) * y - W[1, 0] * x, -W[2, 0] * x - W[2, 1] * y
        )
        moment = moment + spread + w * ex.cross(z, self.moment) + v * ex.cross(z, self.force)
        return moment, force + ex.cross(ex.vertcat(x, y, 0), self.p) + w * ex.cross(z, self.force)

    def _demand(self, xi: Expression, x: Expression) -> tuple[Expression, Expression]:
        """G X (moment, force) of X = (xi, x)."""
        inertia = self.inertia
        return inertia.I @ xi + ex.cross(inertia.h, x), inertia.mass * x + ex.cross(xi, inertia.h)


def body_motion(
    tree: BodyTree, steps: Sequence[Placement], rates: Sequence[Expression], accelerations: Sequence[Expression]
) -> Motion:
    """Motion of all bodies, from the base outward; arguments as in `inverse_dynamics`, base first."""
    zero, z = ex.zeros(3, 1), ex.Expression([0, 0, 1])
    motion = Motion([zero], [ex.zeros(3, 3)], [constant(-tree.gravity)], [zero], [zero], [(zero, zero)])
    alpha = [zero]
    for i, body in tree.moving:
        p, step, qd, qdd = body.parent, steps[i], rates[i], accelerations[i]
        carried, spun = step.to_child(motion.omega[p]), step.to_child(alpha[p])
        drift = ex.cross(carried, z)
        axis = spin_acceleration(carried, spun) @ z
        gain = ex.cross(motion.omega[p], 2 * step.offset)
        a = step.to_child(motion.a[p] + motion.U[p] @ step.offset)
        jump = step.v * axis + step.omega * ex.cross(a, z)
        if step.v:
            along = 2 * drift * (step.v * qd) + z * (step.v * qdd)
            jump = jump + 2 * step.omega * step.v * qd * ex.cross(drift, z)
            gain = gain + step.to_parent(z) * (2 * step.v * qd)
            a = a + along
        omega = carried + z * (step.omega * qd)
        alpha.append(spun + drift * (step.omega * qd) + z * (step.omega * qdd))
        motion.omega.append(omega)
        motion.U.append(spin_acceleration(omega, alpha[i]))
        motion.a.append(a)
        motion.gain.append(gain)
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
    own = [_own(body.inertia, motion.omega[i], motion.U[i], motion.a[i]) for i, body in enumerate(tree.bodies)]
    if F_tip is not None:
        own[tree.tip.body] = _with_tip_wrench(tree, own[tree.tip.body], F_tip)
    for i, body in reversed(tree.moving):
        if body.parent:
            own[body.parent] = own[body.parent].add(own[i].in_parent(steps[i], motion.gain[i]))
    return own


def spin_acceleration(omega: Expression, alpha: Expression) -> Expression:
    """U (3, 3) = [alpha] + [omega]^2."""
    return ex.skew(alpha) + ex.skew(omega) @ ex.skew(omega)


def rotate_matrix(W: Expression, step: Placement) -> Expression:
    """R W R' for any (3, 3) W, R the rotation from {i} to its parent: by double angles about z, then the constant."""
    c, s = step.cosine, step.sine
    swing = s * (s * (W[1, 1] - W[0, 0]) - c * (W[0, 1] + W[1, 0]))
    cross = c * (s * (W[0, 0] - W[1, 1]) + c * (W[0, 1] + W[1, 0]))
    rows = ex.vertcat(
        ex.horzcat(W[0, 0] + swing, cross - W[1, 0], c * W[0, 2] - s * W[1, 2]),
        ex.horzcat(cross - W[0, 1], W[1, 1] - swing, s * W[0, 2] + c * W[1, 2]),
        ex.horzcat(c * W[2, 0] - s * W[2, 1], s * W[2, 0] + c * W[2, 1], W[2, 2]),
    )
    return step.R @ rows @ step.R.T


def _own(inertia: RigidInertia, omega: Expression, U: Expression, a: Expression) -> CompositeMotion:
    h, second = constant(inertia.h), constant(inertia.I.trace() / 2 * _EYE - inertia.I)
    spread = U @ second
    return CompositeMotion(
        CompositeInertia(ex.Expression(inertia.mass), h, constant(inertia.I)),
        ex.cross(omega, 2 * h),
        ex.skew(omega) @ (2 * second),
        ex.vertcat(spread[2, 1] - spread[1, 2], spread[0, 2] - spread[2, 0], spread[1, 0] - spread[0, 1])
        + ex.cross(h, a),
        inertia.mass * a + U @ h,
    )


def _with_tip_wrench(tree: BodyTree, own: CompositeMotion, F_tip: Expression) -> CompositeMotion:
    R, p = constant(tree.tip.R), constant(tree.tip.p)
    f = R @ F_tip[3:]
    return CompositeMotion(own.inertia, own.p, own.W, own.moment + R @ F_tip[:3] + ex.cross(p, f), own.force + f)


_EYE = ex.eye(3).full()


@dataclass(frozen=True, slots=True)
class CompositeInertia:
    """Mass, first moment h (3,) and rotational inertia I (3, 3) about the origin, as expressions."""

    mass: Expression
    h: Expression
    I: Expression

    @staticmethod
    def of(inertia: RigidInertia) -> CompositeInertia:
        """Of a body whose numbers are known; zeros among them are structural."""
        return CompositeInertia(ex.Expression(inertia.mass), constant(inertia.h), constant(inertia.I))

    @staticmethod
    def of_parameters(phi: Sequence[Expression]) -> CompositeInertia:
        """Of a body with ten parameters m, hx, hy, hz, Ixx, Iyy, Izz, Ixy, Ixz, Iyz about the origin."""
        m, hx, hy, hz, *moments = phi
        return CompositeInertia(m, ex.vertcat(hx, hy, hz), _from_six(*moments))

    def add(self, other: CompositeInertia) -> CompositeInertia:
        """Both bodies as one."""
        return CompositeInertia(self.mass + other.mass, self.h + other.h, self.I + other.I)

    def in_parent(self, step: Placement) -> CompositeInertia:
        """Seen from the parent's frame: turned, then shifted by the offset (Steiner)."""
        h = step.to_parent(self.h)
        turned = turned_symmetric(self.I, step)
        p = step.offset
        return CompositeInertia(self.mass, h + self.mass * p, turned + _shift(p, h + 0.5 * self.mass * p))

    def unit_acceleration(self, step: Placement) -> tuple[Expression, Expression]:
        """G S: the wrench (moment, force) per unit acceleration of the joint with the screw S = (w z, v z)."""
        h = self.h
        moment = step.omega * self.I[:, 2] + step.v * ex.vertcat(h[1], -h[0], 0)
        return moment, step.omega * ex.vertcat(-h[1], h[0], 0) + step.v * ex.vertcat(0, 0, self.mass)


def turned_symmetric(inertia: Expression, step: Placement) -> Expression:
    """R_c Rz I Rz' R_c' for a symmetric I, by double angles about z, then the constant turn."""
    c, s = step.cosine, step.sine
    xx, yy, zz, xy, xz, yz = inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2]
    half_swing = s * (s * (yy - xx) - 2 * c * xy)
    new_xx, new_yy = xx + half_swing, yy - half_swing
    new_xy = c * (s * (xx - yy) + 2 * c * xy) - xy
    new_xz, new_yz = c * xz - s * yz, s * xz + c * yz
    about_z = _from_six(new_xx, new_yy, zz, new_xy, new_xz, new_yz)
    return step.R @ about_z @ step.R.T


def _from_six(
    xx: Expression, yy: Expression, zz: Expression, xy: Expression, xz: Expression, yz: Expression
) -> Expression:
    return ex.vertcat(ex.horzcat(xx, xy, xz), ex.horzcat(xy, yy, yz), ex.horzcat(xz, yz, zz))


def _shift(p: Expression, g: Expression) -> Expression:
    """(p . g + g . p) E - p g' - g p': what moving the origin by p adds, with g = h + m p / 2."""
    px, py, pz = p[0], p[1], p[2]
    gx, gy, gz = g[0], g[1], g[2]
    x, y, z = 2 * px * gx, 2 * py * gy, 2 * pz * gz
    return _from_six(y + z, x + z, x + y, -(px * gy + py * gx), -(px * gz + pz * gx), -(py * gz + pz * gy))
