"""Hinges and slides of MJCF."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from mafsil.arrays import PoseMatrix, Vector3, Vector6, frozen
from mafsil.model.faults import BALL_ARMATURE, LIMITS_INVERTED, NEGATIVE_DAMPING, NOT_KEPT, UNKNOWN_TYPE, ZERO_AXIS
from mafsil.model.joint import Joint, JointKind
from mafsil.model.limits import Actuator, Friction, Limits, bound_value
from mafsil.model.mjcf.settings import Settings, choice
from mafsil.model.reading import Reading, written
from mafsil.model.tolerances import NO_LENGTH
from mafsil.model.xml_tree import Element

KINDS = {"hinge": JointKind.REVOLUTE, "slide": JointKind.PRISMATIC}


@dataclass(frozen=True, eq=False, slots=True)
class Hinge:
    """One MJCF joint before it is placed.

    Attributes:
        name, kind: of the joint.
        position: (3,) anchor in the body frame [m].
        axis: (3,) unit direction in the body frame.
        reference: the file's coordinate in the drawn configuration [rad | m].
        limits, wraps, actuator, friction: as for a Joint.
    """

    name: str
    kind: JointKind
    position: Vector3
    axis: Vector3
    reference: float
    limits: Limits
    wraps: bool
    actuator: Actuator | None
    friction: Friction | None

    @property
    def screw(self) -> Vector6:
        """(6,) screw axis about the anchor."""
        zero = np.zeros(3)
        return np.concatenate([self.axis, zero] if self.kind is JointKind.REVOLUTE else [zero, self.axis])

    def joint(self, parent: str, child: str, T_pj: PoseMatrix) -> Joint:
        """The joint between two links."""
        return Joint(
            self.name, self.kind, parent, child, T_pj, self.axis,
            limits=self.limits, wraps=self.wraps, actuator=self.actuator, friction=self.friction,
        )  # fmt: skip


def read_joint(reading: Reading, element: Element, name: str, settings: Settings, T: PoseMatrix) -> Hinge | None:
    """A hinge or slide whose default class is already filled in; None after an error.

    Args:
        reading, element, settings: where it stands.
        name: of the joint.
        T: (4, 4) pose of the frame it stands in, in the body.
    """
    word = element.get("type", "hinge")
    if word not in KINDS:
        known = ", ".join((*KINDS, "ball", "free"))
        reading.report(
            UNKNOWN_TYPE, element, "type", reading.set_attribute(element, "type", "hinge"),
            joint=name, kind=word, known=known,
        )  # fmt: skip
        return None
    kind = KINDS[word]
    factor = settings.degree if kind is JointKind.REVOLUTE else 1.0
    position = reading.vector(element, "pos", 3, (0.0, 0.0, 0.0))
    axis = _read_axis(reading, element, name)
    reference = reading.number(element, "ref", 0.0)
    limits = _read_limits(reading, element, name, factor, settings)
    actuator, friction = _read_resistance(reading, element, settings)
    if not name or position is None or axis is None or reference is None:
        return None
    position = T[:3, :3] @ np.array(position) + T[:3, 3]
    axis = frozen(T[:3, :3] @ axis)
    wraps = kind is JointKind.REVOLUTE and limits.lower == -inf and limits.upper == inf
    return Hinge(name, kind, frozen(position), axis, reference * factor, limits, wraps, actuator, friction)


def read_ball(reading: Reading, element: Element, name: str, T: PoseMatrix) -> list[Hinge]:
    """A ball joint as three hinges about the axes of the body; what acts on all of them alike is left out and said.

    Args:
        reading, element, T: as for `read_joint`.
        name: of the joint.
    """
    if armature := magnitude(reading, element, "armature"):
        reading.report(BALL_ARMATURE, element, "armature", joint=name, armature=armature)
    for attribute in ("damping", "frictionloss", "stiffness", "range"):
        if any(reading.vector(element, attribute, len(element.get(attribute).split()), (0.0,), largest=inf) or ()):
            what = f'{attribute}="{element.get(attribute)}"'
            reading.report(NOT_KEPT, element, attribute, element=element.tag, what=what)
    position = reading.vector(element, "pos", 3, (0.0, 0.0, 0.0))
    if not name or position is None:
        return []
    anchor, free = frozen(T[:3, :3] @ np.array(position) + T[:3, 3]), Limits(-inf, inf)
    axes, kind = zip("xyz", np.eye(3), strict=True), JointKind.REVOLUTE
    return [Hinge(f"{name}_{k}", kind, anchor, frozen(axis), 0.0, free, True, None, None) for k, axis in axes]


def _read_axis(reading: Reading, element: Element, name: str) -> Vector3 | None:
    xyz = reading.vector(element, "axis", 3, (0.0, 0.0, 1.0))
    if xyz is None:
        return None
    largest = max(abs(x) for x in xyz)
    if largest < NO_LENGTH:
        reading.report(ZERO_AXIS, element, "axis", reading.set_attribute(element, "axis", "0 0 1"), joint=name)
        return None
    scaled = np.array(xyz) / largest
    return frozen(scaled / np.linalg.norm(scaled))


def is_limited(reading: Reading, element: Element, flag: str, range_: str, settings: Settings) -> bool:
    """Whether a bound holds: by its flag, or by its mere presence where the compiler allows that."""
    word = choice(reading, element, flag, ("auto", "true", "false"), "auto")
    return range_ in element.attributes if word == "auto" and settings.autolimits else word == "true"


def _read_limits(reading: Reading, element: Element, name: str, factor: float, settings: Settings) -> Limits:
    lower, upper, effort = -inf, inf, inf
    if is_limited(reading, element, "limited", "range", settings):
        bounds = reading.vector(element, "range", 2, largest=inf)
        if bounds is not None and bounds[0] > bounds[1]:
            repair = reading.set_attribute(element, "range", f"{written(bounds[1])} {written(bounds[0])}")
            reading.report(LIMITS_INVERTED, element, "range", repair, joint=name, lower=bounds[0], upper=bounds[1])
        elif bounds is not None:
            lower, upper = bound_value(bounds[0]) * factor, bound_value(bounds[1]) * factor
    if is_limited(reading, element, "actuatorfrclimited", "actuatorfrcrange", settings):
        forces = reading.vector(element, "actuatorfrcrange", 2, largest=inf)
        effort = bound_value(max(abs(forces[0]), abs(forces[1]))) if forces is not None else inf
    return Limits(lower, upper, effort=effort or inf)


def _read_resistance(reading: Reading, element: Element, settings: Settings) -> tuple[Actuator | None, Friction | None]:
    """Armature, damping and friction."""
    armature = magnitude(reading, element, "armature")
    viscous = magnitude(reading, element, "damping")
    coulomb = magnitude(reading, element, "frictionloss")
    viscous = 0.0 if "damper" in settings.off else viscous
    coulomb = 0.0 if "frictionloss" in settings.off else coulomb
    actuator = Actuator(armature=armature) if armature else None
    return actuator, Friction(viscous, coulomb) if viscous or coulomb else None


def magnitude(reading: Reading, element: Element, attribute: str) -> float:
    """A number that must not be negative; of a polynomial in the rate the linear part, and the rest is said."""
    count = min(max(len(element.get(attribute).split()), 1), 3) if attribute == "damping" else 1
    fallback = reading.remove_attribute(element, attribute)
    values = reading.vector(element, attribute, count, (0.0,), fallback=fallback) or (0.0,)
    if any(values[1:]):
        reading.report(
            NOT_KEPT, element, attribute, element=element.tag, what=f'{attribute}="{element.get(attribute)}"'
        )
    if values[0] < 0.0:
        reading.report(NEGATIVE_DAMPING, element, attribute, fallback, attribute=attribute, value=values[0])
    return max(values[0], 0.0)
