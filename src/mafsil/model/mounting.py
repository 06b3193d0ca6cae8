"""Several robots as one: each on its base pose, links and joints named after it.

A robot whose base can be put anywhere: three translations and a turn about the vertical come before its joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mafsil.arrays import PoseMatrix
from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import Link
from mafsil.model.mechanism import Mechanism

PLACES = ("x", "y", "z", "yaw")
"""The coordinates of the base, in order [m, m, m, rad]."""
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
        links += [replace(link, name=_name(name, link.name)) for link in mechanism.links]
        base = _name(name, mechanism.links[0].name)
        joints.append(Joint(_name(name, "mount"), JointKind.FIXED, WORLD, base, T_sb))  # 1
        joints += [_rename(name, joint) for joint in mechanism.joints]  # 2
        loops += [_rename(name, joint) for joint in mechanism.loops]
    first, mechanism, _ = arms[0]
    return Mechanism.assemble(
        " + ".join(name for name, _, _ in arms), links, joints, loops=loops, tip=_name(first, mechanism.tip),
        T_lt=mechanism.T_lt, gravity=mechanism.gravity,
    )  # fmt: skip


def _name(arm: str, name: str) -> str:
    return f"{arm}/{name}"


def _rename(arm: str, joint: Joint) -> Joint:
    mimic = None if joint.mimic is None else replace(joint.mimic, leader=_name(arm, joint.mimic.leader))
    ends = {"parent": _name(arm, joint.parent), "child": _name(arm, joint.child)}
    return replace(joint, name=_name(arm, joint.name), mimic=mimic, **ends)


def on_movable_base(mechanism: Mechanism) -> Mechanism:
    """The mechanism with coordinates (x, y, z, yaw) of its base in {s} before its own.

    Link k of the mechanism becomes link 4 + k; names stay, those of the base are "base pose/x" and so on.

    Args:
        mechanism: any; its own base pose does not count.
    """
    names = [f"base pose/{name}" for name in ("ground", *PLACES[:3])]
    base = mechanism.links[0].name
    axes = np.eye(3)
    sliding = [
        Joint(f"base pose/move {PLACES[k]}", JointKind.PRISMATIC, names[k], names[k + 1], axis=axes[k])
        for k in range(3)
    ]
    yaw_joint = Joint("base pose/turn", JointKind.REVOLUTE, names[3], base, axis=axes[2], wraps=True)
    return Mechanism.assemble(
        mechanism.name, (*(Link(name) for name in names), *mechanism.links), (*sliding, yaw_joint, *mechanism.joints),
        loops=mechanism.loops, tip=mechanism.tip, T_lt=mechanism.T_lt, gravity=mechanism.gravity,
    )  # fmt: skip
