"""Equality constraints and actuators of MJCF: mimic joints, loops, gears, effort limits."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np

from mafsil.arrays import frozen
from mafsil.model.actuator import Actuator
from mafsil.model.faults import (
    COUPLING_NOT_LINEAR,
    NOT_KEPT,
    POINT_LOOP,
    UNKNOWN_BODY,
    UNKNOWN_JOINT,
    UNSUPPORTED,
)
from mafsil.model.joint import Joint, JointKind, Mimic
from mafsil.model.mimics import Declared, held_at
from mafsil.model.mjcf.body import WORLD, Tree
from mafsil.model.mjcf.joint import is_limited
from mafsil.model.mjcf.orientation import rotation_from_quaternion
from mafsil.model.mjcf.settings import ACTUATORS, Settings
from mafsil.model.placement import inverse
from mafsil.model.reading import Reading
from mafsil.model.xml_tree import Element


def read_couplings(
    reading: Reading, root: Element, settings: Settings, tree: Tree
) -> tuple[list[Declared], list[Joint]]:
    """The joints of the tree with their couplings, and the joints that close loops."""
    joints = {joint.name: Declared(joint, tree.elements.get(joint.name, root)) for joint in tree.joints}
    loops: list[Joint] = []
    for section in root.all("equality"):
        for child in section.children:
            element = settings.styled(reading, child, "")
            if element.get("active", "true") == "false":
                continue
            if element.tag == "joint":
                _couple(reading, element, tree, joints)
            elif element.tag == "weld":
                loops += _weld(reading, element, tree, len(loops))
            elif element.tag == "connect":
                reading.report(POINT_LOOP, element, None, reading.remove(element))
            else:
                reading.report(UNSUPPORTED, element, None, reading.remove(element), element=element.tag)
    return list(joints.values()), loops


def _couple(reading: Reading, element: Element, tree: Tree, joints: dict[str, Declared]) -> None:
    """joint1 - ref1 = a0 + a1 (joint2 - ref2): a mimic; without joint2 the joint is held."""
    follower = reading.reference(element, "joint1")
    leader = element.get("joint2")
    for name in (follower, leader):
        if name and name not in tree.elements:
            reading.report(UNKNOWN_JOINT, element, None, reading.remove(element), joint=name)
            return
    count = min(len(element.get("polycoef", "0 1 0 0 0").split()), 5)
    coefficients = reading.vector(element, "polycoef", count, (0.0, 1.0))
    if not follower or not coefficients:
        return
    a0, a1, *higher = (*coefficients, *(0.0, 1.0)[len(coefficients) :])
    if any(higher) and leader:
        reading.report(COUPLING_NOT_LINEAR, element, "polycoef", joint=follower, text=element.get("polycoef"))
        return
    declared = joints[follower]
    if not leader:
        held = held_at(declared.joint, tree.references[follower] + a0)
        joints[follower] = Declared(held, element)
        return
    offset = tree.references[follower] + a0 - a1 * tree.references[leader]
    joints[follower] = Declared(replace(declared.joint, mimic=Mimic(leader, a1, offset)), element)


def _weld(reading: Reading, element: Element, tree: Tree, number: int) -> list[Joint]:
    """A loop closed by a fixed joint."""
    first, second = reading.reference(element, "body1"), element.get("body2", WORLD)
    for name in (first, second):
        if name not in tree.poses:
            reading.report(UNKNOWN_BODY, element, None, reading.remove(element), body=name)
            return []
    T = inverse(tree.poses[first]) @ tree.poses[second]
    numbers = reading.vector(element, "relpose", 7) if "relpose" in element.attributes else None
    if numbers is not None and any(numbers[3:]):
        quaternion = np.array(numbers[3:])
        T = np.eye(4)
        T[:3, :3] = rotation_from_quaternion(quaternion / np.linalg.norm(quaternion))
        T[:3, 3] = numbers[:3]
    name = element.get("name") or f"weld_{number + 1}"
    return [Joint(name, JointKind.FIXED, first, second, frozen(T), actuated=False)]


def read_actuators(reading: Reading, root: Element, settings: Settings, joints: list[Joint]) -> list[Joint]:
    """The joints with gears and effort limits; where there are actuators, joints without one are passive."""
    known = {joint.name: joint for joint in joints}
    tendons = {tendon.get("name"): tendon for section in root.all("tendon") for tendon in section.children}
    driven: set[str] = set()
    for section in root.all("actuator"):
        for child in section.children:
            if child.tag not in ACTUATORS:
                reading.report(NOT_KEPT, child, element="actuator", what=child.tag)
                continue
            element = settings.styled(reading, child, "")
            if "tendon" in element.attributes and element.get("tendon") in tendons:
                driven.update(part.get("joint") for part in tendons[element.get("tendon")].all("joint"))
                reading.report(NOT_KEPT, child, "tendon", element=child.tag, what="tendon")
                continue
            name = element.get("joint") or element.get("jointinparent")
            if not name:
                reading.report(NOT_KEPT, child, element="actuator", what=child.tag)
            elif name not in known:
                reading.report(UNKNOWN_JOINT, child, None, reading.remove(child), joint=name)
            elif name not in driven:
                driven.add(name)
                known[name] = _driven(reading, element, known[name], settings)
    if not driven:
        return joints
    return [_passive(known[joint.name], driven) for joint in joints]


def _driven(reading: Reading, element: Element, joint: Joint, settings: Settings) -> Joint:
    """A joint with the gear and the effort limit of its actuator."""
    words = element.get("gear", "1").split()
    gears = reading.vector(element, "gear", len(words), (1.0,)) if 1 <= len(words) <= 6 else None
    gear = gears[0] if gears else 1.0
    effort = _largest(reading, element, "forcelimited", "forcerange", settings)
    if element.tag == "motor":
        effort = min(effort, _largest(reading, element, "ctrllimited", "ctrlrange", settings))
    effort = min(joint.limits.effort, effort * abs(gear) if gear else inf)
    armature = 0.0 if joint.actuator is None else joint.actuator.armature
    actuator = Actuator(gear_ratio=gear or 1.0, armature=armature)
    return replace(joint, actuator=actuator, limits=replace(joint.limits, effort=effort or inf))


def _largest(reading: Reading, element: Element, flag: str, attribute: str, settings: Settings) -> float:
    """The larger end of a range, or infinity where it does not hold."""
    if not is_limited(reading, element, flag, attribute, settings):
        return inf
    ends = reading.vector(element, attribute, 2)
    return inf if ends is None else max(abs(ends[0]), abs(ends[1]))


def _passive(joint: Joint, driven: set[str]) -> Joint:
    return replace(joint, actuated=joint.name in driven) if joint.moves and joint.mimic is None else joint
