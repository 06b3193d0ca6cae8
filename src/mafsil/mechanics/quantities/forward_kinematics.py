"""Poses of links and tip for given joint coordinates."""

from __future__ import annotations

import mafsil.expression as ex
from mafsil.mechanics.body_tree import Attachment, BodyTree
from mafsil.mechanics.placement import Expression, attached_frame, constant, placements, poses_inward, world_placements
from mafsil.mechanics.quantity import LYNCH, Beside, Quantity, SecondMethod


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
