"""Mitsubishi Electric MELFA RV-7FLM."""

from __future__ import annotations

from math import pi, radians

from mafsil.model.denavit_hartenberg import DHRow, mechanism_from_dh
from mafsil.model.library.masses import with_rods
from mafsil.model.library.outline import Drum, Outline, Tube, housing, with_outline
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

_OUTLINE: Outline = {
    "base": [housing(0.12, (0, 0, 0), (0, 0, 0.2))],
    "link1": [housing(0.105, (0, 0, -0.2), (0, 0, 0.09))],
    "link2": [housing(0.085, (0, 0, -0.1), (0, 0, 0.1)), Tube(0.07, (0, 0, 0), (0.435, 0, 0))],
    "link3": [housing(0.075, (0, 0, -0.09), (0, 0, 0.09)), Tube(0.06, (0.03, 0, 0), (0.05, 0.16, 0))],
    "link4": [Tube(0.055, (0, 0, -0.28), (0, 0, -0.08)), Tube(0.045, (0, 0, -0.08), (0, 0, 0))],
    "link5": [Tube(0.04, (0, 0, 0), (0, 0.03, 0))],
    "link6": [Drum(0.025, (0, 0, -0.02), (0, 0, 0))],
}
_OUTLINE_SOURCE = (
    "capsules along the published lengths, radii 120 and 105 mm (base), 70 mm (upper arm), 60 to 45 mm (forearm),"
    " flange a flat drum of 50 mm across:"
    " estimated, not read off a drawing and not compared with a model of the maker"
)


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
    return with_outline(bare, _OUTLINE, _OUTLINE_SOURCE)
