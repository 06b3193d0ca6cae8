"""Arms with a spherical shoulder, an elbow and a spherical wrist as plain numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, Vector3


@dataclass(frozen=True, eq=False)
class ArmAnglePattern:
    """Seven revolute joints: three axes that meet, one, and three that meet, neighbours of three normal to each other.

    Attributes:
        axes: (7, 3) unit directions of the joints at q = 0, in {s}.
        home: (4, 4) pose of the tip at q = 0.
        shoulder, elbow, wrist: (3,) where the axes meet, and a point of axis 4, at q = 0 [m].
    """

    axes: Floats
    home: PoseMatrix
    shoulder: Vector3
    elbow: Vector3
    wrist: Vector3

    @property
    def branches(self) -> int:
        """Two elbows, two shoulders, two wrists."""
        return 8

    @property
    def parameters(self) -> int:
        """Number of values that have to be given: the arm angle."""
        return 1

    @property
    def quartic(self) -> bool:
        """Whether an equation of fourth degree is solved."""
        return False

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return 7

    @property
    def key(self) -> str:
        """Words for the compiled form: equal words, equal expressions."""
        numbers = (self.axes, self.home, self.shoulder, self.elbow, self.wrist)
        return " ".join(np.ascontiguousarray(one).tobytes().hex() for one in numbers)
