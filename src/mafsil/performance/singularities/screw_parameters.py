"""What a configuration cannot do: lost twists and reciprocal wrenches, read as screws with axis, point and pitch."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Vector3, as_batch, positive
from mafsil.messages import say
from mafsil.performance.tolerances import CLEAR, ROUNDOFF, SHOWN, WITHIN


class ScrewParameters(NamedTuple):
    """A screw as a person sees it.

    Attributes:
        direction: (3,) unit vector along the axis.
        point: (3,) point of the axis nearest to the origin [m]; NaN for infinite pitch.
        pitch: [m]; 0 a pure rotation or force, infinite a pure translation or couple.
    """

    direction: Vector3
    point: Vector3
    pitch: float

    def sentence(self, key: str, language: str | None = None) -> str:
        """The words for `<key>_line`, `<key>_screw` or `<key>_free`, whichever fits the pitch."""
        form = "free" if np.isinf(self.pitch) else "line" if abs(self.pitch) < WITHIN else "screw"
        details = {"direction": vector_text(self.direction), "point": vector_text(self.point), "pitch": self.pitch}
        return say(f"performance.{key}_{form}", language=language, **details)


def twist_screw(V: ArrayLike, *, length: float = 1.0) -> ScrewParameters:
    """Axis, point and pitch of a twist (omega, v).

    Args:
        V: (6,).
        length: [m] by which translations are compared with turns when deciding that it does not turn at all.
    """
    twist = as_batch("V", V, (6,), finite=True)
    return _screw(twist[:3], twist[3:], positive("length", length))


def wrench_screw(F: ArrayLike, *, length: float = 1.0) -> ScrewParameters:
    """Axis, point and pitch of a wrench (m, f): its line of action.

    Args:
        F: (6,).
        length: [m] by which forces are compared with moments when deciding that it has no force.
    """
    wrench = as_batch("F", F, (6,), finite=True)
    return _screw(wrench[3:], wrench[:3], positive("length", length))


def _screw(directed: Floats, moment: Floats, length: float) -> ScrewParameters:
    size = float(np.linalg.norm(directed))
    if size * length <= CLEAR * float(np.linalg.norm(moment)) or size == 0.0:
        total = float(np.linalg.norm(moment))
        return ScrewParameters(signed(moment / total if total else moment), np.full(3, np.nan), float("inf"))
    pitch = float(directed @ moment) / size**2
    return ScrewParameters(signed(directed / size), np.cross(directed, moment) / size**2, pitch)


def signed(direction: Vector3) -> Vector3:
    """The same line's direction with its first clearly non-zero component positive, and no roundoff."""
    clean = np.where(np.abs(direction) < ROUNDOFF, 0.0, direction)
    first = clean[np.argmax(np.abs(clean) > WITHIN)]
    return clean * np.sign(first) if first else clean


def vector_text(vector: Floats) -> str:
    """(x, y, z) with four digits."""
    return "(" + ", ".join(f"{x:.4g}" if abs(x) > SHOWN else "0" for x in vector) + ")"
