"""Closed chains as expressions: the tree's mass matrix and bias forces, and what each loop asks of its coordinates.

The joint that closes a loop leads from its frame {p} on the parent to that of its child {c}; the body twist of {c}
against {p} is V = J_c qd - Ad(T_cp) J_p qd. Rows B select what the joint does not allow: B V = 0, and by time

    B (J_c - Ad(T_cp) J_p) qdd + gamma = 0.

A joint is the list of its forbidden directions, rotations first: all three, the two across its axis, the one across
both axes of a universal joint, none. Only the row of a universal joint moves in {c}: (R_cp a) x s, with the axes a on
the parent and s on the child.

Reference: Featherstone, Rigid Body Dynamics Algorithms, ch. 8.

How one body moves against another: screws of the joints between them, seen from a frame of the first.

Only the joints between count: what both bodies have in common towards the base moves neither against the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.mechanics.body_tree import Attachment, BodyTree, lump_bodies
from mafsil.mechanics.frame_choice import in_chosen_frames, regroup
from mafsil.mechanics.placement import (
    Expression,
    Placement,
    attached_frame,
    constant,
    placements,
    pose_outward,
    world_placements,
)
from mafsil.mechanics.quantities.energy import kinetic_energy, potential_energy
from mafsil.mechanics.quantities.forward_dynamics import mass_matrix
from mafsil.mechanics.quantities.inverse_dynamics import inverse_dynamics
from mafsil.mechanics.quantities.kinematics import joint_screw
from mafsil.mechanics.quantities.link_motion import BodyMotion, outward_motion
from mafsil.model import Joint, JointKind, Mechanism


def rows_of(joint: Joint) -> int:
    """How many motions a joint that closes a loop forbids."""
    return 6 - joint.kind.freedoms


def function(mechanism: Mechanism) -> ex.Function:
    """All that the dynamics of a closed chain need of one state, columns in C order.

    Inputs q (n,) and qd (n,). Outputs the mass matrix (n, n), the bias forces (n,) that hold the tree at qdd = 0, the
    rows of the loops (m, n), their bias gamma (m,), their gaps (m,) [rad, m], one number for each loop that is
    positive unless it is closed the wrong way round, and the energy of the tree.

    Args:
        mechanism: with loops.
    """
    full = in_chosen_frames(lump_bodies(mechanism))
    short = regroup(full)
    q, qd = ex.symbol("q", mechanism.n), ex.symbol("qd", mechanism.n)
    asked = loops(full, mechanism.loops, q, qd)
    outputs = [
        ex.vec(mass_matrix(short, q)),
        inverse_dynamics(short, q, qd, ex.zeros(mechanism.n, 1)),
        ex.vec(asked.rows.T),
        asked.bias,
        asked.gap,
        asked.facing,
        kinetic_energy(full, q, qd) + potential_energy(full, q),
    ]
    return ex.Function("closed_chain", [q, qd], ex.cse(outputs))


def errors_function(mechanism: Mechanism) -> ex.Function:
    """What a state leaves of the loops: gaps (m,), facing (loops,), J qd (m,) and J qdd + gamma (m,).

    Inputs q, qd and qdd (n,).

    Args:
        mechanism: with loops.
    """
    q, qd, qdd = (ex.symbol(name, mechanism.n) for name in ("q", "qd", "qdd"))
    asked = loops(in_chosen_frames(lump_bodies(mechanism)), mechanism.loops, q, qd)
    outputs = [asked.gap, asked.facing, asked.rows @ qd, asked.rows @ qdd + asked.bias]
    return ex.Function("loop_errors", [q, qd, qdd], ex.cse(outputs))


@dataclass(frozen=True, eq=False, slots=True)
class Loops:
    """What loops ask: rows (m, n), bias (m,), gap (m,), and how far each faces the right way (loops,)."""

    rows: Expression
    bias: Expression
    gap: Expression
    facing: Expression


def loops(tree: BodyTree, joints: Sequence[Joint], q: Expression, qd: Expression) -> Loops:
    """Rows, bias and gaps of all loops: what `rows` J and `bias` gamma say is J qd = 0 and J qdd + gamma = 0.

    Args:
        tree: the bodies.
        joints: that close the loops.
        q, qd: (n,) coordinates [rad | m] and rates.
    """
    steps = placements(tree, q)
    # Falling does not show between two bodies; so the motion is the one that the bias forces need.
    motion = outward_motion(tree, steps, qd, ex.zeros(tree.n, 1), fall=tree.gravity)
    found = [_loop(tree, steps, motion, joint, qd) for joint in joints]
    return Loops(*(ex.vertcat(*(getattr(each, name) for each in found)) for name in Loops.__slots__))


def gaps(tree: BodyTree, joints: Sequence[Joint], q: Expression) -> tuple[Expression, Expression]:
    """Gaps (m,) and facing (loops,) alone, as in `Loops`.

    Args:
        tree: the bodies.
        joints: that close the loops.
        q: (n,) coordinates [rad | m].
    """
    R, o = world_placements(tree, placements(tree, q))
    found: list[tuple[Expression, Expression]] = []
    for joint in joints:
        R_p, p_p = attached_frame(tree.frames[joint.parent].behind(joint.T_pj), R, o)
        R_c, p_c = attached_frame(tree.frames[joint.child], R, o)
        found.append(_gap(joint, R_c.T @ R_p, R_c.T @ (p_p - p_c)))
    return ex.vertcat(*(gap for gap, _ in found)), ex.vertcat(*(facing for _, facing in found))


def _loop(tree: BodyTree, steps: list[Placement], motion: BodyMotion, joint: Joint, qd: Expression) -> Loops:
    """What one joint that closes a loop asks.

    With w, alpha, a of the points that the two bodies have at the origin of {c}, all seen from {c}:

        gamma = B (alpha_c - alpha_p + w x w_p, a_c - a_p - (w_p + w_c) x v) + dB/dt V,   V = (w, v) of {c} against {p}
    """
    parent, child = tree.frames[joint.parent].behind(joint.T_pj), tree.frames[joint.child]
    apart, P, p_cb = relative_screws(tree, steps, child, parent.body)
    # Where {p} is, seen from {c}.
    R_cp, p_cp = P @ constant(parent.R), p_cb + P @ constant(parent.p)
    C = constant(child.R).T
    w_c, w_p = C @ motion.omega[child.body], P @ motion.omega[parent.body]
    V = ex.vertcat(w_c - w_p, apart[3:, :] @ qd)
    point = -(P.T @ p_cb)
    alpha = C @ motion.alpha[child.body] - P @ motion.alpha[parent.body] + ex.cross(V[:3], w_p)
    a = C @ _acceleration(motion, child.body, constant(child.p)) - P @ _acceleration(motion, parent.body, point)
    B, rate = _rows(joint, R_cp, V)
    bias = B @ ex.vertcat(alpha, a - ex.cross(w_p + w_c, V[3:])) + rate
    return Loops(B @ apart, bias, *_gap(joint, R_cp, p_cp))


def _acceleration(motion: BodyMotion, body: int, point: Expression) -> Expression:
    """(3,) of a point (3,) of a body."""
    return motion.a[body] + motion.spin[body] @ point


def forbidden(joint: Joint) -> Floats:
    """(m, 6) rows B with B V = 0 for the twists V in {c} that a joint allows; a universal one where it is drawn."""
    turns, shifts = _directions(joint)
    B = np.zeros((len(turns) + len(shifts), 6))
    B[: len(turns), :3], B[len(turns) :, 3:] = turns, shifts
    if joint.pitch and joint.kind is JointKind.HELICAL:
        B[-1, :3] = -joint.pitch * joint.axis
    return B


def _directions(joint: Joint) -> tuple[Floats, Floats]:
    """(k, 3) about which and (l, 3) along which a joint does not let its child move."""
    every, across, axis = np.eye(3), np.stack(_across(joint)), joint.axis[None]
    match joint.kind:
        case JointKind.FIXED:
            return every, every
        case JointKind.PRISMATIC:
            return every, across
        case JointKind.REVOLUTE | JointKind.HELICAL:
            return across, np.concatenate([across, axis])
        case JointKind.CYLINDRICAL:
            return across, across
        case JointKind.UNIVERSAL:
            return np.cross(joint.axis, joint.second)[None], every
        case JointKind.SPHERICAL:
            return every[:0], every
        case JointKind.PLANAR:
            return across, axis


def _across(joint: Joint) -> tuple[Floats, Floats]:
    """Two directions that make a right-handed frame with the axis."""
    helper = np.eye(3)[int(np.abs(joint.axis).argmin())]
    first = np.cross(helper, joint.axis)
    first /= np.linalg.norm(first)
    return first, np.cross(joint.axis, first)


def _rows(joint: Joint, R_cp: Expression, V: Expression) -> tuple[Expression, Expression]:
    """B (m, 6) and dB/dt V (m,): only what stands across both axes of a universal joint moves in {c}."""
    drawn = constant(forbidden(joint))
    if joint.kind is not JointKind.UNIVERSAL:
        return drawn, ex.zeros(drawn.shape[0], 1)
    seen, second, omega = R_cp @ constant(joint.axis), constant(joint.second), V[:3]
    first = ex.cross(seen, second)
    rate = ex.dot(ex.cross(ex.cross(seen, omega), second), omega)
    return ex.vertcat(ex.horzcat(first.T, ex.zeros(1, 3)), drawn[1:, :]), ex.vertcat(rate, ex.zeros(3, 1))


def _gap(joint: Joint, R_cp: Expression, p_cp: Expression) -> tuple[Expression, Expression]:
    """How far a loop gapes, with the derivative B V where it is closed, and whether it faces the right way.

    1. `turn` is a vector whose rate, where the loop is closed, is the part of omega that the joint forbids: half of the
       skew part of R_pc, or a' x a with the axis a' = R_cp a of {p} seen from {c}, which moves with -omega x a'.
    2. A child that has moved along the joint by -p_cp shifts by -turn x p_cp more than it should; that is taken away.
    3. The last shift of a helical joint is compared with its angle.
    """
    B = forbidden(joint)
    axis = constant(joint.axis)
    seen = R_cp @ axis
    # 1
    if joint.kind is JointKind.SPHERICAL:
        return constant(B[:, 3:]) @ -p_cp, ex.ones(1)
    if joint.kind is JointKind.UNIVERSAL:
        return ex.vertcat(-ex.dot(constant(joint.second), seen), -p_cp), ex.ones(1)
    if joint.kind in (JointKind.FIXED, JointKind.PRISMATIC):
        skew = (R_cp[1, 2] - R_cp[2, 1], R_cp[2, 0] - R_cp[0, 2], R_cp[0, 1] - R_cp[1, 0])
        turn, facing = ex.vertcat(*skew) / 2, (R_cp[0, 0] + R_cp[1, 1] + R_cp[2, 2] - 1) / 2
    else:
        turn, facing = ex.cross(seen, axis), ex.dot(axis, seen)
    # 2
    slides = joint.kind not in (JointKind.FIXED, JointKind.REVOLUTE)
    shift = -p_cp - ex.cross(turn, p_cp) if slides else -p_cp
    gap = constant(B[:, :3]) @ turn + constant(B[:, 3:]) @ shift
    # 3
    if joint.kind is JointKind.HELICAL:
        first, second = (constant(row) for row in _across(joint))
        angle = ex.atan2(ex.dot(second, R_cp.T @ first), ex.dot(first, R_cp.T @ first))
        gap = ex.vertcat(gap[:-1], gap[-1] - joint.pitch * angle)
    return gap, facing


def relative_screws(
    tree: BodyTree, steps: Sequence[Placement], frame: Attachment, body: int
) -> tuple[Expression, Expression, Expression]:
    """J (6, n) with V = J qd, the twist of an attached frame {c} against a body {b}, in {c}; and R_cb, p_cb.

    1. Inward from {c} to the body that both have in common: a joint there adds its screw.
    2. Outward to {b}: a joint there takes its screw away.

    Args:
        tree: of the bodies.
        steps: pose of each body in its parent.
        frame: {c}.
        body: index of {b}.
    """
    inward, outward = tree.path(frame.body), tree.path(body)
    shared = sum(1 for a, b in zip(inward, outward, strict=False) if a == b)
    columns: list[Expression] = [ex.zeros(6, 1) for _ in range(tree.n)]

    def add(i: int, sign: float, z: Expression, moment: Expression) -> None:
        own = tree.bodies[i]
        columns[own.coordinate] = columns[own.coordinate] + sign * steps[i].slopes[0] * joint_screw(own, z, moment)

    # 1.
    R, p = constant(frame.R), constant(frame.p)
    for i in reversed(inward[shared:]):
        add(i, 1.0, R[2, :].T, R.T @ ex.vertcat(-p[1], p[0], 0))
        R, p = ex.horzcat(*(steps[i].to_parent(R[:, k]) for k in range(3))), steps[i].offset + steps[i].to_parent(p)
    # 2.
    R, p = R.T, -(R.T @ p)
    for i in outward[shared:]:
        R, p = pose_outward(steps[i], R, p)
        add(i, -1.0, R[:, 2], ex.cross(p, R[:, 2]))
    return (ex.horzcat(*columns) if columns else ex.zeros(6, 0)), R, p
