"""SCARA arms."""

from __future__ import annotations

from math import pi, radians

from mafsil.model.denavit_hartenberg import DHRow, mechanism_from_dh
from mafsil.model.library.masses import with_rods
from mafsil.model.limits import Limits
from mafsil.model.mechanism import Mechanism, Provenance


def cobra600() -> Mechanism:
    """Adept Cobra 600: RRPR, quill pointing down.

    Reference: Adept Technology, Cobra 600 data sheet; kinematics as in the Robotics Toolbox (model cobra600).
    """
    return with_rods(
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
