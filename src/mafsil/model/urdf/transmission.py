"""Gears and rotors from the simple transmissions of a URDF file: one joint, one actuator, one reduction.

The inertia of a rotor is `motorInertia`, on the motor's side, or stands in Drake's words; it is felt at the joint times
the square of the reduction.
"""

from __future__ import annotations

from dataclasses import replace

from mafsil.model.actuator import Actuator
from mafsil.model.faults import TRANSMISSION_IGNORED
from mafsil.model.joint import Joint
from mafsil.model.numbers import decimal
from mafsil.model.reading import Reading
from mafsil.model.xml_tree import Element


def read_transmissions(reading: Reading, robot: Element, joints: list[Joint]) -> list[Joint]:
    """The joints with the gear ratios and the rotors' inertias of the simple transmissions."""
    known = {joint.name for joint in joints if joint.moves}
    actuators: dict[str, Actuator] = {}
    for element in robot.all("transmission"):
        name, actuator = _simple(element)
        if actuator is None or name not in known or name in actuators:
            reading.report(TRANSMISSION_IGNORED, element, name=element.get("name"))
        else:
            actuators[name] = actuator
    return [replace(joint, actuator=actuators.get(joint.name, joint.actuator)) for joint in joints]


def _simple(element: Element) -> tuple[str, Actuator | None]:
    """Joint and motor of a transmission, if it is simple and its numbers are none but good ones."""
    joints, actuators = element.all("joint"), element.all("actuator")
    if len(joints) != 1 or len(actuators) != 1:
        return "", None
    name, gears = joints[0].get("name"), actuators[0].all("drake:gear_ratio")
    places = [place for holder in (actuators[0], joints[0], element) for place in holder.all("mechanicalReduction")]
    words = [gears[0].get("value")] if gears else [place.text for place in places[:1]]
    rotors = [rotor.get("value") for rotor in actuators[0].all("drake:rotor_inertia")]
    rotors += [place.text for holder in (actuators[0], joints[0], element) for place in holder.all("motorInertia")]
    numbers = [decimal(word.strip()) for word in (*(words or ["1"]), *(rotors[:1] or ["0"]))]
    if any(fault is not None for _, fault in numbers):
        return name, None
    (ratio, _), (rotor, _) = numbers
    return name, None if ratio == 0.0 or rotor < 0.0 else Actuator(rotor, ratio)
