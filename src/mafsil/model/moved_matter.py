"""Which joints move matter of their own: links fixed behind them that a rate of this joint alone gives energy."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, Vector6
from mafsil.model.link import Inertial
from mafsil.model.mechanism import Mechanism

NOTHING = 1e-12
"""Share of the energy of a rotation about any axis there below which it is rounding."""


def joints_that_move_matter(mechanism: Mechanism) -> frozenset[str]:
    """Names of the moving joints whose own rate moves mass or rotational inertia between them and the next joints.

    Where all do, the mass matrix is positive definite everywhere: the first joint that moves gives energy.

    Args:
        mechanism: any; motors count too.
    """
    bodies = {link.name: link.inertial for link in mechanism.links}
    found: set[str] = set()
    carrier: dict[str, tuple[int, Floats]] = {}
    for k, joint in enumerate(mechanism.joints):
        if joint.moves:
            carrier[joint.child] = (k, np.eye(4))
        elif joint.parent in carrier:
            first, T = carrier[joint.parent]
            carrier[joint.child] = (first, T @ joint.T_pj)
        if joint.moves and joint.actuator is not None and joint.actuator.reflected_inertia > 0:
            found.add(joint.name)
        body = bodies[joint.child]
        if joint.child in carrier and body is not None:
            first, T = carrier[joint.child]
            if _moves(mechanism.joints[first].screw, body, T):
                found.add(mechanism.joints[first].name)
    return frozenset(found)


def _moves(screw: Vector6, body: Inertial, T: Floats) -> bool:
    """Whether a twist (omega, v) gives a body energy; T is the pose of the body's link where the twist is written."""
    omega, v = np.asarray(screw[:3]), np.asarray(screw[3:])
    com = T[:3, :3] @ body.com + T[:3, 3]
    speed, rate = v + np.cross(omega, com), T[:3, :3].T @ omega
    most = body.mass * (v @ v + omega @ omega * (com @ com)) + omega @ omega * np.trace(body.inertia)
    return bool(body.mass * speed @ speed + rate @ body.inertia @ rate > NOTHING * most)
