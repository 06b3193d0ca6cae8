"""Gearboxes of SDFormat: joints that couple the angles of two hinges on one body, read as a mimic.

With theta_1 the angle from the reference body to the gearbox's parent about `axis`, and theta_2 that to its child about
`axis2`, theta_2 = -gearbox_ratio theta_1. The hinge of the child keeps its coordinate, the other one follows it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mafsil.arrays import Floats
from mafsil.model.faults import MISSING_ELEMENT, SDF_GEARBOX, SDF_GEARBOX_RATIO
from mafsil.model.joint import JointKind, Mimic
from mafsil.model.mimics import Declared
from mafsil.model.reading import Reading
from mafsil.model.sdf.frames import Frames
from mafsil.model.sdf.joint import Chain, direction
from mafsil.model.sdf.scope import Part, number

GEARBOX = "gearbox"
PARALLEL = 1e-6
"""One less the cosine up to which axes are parallel: nine typed digits."""


@dataclass(frozen=True, slots=True)
class _Side:
    """A hinge on the reference body, and the sign of its coordinate against the gearbox's angle."""

    joint: str
    sign: float


def couple_gearboxes(
    reading: Reading, parts: Sequence[Part], frames: Frames, version: tuple[int, int], chains: Sequence[Chain]
) -> list[Chain]:
    """The joints, those that a gearbox lets follow another as mimics.

    Args:
        reading: takes the errors.
        parts: the gearboxes.
        frames: of the model.
        version: of the file.
        chains: all other joints.
    """
    mimics: dict[str, Mimic] = {}
    for part in parts:
        found = _coupling(reading, part, frames, version, chains)
        if found is not None:
            mimics[found[0]] = found[1]
    return [_following(chain, mimics) for chain in chains]


def _following(chain: Chain, mimics: dict[str, Mimic]) -> Chain:
    first = chain.joints[0]
    mimic = mimics.get(first.joint.name)
    if mimic is None:
        return chain
    return replace(chain, joints=[Declared(replace(first.joint, mimic=mimic), first.element), *chain.joints[1:]])


def _coupling(
    reading: Reading, part: Part, frames: Frames, version: tuple[int, int], chains: Sequence[Chain]
) -> tuple[str, Mimic] | None:
    """The hinge that follows, and how; None after an error."""
    element, names = part.element, dict[str, str]()
    for tag in ("parent", "child", "gearbox_reference_body"):
        found = reading.one(element, tag)
        if found is None or not found.text:
            reading.report(MISSING_ELEMENT, element, None, None, element=tag, parent="joint")
            return None
        names[tag] = part.full(found.text)
    ratio = number(reading, element, "gearbox_ratio", 1.0)
    if ratio == 0.0:
        reading.report(SDF_GEARBOX_RATIO, element, None, None, joint=part.name)
        return None
    sides: list[_Side] = []
    for end, tag in (("parent", "axis"), ("child", "axis2")):
        axis = reading.one(element, tag)
        if axis is None:
            reading.report(MISSING_ELEMENT, element, None, None, element=tag, parent="joint")
            return None
        about = direction(reading, part, axis, frames, version)
        side = _side(reading, part, frames, names["gearbox_reference_body"], names[end], about, chains)
        if side is None:
            return None
        sides.append(side)
    first, second = sides
    return first.joint, Mimic(second.joint, -first.sign * second.sign / ratio)


def _side(
    reading: Reading, part: Part, frames: Frames, reference: str, body: str, about: Floats, chains: Sequence[Chain]
) -> _Side | None:
    """The hinge between the reference body and another about an axis (3,) in the gearbox's frame."""
    for chain in chains:
        own = chain.joints[0].joint
        outward = (chain.parent, chain.child) == (reference, body)
        if len(chain.joints) > 1 or own.kind is not JointKind.REVOLUTE:
            continue
        if not outward and (chain.child, chain.parent) != (reference, body):
            continue
        ends = [frames.joint(name) for name in (part.name, own.name)]
        T = frames.between(reading, ends[0], ends[1], part.element)
        along = float(about @ T[:3, :3] @ np.asarray(own.axis))
        if 1.0 - abs(along) < PARALLEL:
            return _Side(own.name, float(np.sign(along)) * (1.0 if outward else -1.0))
    reading.report(SDF_GEARBOX, part.element, None, None, joint=part.name, reference=reference, link=body)
    return None
