"""Wrenches between neighbouring links: what every joint, moving or fixed, has to transmit.

The wrench F_l is what the link before (for the first link: the ground) exerts on link l. Along a joint's own motion it
is the joint's effort less the armature's share, tau = S . F + armature qdd; the five other components are borne by
bearings and structure.

Reference: Lynch & Park, Modern Robotics, sec. 8.3.1.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from mafsil.mechanics.body_tree import Attachment, BodyTree
from mafsil.mechanics.com_frames import link_com_frames
from mafsil.mechanics.composite_motion import spin_acceleration
from mafsil.mechanics.link_motion import BodyMotion, true_motion
from mafsil.mechanics.placement import Expression, Placement, constant, placements, world_placements


def link_wrenches(
    tree: BodyTree,
    q: Expression,
    qd: Expression,
    qdd: Expression,
    F_tip: Expression | None = None,
    base_twist: Expression | None = None,
    base_acceleration: Expression | None = None,
) -> Expression:
    """(L, 6) wrench (m, f) that the link before exerts on each link, at the origin and in the axes of its frame.

    Args:
        tree: the bodies with their true inertias.
        q, qd, qdd: (n,) coordinates [rad | m] and time derivatives.
        F_tip: (6,) wrench the tip exerts on the world, in {tip}; None for none.
        base_twist, base_acceleration: (6,) of a carried base, see `base_motion`.

    Reference: Lynch & Park, Modern Robotics, eq. 8.53.
    """
    transmitted = _transmitted(tree, q, qd, qdd, F_tip, base_twist, base_acceleration)
    return _in_frames(list(tree.frames.values()), transmitted)


def com_wrenches(
    tree: BodyTree,
    q: Expression,
    qd: Expression,
    qdd: Expression,
    F_tip: Expression | None = None,
    base_twist: Expression | None = None,
    base_acceleration: Expression | None = None,
) -> Expression:
    """(L, 6) the same wrenches at the centres of mass, in axes parallel to {s} at zero coordinates.

    Arguments as in `link_wrenches`.
    """
    transmitted = _transmitted(tree, q, qd, qdd, F_tip, base_twist, base_acceleration)
    return _in_frames(link_com_frames(tree), transmitted)


def _transmitted(
    tree: BodyTree,
    q: Expression,
    qd: Expression,
    qdd: Expression,
    F_tip: Expression | None,
    base_twist: Expression | None,
    base_acceleration: Expression | None,
) -> list[Expression]:
    """F_l (6,) of all links, at the origin of the body's frame {i} and in its axes."""
    steps = placements(tree, q)
    motion = true_motion(tree, steps, qd, qdd, base_twist, base_acceleration)
    frames, fall = list(tree.frames.values()), _falls(tree, steps)
    F = [_own(tree, k, frames[k], motion, fall[frames[k].body]) for k in range(len(frames))]
    if F_tip is not None:
        k = list(tree.frames).index(tree.tip_link)
        F[k] = F[k] + _shifted(tree.tip, F_tip)
    for k in reversed(range(1, len(frames))):
        parent, body = tree.links[k].parent, frames[k].body
        F[parent] = F[parent] + (F[k] if frames[parent].body == body else _to_parent(steps[body], F[k]))
    return F


def _own(tree: BodyTree, k: int, frame: Attachment, motion: BodyMotion, fall: Expression) -> Expression:
    """The wrench that link k's own motion and weight need, at the origin of its body's frame."""
    inertia, i = tree.links[k].inertia.moved(frame.R, frame.p), frame.body
    U, w = spin_acceleration(motion.omega[i], motion.alpha[i]), motion.omega[i]
    I, h, a = constant(inertia.I), constant(inertia.h), motion.a[i] - fall
    moment = I @ motion.alpha[i] + ca.cross(w, I @ w) + ca.cross(h, a)
    return ca.vertcat(moment, inertia.mass * a + U @ h)


def _falls(tree: BodyTree, steps: Sequence[Placement]) -> list[Expression]:
    """Gravity in the axes of each body."""
    R, _ = world_placements(tree, steps)
    return [turn.T @ constant(tree.gravity) for turn in R]


def _shifted(frame: Attachment, F: Expression) -> Expression:
    R, p = constant(frame.R), constant(frame.p)
    f = R @ F[3:]
    return ca.vertcat(R @ F[:3] + ca.cross(p, f), f)


def _to_parent(step: Placement, F: Expression) -> Expression:
    f = step.to_parent(F[3:])
    return ca.vertcat(step.to_parent(F[:3]) + ca.cross(step.offset, f), f)


def _in_frames(frames: Sequence[Attachment], F: Sequence[Expression]) -> Expression:
    """Rows (6,) of the wrenches, each moved from its body's frame to the frame attached there."""
    rows: list[Expression] = []
    for frame, wrench in zip(frames, F, strict=True):
        R, p = constant(frame.R), constant(frame.p)
        rows.append(ca.vertcat(R.T @ (wrench[:3] - ca.cross(p, wrench[3:])), R.T @ wrench[3:]).T)
    return ca.vertcat(*rows)
