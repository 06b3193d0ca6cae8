"""Mitsubishi Electric MELFA RV-7FLM."""

from __future__ import annotations

from math import pi, radians

from mafsil.model.denavit_hartenberg import DHRow, mechanism_from_dh
from mafsil.model.library.masses import with_rods
from mafsil.model.limits import Limits
from mafsil.model.mechanism import Mechanism, Provenance

_AXES = (
    (-240, 240, 288),
    (-110, 130, 321),
    (0, 162, 360),
    (-200, 200, 337),
    (-120, 120, 450),
    (-360, 360, 720),
)
"""Range from, to [deg], speed [deg/s] of joints J1 to J6."""


def rv7flm() -> Mechanism:
    """Mitsubishi MELFA RV-7FLM-D, 6R with spherical wrist and forearm set off by 50 mm, tip at the flange.

    Stretched upright at zero, as the maker counts its joints.

    Reference: Mitsubishi Electric, RV-7F series standard specifications manual (RV-7FL: lengths 400, 435, 50, 470, 85
    mm, axis data).
    """
    return with_rods(
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
            limits=[Limits(radians(low), radians(high), radians(speed)) for low, high, speed in _AXES],
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
