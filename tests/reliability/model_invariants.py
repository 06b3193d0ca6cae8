"""What every mechanism that a reader accepts must satisfy."""

from __future__ import annotations

import numpy as np

from mafsil.model import Joint, Mechanism


def violations(mechanism: Mechanism) -> list[str]:
    """Broken invariants, as words; empty for a sound mechanism."""
    found = [f"joint {joint.name!r}: {word}" for joint in mechanism.joints for word in _of_joint(joint)]
    names, joints = mechanism.link_names, [joint.name for joint in mechanism.joints]
    if len(set(names)) < len(names) or len(set(joints)) < len(joints):
        found.append("a name stands twice")
    if any(joint.child != link.name for joint, link in zip(mechanism.joints, mechanism.links[1:], strict=True)):
        found.append("joints and links are not in order")
    if any(parent > k for k, parent in enumerate(mechanism.parents)):
        found.append("a parent stands after its child")
    for link in mechanism.links:
        if link.inertial is not None:
            numbers = (link.inertial.mass, *link.inertial.com, *link.inertial.inertia.flat)
            if not np.isfinite(numbers).all() or link.inertial.mass < 0.0:
                found.append(f"link {link.name!r}: mass properties")
            if not np.array_equal(link.inertial.inertia, link.inertial.inertia.T):
                found.append(f"link {link.name!r}: inertia not symmetric")
        for shape in (*link.visuals, *link.collisions):
            if not _is_pose(shape.T_lg):
                found.append(f"link {link.name!r}: pose of a shape")
    return found


def _of_joint(joint: Joint) -> list[str]:
    found = []
    if not _is_pose(joint.T_pj):
        found.append("pose")
    if joint.moves and not abs(np.linalg.norm(joint.axis) - 1.0) < 1e-14:
        found.append("axis")
    limits = joint.limits
    if not limits.lower <= limits.upper or not min(limits.velocity, limits.effort) > 0.0:
        found.append("limits")
    if joint.mimic is not None and not np.isfinite([joint.mimic.multiplier, joint.mimic.offset]).all():
        found.append("mimic")
    if joint.friction is not None and not 0.0 <= min(joint.friction.viscous, joint.friction.coulomb) < np.inf:
        found.append("friction")
    return found


def _is_pose(T: np.ndarray) -> bool:
    R = T[:3, :3]
    return bool(np.isfinite(T).all() and np.abs(R @ R.T - np.eye(3)).max() < 1e-14 and np.linalg.det(R) > 0.0)
