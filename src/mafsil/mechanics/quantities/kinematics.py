"""Kinematics: poses of links and tip for joint coordinates, twists of a frame from joint rates.

Twists come by space and body Jacobians and their time derivatives.
"""

from __future__ import annotations

import mafsil.expression as ex
from mafsil.mechanics.body_tree import Attachment, Body, BodyTree
from mafsil.mechanics.placement import (
    Expression,
    Placement,
    attached_frame,
    constant,
    placements,
    poses_inward,
    world_placements,
)
from mafsil.mechanics.quantity import LYNCH, Beside, Quantity, SecondMethod
from mafsil.mechanics.textbook import along


def forward_kinematics(tree: BodyTree, q: Expression, frame: Attachment) -> Expression:
    """T_sf (4, 4): pose of an attached frame {f} in the space frame {s}.

    T_sf = T_s0 T_01(q_1) ... T_i-1,i(q_i) T_if

    Args:
        tree: the bodies.
        q: (n,) joint coordinates [rad | m].
        frame: where {f} is attached.

    Reference: Lynch & Park, Modern Robotics, sec. 4.1; link frames as in sec. 5.12 of the specification's book.
    """
    R, p = world_placements(tree, placements(tree, q))
    return _in_space(tree, *attached_frame(frame, R, p))


def forward_kinematics_inward(tree: BodyTree, q: Expression, frame: Attachment) -> Expression:
    """T_sf (4, 4) as `forward_kinematics`, multiplied from the frame back to the base: what the body Jacobian needs.

    Args:
        tree: the bodies.
        q: (n,) joint coordinates [rad | m].
        frame: where {f} is attached.
    """
    return _in_space(tree, *poses_inward(tree, placements(tree, q), frame)[0])


def link_poses(tree: BodyTree, q: Expression) -> Expression:
    """(L * 4, 4) poses of all named links in {s}, stacked in the order of `tree.frames`.

    Args:
        tree: the bodies.
        q: (n,) joint coordinates [rad | m].
    """
    R, p = world_placements(tree, placements(tree, q))
    return ex.vertcat(*(_in_space(tree, *attached_frame(frame, R, p)) for frame in tree.frames.values()))


def _in_space(tree: BodyTree, R: Expression, p: Expression) -> Expression:
    R_s0 = constant(tree.R_s0)
    top = ex.horzcat(R_s0 @ R, constant(tree.p_s0) + R_s0 @ p)
    return ex.vertcat(top, ex.Expression([[0, 0, 0, 1]]))


FORWARD_KINEMATICS = Quantity(
    name="forward_kinematics",
    symbol="T_sf",
    title="Pose of the tip frame, or of a named link's frame, in the space frame {s}.",
    builder=forward_kinematics,
    inputs=("q",),
    shape=(4, 4),
    unit="1, m",
    framed=True,
    expressed_in="{s}",
    reference=LYNCH + "sec. 4.1",
    size=lambda arm: arm.pose,
    second=SecondMethod("verification.rodrigues", lambda book, s: book.pose(s.q, s.frame)),
    regrouped=False,
    needs_joints=False,
    beside=Beside(("jacobian_body", "jacobian_body_rate"), forward_kinematics_inward),
)
LINK_POSES = Quantity(
    name="link_poses",
    symbol="T_sl",
    title="Poses of all links in the space frame {s}, in the order of `mechanism.links`.",
    builder=link_poses,
    inputs=("q",),
    shape=("L", 4, 4),
    unit="1, m",
    expressed_in="{s}",
    reference=LYNCH + "sec. 4.1",
    size=lambda arm: arm.pose,
    second=SecondMethod("verification.rodrigues", lambda book, s: book.poses(s.q)),
    regrouped=False,
    needs_joints=False,
)


def jacobian_space(tree: BodyTree, q: Expression, frame: Attachment) -> Expression:
    """J_s (6, n) with V_s = J_s qd: the joint screws where they stand now, in {s}.

    Column of a joint with axis z through p: (w z, p x w z + v z).

    Args:
        tree: the bodies.
        q: (n,) joint coordinates [rad | m].
        frame: the frame whose twist is meant; only joints between it and the base count.

    Reference: Lynch & Park, Modern Robotics, def. 5.1.
    """
    steps = placements(tree, q)
    return _sum(tree, steps, frame, _space_screws(tree, steps, frame))


def jacobian_body(tree: BodyTree, q: Expression, frame: Attachment) -> Expression:
    """J_b (6, n) with V_b = J_b qd: the joint screws seen from the frame {f} itself, J_b = Ad(T_fs) J_s.

    Args:
        tree: the bodies.
        q: (n,) joint coordinates [rad | m].
        frame: where {f} is attached.

    Reference: Lynch & Park, Modern Robotics, def. 5.2.
    """
    steps = placements(tree, q)
    return _sum(tree, steps, frame, _body_screws(tree, steps, frame))


def jacobian_space_rate(tree: BodyTree, q: Expression, qd: Expression, frame: Attachment) -> Expression:
    """dJ_s/dt (6, n): each screw is carried along by the joints before it, dJ_i/dt = [V_before, J_i].

    Args:
        tree: the bodies.
        q, qd: (n,) coordinates [rad | m] and rates.
        frame: as in `jacobian_space`.
    """
    steps = placements(tree, q)
    screws = _space_screws(tree, steps, frame)
    rates: dict[int, Expression] = {}
    twist = ex.zeros(6, 1)
    for i in tree.path(frame.body):
        rates[i] = bracket(twist, screws[i])
        twist = twist + screws[i] * (steps[i].slopes[0] * qd[tree.bodies[i].coordinate])
    return _sum(tree, steps, frame, rates) + _bent(tree, steps, frame, screws, qd)


def jacobian_body_rate(tree: BodyTree, q: Expression, qd: Expression, frame: Attachment) -> Expression:
    """dJ_b/dt (6, n): seen from {f}, each screw moves against the joints behind it, dJ_i/dt = -[V_behind, J_i].

    Args:
        tree: the bodies.
        q, qd: (n,) coordinates [rad | m] and rates.
        frame: as in `jacobian_body`.
    """
    steps = placements(tree, q)
    screws = _body_screws(tree, steps, frame)
    rates: dict[int, Expression] = {}
    twist = ex.zeros(6, 1)
    for i in reversed(tree.path(frame.body)):
        rates[i] = -bracket(twist, screws[i])
        twist = twist + screws[i] * (steps[i].slopes[0] * qd[tree.bodies[i].coordinate])
    return _sum(tree, steps, frame, rates) + _bent(tree, steps, frame, screws, qd)


def bracket(V1: Expression, V2: Expression) -> Expression:
    """Lie bracket [V1, V2] = (w1 x w2, w1 x v2 - w2 x v1) of two twists (6,)."""
    w1, v1, w2, v2 = V1[:3], V1[3:], V2[:3], V2[3:]
    return ex.vertcat(ex.cross(w1, w2), ex.cross(w1, v2) - ex.cross(w2, v1))


def _space_screws(tree: BodyTree, steps: list[Placement], frame: Attachment) -> dict[int, Expression]:
    """Joint screws of the path to `frame`, in {s}, by body index."""
    R, p = world_placements(tree, steps)
    R_s0, p_s0 = constant(tree.R_s0), constant(tree.p_s0)
    screws: dict[int, Expression] = {}
    for i in tree.path(frame.body):
        z, origin = R_s0 @ R[i][:, 2], p_s0 + R_s0 @ p[i]
        screws[i] = joint_screw(tree.bodies[i], z, ex.cross(origin, z))
    return screws


def _body_screws(tree: BodyTree, steps: list[Placement], frame: Attachment) -> dict[int, Expression]:
    """Joint screws of the path to `frame`, in that frame, by body index: built from the frame back to the base."""
    screws: dict[int, Expression] = {}
    for i, (R, r) in poses_inward(tree, steps, frame).items():
        if i:
            screws[i] = joint_screw(tree.bodies[i], R[2, :].T, R.T @ ex.vertcat(-r[1], r[0], 0))
    return screws


def joint_screw(body: Body, z: Expression, moment: Expression) -> Expression:
    """(w z, w moment + v z) for the joint of a body.

    Args:
        body: whose joint it is.
        z, moment: (3,) its axis, and p x z of a point p on it.
    """
    match body.kind.value:
        case "prismatic":
            return ex.vertcat(ex.zeros(3, 1), z)
        case "helical":
            return ex.vertcat(z, moment + body.pitch * z)
        case _:
            return ex.vertcat(z, moment)


def _sum(tree: BodyTree, steps: list[Placement], frame: Attachment, screws: dict[int, Expression]) -> Expression:
    """Columns of the coordinates: joints that follow one coordinate add up; joints beside the path give zero."""
    columns: list[Expression] = [ex.zeros(6, 1) for _ in range(tree.n)]
    for i in tree.path(frame.body):
        body = tree.bodies[i]
        columns[body.coordinate] = columns[body.coordinate] + steps[i].slopes[0] * screws[i]
    return ex.horzcat(*columns) if columns else ex.zeros(6, 0)


def _bent(
    tree: BodyTree, steps: list[Placement], frame: Attachment, screws: dict[int, Expression], qd: Expression
) -> Expression:
    """What the rate of a Jacobian has from joints that follow along a curve p(x): p''(x) xd times their screws."""
    columns: list[Expression] = [ex.zeros(6, 1) for _ in range(tree.n)]
    for i in tree.path(frame.body):
        k = tree.bodies[i].coordinate
        if tree.bodies[i].higher:
            columns[k] = columns[k] + screws[i] * (steps[i].slopes[1] * qd[k])
    return ex.horzcat(*columns) if columns else ex.zeros(6, 0)


JACOBIAN_SPACE = Quantity(
    name="jacobian_space",
    symbol="J_s",
    title="Space Jacobian: V_s = J_s qd, rows (omega, v).",
    builder=jacobian_space,
    inputs=("q",),
    shape=(6, "n"),
    unit="1 | m",
    framed=True,
    expressed_in="{s}",
    reference=LYNCH + "def. 5.1",
    size=lambda arm: arm.twist[:, None] / arm.unit,
    second=SecondMethod("verification.screws", lambda book, s: book.jacobian_space(s.q, s.frame)),
    regrouped=False,
)
JACOBIAN_BODY = Quantity(
    name="jacobian_body",
    symbol="J_b",
    title="Body Jacobian: V_b = J_b qd, rows (omega, v).",
    builder=jacobian_body,
    inputs=("q",),
    shape=(6, "n"),
    unit="1 | m",
    framed=True,
    expressed_in="the frame itself",
    reference=LYNCH + "def. 5.2",
    size=lambda arm: arm.twist[:, None] / arm.unit,
    second=SecondMethod("verification.screws", lambda book, s: book.jacobian_body(s.q, s.frame)),
    regrouped=False,
)
JACOBIAN_SPACE_RATE = Quantity(
    name="jacobian_space_rate",
    symbol="dJ_s/dt",
    title="Time derivative of the space Jacobian: dV_s/dt = J_s qdd + dJ_s/dt qd.",
    builder=jacobian_space_rate,
    inputs=("q", "qd"),
    shape=(6, "n"),
    unit="1/s | m/s",
    framed=True,
    expressed_in="{s}",
    reference=LYNCH + "sec. 8.6",
    size=lambda arm: arm.twist[:, None] / arm.unit,
    second=SecondMethod(
        "verification.complex_step", lambda book, s: along(lambda q: book.jacobian_space(q, s.frame), s.q, s.qd)
    ),
    regrouped=False,
)
JACOBIAN_BODY_RATE = Quantity(
    name="jacobian_body_rate",
    symbol="dJ_b/dt",
    title="Time derivative of the body Jacobian: dV_b/dt = J_b qdd + dJ_b/dt qd.",
    builder=jacobian_body_rate,
    inputs=("q", "qd"),
    shape=(6, "n"),
    unit="1/s | m/s",
    framed=True,
    expressed_in="the frame itself",
    reference=LYNCH + "sec. 8.6",
    size=lambda arm: arm.twist[:, None] / arm.unit,
    second=SecondMethod(
        "verification.complex_step", lambda book, s: along(lambda q: book.jacobian_body(q, s.frame), s.q, s.qd)
    ),
    regrouped=False,
)
