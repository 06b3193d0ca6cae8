"""A robot whose base can be put anywhere: three translations and a turn about the vertical come before its joints."""

from __future__ import annotations

import numpy as np

from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import Link
from mafsil.model.mechanism import Mechanism

PLACES = ("x", "y", "z", "yaw")
"""The coordinates of the base, in order [m, m, m, rad]."""


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
