"""What kind of displacement it is: none, a translation, a rotation, a right- or left-handed screw, a half turn."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from math import inf, nan, pi

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Vector3, single
from mafsil.geometry import membership, screw
from mafsil.geometry.tolerances import SPECIAL
from mafsil.messages import say


class DisplacementKind(Enum):
    """The kinds of displacements of a body, by Chasles."""

    IDENTITY = "identity"
    TRANSLATION = "translation"
    ROTATION = "rotation"
    RIGHT_HANDED = "right_handed"
    LEFT_HANDED = "left_handed"
    HALF_TURN = "half_turn"


@dataclass(frozen=True, eq=False)
class Displacement:
    """A displacement read as one screw motion.

    Attributes:
        kind: HALF_TURN is a screw by half a turn, whose handedness is undetermined; by half a turn without advance it
            is a ROTATION.
        direction: (3,) along the axis, or of the translation; NaN for the identity.
        point: (3,) point of the axis nearest to the origin [m]; NaN where there is no axis line.
        angle: in [0, pi] [rad].
        advance: along the direction [m].
        pitch: advance per angle [m/rad]; infinite for translations, NaN for the identity.
    """

    kind: DisplacementKind
    direction: Vector3
    point: Vector3
    angle: float
    advance: float
    pitch: float

    def explain(self, language: str | None = None) -> str:
        """The kind, its axis, angle and advance."""
        return say(
            f"geometry.kind_{self.kind.value}",
            language=language,
            direction=_text(self.direction),
            point=_text(self.point),
            angle=float(np.degrees(self.angle)),
            advance=self.advance,
            pitch=self.pitch,
        )


def classify(T: ArrayLike, *, angle: float = SPECIAL, distance: float = SPECIAL) -> Displacement:
    """The kind of one displacement.

    Args:
        T: (4, 4).
        angle: [rad] to none or to half a turn that counts as such.
        distance: [m] that counts as none.

    Raises:
        InputError: T is no pose, or a batch.
    """
    matrix = membership.require("pose", "T", single("T", T, (4, 4)))
    S, amount = screw.chasles(matrix)
    turned = float(amount) if np.abs(S[:3]).max() > 0 else 0.0
    if turned <= angle:
        moved = float(np.linalg.norm(matrix[:3, 3]))
        if moved <= distance:
            return Displacement(DisplacementKind.IDENTITY, np.full(3, nan), np.full(3, nan), 0.0, 0.0, nan)
        return Displacement(DisplacementKind.TRANSLATION, matrix[:3, 3] / moved, np.full(3, nan), 0.0, moved, inf)
    advance = float(S[:3] @ matrix[:3, 3])
    if abs(advance) <= distance:
        kind, advance = DisplacementKind.ROTATION, 0.0
    elif pi - turned <= angle:
        kind = DisplacementKind.HALF_TURN
    else:
        kind = DisplacementKind.RIGHT_HANDED if advance > 0 else DisplacementKind.LEFT_HANDED
    return Displacement(kind, S[:3], screw.nearest_point(S), turned, advance, advance / turned)


def _text(vector: Vector3) -> str:
    return "(" + ", ".join(f"{x:.4g}" if abs(x) > 5e-13 else "0" for x in vector) + ")"
