"""The same linkage drawn elsewhere: at other coordinates, with joints locked, merged or split."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, frozen
from mafsil.errors import ModelError
from mafsil.mobility.linkages.linkage import Linkage, on_linkage
from mafsil.mobility.linkages.linkage_joint import Kind, LinkageJoint
from mafsil.mobility.linkages.loop_closure import body_poses, configuration, largest_gap, loop_state
from mafsil.mobility.spaces.motion_group import span
from mafsil.mobility.tolerances import AS_DRAWN, RANK


@on_linkage
def draw_at(linkage: Linkage, theta: ArrayLike) -> Linkage:
    """The linkage drawn where coordinates take it: coordinates of the result count from there.

    Spherical and floating joints get new axes there, so that their coordinates are never singular where they are drawn.

    Args:
        linkage: as drawn.
        theta: (F,) coordinates that close all loops [rad | m].

    Raises:
        ModelError: the loops gape there; the sentence has the gap.
    """
    linkage.require_all_joints()
    value = configuration(linkage, theta)
    gap = float(largest_gap(linkage, value))
    if gap > AS_DRAWN:
        raise ModelError("mobility.gapes", name=linkage.name or "-", gap=gap)
    T = body_poses(linkage, value)
    screws = loop_state(linkage, value).screws
    index = {body: k for k, body in enumerate(linkage.bodies)}
    joints: list[LinkageJoint] = []
    first = 0
    for each in linkage.joints:
        T_child = T[index[each.child]]
        if each.name in linkage.apart:
            T_child = T_child @ np.linalg.inv(linkage.apart[each.name])
        joints.append(_move(each, T[index[each.parent]], T_child, screws[:, first:], value[first:]))
        first += each.freedoms
    couplings = tuple(
        each.counted_from(float(value[linkage.columns_of([each.leader])[0]])) for each in linkage.couplings
    )
    return replace(linkage, joints=tuple(joints), apart={}, couplings=couplings)


def _move(each: LinkageJoint, T_parent: Floats, T_child: Floats, screws: Floats, theta: Floats) -> LinkageJoint:
    point = T_child[:3, :3] @ each.point + T_child[:3, 3]
    axis, second = T_parent[:3, :3] @ each.axis, T_parent[:3, :3] @ each.second
    if each.kind is Kind.UNIVERSAL:
        second = screws[:3, 1]
    shift = float(theta[0]) if each.freedoms == 1 else 0.0
    return replace(
        each, point=frozen(point), axis=frozen(axis / np.linalg.norm(axis)),
        second=frozen(second / np.linalg.norm(second)), lower=each.lower - shift, upper=each.upper - shift,
        child_point=None,
    )  # fmt: skip


@on_linkage
def lock_joints(linkage: Linkage, names: Iterable[str]) -> Linkage:
    """The linkage with joints locked where they are drawn; their bodies become one, named after the first of them.

    Args:
        linkage: as drawn.
        names: of the joints.

    Raises:
        ModelError: no such joint, or nothing is left to move.
    """
    linkage.require_all_joints()
    off = set(linkage.index_of(names))
    return without(linkage, off)


def without(linkage: Linkage, fixed: set[int]) -> Linkage:
    """The linkage whose joints of these indices hold their two bodies together."""
    require_together(linkage)
    fixed = _with_coupled(linkage, fixed)
    into: list[int] = list(range(len(linkage.bodies)))
    for k in fixed:
        a, b = sorted(into[int(end)] for end in linkage.ends[k])
        into = [a if body == b else body for body in into]
    kept = [
        replace(each, parent=linkage.bodies[into[a]], child=linkage.bodies[into[b]])
        for k, (each, (a, b)) in enumerate(zip(linkage.joints, linkage.ends.tolist(), strict=True))
        if k not in fixed and into[a] != into[b]
    ]
    if not kept:
        raise ModelError("mobility.all_locked", name=linkage.name or "-")
    bodies = tuple(body for k, body in enumerate(linkage.bodies) if into[k] == k)
    output = linkage.bodies[into[linkage.bodies.index(linkage.output)]]
    names = {each.name for each in kept}
    couplings = tuple(each for each in linkage.couplings if {each.follower, each.leader} <= names)
    return replace(linkage, bodies=bodies, joints=tuple(kept), output=output, couplings=couplings)


def _with_coupled(linkage: Linkage, fixed: set[int]) -> set[int]:
    """Locked joints with all that couplings lock beside them."""
    pairs = [set(linkage.index_of([each.follower, each.leader])) for each in linkage.couplings]
    while more := [pair for pair in pairs if pair & fixed and not pair <= fixed]:
        fixed = fixed.union(*more)
    return fixed


@on_linkage
def split_joints(linkage: Linkage) -> Linkage:
    """The linkage with every joint of several freedoms as a chain of joints of one, with massless bodies between.

    The count of freedoms and the mobility stay the same.

    Raises:
        ModelError: it is drawn apart.
    """
    linkage.require_all_joints()
    require_together(linkage)
    joints: list[LinkageJoint] = []
    for each in linkage.joints:
        names = [each.parent, *(f"{each.name}.{k + 1}" for k in range(each.freedoms - 1)), each.child]
        if each.freedoms <= 1:
            joints.append(each)
            continue
        for k, screw in enumerate(each.screws.T):
            turns = bool(np.abs(screw[:3]).max() > 0)
            kind = Kind.REVOLUTE if turns else Kind.PRISMATIC
            axis = screw[:3] if turns else screw[3:]
            joints.append(
                LinkageJoint(
                    f"{each.name}.{k + 1}", kind, names[k], names[k + 1], each.point, frozen(axis),
                    actuated=each.actuated, lower=each.lower, upper=each.upper,
                )
            )  # fmt: skip
    bodies = dict.fromkeys([*linkage.bodies, *(end for each in joints for end in (each.parent, each.child))])
    return replace(linkage, bodies=tuple(bodies), joints=tuple(joints))


def require_together(linkage: Linkage) -> None:
    """Refuse a linkage whose links are drawn apart.

    Raises:
        ModelError: the sentence says how to draw it together.
    """
    if linkage.apart:
        raise ModelError("mobility.apart", name=linkage.name or "-", joints=", ".join(linkage.apart))


def common_freedoms(first: LinkageJoint, second: LinkageJoint) -> Floats:
    """(6, k) twists that two joints between the same two bodies both allow: the intersection of their spans.

    Coaxial hinges share one rotation; hinges that are a little out of line share nothing.
    """
    A, B = span(first.screws), span(second.screws)
    if not A.shape[1] or not B.shape[1]:
        return np.zeros((6, 0))
    _, s, Vt = np.linalg.svd(np.hstack([A, -B]))
    rank = int((s > RANK * float(s[0])).sum())
    return span(A @ Vt[rank:, : A.shape[1]].T)
