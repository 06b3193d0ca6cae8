"""Twists and accelerations of every link, in the frames of the description or at the centres of mass.

A base that is carried along a known motion: the starting values of the outward recursions.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.mechanics.body_tree import Attachment, BodyTree
from mafsil.mechanics.composite_motion import spin_acceleration
from mafsil.mechanics.placement import Expression, Placement, constant, joint_accelerations, joint_values, placements
from mafsil.mechanics.quantity import LYNCH, Quantity, SecondMethod, States
from mafsil.mechanics.textbook import Textbook, adjoint, inverse
from mafsil.mechanics.twist_chain import link_com_frames


@dataclass(frozen=True, slots=True)
class BodyMotion:
    """Motion of the bodies' frames, lists by body index, (3,) in {i}; a is that of the origin as a point.

    `spin` (3, 3) is U = [alpha] + [omega]^2: a point fixed at r in {i} accelerates by a + U r.
    """

    omega: list[Expression]
    v: list[Expression]
    alpha: list[Expression]
    a: list[Expression]
    spin: list[Expression]

    def twist(self, frame: Attachment) -> Expression:
        """V (6,) of an attached frame, in it."""
        R, p, i = constant(frame.R), constant(frame.p), frame.body
        return ex.vertcat(R.T @ self.omega[i], R.T @ (self.v[i] + ex.cross(self.omega[i], p)))

    def acceleration(self, frame: Attachment) -> Expression:
        """Time derivative (6,) of `twist`, component by component: (alpha, a - omega x v)."""
        R, p, i = constant(frame.R), constant(frame.p), frame.body
        V = self.twist(frame)
        a = R.T @ (self.a[i] + self.spin[i] @ p)
        return ex.vertcat(R.T @ self.alpha[i], a - ex.cross(V[:3], V[3:]))


def outward_motion(
    tree: BodyTree,
    steps: list[Placement],
    qd: Expression,
    qdd: Expression,
    base_twist: Expression | None = None,
    base_acceleration: Expression | None = None,
    fall: Floats | None = None,
) -> BodyMotion:
    """Motion of all bodies, the outward sweep of Newton and Euler; arguments as in `inverse_dynamics`.

    With z the joint axis:
        omega_i = R' omega_p + z w qd
        alpha_i = R' alpha_p + z w qdd + omega_i x z w qd
        a_i     = R' (a_p + U_p r_i) + z v qdd + 2 omega_i x z v qd

    Args:
        tree: the bodies.
        steps: their placements.
        qd, qdd: (n,) rates and accelerations of the coordinates.
        base_twist, base_acceleration: (6,) of a carried base, see `base_motion`.
        fall: (3,) acceleration of a freely falling frame, in {0}, against which accelerations are taken; None: at rest.
    """
    rates, accelerations = joint_values(tree, steps, qd), joint_accelerations(tree, steps, qd, qdd)
    base, z = base_motion(tree, base_twist, base_acceleration), ex.Expression([0, 0, 1])
    a_0 = base.a if fall is None else base.a - constant(fall)
    motion = BodyMotion([base.omega], [base.v], [base.alpha], [a_0], [spin_acceleration(base.omega, base.alpha)])
    for i, body in tree.moving:
        p, step, w, s = body.parent, steps[i], z * (steps[i].omega * rates[i]), z * (steps[i].v * rates[i])
        omega = step.to_child(motion.omega[p]) + w
        motion.omega.append(omega)
        motion.v.append(step.to_child(motion.v[p] + ex.cross(motion.omega[p], step.offset)) + s)
        motion.alpha.append(step.to_child(motion.alpha[p]) + ex.cross(omega, w) + z * (step.omega * accelerations[i]))
        pushed = 2 * ex.cross(omega, s) + z * (step.v * accelerations[i])
        motion.a.append(step.to_child(motion.a[p] + motion.spin[p] @ step.offset) + pushed)
        motion.spin.append(spin_acceleration(omega, motion.alpha[i]))
    return motion


def link_twists(tree: BodyTree, q: Expression, qd: Expression, base_twist: Expression | None = None) -> Expression:
    """(L, 6) body twists of all links, each in its own frame.

    Args:
        tree: the bodies.
        q, qd: (n,) coordinates [rad | m] and rates.
        base_twist: (6,) of a carried base, see `base_motion`.

    Reference: Lynch & Park, Modern Robotics, eq. 8.50.
    """
    return _twists(tree, tree.frames.values(), q, qd, base_twist)


def com_twists(tree: BodyTree, q: Expression, qd: Expression, base_twist: Expression | None = None) -> Expression:
    """(L, 6) twists in the frames at the centres of mass; arguments as in `link_twists`."""
    return _twists(tree, link_com_frames(tree), q, qd, base_twist)


def link_accelerations(
    tree: BodyTree,
    q: Expression,
    qd: Expression,
    qdd: Expression,
    base_twist: Expression | None = None,
    base_acceleration: Expression | None = None,
) -> Expression:
    """(L, 6) true derivatives of the body twists of all links, each in its own frame.

    The recursion of Newton and Euler works with these less gravity, dV - (0, g).

    Args:
        tree: the bodies.
        q, qd, qdd: (n,) coordinates [rad | m] and time derivatives.
        base_twist, base_acceleration: (6,) of a carried base, see `base_motion`.

    Reference: Lynch & Park, Modern Robotics, eq. 8.51.
    """
    return _accelerations(tree, tree.frames.values(), q, qd, qdd, base_twist, base_acceleration)


def com_accelerations(
    tree: BodyTree,
    q: Expression,
    qd: Expression,
    qdd: Expression,
    base_twist: Expression | None = None,
    base_acceleration: Expression | None = None,
) -> Expression:
    """(L, 6) derivatives of `com_twists`; arguments as in `link_accelerations`."""
    return _accelerations(tree, link_com_frames(tree), q, qd, qdd, base_twist, base_acceleration)


def _twists(
    tree: BodyTree, frames: Iterable[Attachment], q: Expression, qd: Expression, V_0: Expression | None
) -> Expression:
    motion = outward_motion(tree, placements(tree, q), qd, ex.zeros(tree.n, 1), V_0)
    return ex.vertcat(*(motion.twist(frame).T for frame in frames))


def _accelerations(
    tree: BodyTree,
    frames: Iterable[Attachment],
    q: Expression,
    qd: Expression,
    qdd: Expression,
    V_0: Expression | None,
    dV_0: Expression | None,
) -> Expression:
    motion = outward_motion(tree, placements(tree, q), qd, qdd, V_0, dV_0)
    return ex.vertcat(*(motion.acceleration(frame).T for frame in frames))


def com_frames_of(book: Textbook) -> Floats:
    """(L, 4, 4) poses in the links of frames at their centres of mass, parallel to {s} at zero coordinates."""
    home = book.poses(np.zeros((1, book.mechanism.n)))[0]
    frames = np.tile(np.eye(4), (len(home), 1, 1))
    frames[:, :3, :3] = np.swapaxes(home[:, :3, :3], 1, 2)
    for k, link in enumerate(book.mechanism.links):
        if link.inertial is not None and link.inertial.mass:
            frames[k, :3, 3] = link.inertial.com
    return frames


def _at_com(book: Textbook, motion: Floats) -> Floats:
    """(b, L, 6) twists or their derivatives, in the frames at the centres of mass."""
    return np.einsum("lij,blj->bli", adjoint(inverse(com_frames_of(book))), motion)


def _accelerations_of(book: Textbook, s: States) -> Floats:
    return book.accelerations(s.q, s.qd, s.qdd, s.base_twist, s.base_acceleration)


LINK_TWISTS = Quantity(
    name="link_twists",
    symbol="V_l",
    title="Body twists of all links, each in its own frame, in the order of `mechanism.links`.",
    builder=link_twists,
    inputs=("q", "qd"),
    optional=("base_twist",),
    shape=("L", 6),
    unit="rad/s, m/s",
    expressed_in="the links' frames",
    reference=LYNCH + "eq. 8.50",
    size=lambda arm: arm.twist,
    second=SecondMethod("verification.screws", lambda book, s: book.twists(s.q, s.qd, s.base_twist)),
    regrouped=False,
)
LINK_ACCELERATIONS = Quantity(
    name="link_accelerations",
    symbol="dV_l/dt",
    title="Time derivatives of the body twists of all links, gravity given back, each in its own frame.",
    builder=link_accelerations,
    inputs=("q", "qd", "qdd"),
    optional=("base_twist", "base_acceleration"),
    shape=("L", 6),
    unit="rad/s^2, m/s^2",
    expressed_in="the links' frames",
    reference=LYNCH + "eq. 8.51",
    size=lambda arm: arm.twist,
    second=SecondMethod("verification.complex_step", _accelerations_of),
    regrouped=False,
)
COM_TWISTS = Quantity(
    name="com_twists",
    symbol="V_i",
    title="Twists of all links in frames at their centres of mass, parallel to {s} at zero coordinates.",
    builder=com_twists,
    inputs=("q", "qd"),
    optional=("base_twist",),
    shape=("L", 6),
    unit="rad/s, m/s",
    expressed_in="frames at the centres of mass",
    reference=LYNCH + "eq. 8.50",
    size=lambda arm: arm.twist,
    second=SecondMethod("verification.screws", lambda book, s: _at_com(book, book.twists(s.q, s.qd, s.base_twist))),
    regrouped=False,
)
COM_ACCELERATIONS = Quantity(
    name="com_accelerations",
    symbol="dV_i/dt",
    title="Time derivatives of the twists at the centres of mass, gravity given back.",
    builder=com_accelerations,
    inputs=("q", "qd", "qdd"),
    optional=("base_twist", "base_acceleration"),
    shape=("L", 6),
    unit="rad/s^2, m/s^2",
    expressed_in="frames at the centres of mass",
    reference=LYNCH + "eq. 8.51",
    size=lambda arm: arm.twist,
    second=SecondMethod("verification.complex_step", lambda book, s: _at_com(book, _accelerations_of(book, s))),
    regrouped=False,
)


@dataclass(frozen=True, slots=True)
class BaseMotion:
    """Motion of the base body's frame {0} at its origin, vectors (3,) in {0}; accelerations are those of the point.

    Attributes:
        omega, v: velocities.
        alpha, a: accelerations, without gravity.
    """

    omega: Expression
    v: Expression
    alpha: Expression
    a: Expression


def base_motion(tree: BodyTree, V: Expression | None = None, dV: Expression | None = None) -> BaseMotion:
    """Motion of {0} from that of the space frame {s}, to which the base is fixed and which moves with it.

    A twist's derivative is no point's acceleration: the point at the origin accelerates by dv + omega x v.

    Args:
        tree: the bodies.
        V, dV: (6,) twist (omega, v) of {s} against an inertial frame, in {s}, and its time derivative; None for rest.

    Reference: Lynch & Park, Modern Robotics, sec. 8.3; Featherstone, Rigid Body Dynamics Algorithms, sec. 2.10.
    """
    twist: Expression = ex.zeros(6, 1) if V is None else V
    rate: Expression = ex.zeros(6, 1) if dV is None else dV
    omega, alpha, p, R = twist[:3], rate[:3], constant(tree.p_s0), constant(tree.R_s0)
    lever = ex.cross(omega, p)
    v = twist[3:] + lever
    a = rate[3:] + ex.cross(omega, twist[3:]) + ex.cross(alpha, p) + ex.cross(omega, lever)
    return BaseMotion(R.T @ omega, R.T @ v, R.T @ alpha, R.T @ a)
