"""Joint efforts as a linear function of inertial parameters: tau = Y(q, qd, qdd) pi.

The ten parameters of a rigid body in a frame: mass, first moment h = m c (3), and the inertia about the frame's origin
(Ixx, Iyy, Izz, Ixy, Ixz, Iyz), products with the minus sign inside.

Reference: Atkeson, An & Hollerbach 1986; Khalil & Dombre, Modeling, Identification and Control of Robots, ch. 12.
"""

from __future__ import annotations

import mafsil.expression as ex
from mafsil.mechanics.body_tree import Attachment, BodyTree
from mafsil.mechanics.composite_motion import body_motion, spin_acceleration
from mafsil.mechanics.jacobian import jacobian_body
from mafsil.mechanics.placement import Expression, constant, joint_values, placements


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
    motion = body_motion(tree, steps, joint_values(tree, qd), joint_values(tree, qdd))
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
