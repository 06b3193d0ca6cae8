"""Tip frame and base pose as massless links behind fixed joints, for formats that know links alone."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import replace

import numpy as np

from mafsil.arrays import frozen
from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import Link
from mafsil.model.losses import Loss, Weight
from mafsil.model.mechanism import Mechanism

TIP_NAMES = ("tip", "tcp")
"""Names of a tip link; the second is one that every choice of a tip prefers."""


Marks = Callable[[Mechanism], Collection[str]]
"""The links that a format writes as named frames, which are tips only by a name of convention."""


def no_marks(_mechanism: Mechanism) -> Collection[str]:
    """Of a format that knows links alone."""
    return ()


def with_tip_link(mechanism: Mechanism, marks: Marks = no_marks) -> Mechanism:
    """The mechanism with its tip frame as the frame of a link, one that readers choose as the tip if that can be.

    Args:
        mechanism: any; itself if its tip is the frame of the link that readers choose.
        marks: of the format.
    """
    is_frame_of_link = np.array_equal(mechanism.T_lt, np.eye(4))
    if is_frame_of_link and chosen_tip(mechanism, marks) == mechanism.tip:
        return mechanism
    free = [_free(mechanism, name) for name in TIP_NAMES]
    candidates = [mechanism.with_frame(name).with_tip(name) for name in free]
    for candidate in candidates:
        if chosen_tip(candidate, marks) == candidate.tip:
            return candidate
    return mechanism if is_frame_of_link else candidates[0]


def with_space_link(mechanism: Mechanism) -> Mechanism:
    """The mechanism on a link that stands in the space frame; itself if its base stands there."""
    if np.array_equal(mechanism.T_sb, np.eye(4)):
        return mechanism
    name = _free(mechanism, "space")
    joint = Joint(f"{name}_joint", JointKind.FIXED, name, mechanism.links[0].name, mechanism.T_sb)
    links, joints = (Link(name), *mechanism.links), (joint, *mechanism.joints)
    return replace(mechanism, links=links, joints=joints, T_sb=frozen(np.eye(4)))


def tip_loss(mechanism: Mechanism, marks: Marks = no_marks) -> Iterator[Loss]:
    """The remark that readers choose another tip than this one."""
    chosen = chosen_tip(mechanism, marks)
    if chosen != mechanism.tip:
        yield Loss("writing.tip", Weight.WARNED, "tip", {"tip": mechanism.tip, "chosen": chosen})


def chosen_tip(mechanism: Mechanism, marks: Marks = no_marks) -> str:
    """The link that a reader of a file takes for the tip."""
    links, joints, loops = mechanism.links, mechanism.joints, mechanism.loops
    return Mechanism.assemble(mechanism.name, links, joints, loops=loops, marks=marks(mechanism)).tip


def _free(mechanism: Mechanism, name: str) -> str:
    """The name, with underscores until nothing else is called so."""
    taken = {*mechanism.link_names, *(joint.name for joint in (*mechanism.joints, *mechanism.loops))}
    while name in taken or f"{name}_joint" in taken:
        name += "_"
    return name
