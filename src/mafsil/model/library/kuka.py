"""KUKA LBR iiwa 7 R800."""

from __future__ import annotations

from math import pi, radians

import numpy as np

from mafsil.model.joint import JointKind
from mafsil.model.library.masses import inertial
from mafsil.model.library.outline import Drum, Outline, Tube, with_outline
from mafsil.model.limits import Limits
from mafsil.model.mechanism import Mechanism, Provenance
from mafsil.model.placement import pose_from_xyz_rpy, translation
from mafsil.model.serial import JointPlace, serial_arm

_ORIGINS = (
    ((0.0, 0.0, 0.15), (0.0, 0.0, 0.0)),
    ((0.0, 0.0, 0.19), (pi / 2, 0.0, pi)),
    ((0.0, 0.21, 0.0), (pi / 2, 0.0, pi)),
    ((0.0, 0.0, 0.19), (pi / 2, 0.0, 0.0)),
    ((0.0, 0.21, 0.0), (-pi / 2, pi, 0.0)),
    ((0.0, 0.0607, 0.19), (pi / 2, 0.0, 0.0)),
    ((0.0, 0.081, 0.0607), (-pi / 2, pi, 0.0)),
)
"""xyz [m] and roll, pitch, yaw [rad] of each joint in the link before."""

_MASSES = (
    inertial(4.0, (0.0, -0.03, 0.12), (0.1, 0.09, 0.02)),
    inertial(4.0, (0.0003, 0.059, 0.042), (0.05, 0.018, 0.044)),
    inertial(3.0, (0.0, 0.03, 0.13), (0.08, 0.075, 0.01)),
    inertial(2.7, (0.0, 0.067, 0.034), (0.03, 0.01, 0.029)),
    inertial(1.7, (0.0001, 0.021, 0.076), (0.02, 0.018, 0.005)),
    inertial(1.8, (0.0, 0.0006, 0.0004), (0.005, 0.0036, 0.0047)),
    inertial(0.3, (0.0, 0.0, 0.02), (0.001, 0.001, 0.001)),
)

_AXES = (
    (170, 98, 176),
    (120, 98, 176),
    (170, 100, 110),
    (120, 130, 110),
    (170, 140, 110),
    (120, 180, 40),
    (175, 180, 40),
)
"""Range +- [deg], speed [deg/s], torque [N m]."""

_OUTLINE: Outline = {
    "base": [Tube(0.08, (0, 0, 0.05), (0, 0, 0.09)), Tube(0.05, (-0.08, 0, 0.04), (0, 0, 0.05))],
    "link1": [Tube(0.068, (0, 0, 0.02), (0, 0, 0.18))],
    "link2": [Tube(0.068, (0, 0, 0.01), (0, 0.19, 0))],
    "link3": [Tube(0.068, (0, 0, 0.02), (0, 0, 0.18))],
    "link4": [Tube(0.068, (0, 0, 0.01), (0, 0.19, 0))],
    "link5": [Tube(0.06, (0, 0, 0.02), (0, 0.0, 0.08)), Tube(0.042, (0, 0.05, 0.09), (0, 0.06, 0.19))],
    "link6": [Tube(0.06, (0, 0, 0.03), (0, 0.02, 0.06))],
    "link7": [Drum(0.045, (0, 0, 0), (0, 0, 0.045))],
}
_OUTLINE_SOURCE = (
    "capsules along the published lengths, radii 68 mm (axes 1 to 4) and 60 mm (wrist), flange a flat drum of 45 mm:"
    " estimated, not read off a drawing and not compared with a model of the maker"
)


def iiwa7() -> Mechanism:
    """KUKA LBR iiwa 7 R800, 7 revolute joints with spherical shoulder and wrist, tip at the flange.

    Reference: KUKA Roboter GmbH, LBR iiwa 7 R800 / 14 R820 specification (lengths 340, 400, 400, 126 mm, axis data).
    """
    bare = serial_arm(
        [JointPlace(JointKind.REVOLUTE, pose_from_xyz_rpy(*origin), np.eye(4)) for origin in _ORIGINS],
        base=None,
        T_lt=translation(0.0, 0.0, 0.045),
        name="iiwa7",
        inertials=_MASSES,
        limits=[Limits(-radians(q), radians(q), radians(qd), effort=tau) for q, qd, tau in _AXES],
        provenance=Provenance(
            source="KUKA, specification of the LBR iiwa 7 R800; link frames and masses: iiwa_description (iiwa_stack)",
            notes=(
                "KUKA publishes no mass properties; these are round estimates of the description package, diagonal"
                " tensors about the centres of mass",
                "shoulder, elbow and wrist centres lie 340, 740 and 1140 mm above the base, the flange 1266 mm",
            ),
        ),
    )
    return with_outline(bare, _OUTLINE, _OUTLINE_SOURCE)
