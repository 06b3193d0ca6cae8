"""Whether links and joints form one tree, with a place and a repair for each contradiction."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches

from mafsil.model.faults import (
    CYCLE,
    DUPLICATE_JOINT,
    DUPLICATE_LINK,
    NO_LINKS,
    ONLY_MACROS,
    SELF_JOINT,
    TWO_PARENTS,
    TWO_ROOTS,
    UNKNOWN_LINK,
)
from mafsil.model.link import Link
from mafsil.model.mimics import Declared
from mafsil.model.reading import Reading
from mafsil.model.spanning_tree import joint_of_loop
from mafsil.model.xml_tree import Element

CLOSE = 0.8
"""Share of letters that a misspelt name has in common with what it means."""


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
