"""The tree of MJCF bodies as links and joints of one freedom."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass, field

import numpy as np

from mafsil.arrays import PoseMatrix, frozen
from mafsil.model.diagnostics import Edit, Repair
from mafsil.model.faults import BALL_JOINT, DUPLICATE_JOINT, DUPLICATE_LINK, FREE_JOINT, NOT_KEPT, UNSUPPORTED
from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import Inertial, Link
from mafsil.model.mjcf.geom import Geom, Library, read_geom
from mafsil.model.mjcf.inertial import inertial_of
from mafsil.model.mjcf.joint import Hinge, read_joint
from mafsil.model.mjcf.orientation import read_pose
from mafsil.model.placement import screw_motion, translation
from mafsil.model.reading import Reading
from mafsil.model.xml_tree import Element, escaped

WORLD = "world"
_EXPANDING = ("replicate", "composite", "flexcomp", "attach", "plugin")
_IGNORED = ("site", "camera", "light", "inertial", "geom", "joint", "freejoint", "body", "frame")


@dataclass(slots=True)
class Tree:
    """What the bodies became.

    Attributes:
        links, joints: in document order.
        elements: for each joint its element.
        references: for each joint its coordinate in the drawn configuration.
        lines: where each body stands.
        numbers: up to which each made name is used.
        poses: of each body in the world when all coordinates have their reference values.
    """

    links: list[Link] = field(default_factory=list[Link])
    joints: list[Joint] = field(default_factory=list[Joint])
    elements: dict[str, Element] = field(default_factory=dict[str, Element])
    references: dict[str, float] = field(default_factory=dict[str, float])
    lines: dict[str, int] = field(default_factory=dict[str, int])
    numbers: dict[str, int] = field(default_factory=dict[str, int])
    poses: dict[str, PoseMatrix] = field(default_factory=dict[str, PoseMatrix])

    def free(self, name: str, taken: Container[str]) -> str:
        """The name, numbered if it is taken; counted on, so that many parts without names cost no search."""
        number = self.numbers.get(name, 1)
        candidate = name if number == 1 else f"{name}_{number}"
        while candidate in taken:
            number += 1
            candidate = f"{name}_{number}"
        self.numbers[name] = number
        return candidate


@dataclass(frozen=True, slots=True)
class Place:
    """Where a body hangs: its parent link, its pose there, the default class in force, the body's world pose."""

    parent: str
    T: PoseMatrix
    childclass: str
    T_world: PoseMatrix


def read_tree(reading: Reading, worldbody: Element, library: Library) -> Tree:
    """All bodies below the world."""
    tree = Tree()
    identity = frozen(np.eye(4))
    geoms = _read_geoms(reading, worldbody, library, "", identity)
    tree.links.append(_link(WORLD, None, geoms))
    tree.poses[WORLD] = identity
    waiting = [(worldbody, Place(WORLD, identity, worldbody.get("childclass"), identity))]
    while waiting:
        holder, place = waiting.pop()
        inner: list[tuple[Element, Place]] = []
        for body, at in _bodies(reading, holder, place, library):
            below = _read_body(reading, body, at, library, tree)
            if below is not None:
                inner.append((body, below))
        waiting.extend(reversed(inner))
    return tree


def _bodies(reading: Reading, holder: Element, place: Place, library: Library) -> list[tuple[Element, Place]]:
    """The bodies directly inside an element or inside its frames."""
    found: list[tuple[Element, Place]] = []
    for child in holder.children:
        if child.tag in _EXPANDING:
            reading.report(UNSUPPORTED, child, None, reading.remove(child), element=child.tag)
        elif child.tag == "body":
            found.append((child, place))
        elif child.tag == "frame":
            T = frozen(place.T @ read_pose(reading, child, library.settings))
            T_world = frozen(place.T_world @ read_pose(reading, child, library.settings))
            inner = Place(place.parent, T, child.get("childclass") or place.childclass, T_world)
            found.extend(_bodies(reading, child, inner, library))
        elif child.tag not in _IGNORED:
            reading.report(NOT_KEPT, child, element=holder.tag, what=child.tag)
    return found


def _read_body(reading: Reading, element: Element, place: Place, library: Library, tree: Tree) -> Place | None:
    """Add a body with its joints to the tree; the place of what hangs on it."""
    name = reading.name(element) if "name" in element.attributes else tree.free("body", tree.poses)
    if not name or _is_taken(reading, element, name, tree):
        return None
    for attribute in ("gravcomp", "mocap"):
        if element.get(attribute) not in ("", "0", "false"):
            reading.report(NOT_KEPT, element, attribute, element="body", what=attribute)
    childclass = element.get("childclass") or place.childclass
    T_own = read_pose(reading, element, library.settings)
    geoms = _read_geoms(reading, element, library, childclass, frozen(np.eye(4)))
    inertial = inertial_of(reading, element, name, geoms, library)
    hinges = _read_joints(reading, element, name, childclass, library, tree)
    _add_chain(tree, place, frozen(place.T @ T_own), name, hinges)
    tree.links.append(_link(name, inertial, geoms))
    tree.poses[name] = frozen(place.T_world @ T_own)
    return Place(name, frozen(np.eye(4)), childclass, tree.poses[name])


def _is_taken(reading: Reading, element: Element, name: str, tree: Tree) -> bool:
    """Whether another body, or a link made between its joints, has the name already; that is reported."""
    if name in tree.poses:
        reading.report(DUPLICATE_LINK, element, "name", link=name, line=tree.lines.get(name, 0))
        return True
    tree.lines[name] = element.line
    return False


def _read_joints(
    reading: Reading, body: Element, name: str, childclass: str, library: Library, tree: Tree
) -> list[Hinge]:
    hinges: list[Hinge] = []
    for child in body.children:
        if child.tag == "freejoint":
            reading.report(FREE_JOINT, child, None, reading.remove(child), body=name)
        if child.tag != "joint":
            continue
        element = library.settings.styled(reading, child, childclass)
        kind = element.get("type", "hinge")
        if kind == "free":
            reading.report(FREE_JOINT, child, None, reading.remove(child), body=name)
        elif kind == "ball":
            reading.report(BALL_JOINT, child, None, _three_hinges(reading, child), joint=child.get("name"))
        else:
            hinge = read_joint(reading, element, tree.free("joint", tree.elements), library.settings)
            if hinge is not None and hinge.name in tree.elements:
                first = tree.elements[hinge.name].line
                reading.report(DUPLICATE_JOINT, child, "name", joint=hinge.name, line=first)
            elif hinge is not None:
                tree.elements[hinge.name] = child
                tree.references[hinge.name] = hinge.reference
                hinges.append(hinge)
    return hinges


def _three_hinges(reading: Reading, joint: Element) -> Repair:
    """The repair that replaces a ball joint; the file must say its name if others refer to it."""
    name = joint.get("name") or "ball"
    position = f' pos="{escaped(joint.get("pos"))}"' if "pos" in joint.attributes else ""
    axes = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}
    text = "".join(f'<joint name="{escaped(name)}_{k}" type="hinge" axis="{a}"{position}/>' for k, a in axes.items())
    (removal,) = reading.remove(joint).edits
    return Repair("robotfile.repair_three_hinges", (Edit(removal.start, removal.end, text),))


def _add_chain(tree: Tree, place: Place, T: PoseMatrix, body: str, hinges: list[Hinge]) -> None:
    """Joints from the parent link to a body: each turns about its own anchor, one after the other.

    T is the pose of the body in the parent link at the reference configuration. Between joints, and where the last
    anchor is not the body's origin, stand massless links; the link of the body keeps the body's frame.
    """
    parent, before = place.parent, T
    for k, hinge in enumerate(hinges):
        anchor = translation(*hinge.position)
        last = k == len(hinges) - 1 and not np.any(hinge.position)
        child = body if last else tree.free(f"{body}/{hinge.name}", tree.poses)
        if not last:
            tree.links.append(Link(child))
            tree.poses[child] = frozen(np.eye(4))
        T_pj = before @ anchor @ screw_motion(hinge.screw, -hinge.reference)
        tree.joints.append(hinge.joint(parent, child, frozen(T_pj)))
        parent, before = child, translation(*(-hinge.position))
    if not hinges or np.any(hinges[-1].position):
        name = tree.free(f"{body}/fixed", tree.elements)
        tree.joints.append(Joint(name, JointKind.FIXED, parent, body, frozen(before)))


def _read_geoms(reading: Reading, holder: Element, library: Library, childclass: str, T: PoseMatrix) -> list[Geom]:
    """The geometries of a body, also those inside frames."""
    found: list[Geom] = []
    for child in holder.children:
        if child.tag == "geom":
            geom = read_geom(reading, library.settings.styled(reading, child, childclass), library)
            if geom is not None:
                found.append(geom.moved(T))
        elif child.tag == "frame":
            inner = frozen(T @ read_pose(reading, child, library.settings))
            found.extend(_read_geoms(reading, child, library, child.get("childclass") or childclass, inner))
    return found


def _link(name: str, inertial: Inertial | None, geoms: list[Geom]) -> Link:
    visuals = tuple(geom.shape for geom in geoms if geom.shape is not None and geom.seen)
    collisions = tuple(geom.shape for geom in geoms if geom.shape is not None and geom.collides)
    return Link(name, inertial, visuals, collisions)
