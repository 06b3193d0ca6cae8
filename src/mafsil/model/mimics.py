"""Mimic joints resolved to joints that own their coordinate: chains composed, circles refused."""

from __future__ import annotations

from dataclasses import dataclass, replace

from mafsil.arrays import frozen
from mafsil.errors import ModelError
from mafsil.model.faults import (
    MIMIC_CHAIN,
    MIMIC_CYCLE,
    MIMIC_ITSELF,
    MIMIC_LEADER_FIXED,
    MIMIC_LEADER_MISSING,
    MIMIC_OVERFLOW,
)
from mafsil.model.joint import Joint, JointKind
from mafsil.model.placement import screw_motion
from mafsil.model.reading import Reading
from mafsil.model.xml_tree import Element


@dataclass(frozen=True, slots=True)
class Declared:
    """A joint as it stands in the file, with its element for later remarks."""

    joint: Joint
    element: Element


def resolve_mimics(reading: Reading, joints: list[Declared]) -> list[Joint]:
    """The joints with every mimic pointing to a joint that owns its coordinate."""
    by_name = {declared.joint.name: declared for declared in joints}
    return [_resolve(reading, declared, by_name) for declared in joints]


def _resolve(reading: Reading, declared: Declared, by_name: dict[str, Declared]) -> Joint:
    joint, mimic = declared.joint, declared.joint.mimic
    if mimic is None:
        return joint
    element = declared.element.first("mimic") or declared.element
    seen, current, steps = {joint.name}, mimic, 0
    while True:
        leader = by_name.get(current.leader)
        if leader is None or current.leader in seen:
            fault = MIMIC_LEADER_MISSING if leader is None else MIMIC_CYCLE if steps else MIMIC_ITSELF
            repair = reading.remove(element, guess=leader is not None)
            reading.report(fault, element, "joint", repair, joint=joint.name, leader=current.leader)
            return replace(joint, mimic=None)
        if leader.joint.mimic is None:
            break
        seen.add(current.leader)
        after = leader.joint.mimic
        try:
            current = current.after(after)
        except ModelError:
            reading.report(MIMIC_OVERFLOW, element, "multiplier", joint=joint.name)
            return replace(joint, mimic=None)
        steps += 1
    if steps:
        reading.report(MIMIC_CHAIN, element, "joint", joint=joint.name, leader=current.leader)
    if leader.joint.kind is JointKind.FIXED:
        reading.report(MIMIC_LEADER_FIXED, element, "joint", joint=joint.name, leader=current.leader)
        return locked_at(joint, current.offset)
    return replace(joint, mimic=current)


def locked_at(joint: Joint, q: float) -> Joint:
    """The joint fixed at a value of its coordinate."""
    T_pj = frozen(joint.T_pj @ screw_motion(joint.screw, q))
    return Joint(joint.name, JointKind.FIXED, joint.parent, joint.child, T_pj)
