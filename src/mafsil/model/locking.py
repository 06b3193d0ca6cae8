"""Chains with some joints held: the joint becomes a fixed one, the others keep their names and order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from mafsil.arrays import frozen
from mafsil.errors import ModelError
from mafsil.model.joint import Joint, JointKind
from mafsil.model.mechanism import Mechanism
from mafsil.model.placement import screw_motion


def locked(mechanism: Mechanism, held: Mapping[str, float]) -> Mechanism:
    """The mechanism with joints held at given coordinates.

    Args:
        mechanism: any.
        held: coordinate [rad | m] by name of the joint.

    Raises:
        ModelError: no such joint, or one that is a mimic or is followed by a mimic.
    """
    known = {joint.name for joint in mechanism.joints if joint.moves}
    leaders = {joint.mimic.leader for joint in mechanism.joints if joint.mimic is not None}
    for name in held:
        if name not in known:
            raise ModelError("dh.lock_unknown", joint=name, known=", ".join(sorted(known)))
        if name in leaders or any(joint.name == name and joint.mimic for joint in mechanism.joints):
            raise ModelError("dh.lock_mimic", joint=name)
    joints = tuple(_held(joint, held[joint.name]) if joint.name in held else joint for joint in mechanism.joints)
    return replace(mechanism, joints=joints)


def _held(joint: Joint, value: float) -> Joint:
    T_pj = frozen(joint.T_pj @ screw_motion(joint.screw, value))
    return replace(joint, kind=JointKind.FIXED, T_pj=T_pj, pitch=0.0)
