"""Equality constraints of MJCF: mimic joints, welds as loops; loops that a mechanism cannot hold are said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mafsil.arrays import frozen
from mafsil.model.faults import COUPLING_NOT_LINEAR, LOOP_OPEN, MISSING_ATTRIBUTE
from mafsil.model.joint import Joint, JointKind, Mimic
from mafsil.model.mimics import Declared, locked_at
from mafsil.model.mjcf.orientation import rotation_from_quaternion
from mafsil.model.mjcf.references import References
from mafsil.model.mjcf.scope import Scope
from mafsil.model.placement import inverse
from mafsil.model.xml_tree import Element


def read_couplings(references: References, root: Element) -> tuple[list[Declared], list[Joint]]:
    """The joints of the tree with their couplings, and the joints that close loops.

    1. Every joint of the tree stands for itself.
    2. Constraints that are switched off, one by one or all, are passed over.
    3. A `joint` constraint makes one joint follow another or locks it, a `weld` closes a loop, a `connect` is reported.
    """
    # 1.
    tree = references.tree
    joints = {joint.name: Declared(joint, tree.elements.get(joint.name, root)) for joint in tree.joints}
    loops: list[Joint] = []
    for child, scope in references.sections("equality"):
        settings = scope.library.settings
        element = settings.styled(references.reading, child, "", "equality")
        # 2.
        if element.get("active", "true") == "false" or "equality" in settings.off:
            continue
        # 3.
        if element.tag == "joint":
            _couple(references, element, scope, joints)
        elif element.tag == "weld":
            loops += _weld(references, element, scope, len(loops))
        elif element.tag == "connect":
            _open(references, element, scope)
    return list(joints.values()), loops


def _couple(references: References, element: Element, scope: Scope, joints: dict[str, Declared]) -> None:
    """joint1 - ref1 = a0 + a1 (joint2 - ref2): a mimic; without joint2 the joint is locked."""
    reading, tree = references.reading, references.tree
    if not reading.reference(element, "joint1"):
        return
    count = min(len(element.get("polycoef", "0 1 0 0 0").split()), 5)
    coefficients = reading.vector(element, "polycoef", count, (0.0, 1.0))
    if not coefficients:
        return
    a0, a1, *higher = (*coefficients, *(0.0, 1.0)[len(coefficients) :])
    names = [name for name in (element.get("joint1"), element.get("joint2")) if name]
    if any(higher) and len(names) == 2:
        text = element.get("polycoef")
        reading.report(COUPLING_NOT_LINEAR, element, "polycoef", joint=names[0], text=text)
        return
    for follower, *leaders in references.joints(element, names, scope):
        declared = joints[follower]
        if not leaders:
            locked = locked_at(declared.joint, tree.references[follower] + a0)
            joints[follower] = Declared(locked, element)
            continue
        offset = tree.references[follower] + a0 - a1 * tree.references[leaders[0]]
        joints[follower] = Declared(replace(declared.joint, mimic=Mimic(leaders[0], a1, offset)), element)


def _weld(references: References, element: Element, scope: Scope, number: int) -> list[Joint]:
    """A loop closed by a fixed joint; welds to sites and to bodies moved by the user stay open and are said."""
    reading, tree = references.reading, references.tree
    if "site1" in element.attributes or "site2" in element.attributes:
        _open(references, element, scope)
        return []
    if not reading.reference(element, "body1"):
        return []
    numbers = reading.vector(element, "relpose", 7) if "relpose" in element.attributes else None
    loops: list[Joint] = []
    for first, second in references.bodies(element, [element.get("body1"), element.get("body2")], scope):
        if first in tree.guided or second in tree.guided:
            reading.report(LOOP_OPEN, element, None, None, element="weld", first=first, second=second)
            continue
        T = inverse(tree.poses[first]) @ tree.poses[second]
        if numbers is not None and any(numbers[3:]):
            quaternion = np.array(numbers[3:])
            T = np.eye(4)
            T[:3, :3] = rotation_from_quaternion(quaternion / np.linalg.norm(quaternion))
            T[:3, 3] = numbers[:3]
        named = scope.named(element.get("name")) if element.get("name") else ""
        name = named or f"weld_{number + len(loops) + 1}"
        loops.append(Joint(name, JointKind.FIXED, first, second, frozen(T), actuated=False))
    return loops


def _open(references: References, element: Element, scope: Scope) -> None:
    """A loop that is not kept."""
    reading = references.reading
    if "site1" in element.attributes:
        ends = [(element.get("site1"), element.get("site2"))]
    elif "body1" not in element.attributes:
        reading.report(MISSING_ATTRIBUTE, element, element=element.tag, attribute="body1")
        return
    else:
        names = [element.get("body1"), element.get("body2")]
        ends = [(row[0], row[1]) for row in references.bodies(element, names, scope)]
    for first, second in ends:
        reading.report(LOOP_OPEN, element, None, None, element=element.tag, first=first, second=second)
