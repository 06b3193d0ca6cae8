"""Arms of six joints by Denavit-Hartenberg tables: Unimation PUMA 560, Scheinman's Stanford arm, Mitsubishi RV-7FLM.

The PUMA has the consensus parameters of the classic convention; the Stanford arm is RRPRRR.
"""

from __future__ import annotations

from math import pi, radians

import numpy as np

from mafsil.arrays import frozen
from mafsil.model.denavit_hartenberg import DHRow, mechanism_from_dh
from mafsil.model.library.outline import Drum, Outline, Three, Tube, housing, inertial, with_outline, with_rods
from mafsil.model.limits import Actuator, Friction, Limits
from mafsil.model.link import Inertial
from mafsil.model.mechanism import Mechanism, Provenance
from mafsil.model.placement import translation

_MELFA_AXES = (
    (-240, 240, 288),
    (-110, 130, 321),
    (0, 162, 360),
    (-200, 200, 337),
    (-120, 120, 450),
    (-360, 360, 720),
)
"""Range from, to [deg], speed [deg/s] of joints J1 to J6."""
_MELFA_OUTLINE: Outline = {
    "base": [housing(0.12, (0, 0, 0), (0, 0, 0.2))],
    "link1": [housing(0.105, (0, 0, -0.2), (0, 0, 0.09))],
    "link2": [housing(0.085, (0, 0, -0.1), (0, 0, 0.1)), Tube(0.07, (0, 0, 0), (0.435, 0, 0))],
    "link3": [housing(0.075, (0, 0, -0.09), (0, 0, 0.09)), Tube(0.06, (0.03, 0, 0), (0.05, 0.16, 0))],
    "link4": [Tube(0.055, (0, 0, -0.28), (0, 0, -0.08)), Tube(0.045, (0, 0, -0.08), (0, 0, 0))],
    "link5": [Tube(0.04, (0, 0, 0), (0, 0.03, 0))],
    "link6": [Drum(0.025, (0, 0, -0.02), (0, 0, 0))],
}
_MELFA_OUTLINE_SOURCE = (
    "capsules along the published lengths, radii 120 and 105 mm (base), 70 mm (upper arm), 60 to 45 mm (forearm),"
    " flange a flat drum of 50 mm across:"
    " estimated, not read off a drawing and not compared with a model of the maker"
)
_INCH = 0.0254
_STANFORD_MASSES = (
    (9.29, (0.0, 0.0175, -0.1105), (0.276, 0.255, 0.071)),
    (5.01, (0.0, -0.1054, 0.0), (0.108, 0.018, 0.100)),
    (4.25, (0.0, 0.0, -0.6447), (2.51, 2.51, 0.006)),
    (1.08, (0.0, 0.0092, -0.0054), (0.002, 0.001, 0.001)),
    (0.63, (0.0, 0.0566, 0.0030), (0.003, 0.0004, 0.003)),
    (0.51, (0.0, 0.0, 0.1554), (0.013, 0.013, 0.0003)),
)
"""Mass [kg], centre of mass [m], moments about the origin of the table's frame [kg m^2]."""
_STANFORD_ARMATURES = (0.953, 2.193, 0.782, 0.106, 0.097, 0.020)
_STANFORD_OUTLINE: Outline = {
    "base": [housing(0.09, (0, 0, 0), (0, 0, 0.25))],
    "link1": [housing(0.075, (0, 0, 0.25), (0, 0, 0.49))],
    "link2": [housing(0.065, (0, 0, 0.08), (0, 0, 0.2))],
    "link3": [Tube(0.035, (0, 0, -1.29), (0, 0, -0.03))],
    "link5": [Tube(0.03, (0, 0, 0), (0, 0.03, 0))],
    "link6": [Drum(0.035, (0, 0, 0.05), (0, 0, 10.35 * _INCH))],
}
_STANFORD_OUTLINE_SOURCE = (
    "capsules along the published lengths, radii 75 mm (column), 65 mm (shoulder), 35 mm (boom of 1.3 m and hand,"
    " flat at the tip): estimated, the boom's length after its centre of mass; not compared with a model"
)
_PUMA_ROWS = (
    DHRow(alpha=pi / 2),
    DHRow(a=0.4318),
    DHRow(a=0.0203, d=0.15005, alpha=-pi / 2),
    DHRow(d=0.4318, alpha=pi / 2),
    DHRow(alpha=-pi / 2),
    DHRow(),
)
_PUMA_MASSES = (
    inertial(0.0, (0.0, 0.0, 0.0), (0.0, 0.35, 0.0)),
    inertial(17.4, (-0.3638, 0.006, 0.2275), (0.13, 0.524, 0.539)),
    inertial(4.8, (-0.0203, -0.0141, 0.070), (0.066, 0.086, 0.0125)),
    inertial(0.82, (0.0, 0.019, 0.0), (1.8e-3, 1.3e-3, 1.8e-3)),
    inertial(0.34, (0.0, 0.0, 0.0), (0.3e-3, 0.4e-3, 0.3e-3)),
    inertial(0.09, (0.0, 0.0, 0.032), (0.15e-3, 0.15e-3, 0.04e-3)),
)
_PUMA_RANGES = ((-160, 160), (-45, 225), (-225, 45), (-110, 170), (-100, 100), (-266, 266))
"""[deg]"""
_PUMA_TORQUES = (97.6, 186.4, 89.4, 24.2, 20.1, 21.3)
"""Largest torque of the motors at the joints [N m]."""
_PUMA_MOTOR_SPEEDS = (120.0, 163.0, 129.0, 406.0, 366.0, 440.0)
"""Largest speed of the motors, where their voltage saturates [rad/s]."""
_PUMA_MOTORS = (
    (200e-6, -62.6111, 1.48e-3, 0.395, 0.435),
    (200e-6, 107.815, 0.817e-3, 0.126, 0.071),
    (200e-6, -53.7063, 1.38e-3, 0.132, 0.105),
    (33e-6, 76.0364, 71.2e-6, 11.2e-3, 16.9e-3),
    (33e-6, 71.923, 82.6e-6, 9.26e-3, 14.5e-3),
    (33e-6, 76.686, 36.7e-6, 3.96e-3, 10.5e-3),
)
"""Rotor inertia [kg m^2], gear ratio, viscous [N m s/rad] and Coulomb friction (+, -) [N m], on the motor's side."""
_PUMA_OUTLINE: Outline = {
    "base": [housing(0.09, (0, 0, -0.672), (0, 0, -0.11)), Tube(0.05, (-0.1, 0, -0.622), (0.1, 0, -0.622))],
    "column": [housing(0.09, (0, 0, -0.11), (0, 0, 0.09)), housing(0.085, (0, 0.09, 0), (0, -0.13, 0))],
    "upper_arm": [Tube(0.07, (-0.13, 0, 0.2), (0, 0, 0.2)), Tube(0.06, (0, 0, 0.2), (0.4318, 0, 0.2))],
    "forearm": [housing(0.06, (0, 0, 0.05), (0, 0, 0.16)), Tube(0.05, (0, 0, 0.11), (0.0203, 0.33, 0.14))],
    "wrist_1": [Drum(0.04, (0, 0, 0.34), (0, 0, 0.4318))],
    "flange": [Drum(0.025, (0, 0, -0.04), (0, 0, 0))],
}
_PUMA_OUTLINE_SOURCE = (
    "capsules along the published lengths, radii 90 mm (column), 70 to 50 mm (arms), 40 mm (wrist):"
    " estimated, not read off a drawing and not compared with a model of the maker;"
    " the hand ends at the wrist's centre, where the tables put the tip"
)


def puma560(base_height: float = 0.0) -> Mechanism:
    """PUMA 560, 6R with shoulder offset and spherical wrist.

    Args:
        base_height: of the shoulder above the space frame [m]; 0.672 puts the frame on the floor.

    Reference: P. I. Corke, B. Armstrong-Helouvry, A search for consensus among model parameters reported for the PUMA
    560 robot, IEEE ICRA 1994; B. Armstrong, O. Khatib, J. Burdick, The explicit dynamic model and inertial parameters
    of the PUMA 560 arm, IEEE ICRA 1986 (torques); P. I. Corke, Visual control of robots, 1996 (motor speeds).
    """
    bare = mechanism_from_dh(
        _PUMA_ROWS,
        "classic",
        base=translation(0.0, 0.0, base_height),
        name="puma560",
        inertials=_PUMA_MASSES,
        limits=[
            Limits(radians(low), radians(high), speed / abs(motor[1]), effort=torque)
            for (low, high), torque, speed, motor in zip(
                _PUMA_RANGES, _PUMA_TORQUES, _PUMA_MOTOR_SPEEDS, _PUMA_MOTORS, strict=True
            )
        ],
        actuators=[Actuator(rotor_inertia=rotor, gear_ratio=gear) for rotor, gear, *_ in _PUMA_MOTORS],
        frictions=[
            Friction(viscous=gear**2 * viscous, coulomb=abs(gear) * plus, coulomb_negative=abs(gear) * minus)
            for _, gear, viscous, plus, minus in _PUMA_MOTORS
        ],
        link_names=("base", "column", "upper_arm", "forearm", "wrist_1", "wrist_2", "flange"),
        provenance=Provenance(
            source="Corke and Armstrong-Helouvry, IEEE ICRA 1994, as used in the Robotics Toolbox (model puma560)",
            notes=(
                "link 1: only its inertia about axis 1 is known (0.35 kg m^2); mass 0 stands for `not measured`, and"
                " the tensor is not that of a rigid body",
                "link 3: the largest moment as published (0.086) exceeds the sum of the others by 10 percent, which no"
                " rigid body can have",
                "signs of the gear ratios as published: motors 1 and 3 turn against their joints",
                "friction published at the motor, converted: viscous times gear ratio squared, Coulomb times its size",
                "joint ranges from Wang and Chen, IEEE T-RA 7(4), 1991; other sources differ by up to 75 degrees",
                "speed limits: measured voltage saturation of the motors over the gear ratios (Corke 1996, tables 2.9,"
                " 2.18), not the maker's data",
                "shoulder offset 0.15005 m as in the Robotics Toolbox; Corke's book of 1996 prints 0.1254 m",
                "zero pose: the L shape of Paul and Corke, forearm up; space frame at the shoulder",
            ),
        ),
    )
    return with_outline(bare, _PUMA_OUTLINE, _PUMA_OUTLINE_SOURCE)


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
        inertials=[_about_origin(*row) for row in _STANFORD_MASSES],
        limits=[
            half_turn,
            half_turn,
            Limits(12 * _INCH, 50 * _INCH),
            half_turn,
            Limits(radians(-90), radians(90)),
            half_turn,
        ],
        actuators=[Actuator(armature=value) for value in _STANFORD_ARMATURES],
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
    return with_outline(bare, _STANFORD_OUTLINE, _STANFORD_OUTLINE_SOURCE)


def _about_origin(mass: float, com: Three, moments: Three) -> Inertial:
    """Moments about the frame's origin, moved to the centre of mass."""
    c = np.array(com)
    shift = mass * (c @ c * np.eye(3) - np.outer(c, c))
    return Inertial(mass, frozen(com), frozen(np.diag(moments) - shift))


def rv7flm() -> Mechanism:
    """Mitsubishi MELFA RV-7FLM-D, 6R with spherical wrist and forearm set off by 50 mm, tip at the flange.

    Stretched upright at zero, as the maker counts its joints.

    Reference: Mitsubishi Electric, RV-7F series standard specifications manual (RV-7FL: lengths 400, 435, 50, 470, 85
    mm, axis data).
    """
    bare = with_rods(
        mechanism_from_dh(
            (
                DHRow(d=0.4),
                DHRow(alpha=-pi / 2, theta=-pi / 2),
                DHRow(a=0.435, theta=-pi / 2),
                DHRow(alpha=-pi / 2, a=0.05, d=0.47),
                DHRow(alpha=pi / 2),
                DHRow(alpha=-pi / 2, d=0.085, theta=pi),
            ),
            "modified",
            name="rv7flm",
            joint_names=("J1", "J2", "J3", "J4", "J5", "J6"),
            limits=[Limits(radians(low), radians(high), radians(speed)) for low, high, speed in _MELFA_AXES],
            provenance=Provenance(
                source="Mitsubishi Electric, specifications of the RV-7FL; M: its sealed, oil mist variant",
                notes=(
                    "the maker's reach of 908 mm is 435 + hypot(470, 50) mm, to the wrist centre",
                    "torques unknown",
                ),
            ),
        ),
        radius=0.05,
    )
    return with_outline(bare, _MELFA_OUTLINE, _MELFA_OUTLINE_SOURCE)
