"""Joints of SDFormat: a frame of their own, one axis or two, limits, friction; named frames and gearboxes with them.

Named frames become links without mass that hang on what they are attached to, or the tip of a robot of ours; what the
format has no word for stands in attributes of our own, which other readers pass over.

A gearbox couples the angles of two hinges on one body and is read as a mimic. With theta_1 the angle from the reference
body to the gearbox's parent about `axis`, and theta_2 that to its child about `axis2`, theta_2 is -gearbox_ratio
theta_1. The hinge of the child keeps its coordinate, the other one follows it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, pi

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, frozen
from mafsil.model.faults import (
    LIMITS_INVERTED,
    MISSING_ELEMENT,
    NEGATIVE_DAMPING,
    NOT_KEPT,
    SDF_GEARBOX,
    SDF_GEARBOX_RATIO,
    SDF_JOINT,
    ZERO_AXIS,
)
from mafsil.model.joint import Joint, JointKind, Mimic
from mafsil.model.limits import Actuator, Friction, Limits, bound_value
from mafsil.model.link import Link
from mafsil.model.mimics import Declared
from mafsil.model.placement import inverse
from mafsil.model.reading import Reading
from mafsil.model.sdf.frames import Frames
from mafsil.model.sdf.scope import MODEL, Part, Parts, flag, number, numbers
from mafsil.model.tolerances import SAME_POSE, WRITTEN
from mafsil.model.xml_tree import Element

KINDS = {
    "revolute": (JointKind.REVOLUTE,),
    "continuous": (JointKind.REVOLUTE,),
    "prismatic": (JointKind.PRISMATIC,),
    "screw": (JointKind.HELICAL,),
    "fixed": (JointKind.FIXED,),
    "universal": (JointKind.REVOLUTE, JointKind.REVOLUTE),
    "revolute2": (JointKind.REVOLUTE, JointKind.REVOLUTE),
    "ball": (JointKind.REVOLUTE, JointKind.REVOLUTE, JointKind.REVOLUTE),
}
"""Joints of one freedom after one another for every type that can be read."""
ENDS = ("parent", "child")
ACCELERATION, GEAR_RATIO, ROTOR_INERTIA = "drake:acceleration", "drake:gear_ratio", "drake:rotor_inertia"


@dataclass(frozen=True, slots=True)
class Chain:
    """What a joint becomes: joints in a row, and massless links between them.

    Attributes:
        joints: from parent to child; the last one leads to a frame at the joint, `T_jc` before the child's own.
        links: between them.
        parent, child: full names.
        T_jc: (4, 4) pose of the child in the joint's frame at zero.
    """

    joints: list[Declared]
    links: list[Link]
    parent: str
    child: str
    T_jc: PoseMatrix


def read_joint(reading: Reading, part: Part, parts: Parts, version: tuple[int, int]) -> Chain | None:
    """A joint, or None after an error that leaves nothing to go on with."""
    element, name, frames = part.element, part.name, parts.frames
    kind = element.get("type")
    ends = [reading.one(element, tag) for tag in ENDS]
    if kind not in KINDS:
        reading.report(SDF_JOINT, element, "type", None, joint=name, kind=kind, known=", ".join(KINDS))
        return None
    missing = [tag for tag, end in zip(ENDS, ends, strict=True) if end is None or not end.text]
    if missing:
        reading.report(MISSING_ELEMENT, element, None, None, element=missing[0], parent="joint")
        return None
    parent, child = (parts.carrier(part.full(end.text)) for end in ends if end is not None)
    T_pj = frames.between(reading, parent, frames.joint(name), element)
    T_jc = frames.between(reading, frames.joint(name), child, element)
    joints: list[Declared] = []
    links: list[Link] = []
    kinds = KINDS[kind]
    for k, one in enumerate(kinds):
        last = k == len(kinds) - 1
        end = f"{name}/frame" if last else f"{name}/between{'' if k == 0 else k + 1}"
        own, start = name if k == 0 else f"{name}/axis{k + 1}", parent if k == 0 else links[-1].name
        if kind == "ball":
            joint = Joint(own, one, start, end, frozen(T_pj), frozen(np.eye(3)[k]), wraps=True, actuated=False)
        else:
            axis = reading.one(element, "axis" if k == 0 else "axis2")
            joint = _one(reading, part, axis, frames, version, one, own, start, end, T_pj)
            joint = replace(joint, actuator=_actuator(reading, part.element)) if len(kinds) == 1 else joint
        if not last:
            links.append(Link(end))
        joints.append(Declared(joint, element))
        T_pj = frozen(np.eye(4))
    return Chain(joints, links, parent, child, frozen(T_jc))


def _one(
    reading: Reading, part: Part, axis: Element | None, frames: Frames, version: tuple[int, int], kind: JointKind,
    name: str, parent: str, child: str, T_pj: PoseMatrix,
) -> Joint:  # fmt: skip
    """A joint of one freedom."""
    pose = frozen(T_pj)
    if kind is JointKind.FIXED:
        return Joint(name, kind, parent, child, pose)
    if axis is None:
        reading.report(MISSING_ELEMENT, part.element, None, None, element="axis", parent="joint")
        return Joint(name, kind, parent, child, pose)
    along = direction(reading, part, axis, frames, version)
    limits = _limits(reading, axis, name, ranged=part.element.get("type") != "continuous")
    wraps = kind is JointKind.REVOLUTE and limits.lower == -inf and limits.upper == inf
    pitch = _pitch(reading, part.element) if kind is JointKind.HELICAL else 0.0
    mimic, friction = _mimic(reading, part, axis), _friction(reading, axis)
    driven = limits.effort > 0.0 and not _sprung(axis)
    return Joint(name, kind, parent, child, pose, frozen(along), pitch, limits, wraps, driven, mimic, None, friction)


def _sprung(axis: Element) -> bool:
    """Whether a spring moves the joint: a motor would have to overcome it, so that none is there."""
    dynamics = axis.first("dynamics")
    stiffness = None if dynamics is None else dynamics.first("spring_stiffness")
    return stiffness is not None and stiffness.text.strip() not in ("", "0", "0.0")


def direction(reading: Reading, part: Part, axis: Element, frames: Frames, version: tuple[int, int]) -> Floats:
    """The unit axis (3,) in the joint's frame.

    It is given in the joint's frame, or in another one by `expressed_in` (from 1.7), or in the model's frame: always up
    to 1.4, by `use_parent_model_frame` from 1.5 to 1.6.

    Args:
        reading: takes the errors.
        part: the joint.
        axis: element with `xyz`.
        frames: of the model.
        version: of the file.
    """
    holder = reading.one(axis, "xyz")
    xyz = np.array(numbers(reading, holder, 3, (0.0, 0.0, 1.0)))
    length = float(np.linalg.norm(xyz))
    if length < WRITTEN:
        reading.report(ZERO_AXIS, axis, None, None, joint=part.name)
        return np.array([0.0, 0.0, 1.0])
    expressed = "" if holder is None else holder.get("expressed_in")
    in_model = flag(reading, axis, "use_parent_model_frame", default=version <= (1, 4))
    if not expressed and not (in_model and version < (1, 7)):
        return xyz / length
    frame = part.full(expressed)
    R = frames.between(reading, frames.joint(part.name), frame, axis)[:3, :3]
    turned = R @ xyz
    return turned / np.linalg.norm(turned)


def _limits(reading: Reading, axis: Element, name: str, *, ranged: bool) -> Limits:
    element = reading.one(axis, "limit")
    if element is None:
        return Limits()
    lower, upper = (
        number(reading, element, tag, sign * inf, infinite=True) for tag, sign in (("lower", -1), ("upper", 1))
    )
    lower, upper = bound_value(lower), bound_value(upper)
    velocity, effort = (number(reading, element, tag, inf, infinite=True) for tag in ("velocity", "effort"))
    if lower > upper:
        reading.report(LIMITS_INVERTED, element, None, None, joint=name, lower=lower, upper=upper)
        return Limits()
    bounds = (lower, upper) if ranged else (-inf, inf)
    velocity, effort = (bound_value(value) if value >= 0 else inf for value in (velocity, effort))
    acceleration = number(reading, element, ACCELERATION, inf, infinite=True)
    return Limits(*bounds, velocity, bound_value(acceleration) if acceleration >= 0 else inf, effort=effort)


def _actuator(reading: Reading, joint: Element) -> Actuator | None:
    """Gear and rotor in the words of Drake."""
    if joint.first(GEAR_RATIO) is None and joint.first(ROTOR_INERTIA) is None:
        return None
    rotor, ratio = number(reading, joint, ROTOR_INERTIA, 0.0), number(reading, joint, GEAR_RATIO, 1.0)
    if ratio == 0.0 or rotor < 0.0:
        reading.report(NOT_KEPT, joint, None, None, what=ROTOR_INERTIA if ratio else GEAR_RATIO, element="joint")
        return None
    return Actuator(rotor, ratio)


def _pitch(reading: Reading, joint: Element) -> float:
    """Advance per angle [m/rad]: `screw_thread_pitch` is metres per turn, the older `thread_pitch` is -1 over it."""
    if joint.first("screw_thread_pitch") is not None:
        return number(reading, joint, "screw_thread_pitch", 1.0) / (2 * pi)
    older = number(reading, joint, "thread_pitch", 1.0)
    return -1.0 / older if older else 0.0


def _friction(reading: Reading, axis: Element) -> Friction | None:
    element = reading.one(axis, "dynamics")
    if element is None:
        return None
    values = [number(reading, element, tag, 0.0) for tag in ("damping", "friction")]
    for tag, value in zip(("damping", "friction"), values, strict=True):
        if value < 0.0:
            reading.report(NEGATIVE_DAMPING, element, None, None, attribute=tag, value=value)
            return None
    if number(reading, element, "spring_stiffness", 0.0) != 0.0:
        reading.report(NOT_KEPT, element, None, None, what="spring_stiffness", element="dynamics")
    return Friction(*values) if any(values) else None


def _mimic(reading: Reading, part: Part, axis: Element) -> Mimic | None:
    """Q = multiplier (leader - reference) + offset; Drake writes it on the joint, without a reference."""
    element = reading.one(axis, "mimic")
    drake = reading.one(part.element, "drake:mimic") if element is None else None
    if drake is not None:
        slope, offset = reading.number(drake, "multiplier", 1.0), reading.number(drake, "offset", 0.0)
        return None if slope is None or offset is None else Mimic(part.full(drake.get("joint")), slope, offset)
    if element is None:
        return None
    multiplier, offset = number(reading, element, "multiplier", 1.0), number(reading, element, "offset", 0.0)
    leader = part.full(element.get("joint"))
    if element.get("axis") == "axis2":
        leader += "/axis2"
    return Mimic(leader, multiplier, offset - multiplier * number(reading, element, "reference", 0.0))


def fixed_joint(name: str, parent: str, child: str, T: PoseMatrix) -> Joint:
    """A joint that does not move."""
    return Joint(name, JointKind.FIXED, parent, child, frozen(T))


def is_identity(T: PoseMatrix) -> bool:
    """Whether a pose is the identity to rounding."""
    return bool(np.abs(T - np.eye(4)).max() < SAME_POSE)


def invert_pose(T: PoseMatrix) -> PoseMatrix:
    """The inverse pose, frozen."""
    return frozen(inverse(T))


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
