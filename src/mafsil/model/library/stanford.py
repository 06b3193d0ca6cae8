"""The Stanford arm of Scheinman: RRPRRR, classic Denavit-Hartenberg convention."""

from __future__ import annotations

from math import pi, radians

import numpy as np

from mafsil.arrays import frozen
from mafsil.model.actuator import Actuator
from mafsil.model.denavit_hartenberg import DHRow, mechanism_from_dh
from mafsil.model.library.masses import Three
from mafsil.model.library.outline import Drum, Outline, Tube, housing, with_outline
from mafsil.model.limits import Limits
from mafsil.model.link import Inertial
from mafsil.model.mechanism import Mechanism, Provenance
from mafsil.model.placement import translation

_INCH = 0.0254

_MASSES = (
    (9.29, (0.0, 0.0175, -0.1105), (0.276, 0.255, 0.071)),
    (5.01, (0.0, -0.1054, 0.0), (0.108, 0.018, 0.100)),
    (4.25, (0.0, 0.0, -0.6447), (2.51, 2.51, 0.006)),
    (1.08, (0.0, 0.0092, -0.0054), (0.002, 0.001, 0.001)),
    (0.63, (0.0, 0.0566, 0.0030), (0.003, 0.0004, 0.003)),
    (0.51, (0.0, 0.0, 0.1554), (0.013, 0.013, 0.0003)),
)
"""Mass [kg], centre of mass [m], moments about the origin of the table's frame [kg m^2]."""

_ARMATURES = (0.953, 2.193, 0.782, 0.106, 0.097, 0.020)

_OUTLINE: Outline = {
    "base": [housing(0.09, (0, 0, 0), (0, 0, 0.25))],
    "link1": [housing(0.075, (0, 0, 0.25), (0, 0, 0.49))],
    "link2": [housing(0.065, (0, 0, 0.08), (0, 0, 0.2))],
    "link3": [Tube(0.035, (0, 0, -1.29), (0, 0, -0.03))],
    "link5": [Tube(0.03, (0, 0, 0), (0, 0.03, 0))],
    "link6": [Drum(0.035, (0, 0, 0.05), (0, 0, 10.35 * _INCH))],
}
_OUTLINE_SOURCE = (
    "capsules along the published lengths, radii 75 mm (column), 65 mm (shoulder), 35 mm (boom of 1.3 m and hand,"
    " flat at the tip): estimated, the boom's length after its centre of mass; not compared with a model"
)


def stanford_arm() -> Mechanism:
    """Stanford arm: two revolute joints, a prismatic boom, a spherical wrist; the tip lies between the finger tips.

    Reference: R. P. Paul, Modelling, trajectory calculation and servoing of a computer controlled arm, Stanford
    AIM-177, 1972 (kinematics); R. P. Paul, Robot manipulators, MIT Press 1981, tables 6.5 and 6.6 (masses), after
    A. K. Bejczy, Robot arm dynamics and control, JPL TM 33-669, 1974.
    """
    half_turn = Limits(radians(-170), radians(170))
    bare = mechanism_from_dh(
        (
            DHRow(d=16.24 * _INCH, alpha=-pi / 2),
            DHRow(d=6.05 * _INCH, alpha=pi / 2),
            DHRow(theta=-pi / 2, kind="P"),
            DHRow(alpha=-pi / 2),
            DHRow(alpha=pi / 2),
            DHRow(),
        ),
        "classic",
        tool=translation(0.0, 0.0, 10.35 * _INCH),
        name="stanford_arm",
        inertials=[_about_origin(*row) for row in _MASSES],
        limits=[
            half_turn,
            half_turn,
            Limits(12 * _INCH, 50 * _INCH),
            half_turn,
            Limits(radians(-90), radians(90)),
            half_turn,
        ],
        actuators=[Actuator(armature=value) for value in _ARMATURES],
        provenance=Provenance(
            source="Paul, AIM-177, 1972, and Robot manipulators, 1981; numbers as collected in the Robotics Toolbox",
            notes=(
                "link length a3 is 0 as in Paul's figure 2.3; some collections print 0.0203 m, which is the PUMA's",
                "centres of mass: the collected table mixes metres with tenths; taken here as Paul's centimetres,"
                " for example -64.47 cm for the boom, not -6.447 m",
                "moments taken about the origins of the table's frames: about the centres of mass they would give"
                " links far longer than they are (hand: 0.16 m radius of gyration)",
                "link 5: the moment about z is printed 0, which no rigid body with the other two has; 0.003 guessed",
                "gear ratios unknown; the reflected inertia of the drives is given as armature",
                "q3 = 0 lies outside the range of the boom (0.3048 .. 1.27 m)",
            ),
        ),
    )
    return with_outline(bare, _OUTLINE, _OUTLINE_SOURCE)


def _about_origin(mass: float, com: Three, moments: Three) -> Inertial:
    """Moments about the frame's origin, moved to the centre of mass."""
    c = np.array(com)
    shift = mass * (c @ c * np.eye(3) - np.outer(c, c))
    return Inertial(mass, frozen(com), frozen(np.diag(moments) - shift))
