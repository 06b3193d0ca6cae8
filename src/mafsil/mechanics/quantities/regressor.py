"""Joint efforts as a linear function of inertial parameters: tau = Y(q, qd, qdd) pi.

The ten parameters of a rigid body in a frame: mass, first moment h = m c (3), and the inertia about the frame's origin
(Ixx, Iyy, Izz, Ixy, Ixz, Iyz), products with the minus sign inside.

Reference: Atkeson, An & Hollerbach 1986; Khalil & Dombre, Modeling, Identification and Control of Robots, ch. 12.
"""

from __future__ import annotations

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.mechanics.body_tree import Attachment, BodyTree
from mafsil.mechanics.composite_motion import body_motion, spin_acceleration
from mafsil.mechanics.placement import Expression, constant, joint_accelerations, joint_values, placements
from mafsil.mechanics.quantities.jacobian import jacobian_body
from mafsil.mechanics.quantity import Quantity, SecondMethod, States
from mafsil.mechanics.textbook import Textbook, adjoint, dual_bracket, inverse, skew
from mafsil.model import Mechanism


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
