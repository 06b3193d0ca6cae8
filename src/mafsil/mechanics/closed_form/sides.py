"""The sides of an arm as expressions of its coordinates; what they mean stands in `mafsil.mechanics.arm_sides`."""

from __future__ import annotations

from collections.abc import Sequence

import mafsil.expression as ex
from mafsil.algebra.spatial import cross
from mafsil.algebra.subproblems import Turn
from mafsil.mechanics.arm_sides import ArmSides, Carried, Elbow, Placing, PlaneElbow, Shoulder, Stroke
from mafsil.mechanics.closed_form.line import Line, Motion, across, forward, norm, triple
from mafsil.mechanics.closed_form.thresholds import MERGED


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
        place, revolute = self._point(placing.point), 0
        columns: list[ex.Expression] = []
        for k in placing.joints:
            axis, sliding = self._axis(k), self.sides.prismatic[k]
            revolute += not sliding
            columns.append(axis if sliding else cross(axis, place - self._point(Carried(self.sides.points[k], k))))
        one, two, three = columns
        return triple(one, two, three) / self.size**revolute
