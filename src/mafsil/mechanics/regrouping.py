"""Inertia that a joint cannot feel moves to the parent body, where it is felt the same: fewer numbers, equal motion.

For a revolute joint about z these are the mass, the first moment along z and Iyy (taken from Ixx too); for a prismatic
one the whole rotational inertia. The moved part dG satisfies dG S = 0 and does not change under the joint's motion, so
joint efforts, mass matrix and accelerations stay as they were; link wrenches do not.

Reference: Khalil & Dombre, Modeling, Identification and Control of Robots, sec. 9.4 (base inertial parameters).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mafsil.mechanics.body_tree import BodyTree, RigidInertia
from mafsil.mechanics.tolerances import NEGLIGIBLE_INERTIA, SMALLEST
from mafsil.model import JointKind


def regroup(tree: BodyTree) -> BodyTree:
    """The same tree with the fewest inertial numbers; the base keeps none."""
    bodies = list(tree.bodies)
    for i, _ in reversed(tree.moving):
        kept, passed = _split(bodies[i].kind, bodies[i].inertia)
        parent = bodies[bodies[i].parent]
        bodies[i] = replace(bodies[i], inertia=_without_rounding(kept))
        bodies[bodies[i].parent] = replace(parent, inertia=parent.inertia + passed.in_frame(bodies[i].R, bodies[i].p))
    bodies[0] = replace(bodies[0], inertia=RigidInertia.zero())
    return replace(tree, bodies=tuple(bodies))


def _split(kind: JointKind, inertia: RigidInertia) -> tuple[RigidInertia, RigidInertia]:
    """(what the joint feels, what it does not)."""
    match kind:
        case JointKind.REVOLUTE:
            passed = RigidInertia(
                inertia.mass,
                np.array([0.0, 0.0, inertia.h[2]]),
                np.diag([inertia.I[1, 1], inertia.I[1, 1], 0.0]),
            )
        case JointKind.PRISMATIC:
            passed = RigidInertia(0.0, np.zeros(3), inertia.I)
        case _:
            passed = RigidInertia.zero()
    return RigidInertia(inertia.mass - passed.mass, inertia.h - passed.h, inertia.I - passed.I), passed


def _without_rounding(inertia: RigidInertia) -> RigidInertia:
    """Entries at rounding level against the body's own largest one are zero."""
    scale = max(float(np.abs(inertia.I).max()), SMALLEST)
    return replace(inertia, I=np.where(np.abs(inertia.I) < NEGLIGIBLE_INERTIA * scale, 0.0, inertia.I))
