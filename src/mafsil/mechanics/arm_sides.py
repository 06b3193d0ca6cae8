"""On which side an arm's shoulder, elbow and wrist are: numbers of the configuration, read off its joints.

Up is the first axis that turns the arm, in the sense in which it leads to larger z in {s}; its own sense where it is
level. Seen so, with the wrist ahead of the shoulder:

shoulder  right if the upper arm lies to the right of the first axis; of an arm without such an offset if the
          shoulder's axis points to the right:  w . ((end - start) x up) > 0
elbow     up if it lies above the line from shoulder to wrist. Where the arm moves in a plane through the first axis the
          line is read from the shoulder to the wrist as it reaches out, so that the name stays while the arm leans back
          over its shoulder:  s (E - S) . (h x (W - S)) > 0.  Else by height:  (E - S) . up across (W - S) > 0.
          Of a prismatic joint out if its stroke leads the wrist away from the shoulder.
wrist     not flipped if its middle axis bends it to the positive side:  w_b . (w_a x w_c) > 0

Reference: Lee and Ziegler, A geometric approach in solving the inverse kinematics of PUMA robots, 1984.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import ClassVar, TypeAlias

from mafsil.arrays import Floats, Vector3

Words: TypeAlias = tuple[str, str, str]
"""Of a negative number, of none, of a positive one."""

MERGED = "merged"
"""Where two branches are one."""


@dataclass(frozen=True, eq=False)
class Carried:
    """A point or a direction at q = 0 in {s}, and how many joints from the base carry it."""

    at: Vector3
    after: int


@dataclass(frozen=True, eq=False)
class Shoulder:
    """Which way the shoulder's axis points, seen from `start` towards `end`."""

    axis: Carried
    start: Carried
    end: Carried
    up: Carried


@dataclass(frozen=True, eq=False)
class PlaneElbow:
    """An elbow in a plane: to the left of the walk from shoulder to wrist, seen with `normal` towards the viewer.

    With `reach` the viewer stands where the wrist is to the right of the first axis, which points up.
    """

    words: ClassVar[Words] = ("down", MERGED, "up")
    normal: Carried
    shoulder: Carried
    elbow: Carried
    wrist: Carried
    reach: Shoulder | None = None


@dataclass(frozen=True, eq=False)
class HighElbow:
    """An elbow above or below the line from shoulder to wrist."""

    words: ClassVar[Words] = ("down", "level", "up")
    shoulder: Carried
    elbow: Carried
    wrist: Carried
    up: Carried


@dataclass(frozen=True, eq=False)
class Stroke:
    """A prismatic joint along `axis`, perhaps only across another, that leads `end` away from `start`."""

    words: ClassVar[Words] = ("in", MERGED, "out")
    axis: Carried
    start: Carried
    end: Carried
    across: Carried | None = None


@dataclass(frozen=True, eq=False)
class Placing:
    """Three joints without such a shape: the sign of the determinant of the velocities that they give a point."""

    words: ClassVar[Words] = ("-", MERGED, "+")
    joints: tuple[int, int, int]
    point: Carried


Elbow: TypeAlias = PlaneElbow | HighElbow | Stroke | Placing


@dataclass(frozen=True, eq=False)
class ArmSides:
    """Which sides an arm has.

    Attributes:
        axes: (n, 3) unit directions of the joints at q = 0, base first, in {s}.
        points: (n, 3) a point of each axis [m].
        prismatic: (n) whether the joint is prismatic.
        size: length by which the arm is measured [m].
        shoulder, elbow, wrist: None where the arm has none; of the wrist its three axes.
        exact: whether the sides tell apart all branches of a pose.
    """

    axes: Floats
    points: Floats
    prismatic: tuple[bool, ...]
    size: float
    shoulder: Shoulder | None
    elbow: Elbow | None
    wrist: tuple[Carried, Carried, Carried] | None
    exact: bool

    @property
    def key(self) -> str:
        """Words for the compiled function: equal words, equal expressions."""
        chain = f"{self.axes.tobytes().hex()} {self.points.tobytes().hex()} {self.prismatic} {self.size.hex()}"
        wrist = " ".join(_words(axis) for axis in self.wrist or ())
        return f"{chain} {_words(self.shoulder)} {_words(self.elbow)} {wrist}"


def _words(part: object) -> str:
    """All numbers of a part as words."""
    if isinstance(part, Carried):
        return f"{part.at.tobytes().hex()}@{part.after}"
    if isinstance(part, Shoulder | PlaneElbow | HighElbow | Stroke | Placing):
        return " ".join([type(part).__name__, *(_words(getattr(part, one.name)) for one in fields(part))])
    return str(part)
