"""Names as SDFormat holds them: one set for links, joints and frames of a model, and some words kept for itself."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from mafsil.model.joint import Joint
from mafsil.model.mechanism import Mechanism
from mafsil.model.sdf.frames import WORLD
from mafsil.model.shape import Shape

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
