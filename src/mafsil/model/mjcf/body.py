"""The tree of MJCF bodies as links and joints of one freedom."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass, field

import numpy as np

from mafsil.arrays import PoseMatrix, frozen
from mafsil.model.diagnostics import Diagnostic, Edit, Repair
from mafsil.model.faults import (
    BALL_JOINT,
    DUPLICATE_JOINT,
    DUPLICATE_LINK,
    FREE_JOINT,
    LOOSE_OBJECT,
    SECOND_INERTIAL,
    TOO_MANY_LINKS,
    UNKNOWN_PART,
    UNSUPPORTED,
)
from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import Inertial, Link
from mafsil.model.mjcf.geom import Geom, along_line, read_geom
from mafsil.model.mjcf.inertial import Matters, inertial_of
from mafsil.model.mjcf.joint import Hinge, read_ball, read_joint
from mafsil.model.mjcf.scope import Part, Scope, Unfolding
from mafsil.model.mjcf.settings import read_pose
from mafsil.model.placement import screw_motion, translation
from mafsil.model.reading import Reading, written
from mafsil.model.xml_tree import Element, ReadLimits, Refusal, escape

WORLD = "world"
SOFT = ("composite", "flexcomp")


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
        sites: of each named site its body and its pose (4, 4) there.
        frames: of each named frame the same.
        holding: names of the sites at which loops are held.
        closing: names of the joints that close loops, and of those that carry their ends.
        declared: names that the files give, which no made name takes.
        floating: bodies in the world that a free joint leaves loose, with what was reported about each and what hangs
            on it.
        guided: bodies that a user of the simulation moves by hand (`mocap`).
        left_out, absent_joints: names of bodies, and of joints, that are not part of the mechanism.
        soft: beginnings of the names of bodies that a soft object would be made of.
    """

    links: list[Link] = field(default_factory=list[Link])
    joints: list[Joint] = field(default_factory=list[Joint])
    elements: dict[str, Element] = field(default_factory=dict[str, Element])
    references: dict[str, float] = field(default_factory=dict[str, float])
    lines: dict[str, int] = field(default_factory=dict[str, int])
    numbers: dict[str, int] = field(default_factory=dict[str, int])
    poses: dict[str, PoseMatrix] = field(default_factory=dict[str, PoseMatrix])
    sites: dict[str, tuple[str, PoseMatrix]] = field(default_factory=dict[str, tuple[str, PoseMatrix]])
    frames: dict[str, tuple[str, PoseMatrix]] = field(default_factory=dict[str, tuple[str, PoseMatrix]])
    holding: set[str] = field(default_factory=set[str])
    closing: set[str] = field(default_factory=set[str])
    declared: set[str] = field(default_factory=set[str])
    floating: dict[str, tuple[Element, list[Diagnostic]]] = field(
        default_factory=dict[str, tuple[Element, list[Diagnostic]]]
    )
    guided: set[str] = field(default_factory=set[str])
    left_out: set[str] = field(default_factory=set[str])
    absent_joints: set[str] = field(default_factory=set[str])
    soft: list[str] = field(default_factory=list[str])

    def free(self, name: str, taken: Container[str]) -> str:
        """The name, numbered if it is taken; counted on, so that many parts without names cost no search."""
        number = self.numbers.get(name, 1)
        candidate = name if number == 1 else f"{name}_{number}"
        while candidate in taken or candidate in self.declared:
            number += 1
            candidate = f"{name}_{number}"
        self.numbers[name] = number
        return candidate


@dataclass(frozen=True, eq=False, slots=True)
class Place:
    """Where a body hangs.

    Attributes:
        parent: its parent link.
        T_world: (4, 4) pose of that in the world.
        moves: whether a joint lies between the world and the parent.
    """

    parent: str
    T_world: PoseMatrix
    moves: bool


@dataclass(slots=True)
class TreeReader:
    """Reads all bodies below the world.

    Attributes:
        reading: where faults are reported.
        unfolding: takes the bodies apart.
        limits: sizes beyond which the model is refused.
        tree: what was read so far.
    """

    reading: Reading
    unfolding: Unfolding
    limits: ReadLimits
    tree: Tree = field(default_factory=Tree)

    def read(self, scope: Scope) -> Tree:
        """The tree of a model."""
        identity = frozen(np.eye(4))
        named = ("body", "joint", "freejoint")
        self.tree.declared = {e.get("name") for e in scope.model.root.walk() if e.tag in named}
        parts = [p for section in scope.model.bodies() for p in self.unfolding.parts(section, identity, "", scope)]
        for part in parts:
            if part.element.tag in ("joint", "freejoint", "inertial"):
                details = {"element": part.element.tag, "parent": "worldbody", "known": "body, geom"}
                self.reading.report(UNKNOWN_PART, part.element, None, None, **details)
        self.tree.links.append(_link(WORLD, None, self._geoms(parts)))
        self.tree.poses[WORLD] = identity
        self._note_frames(parts, WORLD)
        self._read_children(parts, Place(WORLD, identity, moves=False))
        return self.tree

    def _read_children(self, parts: list[Part], place: Place) -> None:
        for part in parts:
            if part.element.tag == "body":
                before = len(self.reading.diagnostics)
                name = self._read_body(part, place)
                if name in self.tree.floating and place.parent == WORLD:
                    self.tree.floating[name][1].extend(self.reading.diagnostics[before:])
            elif part.element.tag in SOFT:
                self._soft(part, place)

    def _soft(self, part: Part, place: Place) -> None:
        """A cable or cloth: beside the robot it is left out, on the robot it would change the mechanism."""
        element = part.element
        if place.moves:
            self.reading.report(UNSUPPORTED, element, None, self.reading.remove(element), element=element.tag)
        else:
            name = part.scope.full_name(element.get("name") or element.get("prefix")) or element.tag
            self.tree.soft.append(name)
            self.reading.report(LOOSE_OBJECT, element, None, None, body=name)

    def _read_body(self, part: Part, place: Place) -> str:
        """Add a body with its joints and all that hangs on it to the tree; its name."""
        element, scope, tree = part.element, part.scope, self.tree
        name = tree.free("body", tree.poses)
        if "name" in element.attributes:
            name = scope.full_name(self.reading.name(element))
        if self._is_taken(element, name):
            return ""
        if len(tree.links) + len(tree.sites) + len(tree.frames) >= self.limits.links:
            raise Refusal(Diagnostic(TOO_MANY_LINKS, element.line, element.column, {"limit": self.limits.links}))
        if element.get("mocap") == "true":
            tree.guided.add(name)
        childclass = element.get("childclass") or part.childclass
        T_own = frozen(part.T @ read_pose(self.reading, element, scope.library.settings))
        tree.poses[name] = frozen(place.T_world @ T_own)
        inside = list(self.unfolding.parts(element, frozen(np.eye(4)), childclass, scope))
        hinges = self._joints(inside, name, place)
        moves = place.moves or bool(hinges)
        geoms = self._geoms(inside)
        own = self._only_inertial(inside)
        matters = Matters(None if own is None else own.element, T_own if own is None else own.T, geoms, moves)
        inertial = inertial_of(self.reading, element, name, matters, scope.library.settings)
        _add_chain(tree, place.parent, T_own, name, hinges)
        tree.links.append(_link(name, inertial, geoms))
        self._note_frames(inside, name)
        self._read_children(inside, Place(name, tree.poses[name], moves))
        return name

    def _note_frames(self, parts: list[Part], body: str) -> None:
        """Named sites, which loops may refer to, and named frames, of which the first of a name counts."""
        for part in parts:
            tag, name = part.element.tag, part.element.get("name")
            if tag == "site" and name:
                self.tree.sites.setdefault(part.scope.full_name(name), (body, _site_pose(self.reading, part)))
            elif tag == "frame":
                self.tree.frames.setdefault(part.scope.full_name(name), (body, part.T))

    def _only_inertial(self, parts: list[Part]) -> Part | None:
        """The `inertial` of a body; a second one is reported."""
        found = [part for part in parts if part.element.tag == "inertial"]
        for extra in found[1:]:
            repair = self.reading.remove(extra.element)
            self.reading.report(SECOND_INERTIAL, extra.element, None, repair)
        return found[0] if found else None

    def _is_taken(self, element: Element, name: str) -> bool:
        """Whether another body, or a link made between its joints, has the name already; that is reported."""
        if not name:
            return True
        if name in self.tree.poses:
            line = self.tree.lines.get(name, 0)
            self.reading.report(DUPLICATE_LINK, element, "name", link=name, line=line)
            return True
        self.tree.lines[name] = element.line
        return False

    def _joints(self, parts: list[Part], body: str, place: Place) -> list[Hinge]:
        hinges: list[Hinge] = []
        for part in parts:
            if part.element.tag == "freejoint":
                self._free(part, body, place)
            elif part.element.tag == "joint":
                hinges += self._joint(part, body, place)
        return hinges

    def _free(self, part: Part, body: str, place: Place) -> None:
        """A body that floats in the world is noted; inside another body that is not possible."""
        if place.parent == WORLD:
            self.tree.floating[body] = (part.element, [])
            self.tree.absent_joints.add(part.scope.full_name(part.element.get("name")))
        else:
            self.reading.report(FREE_JOINT, part.element, None, self.reading.remove(part.element), body=body)

    def _joint(self, part: Part, body: str, place: Place) -> list[Hinge]:
        """One hinge or slide, or none after an error or for a free joint."""
        reading, tree, settings = self.reading, self.tree, part.scope.library.settings
        element = settings.apply_defaults(reading, part.element, part.childclass)
        kind = element.get("type", "hinge")
        if kind == "free":
            self._free(part, body, place)
            return []
        name = tree.free("joint", tree.elements)
        if "name" in element.attributes:
            name = reading.name(element) and part.scope.full_name(element.get("name"))
        if kind == "ball":
            tree.absent_joints.add(name)
            tree.elements.setdefault(name, part.element)
            reading.report(BALL_JOINT, part.element, None, _three_hinges(reading, part, element), joint=name)
            return self._unique(part, read_ball(reading, element, name, part.T))
        hinge = read_joint(reading, element, name, settings, part.T)
        return [] if hinge is None else self._unique(part, [hinge])

    def _unique(self, part: Part, hinges: list[Hinge]) -> list[Hinge]:
        """The joints of an element, unless another has a name of theirs."""
        known = self.tree.elements
        for hinge in hinges:
            if hinge.name in known:
                line = known[hinge.name].line
                self.reading.report(DUPLICATE_JOINT, part.element, "name", joint=hinge.name, line=line)
                return []
        for hinge in hinges:
            known[hinge.name] = part.element
            self.tree.references[hinge.name] = hinge.reference
        return hinges

    def _geoms(self, parts: list[Part]) -> list[Geom]:
        """The geometries of a body, in its frame."""
        found: list[Geom] = []
        for part in parts:
            if part.element.tag == "geom":
                library = part.scope.library
                geom = read_geom(
                    self.reading, library.settings.apply_defaults(self.reading, part.element, part.childclass), library
                )
                if geom is not None:
                    found.append(geom.in_frame(part.T))
        return found


def _site_pose(reading: Reading, part: Part) -> PoseMatrix:
    """The pose (4, 4) of a site in its body; where two points are given, its z axis joins them."""
    settings = part.scope.library.settings
    element = settings.apply_defaults(reading, part.element, part.childclass)
    ends = reading.vector(element, "fromto", 6) if "fromto" in element.attributes else None
    T = read_pose(reading, element, settings) if ends is None else along_line(np.array(ends))
    return frozen(part.T @ T)


def _three_hinges(reading: Reading, part: Part, styled: Element) -> Repair:
    """The repair that replaces a ball joint; what refers to it by its name is not repaired."""
    joint = part.element
    name = escape(joint.get("name"))
    names = {k: f' name="{name}_{k}"' if name else "" for k in "xyz"}
    position = f' pos="{escape(joint.get("pos"))}"' if "pos" in joint.attributes else ""
    axes = {k: " ".join(map(written, axis)) for k, axis in zip("xyz", part.T[:3, :3], strict=True)}
    text = "".join(f'<joint{names[k]} type="hinge" axis="{a}"{position}/>' for k, a in axes.items())
    (removal,) = reading.remove(joint).edits
    edits, loses = (Edit(removal.start, removal.end, text),), "armature" in styled.attributes
    return Repair("robotfile.repair_three_hinges", edits, guess=loses)


def _add_chain(tree: Tree, parent: str, T: PoseMatrix, body: str, hinges: list[Hinge]) -> None:
    """Joints from the parent link to a body: each turns about its own anchor, one after the other.

    T is the pose of the body in the parent link at the reference configuration. Between joints, and where the last
    anchor is not the body's origin, stand massless links; the link of the body keeps the body's frame.
    """
    before = T
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


def hung_frames(tree: Tree) -> list[Joint]:
    """Sites and named frames as links without mass, which are added to the tree, and the joints that fix them.

    Sites that only hold loops are none. One that is called like a body gets what it is behind its name.
    """
    taken = {*tree.elements, *tree.closing}
    each = [("site", name, place) for name, place in tree.sites.items() if name not in tree.holding]
    each += [("frame", name, place) for name, place in tree.frames.items()]
    joints: list[Joint] = []
    for kind, name, (body, T) in each:
        if body not in tree.left_out:
            link = name if name not in tree.poses else tree.free(f"{name}/{kind}", tree.poses)
            tree.poses[link] = frozen(tree.poses[body] @ T)
            tree.links.append(Link(link))
            joints.append(Joint(tree.free(f"{link}/attached", taken), JointKind.FIXED, body, link, T))
    return joints


def _link(name: str, inertial: Inertial | None, geoms: list[Geom]) -> Link:
    visuals = tuple(geom.shape for geom in geoms if geom.shape is not None and geom.seen)
    collisions = tuple(geom.shape for geom in geoms if geom.shape is not None and geom.collides)
    return Link(name, inertial, visuals, collisions)
