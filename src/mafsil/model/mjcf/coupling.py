"""Equality constraints of MJCF: mimic and locked joints, and loops."""

from __future__ import annotations

from dataclasses import replace

from mafsil.model.joint import Joint, Mimic
from mafsil.model.mimics import Declared, locked_at
from mafsil.model.mjcf.closure import KINDS, read_loops
from mafsil.model.mjcf.references import References
from mafsil.model.mjcf.scope import Scope
from mafsil.model.xml_tree import Element


def read_couplings(references: References, root: Element) -> tuple[list[Declared], list[Joint]]:
    """The joints of the tree with their couplings, and the joints that close loops.

    1. Every joint of the tree stands for itself.
    2. Constraints that are switched off, one by one or all, are passed over.
    3. A `joint` constraint makes one joint follow another or locks it; `weld` and `connect` close loops.
    """
    # 1.
    tree = references.tree
    joints = {joint.name: Declared(joint, tree.elements.get(joint.name, root)) for joint in tree.joints}
    loops: list[Joint] = []
    for child, scope in references.sections("equality"):
        settings = scope.library.settings
        element = settings.apply_defaults(references.reading, child, "", "equality")
        # 2.
        if element.get("active", "true") == "false" or "equality" in settings.off:
            continue
        # 3.
        if element.tag == "joint":
            _couple(references, element, scope, joints)
        elif element.tag in KINDS:
            for loop, carrier in read_loops(references, element, scope):
                loops.append(loop)
                if carrier is not None:
                    joints[carrier.name] = Declared(carrier, element)
    return list(joints.values()), loops


def _couple(references: References, element: Element, scope: Scope, joints: dict[str, Declared]) -> None:
    """joint1 - ref1 = a0 + a1 (joint2 - ref2) + a2 (joint2 - ref2)^2 ...: a mimic; without joint2 it is locked."""
    reading, tree = references.reading, references.tree
    if not reading.reference(element, "joint1"):
        return
    count = min(len(element.get("polycoef", "0 1 0 0 0").split()), 5)
    coefficients = reading.vector(element, "polycoef", count, (0.0, 1.0))
    if not coefficients:
        return
    curve = (*coefficients, *(0.0, 1.0)[len(coefficients) :])
    names = [name for name in (element.get("joint1"), element.get("joint2")) if name]
    for follower, *leaders in references.joints(element, names, scope):
        declared = joints[follower]
        if not leaders:
            locked = locked_at(declared.joint, tree.references[follower] + curve[0])
            joints[follower] = Declared(locked, element)
            continue
        curve_here = Mimic(leaders[0], curve[1], curve[0], curve[2:]).after(
            Mimic("", 1.0, -tree.references[leaders[0]])
        )
        mimic = replace(curve_here, leader=leaders[0], offset=tree.references[follower] + curve_here.offset)
        joints[follower] = Declared(replace(declared.joint, mimic=mimic), element)
