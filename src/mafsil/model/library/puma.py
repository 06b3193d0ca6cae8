"""Unimation PUMA 560: the consensus parameters, classic Denavit-Hartenberg convention."""

from __future__ import annotations

from math import pi, radians

from mafsil.model.actuator import Actuator, Friction
from mafsil.model.denavit_hartenberg import DHRow, mechanism_from_dh
from mafsil.model.library.masses import inertial
from mafsil.model.library.outline import Drum, Outline, Tube, housing, with_outline
from mafsil.model.limits import Limits
from mafsil.model.mechanism import Mechanism, Provenance
from mafsil.model.placement import translation

_ROWS = (
    DHRow(alpha=pi / 2),
    DHRow(a=0.4318),
    DHRow(a=0.0203, d=0.15005, alpha=-pi / 2),
    DHRow(d=0.4318, alpha=pi / 2),
    DHRow(alpha=-pi / 2),
    DHRow(),
)

_MASSES = (
    inertial(0.0, (0.0, 0.0, 0.0), (0.0, 0.35, 0.0)),
    inertial(17.4, (-0.3638, 0.006, 0.2275), (0.13, 0.524, 0.539)),
    inertial(4.8, (-0.0203, -0.0141, 0.070), (0.066, 0.086, 0.0125)),
    inertial(0.82, (0.0, 0.019, 0.0), (1.8e-3, 1.3e-3, 1.8e-3)),
    inertial(0.34, (0.0, 0.0, 0.0), (0.3e-3, 0.4e-3, 0.3e-3)),
    inertial(0.09, (0.0, 0.0, 0.032), (0.15e-3, 0.15e-3, 0.04e-3)),
)

_RANGES = ((-160, 160), (-45, 225), (-225, 45), (-110, 170), (-100, 100), (-266, 266))
"""[deg]"""
_TORQUES = (97.6, 186.4, 89.4, 24.2, 20.1, 21.3)
"""Largest torque of the motors at the joints [N m]."""
_MOTOR_SPEEDS = (120.0, 163.0, 129.0, 406.0, 366.0, 440.0)
"""Largest speed of the motors, where their voltage saturates [rad/s]."""

_MOTORS = (
    (200e-6, -62.6111, 1.48e-3, 0.395, 0.435),
    (200e-6, 107.815, 0.817e-3, 0.126, 0.071),
    (200e-6, -53.7063, 1.38e-3, 0.132, 0.105),
    (33e-6, 76.0364, 71.2e-6, 11.2e-3, 16.9e-3),
    (33e-6, 71.923, 82.6e-6, 9.26e-3, 14.5e-3),
    (33e-6, 76.686, 36.7e-6, 3.96e-3, 10.5e-3),
)
"""Rotor inertia [kg m^2], gear ratio, viscous [N m s/rad] and Coulomb friction (+, -) [N m], on the motor's side."""

_OUTLINE: Outline = {
    "base": [housing(0.09, (0, 0, -0.672), (0, 0, -0.11)), Tube(0.05, (-0.1, 0, -0.622), (0.1, 0, -0.622))],
    "column": [housing(0.09, (0, 0, -0.11), (0, 0, 0.09)), housing(0.085, (0, 0.09, 0), (0, -0.13, 0))],
    "upper_arm": [Tube(0.07, (-0.13, 0, 0.2), (0, 0, 0.2)), Tube(0.06, (0, 0, 0.2), (0.4318, 0, 0.2))],
    "forearm": [housing(0.06, (0, 0, 0.05), (0, 0, 0.16)), Tube(0.05, (0, 0, 0.11), (0.0203, 0.33, 0.14))],
    "wrist_1": [Drum(0.04, (0, 0, 0.34), (0, 0, 0.4318))],
    "flange": [Drum(0.025, (0, 0, -0.04), (0, 0, 0))],
}
_OUTLINE_SOURCE = (
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
        _ROWS,
        "classic",
        base=translation(0.0, 0.0, base_height),
        name="puma560",
        inertials=_MASSES,
        limits=[
            Limits(radians(low), radians(high), speed / abs(motor[1]), effort=torque)
            for (low, high), torque, speed, motor in zip(_RANGES, _TORQUES, _MOTOR_SPEEDS, _MOTORS, strict=True)
        ],
        actuators=[Actuator(rotor_inertia=rotor, gear_ratio=gear) for rotor, gear, *_ in _MOTORS],
        frictions=[
            Friction(viscous=gear**2 * viscous, coulomb=abs(gear) * plus, coulomb_negative=abs(gear) * minus)
            for _, gear, viscous, plus, minus in _MOTORS
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
    return with_outline(bare, _OUTLINE, _OUTLINE_SOURCE)
