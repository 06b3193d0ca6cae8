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

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TypeAlias

import mafsil.expression as ex
from mafsil.algebra.spatial import cross
from mafsil.algebra.subproblems import Turn
from mafsil.arrays import Floats, Vector3
from mafsil.mechanics.closed_form.line import Line, Motion, across, forward, norm, triple
from mafsil.mechanics.closed_form.thresholds import MERGED


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

    normal: Carried
    shoulder: Carried
    elbow: Carried
    wrist: Carried
    reach: Shoulder | None = None


@dataclass(frozen=True, eq=False)
class HighElbow:
    """An elbow above or below the line from shoulder to wrist."""

    shoulder: Carried
    elbow: Carried
    wrist: Carried
    up: Carried


@dataclass(frozen=True, eq=False)
class Stroke:
    """A prismatic joint along `axis`, perhaps only across another, that leads `end` away from `start`."""

    axis: Carried
    start: Carried
    end: Carried
    across: Carried | None = None


@dataclass(frozen=True, eq=False)
class Placing:
    """Three joints without such a shape: the sign of the determinant of the velocities that they give a point."""

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


def sides_function(sides: ArmSides) -> ex.Function:
    """Of q to the sum of the digits of shoulder, elbow and wrist times 1, 3 and 9: 0 negative, 1 neither, 2 positive.

    Args:
        sides: of the arm.
    """
    q = ex.symbol("q", len(sides.prismatic))
    code = ex.Expression(0)
    for number, weight in zip(_Configuration(sides, q).numbers(), (1, 3, 9), strict=True):
        digit = 1 if number is None else ex.if_else(number > MERGED, 2, ex.if_else(number < -MERGED, 0, 1))
        code = code + weight * digit
    return ex.Function("branch_code", [q], [ex.cse(code)])


class _Configuration:
    """The joints of an arm at q."""

    def __init__(self, sides: ArmSides, q: ex.Expression) -> None:
        self.sides, self.size = sides, sides.size
        rows = zip(sides.prismatic, sides.axes, sides.points, strict=True)
        self.lines = [Line(sliding, ex.Expression(w), ex.Expression(r)) for sliding, w, r in rows]
        self.motions: list[Motion] = [
            q[i] if sliding else Turn(ex.cos(q[i]), ex.sin(q[i])) for i, sliding in enumerate(sides.prismatic)
        ]

    def numbers(self) -> Sequence[ex.Expression | None]:
        """Shoulder, elbow and wrist."""
        one, two, three = self.sides.shoulder, self.sides.elbow, self.sides.wrist
        return (
            None if one is None else self._shoulder(one),
            None if two is None else self._elbow(two),
            None if three is None else triple(*(self._vector(three[k]) for k in (1, 0, 2))),
        )

    def _point(self, point: Carried) -> ex.Expression:
        return forward(self.lines[: point.after], self.motions, ex.Expression(point.at))

    def _vector(self, direction: Carried) -> ex.Expression:
        x = ex.Expression(direction.at)
        for line, motion in reversed(list(zip(self.lines[: direction.after], self.motions, strict=False))):
            x = line.vector(x, motion)
        return x

    def _axis(self, k: int) -> ex.Expression:
        return self._vector(Carried(self.sides.axes[k], k))

    def _shoulder(self, one: Shoulder) -> ex.Expression:
        reach = self._point(one.end) - self._point(one.start)
        return triple(self._vector(one.axis), reach, self._vector(one.up)) / self.size

    def _elbow(self, elbow: Elbow) -> ex.Expression:
        if isinstance(elbow, Stroke):
            along = self._vector(elbow.axis)
            along = along if elbow.across is None else across(self._vector(elbow.across), along)
            return ex.dot(along, self._point(elbow.end) - self._point(elbow.start)) / self.size
        if isinstance(elbow, Placing):
            return self._determinant(elbow)
        S, E, W = (self._point(x) for x in (elbow.shoulder, elbow.elbow, elbow.wrist))
        if isinstance(elbow, PlaneElbow):
            left = ex.dot(E - S, cross(self._vector(elbow.normal), W - S)) / self.size**2
            return left if elbow.reach is None else ex.if_else(self._shoulder(elbow.reach) < 0, -left, left)
        line = W - S
        line = line / ex.fmax(norm(line), 1e-300)
        return ex.dot(E - S, across(line, self._vector(elbow.up))) / self.size

    def _determinant(self, placing: Placing) -> ex.Expression:
        place, turning = self._point(placing.point), 0
        columns: list[ex.Expression] = []
        for k in placing.joints:
            axis, sliding = self._axis(k), self.sides.prismatic[k]
            turning += not sliding
            columns.append(axis if sliding else cross(axis, place - self._point(Carried(self.sides.points[k], k))))
        one, two, three = columns
        return triple(one, two, three) / self.size**turning
