"""The strict URDF reader: finds everything wrong in one pass, says where, and changes nothing silently.

Links of a URDF file: mass properties and shapes.

Whether links and joints form one tree, with a place and a repair for each contradiction.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from mafsil.arrays import Floats, frozen
from mafsil.model.asset_path import Assets
from mafsil.model.diagnostics import Repair, Severity
from mafsil.model.faults import (
    CYCLE,
    DUPLICATE_JOINT,
    DUPLICATE_LINK,
    MISSING_ELEMENT,
    NAMELESS_ROBOT,
    NO_INERTIAL,
    NO_LINKS,
    ONLY_MACROS,
    SELF_JOINT,
    TENSOR_INCOMPLETE,
    TWO_PARENTS,
    TWO_ROOTS,
    UNKNOWN_LINK,
    WRONG_ROOT,
    XACRO_LEFT_OVER,
    ZERO_INERTIA,
)
from mafsil.model.file_reader import Format
from mafsil.model.inertia_check import inertia_fault, mass_fault, nearest_physical
from mafsil.model.joint import Joint
from mafsil.model.link import Inertial, Link
from mafsil.model.mechanism import Mechanism
from mafsil.model.mimics import Declared, resolve_mimics
from mafsil.model.reading import Reading, written
from mafsil.model.spanning_tree import joint_of_loop
from mafsil.model.urdf.joint import read_joint, read_transmissions
from mafsil.model.urdf.shape import Materials, read_origin, read_shapes
from mafsil.model.urdf.vocabulary import URDF as VOCABULARY
from mafsil.model.urdf.vocabulary import version_of
from mafsil.model.vocabulary import Version, audit
from mafsil.model.xacro import expand, is_xacro, left_over
from mafsil.model.xml_tree import Element, ReadLimits

CLOSE = 0.8
"""Share of letters that a misspelt name has in common with what it means."""
MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
PRODUCTS = ("ixy", "ixz", "iyz")


def _build(reading: Reading, assets: Assets, source: str, limits: ReadLimits) -> Mechanism | None:
    root = reading.document.root
    if root.tag != "robot":
        reading.report(WRONG_ROOT, root, found=root.tag, expected="robot")
        return None
    robot = _plain(reading, assets, limits)
    if robot is None:
        return None
    version = version_of(reading, robot)
    audit(reading, robot, VOCABULARY, version)
    name = robot.get("name").strip()
    if not name:
        reading.report(NAMELESS_ROBOT, robot)
        name = Path(source).name.split(".")[0] if source != "<text>" else "robot"
    links, joints = _read_parts(reading, robot, assets, version)
    return None if reading.failed else Mechanism.assemble(name, [declared.link for declared in links], joints)


def _read_parts(
    reading: Reading, robot: Element, assets: Assets, version: Version
) -> tuple[list[DeclaredLink], list[Joint]]:
    materials = Materials.collect(reading, robot)
    links = [
        DeclaredLink(link, element)
        for element in robot.all("link")
        if (link := read_link(reading, element, materials, assets)) is not None
    ]
    carried = frozenset(end.get("link") for joint in robot.all("joint") for end in joint.all("child")[:1])
    read = (read_joint(reading, element, carried, version) for element in robot.all("joint"))
    declared = [joint for joint in read if joint is not None]
    check_links(reading, robot, links)
    check_joints(reading, robot, links, declared)
    joints = read_transmissions(reading, robot, resolve_mimics(reading, declared))
    return links, joints


def _plain(reading: Reading, assets: Assets, limits: ReadLimits) -> Element | None:
    """The robot without any xacro: what is left over in a finished file ignored, everything else expanded."""
    root = reading.document.root
    if not is_xacro(root):
        return root
    rests = [] if reading.arguments else left_over(root)
    gone = frozenset(rests)
    for element in rests:
        reading.report(XACRO_LEFT_OVER, element, None, reading.remove(element), element=element.tag)
    if rests:
        for element in root.walk():
            element.children = [child for child in element.children if child not in gone]
        return root
    return expand(reading, assets, limits)


URDF = Format(_build)
read, diagnose, repair, file_reader = URDF.read, URDF.diagnose, URDF.repair, URDF.reader


def read_link(reading: Reading, element: Element, materials: Materials, assets: Assets) -> Link | None:
    """A link, or None if it has no name."""
    name = reading.name(element)
    inertial = _read_inertial(reading, element, name)
    visuals = read_shapes(reading, element.all("visual"), materials, assets)
    collisions = read_shapes(reading, element.all("collision"), materials, assets)
    return Link(name, inertial, visuals, collisions) if name else None


def _read_inertial(reading: Reading, link: Element, name: str) -> Inertial | None:
    element = reading.one(link, "inertial")
    if element is None:
        reading.report(NO_INERTIAL, link, link=name)
        return None
    without = reading.remove(element)
    mass = _read_mass(reading, element, without)
    moments = _read_moments(reading, element, name, without)
    T = read_origin(reading, element)
    if mass is None or moments is None:
        return None
    _judge(reading, element, name, mass, moments)
    R = T[:3, :3]
    turned = R @ moments @ R.T
    return Inertial(mass, frozen(T[:3, 3]), frozen((turned + turned.T) / 2))


def _read_mass(reading: Reading, inertial: Element, without: Repair) -> float | None:
    mass = reading.one(inertial, "mass")
    if mass is None:
        reading.report(MISSING_ELEMENT, inertial, None, without, element="mass", parent="inertial")
        return None
    return reading.number(mass, "value", fallback=without)


def _read_moments(reading: Reading, inertial: Element, name: str, without: Repair) -> Floats | None:
    """The tensor; what is not written off its diagonal is zero, and so is one that is not written at all."""
    element = reading.one(inertial, "inertia")
    if element is None:
        return np.zeros((3, 3))
    missing = [key for key in PRODUCTS if key not in element.attributes]
    values = [reading.number(element, key, 0.0 if key in missing else None, fallback=without) for key in MOMENTS]
    known = [value for value in values if value is not None]
    if len(known) < len(values):
        return None
    if missing:
        edits = tuple(reading.document.set_attribute(element, key, "0") for key in missing)
        repair = Repair("robotfile.repair_products", edits)
        reading.report(TENSOR_INCOMPLETE, element, None, repair, link=name, missing=", ".join(missing))
    ixx, ixy, ixz, iyy, iyz, izz = known
    return np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])


def _judge(reading: Reading, inertial: Element, name: str, mass: float, moments: Floats) -> None:
    """Report mass properties that no body has, with the nearest that one can have."""
    if fault := mass_fault(mass, moments):
        element = inertial.first("mass") or inertial
        repair = reading.set_attribute(element, "value", written(-mass), guess=True) if mass < 0.0 else None
        reading.report(fault, element, "value", repair, link=name, mass=mass)
    if fault := inertia_fault(mass, moments):
        element = inertial.first("inertia") or inertial
        guess = fault.severity is Severity.ERROR
        repair = replace(_physical(reading, element, moments), guess=guess) if fault is not ZERO_INERTIA else None
        eigenvalues = ", ".join(f"{value:.4g}" for value in np.linalg.eigvalsh(moments))
        reading.report(fault, element, None, repair, link=name, moments=eigenvalues)


def _physical(reading: Reading, element: Element, moments: Floats) -> Repair:
    """The repair that writes the nearest physical inertia."""
    nearest = nearest_physical(moments)
    i, j = np.triu_indices(3)
    edits = tuple(
        reading.document.set_attribute(element, key, written(nearest[a, b]))
        for key, a, b in zip(MOMENTS, i, j, strict=True)
    )
    return Repair("robotfile.repair_inertia", edits)


@dataclass(frozen=True, slots=True)
class DeclaredLink:
    """A link with its element."""

    link: Link
    element: Element


def check_links(reading: Reading, robot: Element, links: list[DeclaredLink]) -> None:
    """At least one link, no name twice."""
    if not robot.all("link"):
        macros = any(child.tag == "xacro:macro" for child in reading.document.root.children)
        reading.report(ONLY_MACROS if macros else NO_LINKS, robot)
    seen: dict[str, Element] = {}
    for declared in links:
        name = declared.link.name
        if name in seen:
            repair = reading.remove(declared.element) if _same(declared.element, seen[name]) else None
            line = seen[name].line
            reading.report(DUPLICATE_LINK, declared.element, "name", repair, link=name, line=line)
        else:
            seen[name] = declared.element


def _same(one: Element, two: Element) -> bool:
    """Whether two elements say the same, place and layout apart."""
    if (one.tag, one.attributes, one.text, len(one.children)) != (two.tag, two.attributes, two.text, len(two.children)):
        return False
    return all(_same(a, b) for a, b in zip(one.children, two.children, strict=True))


def check_joints(reading: Reading, robot: Element, links: list[DeclaredLink], joints: list[Declared]) -> None:
    """Unique names, both ends exist, one parent each, one root, no cycle."""
    known = {declared.link.name for declared in links}
    names: dict[str, int] = {}
    carried: dict[str, str] = {}
    sound = True
    for declared in joints:
        _check_name(reading, declared, names)
        sound &= _check_ends(reading, declared, known)
        sound &= _check_parent(reading, declared, carried)
    if sound:
        _check_tree(reading, robot, [declared.link.name for declared in links], joints)


def _check_name(reading: Reading, declared: Declared, names: dict[str, int]) -> None:
    name, element = declared.joint.name, declared.element
    if name not in names:
        names[name] = element.line
        return
    number = next(k for k in range(2, len(names) + 3) if f"{name}_{k}" not in names)
    repair = reading.set_attribute(element, "name", f"{name}_{number}")
    reading.report(DUPLICATE_JOINT, element, "name", repair, joint=name, line=names[name])
    names[f"{name}_{number}"] = element.line


def _check_ends(reading: Reading, declared: Declared, known: set[str]) -> bool:
    joint, element = declared.joint, declared.element
    if joint.parent == joint.child:
        reading.report(SELF_JOINT, element, None, None, joint=joint.name, link=joint.child)
        return False
    missing = [(tag, link) for tag, link in (("parent", joint.parent), ("child", joint.child)) if link not in known]
    for tag, link in missing:
        end = element.first(tag) or element
        close = get_close_matches(link, sorted(known), n=2, cutoff=CLOSE)
        repair = reading.set_attribute(end, "link", close[0], guess=True) if len(close) == 1 else None
        reading.report(UNKNOWN_LINK, end, "link", repair, joint=joint.name, link=link)
    return not missing


def _check_parent(reading: Reading, declared: Declared, carried: dict[str, str]) -> bool:
    joint, element = declared.joint, declared.element
    first = carried.setdefault(joint.child, joint.name)
    if first == joint.name:
        return True
    reading.report(
        TWO_PARENTS, element, None, None,
        link=joint.child, first=first, second=joint.name,
    )  # fmt: skip
    return False


def _check_tree(reading: Reading, robot: Element, links: list[str], joints: list[Declared]) -> None:
    """One root from which every link is reached."""
    loop = joint_of_loop(declared.joint for declared in joints)
    if loop is not None:
        element = next(declared.element for declared in joints if declared.joint is loop)
        reading.report(CYCLE, element, None, None, joint=loop.name)
        return
    children = {declared.joint.child for declared in joints}
    roots = [name for name in links if name not in children]
    for extra in roots[1:]:
        element = next(e for e in robot.all("link") if e.get("name") == extra)
        reading.report(TWO_ROOTS, element, None, None, first=roots[0], second=extra)
