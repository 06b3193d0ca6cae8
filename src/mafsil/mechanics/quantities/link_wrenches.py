"""Wrenches between neighbouring links: what every joint, moving or fixed, has to transmit.

The wrench F_l is what the link before (for the first link: the ground) exerts on link l. Along a joint's own motion it
is the joint's effort less the armature's share, tau = S . F + armature qdd; the five other components are borne by
bearings and structure.

Reference: Lynch & Park, Modern Robotics, sec. 8.3.1.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.mechanics.body_tree import Attachment, BodyTree
from mafsil.mechanics.composite_motion import CompositeInertia
from mafsil.mechanics.placement import Expression, placements
from mafsil.mechanics.quantities.link_motion import BodyMotion, com_frames_of, outward_motion
from mafsil.mechanics.quantity import LYNCH, Quantity, SecondMethod, States
from mafsil.mechanics.textbook import Textbook, adjoint
from mafsil.mechanics.twist_chain import link_com_frames
from mafsil.mechanics.wrench import Wrench, transmitted_wrenches


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
    transmitted = _transmit(tree, q, qd, qdd, F_tip, base_twist, base_acceleration)
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
    transmitted = _transmit(tree, q, qd, qdd, F_tip, base_twist, base_acceleration)
    return _in_frames(link_com_frames(tree), transmitted)


def _transmit(
    tree: BodyTree,
    q: Expression,
    qd: Expression,
    qdd: Expression,
    F_tip: Expression | None,
    base_twist: Expression | None,
    base_acceleration: Expression | None,
) -> list[Wrench]:
    """F_l of all links, at the origin of the body's frame {i} and in its axes."""
    steps = placements(tree, q)
    motion = outward_motion(tree, steps, qd, qdd, base_twist, base_acceleration, fall=tree.gravity)
    frames = list(tree.frames.values())
    needs = [_own(tree, k, frame, motion) for k, frame in enumerate(frames)]
    if F_tip is not None:
        k = list(tree.frames).index(tree.tip_link)
        needs[k] = needs[k] + Wrench.at(tree.tip, F_tip)
    parents = [link.parent for link in tree.links]

    def passed_on(k: int, F: Wrench) -> Wrench:
        body = frames[k].body
        return F if frames[parents[k]].body == body else F.in_parent(steps[body])

    return transmitted_wrenches(parents, needs, passed_on)


def _own(tree: BodyTree, k: int, frame: Attachment, motion: BodyMotion) -> Wrench:
    """The wrench that link k's own motion and weight need, at the origin of its body's frame."""
    inertia, i = tree.links[k].inertia.in_frame(frame.R, frame.p), frame.body
    return Wrench.of_motion(CompositeInertia.of(inertia), motion.omega[i], motion.alpha[i], motion.a[i], motion.spin[i])


def _in_frames(frames: Sequence[Attachment], F: Sequence[Wrench]) -> Expression:
    """Rows (6,) of the wrenches, each seen from the frame attached to its body."""
    return ex.vertcat(*(wrench.seen_from(frame).T for frame, wrench in zip(frames, F, strict=True)))


def _by_recursion(book: Textbook, s: States) -> Floats:
    """The recursion in matrices, link by link."""
    return book.newton_euler(s.q, s.qd, s.qdd, s.tip_wrench, s.base_twist, s.base_acceleration).F


def _at_com(book: Textbook, s: States) -> Floats:
    return np.einsum("lji,blj->bli", adjoint(com_frames_of(book)), _by_recursion(book, s))


LINK_WRENCHES = Quantity(
    name="link_wrenches",
    symbol="F_l",
    title="Wrenches that each link gets from the one before (the first from the ground), through any joint.",
    builder=link_wrenches,
    inputs=("q", "qd", "qdd"),
    optional=("tip_wrench", "base_twist", "base_acceleration"),
    shape=("L", 6),
    unit="N m, N",
    expressed_in="the links' frames",
    reference=LYNCH + "eq. 8.53",
    size=lambda arm: arm.wrench,
    second=SecondMethod("verification.newton_euler", _by_recursion),
    regrouped=False,
    needs_mass=True,
)

COM_WRENCHES = Quantity(
    name="com_wrenches",
    symbol="F_i",
    title="Wrenches as `link_wrenches`, at the centres of mass, in axes parallel to {s} at zero coordinates.",
    builder=com_wrenches,
    inputs=("q", "qd", "qdd"),
    optional=("tip_wrench", "base_twist", "base_acceleration"),
    shape=("L", 6),
    unit="N m, N",
    expressed_in="frames at the centres of mass",
    reference=LYNCH + "eq. 8.53",
    size=lambda arm: arm.wrench,
    second=SecondMethod("verification.newton_euler", _at_com),
    regrouped=False,
    needs_mass=True,
)
