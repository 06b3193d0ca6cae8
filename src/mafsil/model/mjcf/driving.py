"""Actuators and tendons of MJCF: gears, effort limits, and the inertia and damping that they add to joints."""

from __future__ import annotations

from dataclasses import replace
from math import inf

from mafsil.model.faults import NOT_KEPT, TENDON_ARMATURE
from mafsil.model.joint import Joint
from mafsil.model.limits import Actuator, Friction
from mafsil.model.mjcf.closure import References
from mafsil.model.mjcf.joint import is_limited, magnitude
from mafsil.model.mjcf.scope import Scope
from mafsil.model.mjcf.settings import Settings
from mafsil.model.reading import Reading
from mafsil.model.xml_tree import Element

Lever = dict[str, float]
"""How far a tendon runs per rate of each joint."""


class Driving:
    """Puts motors and tendons onto joints.

    Args:
        references: where names are looked up.
        joints: with their couplings resolved.
    """

    def __init__(self, references: References, joints: list[Joint]) -> None:
        self.references = references
        self.joints = {joint.name: joint for joint in joints}
        self.tendons: dict[str, Lever] = {}
        self.spatial: set[str] = set()
        self.driven: set[str] = set()

    def finish(self) -> list[Joint]:
        """The joints with all that drives them; where there are actuators, joints without one are passive."""
        for child, scope in self.references.sections("tendon"):
            self._tendon(scope.library.settings.apply_defaults(self.references.reading, child, "", "tendon"), scope)
        for child, scope in self.references.sections("actuator"):
            self._actuator(scope.library.settings.apply_defaults(self.references.reading, child, ""), scope)
        if not self.driven:
            return list(self.joints.values())
        return [_passive(joint, self.driven) for joint in self.joints.values()]

    def _tendon(self, element: Element, scope: Scope) -> None:
        reading = self.references.reading
        name = scope.full_name(element.get("name"))
        armature = magnitude(reading, element, "armature")
        if element.tag == "spatial":
            self.spatial.add(name)
            if armature:
                reading.report(TENDON_ARMATURE, element, "armature", tendon=name, armature=armature)
            return
        wraps = element.all("joint")
        coefficients = [reading.number(wrap, "coef") or 0.0 for wrap in wraps]
        for row in self.references.joints(element, [wrap.get("joint") for wrap in wraps], scope) if wraps else ():
            lever: Lever = {}
            for joint, coefficient in zip(row, coefficients, strict=True):
                lever[joint] = lever.get(joint, 0.0) + coefficient
            self.tendons[name + row[0].removeprefix(scope.prefix + wraps[0].get("joint") + scope.suffix)] = lever
            self._add_inertia(element, name, lever, armature)

    def _add_inertia(self, element: Element, tendon: str, lever: Lever, armature: float) -> None:
        """Armature J' J of a tendon: expressed where all its joints are coupled to one coordinate."""
        along, bent = Lever(), False
        for name, coefficient in lever.items():
            joint = self.joints[name]
            if not joint.moves:
                continue
            owner, factor = (name, 1.0) if joint.mimic is None else (joint.mimic.leader, joint.mimic.multiplier)
            bent = bent or bool(coefficient and joint.mimic is not None and joint.mimic.higher)
            along[owner] = along.get(owner, 0.0) + coefficient * factor
        moved = {name: length for name, length in along.items() if length}
        if not armature or not moved:
            return
        if len(moved) > 1 or bent:
            reading = self.references.reading
            reading.report(TENDON_ARMATURE, element, "armature", tendon=tendon, armature=armature)
            return
        ((owner, length),) = moved.items()
        self._add(owner, armature * length**2, 0.0)

    def _add(self, name: str, armature: float, damping: float) -> None:
        """More inertia and viscous friction on a joint."""
        joint = self.joints[name]
        if armature:
            actuator = joint.actuator or Actuator()
            joint = replace(joint, actuator=replace(actuator, armature=actuator.armature + armature))
        if damping:
            friction = joint.friction or Friction()
            joint = replace(joint, friction=replace(friction, viscous=friction.viscous + damping))
        self.joints[name] = joint

    def _actuator(self, element: Element, scope: Scope) -> None:
        reading = self.references.reading
        if "tendon" in element.attributes:
            self._pulls(element, scope)
            return
        name = element.get("joint") or element.get("jointinparent")
        if not name:
            if not any(key in element.attributes for key in ("site", "body", "slidersite", "cranksite")):
                reading.report(NOT_KEPT, element, None, None, element="actuator", what=element.tag)
            return
        gear, settings = _gear(reading, element), scope.library.settings
        armature, damping = _added(reading, element, settings)
        for (joint,) in self.references.joints(element, [name], scope):
            self._add(joint, gear**2 * armature, gear**2 * damping)
            if joint not in self.driven:
                self.driven.add(joint)
                self.joints[joint] = _drive(reading, element, self.joints[joint], gear, settings)

    def _pulls(self, element: Element, scope: Scope) -> None:
        """An actuator on a tendon drives all its joints; its share of each is no gear of a joint, which is said."""
        reading = self.references.reading
        tendon = scope.full_name(element.get("tendon"))
        reading.report(NOT_KEPT, element, "tendon", element=element.tag, what="tendon")
        gear = _gear(reading, element)
        armature, _ = _added(reading, element, scope.library.settings)
        if armature and tendon in self.spatial:
            reading.report(TENDON_ARMATURE, element, "armature", tendon=tendon, armature=armature)
        for name, lever in self.tendons.items():
            if name == tendon:
                self.driven.update(lever)
                self._add_inertia(element, tendon, lever, gear**2 * armature)


def _gear(reading: Reading, element: Element) -> float:
    """The first number of the gear: the only one that acts on a hinge or slide."""
    words = element.get("gear", "1").split()
    gears = reading.vector(element, "gear", len(words), (1.0,)) if 1 <= len(words) <= 6 else None
    return gears[0] if gears else 1.0


def _added(reading: Reading, element: Element, settings: Settings) -> tuple[float, float]:
    """Inertia and damping of a motor, on its own side."""
    damping = magnitude(reading, element, "damping")
    return magnitude(reading, element, "armature"), 0.0 if "damper" in settings.off else damping


def _drive(reading: Reading, element: Element, joint: Joint, gear: float, settings: Settings) -> Joint:
    """A joint with the gear and the effort limit of its actuator."""
    effort = _largest(reading, element, "forcelimited", "forcerange", settings)
    if element.tag == "motor":
        effort = min(effort, _largest(reading, element, "ctrllimited", "ctrlrange", settings))
    effort = min(joint.limits.effort, effort * abs(gear) if gear else inf)
    armature = 0.0 if joint.actuator is None else joint.actuator.armature
    actuator = Actuator(gear_ratio=gear or 1.0, armature=armature)
    return replace(joint, actuator=actuator, limits=replace(joint.limits, effort=effort or inf))


def _largest(reading: Reading, element: Element, flag: str, attribute: str, settings: Settings) -> float:
    """The larger end of a range, or infinity where it does not hold."""
    if not is_limited(reading, element, flag, attribute, settings):
        return inf
    ends = reading.vector(element, attribute, 2)
    return inf if ends is None else max(abs(ends[0]), abs(ends[1]))


def _passive(joint: Joint, driven: set[str]) -> Joint:
    return replace(joint, actuated=joint.name in driven) if joint.moves and joint.mimic is None else joint
