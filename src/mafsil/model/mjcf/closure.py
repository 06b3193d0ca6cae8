"""Loops of MJCF: `connect` closes one by a ball joint, `weld` by a fixed one, between bodies or between sites."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, frozen
from mafsil.model.faults import LOOP_CLOSED, LOOP_OPEN, MISSING_ATTRIBUTE
from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import Link
from mafsil.model.mjcf.references import References
from mafsil.model.mjcf.scope import Scope
from mafsil.model.placement import inverse, rotation_from_quaternion
from mafsil.model.xml_tree import Element

KINDS = {"connect": JointKind.SPHERICAL, "weld": JointKind.FIXED}
COINCIDENT = 1e-12
"""Difference of two poses that are one: thousand roundings of metres."""


@dataclass(frozen=True, slots=True)
class End:
    """One end of a loop: a body and the joint's frame in it."""

    body: str
    T: PoseMatrix


def read_loops(references: References, element: Element, scope: Scope) -> list[tuple[Joint, Joint | None]]:
    """The joints that close the loops of one constraint, each with the fixed joint that carries its child, or None.

    1. Both ends are looked up, once for every replication; bodies that the user moves by hand leave a loop open.
    2. A ball joint needs no orientation.
    3. Where the child's frame does not stand in the joint, a massless link fixed to it does.
    """
    tree = references.tree
    found: list[tuple[Joint, Joint | None]] = []
    for first, second in _ends(references, element, scope):
        # 1.
        if first.body in tree.guided or second.body in tree.guided:
            references.reading.report(
                LOOP_OPEN, element, None, None, element=element.tag, first=first.body, second=second.body
            )
            continue
        references.reading.report(
            LOOP_CLOSED, element, None, None, element=element.tag, first=first.body, second=second.body
        )
        # 2.
        ball = element.tag == "connect"
        T_pj, T_cj = (_without_rotation(end.T) if ball else end.T for end in (first, second))
        # 3.
        named = scope.full_name(element.get("name")) if element.get("name") else ""
        name = named if named and not found else tree.free(named or element.tag, {*tree.elements, *tree.closing})
        tree.closing.add(name)
        child, carrier = second.body, None
        if np.abs(T_cj - np.eye(4)).max() > COINCIDENT:
            child = tree.free(f"{name}/end", tree.poses)
            tree.links.append(Link(child))
            tree.poses[child] = frozen(tree.poses[second.body] @ T_cj)
            fixed = tree.free(f"{child}/fixed", {*tree.elements, *tree.closing})
            tree.closing.add(fixed)
            carrier = Joint(fixed, JointKind.FIXED, second.body, child, frozen(T_cj))
        found.append((Joint(name, KINDS[element.tag], first.body, child, frozen(T_pj), actuated=False), carrier))
    return found


def _ends(references: References, element: Element, scope: Scope) -> Iterator[tuple[End, End]]:
    """Both ends of a constraint, between sites if it names them."""
    if "site1" in element.attributes or "site2" in element.attributes:
        yield from _sites(references, element, scope)
    elif references.reading.reference(element, "body1"):
        yield from _bodies(references, element, scope)


def _bodies(references: References, element: Element, scope: Scope) -> Iterator[tuple[End, End]]:
    """The anchor is given in the first body, and stands where the file draws it in the second one."""
    reading, poses = references.reading, references.tree.poses
    T_first: Floats | None = None
    if element.tag == "connect":
        anchor = reading.vector(element, "anchor", 3)
        if anchor is None:
            return
        T_first = np.eye(4)
        T_first[:3, 3] = anchor
    elif "relpose" in element.attributes:
        numbers = reading.vector(element, "relpose", 7)
        if numbers is None:
            return
        if any(numbers[3:]):
            quaternion = np.array(numbers[3:])
            T_first = np.eye(4)
            T_first[:3, :3] = rotation_from_quaternion(quaternion / np.linalg.norm(quaternion))
            T_first[:3, 3] = numbers[:3]
    for first, second in references.bodies(element, [element.get("body1"), element.get("body2")], scope):
        T_between = inverse(poses[first]) @ poses[second]
        if T_first is None:
            yield End(first, T_between), End(second, np.eye(4))
        elif element.tag == "weld":
            yield End(first, T_first), End(second, np.eye(4))
        else:
            yield End(first, T_first), End(second, inverse(T_between) @ T_first)


def _sites(references: References, element: Element, scope: Scope) -> Iterator[tuple[End, End]]:
    """Sites have poses of their own."""
    sites, left_out = references.tree.sites, references.tree.left_out
    names = [element.get(key) for key in ("site1", "site2")]
    for key, name in zip(("site1", "site2"), names, strict=True):
        if not name:
            references.reading.report(MISSING_ATTRIBUTE, element, element=element.tag, attribute=key)
            return
    for pair in references.sites(element, names, scope):
        references.tree.holding.update(pair)
        first, second = (sites[name] for name in pair)
        if not {first[0], second[0]} & left_out:
            yield End(*first), End(*second)


def _without_rotation(T: PoseMatrix) -> Floats:
    moved = np.eye(4)
    moved[:3, 3] = T[:3, 3]
    return moved
