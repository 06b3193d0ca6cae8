"""Arms of seven revolute joints: Franka Panda (FER) and Research 3 (FR3), without hand, and KUKA LBR iiwa 7 R800.

The tip is the flange.
"""

from __future__ import annotations

from math import pi, radians

import numpy as np

from mafsil.model.denavit_hartenberg import DHRow, mechanism_from_dh
from mafsil.model.exponentials import JointPlace, serial_arm
from mafsil.model.joint import JointKind
from mafsil.model.library.outline import Drum, Outline, Tube, inertial, with_outline
from mafsil.model.limits import Limits
from mafsil.model.link import Inertial
from mafsil.model.mechanism import Mechanism, Provenance
from mafsil.model.placement import pose_from_xyz_rpy, translation

_IIWA_ORIGINS = (
    ((0.0, 0.0, 0.15), (0.0, 0.0, 0.0)),
    ((0.0, 0.0, 0.19), (pi / 2, 0.0, pi)),
    ((0.0, 0.21, 0.0), (pi / 2, 0.0, pi)),
    ((0.0, 0.0, 0.19), (pi / 2, 0.0, 0.0)),
    ((0.0, 0.21, 0.0), (-pi / 2, pi, 0.0)),
    ((0.0, 0.0607, 0.19), (pi / 2, 0.0, 0.0)),
    ((0.0, 0.081, 0.0607), (-pi / 2, pi, 0.0)),
)
"""xyz [m] and roll, pitch, yaw [rad] of each joint in the link before."""
_IIWA_MASSES = (
    inertial(4.0, (0.0, -0.03, 0.12), (0.1, 0.09, 0.02)),
    inertial(4.0, (0.0003, 0.059, 0.042), (0.05, 0.018, 0.044)),
    inertial(3.0, (0.0, 0.03, 0.13), (0.08, 0.075, 0.01)),
    inertial(2.7, (0.0, 0.067, 0.034), (0.03, 0.01, 0.029)),
    inertial(1.7, (0.0001, 0.021, 0.076), (0.02, 0.018, 0.005)),
    inertial(1.8, (0.0, 0.0006, 0.0004), (0.005, 0.0036, 0.0047)),
    inertial(0.3, (0.0, 0.0, 0.02), (0.001, 0.001, 0.001)),
)
_IIWA_AXES = (
    (170, 98, 176),
    (120, 98, 176),
    (170, 100, 110),
    (120, 130, 110),
    (170, 140, 110),
    (120, 180, 40),
    (175, 180, 40),
)
"""Range +- [deg], speed [deg/s], torque [N m]."""
_IIWA_OUTLINE: Outline = {
    "base": [Tube(0.08, (0, 0, 0.05), (0, 0, 0.09)), Tube(0.05, (-0.08, 0, 0.04), (0, 0, 0.05))],
    "link1": [Tube(0.068, (0, 0, 0.02), (0, 0, 0.18))],
    "link2": [Tube(0.068, (0, 0, 0.01), (0, 0.19, 0))],
    "link3": [Tube(0.068, (0, 0, 0.02), (0, 0, 0.18))],
    "link4": [Tube(0.068, (0, 0, 0.01), (0, 0.19, 0))],
    "link5": [Tube(0.06, (0, 0, 0.02), (0, 0.0, 0.08)), Tube(0.042, (0, 0.05, 0.09), (0, 0.06, 0.19))],
    "link6": [Tube(0.06, (0, 0, 0.03), (0, 0.02, 0.06))],
    "link7": [Drum(0.045, (0, 0, 0), (0, 0, 0.045))],
}
_IIWA_OUTLINE_SOURCE = (
    "capsules along the published lengths, radii 68 mm (axes 1 to 4) and 60 mm (wrist), flange a flat drum of 45 mm:"
    " estimated, not read off a drawing and not compared with a model of the maker"
)
_FRANKA_FLANGE = 0.107
_FRANKA_ROWS = (
    DHRow(a=0.0, alpha=0.0, d=0.333),
    DHRow(a=0.0, alpha=-pi / 2),
    DHRow(a=0.0, alpha=pi / 2, d=0.316),
    DHRow(a=0.0825, alpha=pi / 2),
    DHRow(a=-0.0825, alpha=-pi / 2, d=0.384),
    DHRow(a=0.0, alpha=pi / 2),
    DHRow(a=0.088, alpha=pi / 2),
)
_PANDA_LIMITS = (
    Limits(-2.8973, 2.8973, 2.1750, 15.0, 7500.0, 87.0),
    Limits(-1.7628, 1.7628, 2.1750, 7.5, 3750.0, 87.0),
    Limits(-2.8973, 2.8973, 2.1750, 10.0, 5000.0, 87.0),
    Limits(-3.0718, -0.0698, 2.1750, 12.5, 6250.0, 87.0),
    Limits(-2.8973, 2.8973, 2.6100, 15.0, 7500.0, 12.0),
    Limits(-0.0175, 3.7525, 2.6100, 20.0, 10000.0, 12.0),
    Limits(-2.8973, 2.8973, 2.6100, 20.0, 10000.0, 12.0),
)
_PANDA_MASSES = (
    inertial(4.970684, (0.003875, 0.002081, -0.04762), (0.70337, 0.70661, 0.009117, -0.000139, 0.006772, 0.019169)),
    inertial(0.646926, (-0.003141, -0.02872, 0.003495), (0.007962, 0.02811, 0.025995, -0.003925, 0.010254, 0.000704)),
    inertial(3.228604, (0.027518, 0.039252, -0.066502), (0.037242, 0.036155, 0.01083, -0.004761, -0.011396, -0.012805)),
    inertial(3.587895, (-0.05317, 0.104419, 0.027454), (0.025853, 0.019552, 0.028323, 0.007796, -0.001332, 0.008641)),
    inertial(
        1.225946, (-0.011953, 0.041065, -0.038437), (0.035549, 0.029474, 0.008627, -0.002117, -0.004037, 0.000229)
    ),
    inertial(1.666555, (0.060149, -0.014117, -0.010517), (0.001964, 0.004354, 0.005433, 0.000109, -0.001158, 0.000341)),
    inertial(
        0.735522, (0.010517, -0.004252, 0.061597), (0.012516, 0.010027, 0.004815, -0.000428, -0.001196, -0.000741)
    ),
)
_FRANKA_OUTLINE: Outline = {
    "base": [
        Tube(0.074, (-0.07, 0, 0.05), (0, 0, 0.069)),
        Tube(0.03, (-0.01, -0.065, 0.03), (-0.01, 0.065, 0.03)),
        Tube(0.03, (-0.12, -0.045, 0.03), (-0.12, 0.045, 0.03)),
    ],
    "link1": [
        Tube(0.055, (0, 0, -0.172), (0, 0, -0.1)),
        Tube(0.055, (0, 0, -0.1), (0, -0.06, -0.03)),
        Tube(0.055, (0, -0.02, 0), (0, -0.074, 0)),
    ],
    "link2": [
        Tube(0.055, (0, -0.174, 0), (0, -0.1, 0)),
        Tube(0.055, (0, -0.1, 0), (0, -0.03, 0.06)),
        Tube(0.055, (0, 0, 0.02), (0, 0, 0.074)),
    ],
    "link3": [
        Tube(0.055, (0, 0, -0.1), (0, 0, -0.066)),
        Tube(0.055, (0, 0, -0.066), (0.0825, 0.056, 0)),
        Tube(0.055, (0.0825, 0.02, 0), (0.0825, 0.056, 0)),
    ],
    "link4": [
        Tube(0.055, (0, 0, 0.02), (0, 0, 0.056)),
        Tube(0.055, (0, 0, 0.056), (-0.0825, 0.067, 0)),
        Tube(0.055, (-0.0825, 0.067, 0), (-0.0825, 0.104, 0)),
    ],
    "link5": [
        Tube(0.055, (0, 0, -0.24), (0, 0.01, -0.195)),
        Tube(0.033, (0, 0.055, -0.2), (0, 0.085, -0.06)),
        Tube(0.05, (0, 0.06, 0), (0, 0.08, 0)),
    ],
    "link6": [Tube(0.048, (0, 0, 0.008), (0.05, 0.02, 0.008)), Tube(0.045, (0.088, -0.02, 0), (0.088, 0.037, 0))],
    "link7": [Drum(0.044, (0, 0, 0.052), (0, 0, _FRANKA_FLANGE)), Tube(0.022, (0, 0, 0.083), (0.047, 0.047, 0.083))],
}
_FRANKA_OUTLINE_SOURCE = (
    "capsules fitted to the Panda's meshes as example-robot-data has them (the FR3 takes the same): radii 55 mm"
    " (joints 1 to 5), 50 to 45 mm (wrist), flange a flat drum of 44 mm"
)


def panda() -> Mechanism:
    """Franka Emika Panda (FER), 7 revolute joints, tip at the flange.

    Reference: Franka Emika, robot and interface specifications (kinematics, limits); C. Gaz, M. Cognetti, A. Oliva,
    P. Robuffo Giordano, A. De Luca, Dynamic identification of the Franka Emika Panda robot with retrieval of feasible
    parameters using penalty-based optimization, IEEE RA-L 4(4), 2019 (masses).
    """
    return _franka(
        "panda",
        _PANDA_LIMITS,
        _PANDA_MASSES,
        Provenance(
            source="Franka Emika robot and interface specifications; Gaz et al., IEEE RA-L 4(4), 2019",
            notes=(
                "masses identified from motion data under physical bounds: predict torques well, but a single link's"
                " mass, centre or inertia need not be the true one (link 1: 0.7 kg m^2 across)",
                "inertia tensors about the centres of mass, axes of the modified Denavit-Hartenberg frames",
                "no hand: the tip is the flange, 107 mm beyond axis 7; the inertia of motors is contained in the links",
                "jerk limits as published: rad/s^3",
            ),
        ),
    )


def _franka(name: str, limits: tuple[Limits, ...], masses: tuple[Inertial, ...], provenance: Provenance) -> Mechanism:
    bare = mechanism_from_dh(
        _FRANKA_ROWS,
        "modified",
        tool=translation(0.0, 0.0, _FRANKA_FLANGE),
        name=name,
        inertials=masses,
        limits=limits,
        provenance=provenance,
    )
    return with_outline(bare, _FRANKA_OUTLINE, _FRANKA_OUTLINE_SOURCE)


_FR3_LIMITS = (
    Limits(-2.7437, 2.7437, 2.62, 10.0, 5000.0, 87.0),
    Limits(-1.7837, 1.7837, 2.62, 10.0, 5000.0, 87.0),
    Limits(-2.9007, 2.9007, 2.62, 10.0, 5000.0, 87.0),
    Limits(-3.0421, -0.1518, 2.62, 10.0, 5000.0, 87.0),
    Limits(-2.8065, 2.8065, 5.26, 10.0, 5000.0, 12.0),
    Limits(0.5445, 4.5169, 4.18, 10.0, 5000.0, 12.0),
    Limits(-3.0159, 3.0159, 5.26, 10.0, 5000.0, 12.0),
)
_FR3_MASSES = (
    inertial(
        2.9274653454,
        (4.128e-7, -0.0181251324, -0.038603597),
        (0.0239273165, 0.0224821613, 0.0063500983, 0.0000133179, -0.0001140477, -0.0019950321),
    ),
    inertial(
        2.9355370338,
        (0.0031828864, -0.0743221644, 0.0088146084),
        (0.0419389463, 0.0251451489, 0.0617021447, 0.0002025733, 0.0040777842, -0.0042252158),
    ),
    inertial(
        2.2449013699,
        (0.0407015686, -0.0048200565, -0.0289730823),
        (0.0241014255, 0.0197405327, 0.0190444945, 0.0024046946, -0.0028562693, -0.0021042127),
    ),
    inertial(
        2.6155955791,
        (-0.0459100965, 0.063049296, -0.0085187868),
        (0.0345299832, 0.0288816219, 0.0412547117, 0.0132255227, 0.0101514300, -0.0009762834),
    ),
    inertial(
        2.3271207594,
        (-0.0016039605, 0.0292536262, -0.097296599),
        (0.0516102785, 0.0478772971, 0.0164236256, -0.0057151734, -0.0035673168, 0.0106739851),
    ),
    inertial(
        1.8170376524,
        (0.0597131221, -0.0410294666, -0.0101692726),
        (0.0054123336, 0.0140583295, 0.0160808179, 0.0061934564, 0.0014219289, -0.0013140754),
    ),
    inertial(
        0.6271432862,
        (0.0045225817, 0.0086261921, -0.0161633251),
        (0.0002109239, 0.0001771857, 0.0000599319, -0.0000243330, 0.0000456448, 0.0000874407),
    ),
)


def fr3() -> Mechanism:
    """Franka Research 3, 7 revolute joints, tip at the flange: the Panda's kinematics, other limits and masses.

    Reference: Franka Robotics, robot specifications of the FR3 and the maker's description package.
    """
    return _franka(
        "fr3",
        _FR3_LIMITS,
        _FR3_MASSES,
        Provenance(
            source="Franka Robotics, FR3 specifications; masses: the maker's package franka_description",
            notes=(
                "inertia tensors about the centres of mass, axes of the modified Denavit-Hartenberg frames",
                "speed limits are the largest; the robot lowers them near the ends of the joint ranges",
                "no hand: the tip is the flange, 107 mm beyond axis 7",
            ),
        ),
    )


def iiwa7() -> Mechanism:
    """KUKA LBR iiwa 7 R800, 7 revolute joints with spherical shoulder and wrist, tip at the flange.

    Reference: KUKA Roboter GmbH, LBR iiwa 7 R800 / 14 R820 specification (lengths 340, 400, 400, 126 mm, axis data).
    """
    bare = serial_arm(
        [JointPlace(JointKind.REVOLUTE, pose_from_xyz_rpy(*origin), np.eye(4)) for origin in _IIWA_ORIGINS],
        base=None,
        T_lt=translation(0.0, 0.0, 0.045),
        name="iiwa7",
        inertials=_IIWA_MASSES,
        limits=[Limits(-radians(q), radians(q), radians(qd), effort=tau) for q, qd, tau in _IIWA_AXES],
        provenance=Provenance(
            source="KUKA, specification of the LBR iiwa 7 R800; link frames and masses: iiwa_description (iiwa_stack)",
            notes=(
                "KUKA publishes no mass properties; these are round estimates of the description package, diagonal"
                " tensors about the centres of mass",
                "shoulder, elbow and wrist centres lie 340, 740 and 1140 mm above the base, the flange 1266 mm",
            ),
        ),
    )
    return with_outline(bare, _IIWA_OUTLINE, _IIWA_OUTLINE_SOURCE)
