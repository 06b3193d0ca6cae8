"""Poses of links and tip for given joint coordinates."""

from __future__ import annotations

import mafsil.expression as ex
from mafsil.mechanics.body_tree import Attachment, BodyTree
from mafsil.mechanics.placement import Expression, attached, constant, placements, poses_inward, world_placements


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
    return _in_space(tree, *attached(frame, R, p))


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
    return ex.vertcat(*(_in_space(tree, *attached(frame, R, p)) for frame in tree.frames.values()))


def _in_space(tree: BodyTree, R: Expression, p: Expression) -> Expression:
    R_s0 = constant(tree.R_s0)
    top = ex.horzcat(R_s0 @ R, constant(tree.p_s0) + R_s0 @ p)
    return ex.vertcat(top, ex.Expression([[0, 0, 0, 1]]))
