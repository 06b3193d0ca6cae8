"""Gear ratios from the simple transmissions of a URDF file: one joint, one actuator, one reduction."""

from __future__ import annotations

from dataclasses import replace

from mafsil.model.actuator import Actuator
from mafsil.model.faults import TRANSMISSION_IGNORED
from mafsil.model.joint import Joint
from mafsil.model.numbers import decimal
from mafsil.model.reading import Reading
from mafsil.model.xml_tree import Element


def read_transmissions(reading: Reading, robot: Element, joints: list[Joint]) -> list[Joint]:
    """The joints with the gear ratios that the simple transmissions give them."""
    known = {joint.name for joint in joints if joint.moves}
    ratios: dict[str, float] = {}
    for element in robot.all("transmission"):
        found = _simple(element)
        if found is None or found[0] not in known or found[0] in ratios:
            reading.report(TRANSMISSION_IGNORED, element, name=element.get("name"))
        else:
            ratios[found[0]] = found[1]
    return [_geared(joint, ratios) for joint in joints]


def _geared(joint: Joint, ratios: dict[str, float]) -> Joint:
    return replace(joint, actuator=Actuator(gear_ratio=ratios[joint.name])) if joint.name in ratios else joint


def _simple(element: Element) -> tuple[str, float] | None:
    """Joint and reduction of a transmission, if it is simple and its reduction is a number other than zero."""
    joints, actuators = element.all("joint"), element.all("actuator")
    if len(joints) != 1 or len(actuators) != 1:
        return None
    places = [place for holder in (actuators[0], joints[0], element) for place in holder.all("mechanicalReduction")]
    if not places:
        return joints[0].get("name"), 1.0
    ratio, fault = decimal(places[0].text)
    return (joints[0].get("name"), ratio) if fault is None and ratio != 0.0 else None
