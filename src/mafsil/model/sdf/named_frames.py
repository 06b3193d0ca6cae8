"""Named frames of SDFormat: links without mass that hang on what they are attached to, or the tip of a robot of ours.

What the format has no word for stands in attributes of our own, which other readers pass over.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import PoseMatrix, frozen
from mafsil.model.mimics import Declared
from mafsil.model.reading import Reading
from mafsil.model.sdf.joint import Chain, fixed_joint
from mafsil.model.sdf.scope import MODEL, Part, Parts

IS_BASE = "mafsil:base"
"""Attribute of a joint that holds the base in the space; it is no joint of the robot."""
IS_TIP = "mafsil:tip"
"""Attribute of the frame that is the tip of the robot, and no link."""
OWN_JOINT = "mafsil:joint"
"""Attribute of a frame that is a link without mass: the name of the fixed joint that carries it."""


def read_frame(reading: Reading, part: Part, parts: Parts) -> Chain:
    """A frame as a link behind a fixed joint.

    Args:
        reading: takes the errors.
        part: the frame.
        parts: of the robot.
    """
    parent = _carrier(part, parts)
    T = parts.frames.between(reading, parent, part.name, part.element)
    joint = fixed_joint(part.element.get(OWN_JOINT) or f"{part.name}/attached", parent, part.name, T)
    return Chain([Declared(joint, part.element)], [], parent, part.name, frozen(np.eye(4)))


def tip_frame(reading: Reading, parts: Parts) -> tuple[str | None, PoseMatrix | None]:
    """The link of the tip and the pose (4, 4) of its frame there, where the file says so."""
    for part in parts.of("frame"):
        if part.element.get(IS_TIP):
            link = _carrier(part, parts)
            return link, parts.frames.between(reading, link, part.name, part.element)
    return None, None


def _carrier(part: Part, parts: Parts) -> str:
    return parts.carrier(part.full(part.element.get("attached_to") or MODEL))
