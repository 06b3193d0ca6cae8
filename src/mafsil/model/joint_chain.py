"""A joint of several freedoms in a tree: revolute and prismatic joints in a row, with massless links between them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mafsil.arrays import Floats, frozen
from mafsil.model.joint import Joint, JointKind
from mafsil.model.limits import Limits
from mafsil.model.link import Link

REVOLUTE, PRISMATIC = JointKind.REVOLUTE, JointKind.PRISMATIC
KINDS = {
    JointKind.FIXED: (JointKind.FIXED,),
    JointKind.REVOLUTE: (REVOLUTE,),
    JointKind.PRISMATIC: (PRISMATIC,),
    JointKind.CYLINDRICAL: (PRISMATIC, REVOLUTE),
    JointKind.UNIVERSAL: (REVOLUTE, REVOLUTE),
    JointKind.SPHERICAL: (REVOLUTE, REVOLUTE, REVOLUTE),
}
"""Joints of one freedom for every kind that a tree can have so."""


def joint_chain(joint: Joint, kind: JointKind, axis: Floats, second: Floats) -> tuple[list[Joint], list[Link]]:
    """What stands in place of a joint: joints NAME, NAME/axis2, NAME/axis3, and links NAME/between, NAME/between2.

    They are not driven and have no ranges.

    Args:
        joint: whose frame, parent and child they have.
        kind: of `KINDS`.
        axis: (3,) unit axis in the joint's frame; of a ball joint x, y and z are, in their order.
        second: (3,) of a universal joint.
    """
    kinds, name = KINDS[kind], joint.name
    axes = (
        np.eye(3) if kind is JointKind.SPHERICAL else np.stack([axis, second if kind is JointKind.UNIVERSAL else axis])
    )
    links = [Link(f"{name}/between{'' if k == 0 else k + 1}") for k in range(len(kinds) - 1)]
    ends = [joint.parent, *(link.name for link in links), joint.child]
    joints = [
        replace(
            joint, name=name if k == 0 else f"{name}/axis{k + 1}", kind=one, parent=ends[k], child=ends[k + 1],
            T_pj=joint.T_pj if k == 0 else frozen(np.eye(4)), axis=frozen(axes[k] if one.freedoms else joint.axis),
            limits=Limits(), wraps=one is REVOLUTE, actuated=False, mimic=None, friction=None,
        )
        for k, one in enumerate(kinds)
    ]  # fmt: skip
    return joints, links
