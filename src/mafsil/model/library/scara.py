"""SCARA arms."""

from __future__ import annotations

from math import pi, radians

from mafsil.model.denavit_hartenberg import DHRow, mechanism_from_dh
from mafsil.model.library.masses import with_rods
from mafsil.model.library.outline import Drum, Outline, Tube, housing, with_outline
from mafsil.model.limits import Limits
from mafsil.model.mechanism import Mechanism, Provenance

_OUTLINE: Outline = {
    "base": [housing(0.09, (0, 0, 0), (0, 0, 0.26))],
    "link1": [Tube(0.06, (0, 0, 0.325), (0.325, 0, 0.325))],
    "link2": [Tube(0.06, (0, 0, 0.105), (0.275, 0, 0.105)), housing(0.06, (0.2, 0, 0.12), (0.2, 0, 0.28))],
    "link3": [Drum(0.012, (0, 0, -0.3), (0, 0, -0.02))],
    "link4": [Drum(0.0315, (0, 0, -0.02), (0, 0, 0))],
}
_OUTLINE_SOURCE = (
    "capsules along the published lengths, radii 90 mm (column), 60 mm (arms), 12 mm (quill), user flange a flat drum"
    " of 63 mm across:"
    " estimated, not read off a drawing and not compared with a model of the maker"
)


def cobra600() -> Mechanism:
    """Adept Cobra 600: RRPR, quill pointing down.

    Reference: Adept Technology, Cobra 600 data sheet; kinematics as in the Robotics Toolbox (model cobra600).
    """
    bare = with_rods(
        mechanism_from_dh(
            (DHRow(d=0.387, a=0.325), DHRow(a=0.275, alpha=pi), DHRow(kind="P"), DHRow()),
            "classic",
            name="cobra600",
            limits=[
                Limits(radians(-50), radians(50)),
                Limits(radians(-88), radians(88)),
                Limits(0.0, 0.210),
                Limits(),
            ],
            provenance=Provenance(
                source="Adept Cobra 600 data sheet, as collected in the Robotics Toolbox",
                notes=("range of joint 4 and all speeds and torques unknown",),
            ),
        ),
        radius=0.06,
    )
    return with_outline(bare, _OUTLINE, _OUTLINE_SOURCE)
