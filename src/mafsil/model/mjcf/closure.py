"""Equality constraints of MJCF: mimic and locked joints, and loops.

`connect` closes a loop by a ball joint, `weld` by a fixed one, between bodies or between sites. The names that
constraints, tendons and actuators use are found with the prefix and the suffixes of their model in place.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, frozen
from mafsil.model.faults import LOOP_CLOSED, LOOP_OPEN, MISSING_ATTRIBUTE, UNKNOWN_BODY, UNKNOWN_JOINT, UNKNOWN_SITE
from mafsil.model.joint import Joint, JointKind, Mimic
from mafsil.model.link import Link
from mafsil.model.mimics import Declared, locked_at
from mafsil.model.mjcf.body import WORLD, Tree
from mafsil.model.mjcf.scope import Scope, Unfolding
from mafsil.model.placement import inverse, rotation_from_quaternion
from mafsil.model.reading import Reading
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


@dataclass(frozen=True, eq=False, slots=True)
class References:
    """Looks names up.

    Attributes:
        reading: where unknown names are reported.
        unfolding: the models in place and the suffixes of replications.
        tree: the bodies and joints.
    """

    reading: Reading
    unfolding: Unfolding
    tree: Tree

    def sections(self, tag: str) -> Iterator[tuple[Element, Scope]]:
        """The elements inside the sections of that tag, of every model in place."""
        for scope in self.unfolding.scopes:
            for section in scope.model.root.all(tag):
                for child in section.children:
                    yield child, scope

    def joints(self, element: Element, names: list[str], scope: Scope) -> list[tuple[str, ...]]:
        """The joints that an element names, once for every replication it belongs to; unknown ones are reported."""
        return self._instances(element, names, scope, self.tree.elements, "joint")

    def bodies(self, element: Element, names: list[str], scope: Scope) -> list[tuple[str, ...]]:
        """The bodies that an element names, as `joints`; an empty name is the world."""
        return self._instances(element, names, scope, self.tree.poses, "body")

    def sites(self, element: Element, names: list[str], scope: Scope) -> list[tuple[str, ...]]:
        """The sites that an element names, as `joints`."""
        return self._instances(element, names, scope, self.tree.sites, "site")

    def tied_pairs(self, element: Element, scope: Scope) -> list[tuple[str, ...]]:
        """The pairs of bodies that a constraint ties, by themselves or by their sites; unknown ones are passed over."""
        between_sites = "site1" in element.attributes or "site2" in element.attributes
        keys, known = (("site1", "site2"), self.tree.sites) if between_sites else (("body1", "body2"), self.tree.poses)
        rows = self._instances(element, [element.get(key) for key in keys], scope, known, None)
        return [tuple(self.tree.sites[name][0] for name in row) for row in rows] if between_sites else rows

    def _instances(
        self, element: Element, names: list[str], scope: Scope, known: Collection[str], kind: str | None
    ) -> list[tuple[str, ...]]:
        suffixes = [s for s in self.unfolding.suffixes if s.endswith(scope.suffix) and s != scope.suffix]
        found: list[tuple[str, ...]] = []
        for suffix in (scope.suffix, *suffixes):
            lengthened = [self._lengthen(name, scope, suffix, known) for name in names]
            if all(lengthened) and (suffix == scope.suffix or any(name.endswith(suffix) for name in lengthened)):
                found.append(tuple(lengthened))
                if suffix == scope.suffix:
                    break
        if not found and kind is not None:
            self._report(element, names, scope, suffixes, known, kind)
        absent = self._absent(known)
        return [row for row in found if not any(name in absent for name in row)]

    def _absent(self, known: Collection[str]) -> set[str]:
        """The names of that kind that are not part of the mechanism."""
        return self.tree.absent_joints if known is self.tree.elements else self.tree.left_out

    def _lengthen(self, name: str, scope: Scope, suffix: str, known: Collection[str]) -> str:
        """A name in place, or empty if there is none such."""
        if name in ("", WORLD):
            return WORLD
        for candidate in (f"{scope.prefix}{name}{suffix}", f"{scope.prefix}{name}{scope.suffix}"):
            if candidate in known or candidate in self._absent(known):
                return candidate
            if candidate.startswith(tuple(f"{soft}_" for soft in self.tree.soft)):
                self._absent(known).add(candidate)
                return candidate
        return ""

    def _report(
        self, element: Element, names: list[str], scope: Scope, suffixes: list[str], known: Collection[str],
        kind: str,
    ) -> None:  # fmt: skip
        """An unknown name; what belongs to a part of a model that was not attached is none."""
        if scope.partly:
            return
        places = (scope.suffix, *suffixes)
        unknown = (n for n in names if not any(self._lengthen(n, scope, suffix, known) for suffix in places))
        missing = next(unknown, names[0])
        repair = self.reading.remove(element)
        fault = {"body": UNKNOWN_BODY, "joint": UNKNOWN_JOINT, "site": UNKNOWN_SITE}[kind]
        self.reading.report(fault, element, None, repair, **{kind: missing})
