"""Joint efforts that produce a motion: the recursion of Newton and Euler, and its regressor tau = Y(q, qd, qdd) pi.

The recursion runs with 3-vectors in body frames. The ten parameters of a rigid body in a frame: mass, first moment
h = m c (3), and the inertia about the frame's origin (Ixx, Iyy, Izz, Ixy, Ixz, Iyz), products with the minus sign
inside.

Reference: Atkeson, An & Hollerbach 1986; Khalil & Dombre, Modeling, Identification and Control of Robots, ch. 12.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.mechanics.body_tree import Attachment, BodyTree
from mafsil.mechanics.composite_motion import CompositeInertia, body_motion, spin_acceleration
from mafsil.mechanics.placement import (
    Expression,
    constant,
    coordinate_efforts,
    joint_accelerations,
    joint_values,
    placements,
)
from mafsil.mechanics.quantities.kinematics import jacobian_body
from mafsil.mechanics.quantities.link_motion import BodyMotion, outward_motion
from mafsil.mechanics.quantity import LYNCH, Quantity, SecondMethod, States
from mafsil.mechanics.textbook import Textbook, adjoint, dual_bracket, gradient, inverse, skew
from mafsil.mechanics.wrench import Wrench, transmitted_wrenches
from mafsil.model import Mechanism


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


def regressor(tree: BodyTree, q: Expression, qd: Expression, qdd: Expression) -> Expression:
    """Y (n L, 10), row i L + l: the effort of joint i per parameter of link l, in the links' frames.

    tau = sum over the links of Y_l pi_l + armatures qdd

    Args:
        tree: the bodies.
        q, qd, qdd: (n,) coordinates [rad | m] and time derivatives.

    Reference: as the module.
    """
    blocks = [frame_regressor(tree, q, qd, qdd, frame) for frame in tree.frames.values()]
    return ex.vertcat(*(block[i, :] for i in range(tree.n) for block in blocks))


def frame_regressor(tree: BodyTree, q: Expression, qd: Expression, qdd: Expression, frame: Attachment) -> Expression:
    """(n, 10): the efforts that a body fixed to the frame {f} asks for, per parameter of it in {f}.

    J_f' (m, f) with the wrench of the body's motion, linear in its parameters:
        f = m a + U h,  m = h x a + I alpha + omega x I omega

    Args:
        tree: the bodies.
        q, qd, qdd: (n,) coordinates [rad | m] and time derivatives.
        frame: where {f} is attached.

    Reference: as the module.
    """
    steps = placements(tree, q)
    motion = body_motion(tree, steps, joint_values(tree, steps, qd), joint_accelerations(tree, steps, qd, qdd))
    R, p, i = constant(frame.R), constant(frame.p), frame.body
    U = motion.U[i]
    alpha = ex.vertcat(U[2, 1] - U[1, 2], U[0, 2] - U[2, 0], U[1, 0] - U[0, 1]) / 2
    columns = _wrench_columns(R.T @ motion.omega[i], R.T @ alpha, R.T @ (motion.a[i] + U @ p))
    return jacobian_body(tree, q, frame).T @ columns


def _wrench_columns(w: Expression, alpha: Expression, a: Expression) -> Expression:
    """(6, 10) wrench (m, f) per parameter."""
    by_inertia = _inertia_times(alpha) + ex.skew(w) @ _inertia_times(w)
    moment = ex.horzcat(ex.zeros(3, 1), -ex.skew(a), by_inertia)
    force = ex.horzcat(a, spin_acceleration(w, alpha), ex.zeros(3, 6))
    return ex.vertcat(moment, force)


def _inertia_times(x: Expression) -> Expression:
    """(3, 6): I x per entry (Ixx, Iyy, Izz, Ixy, Ixz, Iyz) of I."""
    zero = ex.zeros(1, 1)
    return ex.vertcat(
        ex.horzcat(x[0], zero, zero, x[1], x[2], zero),
        ex.horzcat(zero, x[1], zero, x[0], zero, x[2]),
        ex.horzcat(zero, zero, x[2], zero, x[0], x[1]),
    )


def _of_unit_bodies(book: Textbook, s: States) -> Floats:
    """Virtual work of a body with one parameter equal to one, link by link."""
    V, dV = book.twists(s.q, s.qd), book.accelerations(s.q, s.qd, s.qdd)
    columns = _unit_columns(V, dV, book.poses(s.q), book.mechanism)
    return np.einsum("blin,blip->bnlp", book.link_jacobians(s.q), columns)


def _of_unit_payload(book: Textbook, s: States) -> Floats:
    link, T_lf = book.place(s.frame)
    X = adjoint(inverse(T_lf))
    V = np.einsum("ij,bj->bi", X, book.twists(s.q, s.qd)[:, link])
    dV = np.einsum("ij,bj->bi", X, book.accelerations(s.q, s.qd, s.qdd)[:, link])
    T = book.pose(s.q, s.frame)
    columns = _unit_columns(V[:, None], dV[:, None], T[:, None], book.mechanism)[:, 0]
    return np.einsum("bin,bip->bnp", book.jacobian_body(s.q, s.frame), columns)


def _unit_columns(V: Floats, dV: Floats, T: Floats, mechanism: Mechanism) -> Floats:
    """(b, L, 6, 10) wrench that each unit parameter needs in the frame of its link."""
    fall = np.zeros_like(V)
    fall[..., 3:] = np.einsum("blji,j->bli", T[..., :3, :3], mechanism.gravity)
    columns = [
        np.einsum("ij,blj->bli", G, dV - fall) - dual_bracket(V, np.einsum("ij,blj->bli", G, V))
        for G in _unit_inertias()
    ]
    return np.stack(columns, axis=-1)


def _unit_inertias() -> list[Floats]:
    """(6, 6) inertias of m, hx, hy, hz, Ixx, Iyy, Izz, Ixy, Ixz, Iyz, each one alone."""
    found = [np.diag([0.0, 0, 0, 1, 1, 1])]
    for axis in np.eye(3):
        G = np.zeros((6, 6))
        G[:3, 3:], G[3:, :3] = skew(axis), skew(axis).T
        found.append(G)
    for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)):
        G = np.zeros((6, 6))
        G[i, j] = G[j, i] = 1.0
        found.append(G)
    return found


REGRESSOR = Quantity(
    name="regressor",
    symbol="Y",
    title="Efforts per inertial parameter of each link (m, h, Ixx, Iyy, Izz, Ixy, Ixz, Iyz), in the links' frames.",
    builder=regressor,
    inputs=("q", "qd", "qdd"),
    shape=("n", "L", 10),
    unit="m/s^2, 1/s^2 and so on",
    reference="Atkeson, An & Hollerbach 1986",
    size=lambda arm: arm.parameters / arm.unit[:, None, None],
    second=SecondMethod("verification.unit_bodies", _of_unit_bodies),
    regrouped=False,
)
PAYLOAD_REGRESSOR = Quantity(
    name="payload_regressor",
    symbol="Y_f",
    title="Efforts per inertial parameter of a body fixed to the tip frame, or to a named link's frame.",
    builder=frame_regressor,
    inputs=("q", "qd", "qdd"),
    shape=("n", 10),
    unit="m/s^2, 1/s^2 and so on",
    framed=True,
    expressed_in="the frame itself",
    reference="Atkeson, An & Hollerbach 1986",
    size=lambda arm: arm.parameters / arm.unit[:, None],
    second=SecondMethod("verification.unit_bodies", _of_unit_payload),
    regrouped=False,
)
