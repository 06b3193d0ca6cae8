"""Several robots as one: each on its base pose, links and joints named after it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from mafsil.arrays import PoseMatrix
from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import Link
from mafsil.model.mechanism import Mechanism

WORLD = "world"
"""The link that carries all bases; its frame is {s}."""


def mounted_together(arms: Sequence[tuple[str, Mechanism, PoseMatrix]]) -> Mechanism:
    """One mechanism of several: a coordinate vector of all their coordinates, arm after arm.

    1. The first link is the space frame; each base hangs on it by a fixed joint.
    2. Link k of an arm is called "arm/link" and stands at 1 + links of the arms before + k; joints likewise.

    Args:
        arms: name, mechanism, and pose (4, 4) of its base link in {s}; the names differ.
    """
    links, joints, loops = [Link(WORLD)], list[Joint](), list[Joint]()
    for name, mechanism, T_sb in arms:
        links += [replace(link, name=_named(name, link.name)) for link in mechanism.links]
        base = _named(name, mechanism.links[0].name)
        joints.append(Joint(_named(name, "mount"), JointKind.FIXED, WORLD, base, T_sb))  # 1
        joints += [_renamed(name, joint) for joint in mechanism.joints]  # 2
        loops += [_renamed(name, joint) for joint in mechanism.loops]
    first, mechanism, _ = arms[0]
    return Mechanism.assemble(
        " + ".join(name for name, _, _ in arms), links, joints, loops=loops, tip=_named(first, mechanism.tip),
        T_lt=mechanism.T_lt, gravity=mechanism.gravity,
    )  # fmt: skip


def _named(arm: str, name: str) -> str:
    return f"{arm}/{name}"


def _renamed(arm: str, joint: Joint) -> Joint:
    mimic = None if joint.mimic is None else replace(joint.mimic, leader=_named(arm, joint.mimic.leader))
    ends = {"parent": _named(arm, joint.parent), "child": _named(arm, joint.child)}
    return replace(joint, name=_named(arm, joint.name), mimic=mimic, **ends)
