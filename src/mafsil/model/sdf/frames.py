"""Frames of a model: links, joints, frames and nested models, each given relative to another one.

Names as SDFormat holds them: one set for links, joints and frames of a model, and some words kept for itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from mafsil.arrays import PoseMatrix, frozen
from mafsil.model.faults import SDF_CIRCLE, SDF_FRAME
from mafsil.model.joint import Joint
from mafsil.model.link import Shape
from mafsil.model.mechanism import Mechanism
from mafsil.model.placement import inverse
from mafsil.model.reading import Reading
from mafsil.model.xml_tree import Element

WORLD = "world"


@dataclass(frozen=True, slots=True)
class Given:
    """A pose as the file gives it: relative to a frame of that full name."""

    relative_to: str
    T: PoseMatrix
    element: Element


@dataclass(slots=True)
class Frames:
    """Poses of all frames of a model by their full names.

    Attributes:
        given: as they stand in the file.
        T_ws: (4, 4) pose of the outermost model's frame in the world.
        of_joints: names under which the frames of joints stand that are called like something else, as up to 1.6.
    """

    given: dict[str, Given] = field(default_factory=dict[str, Given])
    T_ws: PoseMatrix = field(default_factory=lambda: frozen(np.eye(4)))
    of_joints: dict[str, str] = field(default_factory=dict[str, str])
    _known: dict[str, PoseMatrix] = field(default_factory=dict[str, PoseMatrix])

    def pose(self, reading: Reading, name: str, element: Element) -> PoseMatrix:
        """The pose (4, 4) of a frame in the outermost model's frame; an unknown one or a circle is reported.

        Args:
            reading: of the file.
            name: full name of the frame; `world` is the space in which the model stands.
            element: what asks for it.
        """
        if name == WORLD and WORLD not in self.given:
            return inverse(self.T_ws)
        chain: list[str] = []
        at = name
        while at not in self._known and at in self.given:
            if at in chain:
                reading.report(SDF_CIRCLE, element, None, None, name=name)
                return frozen(np.eye(4))
            chain.append(at)
            at = self.given[at].relative_to
        if at and at != WORLD and at not in self._known:
            reading.report(SDF_FRAME, element, None, None, name=at)
            return frozen(np.eye(4))
        T = inverse(self.T_ws) if at == WORLD else self._known.get(at, np.eye(4))
        for step in reversed(chain):
            T = T @ self.given[step].T
            self._known[step] = frozen(T)
        return self._known[name]

    def placement_frame(self, reading: Reading, name: str, element: Element) -> PoseMatrix:
        """The pose (4, 4) of the frame by which a model is placed, in the model, whose own place is not known yet."""
        T = self.pose(reading, name, element)
        self._known.clear()
        return T

    def joint(self, name: str) -> str:
        """The name of a joint's frame."""
        return self.of_joints.get(name, name)

    def between(self, reading: Reading, a: str, b: str, element: Element) -> PoseMatrix:
        """The pose (4, 4) of frame b in frame a."""
        return inverse(self.pose(reading, a, element)) @ self.pose(reading, b, element)


OWN_NAME = "mafsil:name"
"""Attribute of what has another name, or one that others bear too."""
SCOPE = "::"
RESERVED = "__"


@dataclass(slots=True)
class WrittenNames:
    """Names that are free in a model.

    Attributes:
        taken: so far.
    """

    taken: set[str] = field(default_factory=set[str])

    def free(self, name: str, ending: str = "_") -> str:
        """The name, or the next one that SDFormat takes and that is free; it is taken then.

        Args:
            name: as it should be.
            ending: for what is called like something else.
        """
        name = name.replace(SCOPE, "/")
        if name.startswith(RESERVED) and name.endswith(RESERVED):
            name = name.strip("_") or "_"
        while name in self.taken or name == WORLD:
            name += ending
        self.taken.add(name)
        return name


def stands_in_world(mechanism: Mechanism) -> bool:
    """Whether the base is the world itself, which carries what may hang on it."""
    base = mechanism.links[0]
    bare = base.is_bare and mechanism.tip != base.name
    return bare and base.name == WORLD and np.array_equal(mechanism.T_sb, np.eye(4))


def rename_for_sdf(mechanism: Mechanism) -> tuple[Mechanism, dict[str, str]]:
    """The mechanism with names that SDFormat takes, and those that had to be changed, new to old.

    Links keep theirs before joints do.
    """
    names = WrittenNames()
    in_world = [WORLD] if stands_in_world(mechanism) else []
    links = dict(zip(in_world, in_world, strict=True))
    links |= {name: names.free(name) for name in mechanism.link_names[len(in_world) :]}
    every = (*mechanism.joints, *mechanism.loops)
    joints = {joint.name: names.free(joint.name, "_joint") for joint in every}
    name = WrittenNames().free(mechanism.name)
    pairs = ((mechanism.name, name), *links.items(), *joints.items())
    return with_names(mechanism, name, links, joints), {new: old for old, new in pairs if old != new}


def with_names(mechanism: Mechanism, name: str, links: Mapping[str, str], joints: Mapping[str, str]) -> Mechanism:
    """The mechanism with another name, and other names of links and joints where there are some.

    Raises:
        ModelError: two would have the same.
    """
    tree, loops = (tuple(_call(joint, links, joints) for joint in of) for of in (mechanism.joints, mechanism.loops))
    each = tuple(replace(link, name=links.get(link.name, link.name)) for link in mechanism.links)
    own = mechanism
    return Mechanism.assemble(
        name, each, tree, loops=loops, tip=links.get(own.tip, own.tip), T_lt=own.T_lt, T_sb=own.T_sb,
        gravity=own.gravity, provenance=own.provenance,
    )  # fmt: skip


def named_shapes(shapes: tuple[Shape, ...], kind: str) -> Iterator[tuple[str, Shape]]:
    """The shapes with names that are there once."""
    names = WrittenNames()
    for shape in shapes:
        yield names.free(shape.name or kind), shape


def _call(joint: Joint, links: Mapping[str, str], joints: Mapping[str, str]) -> Joint:
    mimic = joint.mimic
    if mimic is not None:
        mimic = replace(mimic, leader=joints.get(mimic.leader, mimic.leader))
    ends = {end: links.get(name, name) for end, name in (("parent", joint.parent), ("child", joint.child))}
    return replace(joint, name=joints.get(joint.name, joint.name), mimic=mimic, **ends)
