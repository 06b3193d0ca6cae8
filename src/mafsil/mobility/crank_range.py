"""How far a crank goes: the curve of configurations, cut into arcs on which the crank moves one way.

The curve is followed first, so that it does not matter whether the crank can go round. Dead points of the crank and
limits of joints cut it. Rows are placed by a parameter p: the angle of the crank from where it is drawn, where it goes
round; else c = (c_a + c_b) / 2 - (c_b - c_a) / 2 cos p between the ends of an arc, of which all coordinates are smooth
functions, at dead points too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mafsil.answer import Status
from mafsil.arrays import Booleans, Floats
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.linkages.linkage_joint import Kind, LinkageJoint
from mafsil.mobility.linkages.loop_closure import are_lengths, body_poses, close_loops_near, loop_matrix, units
from mafsil.mobility.tolerances import TYPED
from mafsil.mobility.tracing import BISECTIONS, TraceStatus, trace_motion
from mafsil.solvers import decompositions
from mafsil.solvers.cubic_spline import Spline

STEP = 0.1
"""Longest step along the curve [rad, sizes]: splines through its points miss by a few millionths of that."""
AT_REST = 1e-7
"""Rates of the crank below it, beside those of all joints, are none: it drives nothing."""
BESIDE = 1e-2
"""Distance in p at which rows of a crossing of branches are evaluated instead: fourth powers of it are rounding."""
CROSSING = 3e-3
"""Second least singular value of the loops, over the largest, below which branches cross too near to be told."""
NEAR_END = 10 * BESIDE
"""Distance in p from an end within which rows are evaluated as they are: what grows towards a dead point is steep."""
JUMPED = 0.05
"""From the spline to the closed configuration [rad, sizes]: farther away it is another one."""
IN_LINE = 1e-6
"""Of the size: height of the triangle of three pins that are on one line, as bisection finds it."""
MOVES = 1e-5
"""Share of the largest rate at a dead point above which a joint moves."""
EXTRA = 4
"""Points of a closed curve that are repeated beyond its ends for the spline."""


class TurnStatus(Status):
    """Whether the crank goes round."""

    ROUND = ("mobility.turn_round", True)
    ROUND_SEVERAL = ("mobility.turn_round_several", True)
    BETWEEN = ("mobility.turn_between", True)
    OPEN = ("mobility.turn_open", True)
    INCOMPLETE = ("mobility.turn_incomplete", False)


@dataclass(frozen=True, eq=False)
class RangeEnd:
    """Where a crank turns back, and why.

    Attributes:
        crank: its coordinate [rad | m].
        theta: (F,) of all joints [rad | m].
        moving: names of the joints that still move there with the crank held, of a dead point.
        in_line: whether these are three pins on one line: two links stretched or folded.
        limit: name of the joint that is at its limit; empty at a dead point.
    """

    crank: float
    theta: Floats
    moving: tuple[str, ...] = ()
    in_line: bool = False
    limit: str = ""

    def sentence(self, at: str, language: str | None = None) -> str:
        """The reason in words.

        Args:
            at: the coordinate of the crank for people.
            language: of the sentence.
        """
        key = "limit" if self.limit else "in_line" if self.in_line else "dead"
        return say(f"mobility.turn_{key}", language=language, at=at, joints=", ".join(self.moving), joint=self.limit)


@dataclass(frozen=True, eq=False)
class _Arc:
    """A stretch of the curve on which the crank moves one way.

    Attributes:
        begin, end: coordinate of the crank [rad | m].
        around: p is the way of the crank; else between ends that stay.
        path: (F,) coordinates as a spline of p [rad | m].
    """

    begin: float
    end: float
    around: bool
    path: Spline

    @classmethod
    def of(cls, theta: Floats, column: int, period: Floats | None) -> _Arc:
        """Of points (k, F) of the curve; with a period (F,) the last is the first, so much farther."""
        c = theta[:, column]
        begin, end = float(c[0]), float(c[-1])
        if period is not None:
            theta = np.concatenate([theta[-1 - EXTRA : -1] - period, theta, theta[1 : 1 + EXTRA] + period])
            p = np.abs(theta[:, column] - begin) * np.sign((theta[:, column] - begin) * (end - begin))
        else:
            p = np.arccos(np.clip(1.0 - 2.0 * (c - begin) / (end - begin), -1.0, 1.0))
        onward = np.concatenate([[True], np.diff(np.maximum.accumulate(p)) > TYPED])
        return cls(begin, end, period is not None, Spline(p[onward], theta[onward]))

    def crank(self, p: Floats) -> Floats:
        """Coordinate of the crank at p."""
        if self.around:
            return self.begin + np.sign(self.end - self.begin) * p
        return (self.begin + self.end) / 2 - (self.end - self.begin) / 2 * np.cos(p)

    def rows(self, count: int) -> Floats:
        """(count,) evenly spaced p, from the first of a turn on, at the middles of steps between ends."""
        step = np.arange(count) / count
        return abs(self.end - self.begin) * step if self.around else np.pi * (step + 0.5 / count)


@dataclass(frozen=True, eq=False)
class CrankRange:
    """All that a crank does on the curve of configurations from where a linkage is drawn.

    Attributes:
        linkage: as drawn.
        crank: name of the driven joint.
        status: whether it goes round.
        turns: of the crank until all bodies stand as at the beginning; 0 where it does not go round.
        arcs: in the order of the curve.
        ends: where it turns back.
    """

    linkage: Linkage
    crank: str
    status: TurnStatus
    turns: int
    arcs: tuple[_Arc, ...]
    ends: tuple[RangeEnd, ...]

    @classmethod
    def of(cls, linkage: Linkage, crank: str, sense: float) -> CrankRange:
        """Followed from where it is drawn.

        Args:
            linkage: of mobility 1 there.
            crank: name of the driven joint.
            sense: of its motion at the beginning, 1 or -1.

        Raises:
            InputError: the mobility is not 1, the crank does not move, or a joint is beyond its limits as drawn.
        """
        column = int(linkage.columns_of([crank])[0])
        curve = trace_motion(linkage, step=STEP)
        theta, rate = curve.theta, curve.tangents[:, column]
        if np.abs(rate).max() < AT_REST:
            raise InputError("mobility.crank_idle", crank=crank)
        closed = curve.status is TraceStatus.CLOSED
        if closed:
            # The last step passes the start: it ends there, whole turns away.
            goes_round = np.array([each.kind is not Kind.HELICAL for each in _owners(linkage)], dtype=np.bool_)
            turns: Floats = (theta[-1] - theta[0]) / (2 * np.pi)
            period = 2 * np.pi * turns.round() * (goes_round & ~are_lengths(linkage))
            theta = np.concatenate([theta[:-1], [theta[0] + period]])
        if rate[np.abs(rate) > AT_REST][0] * sense < 0:
            theta = theta[::-1] - (theta[-1] - theta[0] if closed else 0.0)
        theta, stops, whole = _within_limits(linkage, theta, column, closed)
        return _cut(linkage, crank, column, theta, stops, closed and whole, curve.status)

    def timing(self, p: Floats, arc: NDArray[np.intp], speed: float) -> tuple[Floats, Floats, Floats]:
        """Times (k,) from the beginning of the first arc on [s], speeds and accelerations (k,) of the crank there.

        Args:
            p, arc: (k,) parameters and arcs.
            speed: on a turn all along; between ends the largest, of a harmonic motion.
        """
        t, v, a = np.zeros(len(p)), np.zeros(len(p)), np.zeros(len(p))
        begin = 0.0
        for k, each in enumerate(self.arcs):
            on, way = arc == k, each.end - each.begin
            rate = speed if each.around else 2.0 * speed / abs(way)
            t[on] = begin + p[on] / rate
            v[on] = np.sign(way) * speed if each.around else way / 2 * np.sin(p[on]) * rate
            a[on] = 0.0 if each.around else way / 2 * np.cos(p[on]) * rate**2
            begin += np.pi / rate
        return t, v, a

    def rows(self, count: int) -> tuple[Floats, NDArray[np.intp]]:
        """Parameters (k,) and arcs (k,) of `count` rows for each turn or arc."""
        p = [each.rows(count * max(self.turns, 1)) for each in self.arcs]
        return np.concatenate(p), np.repeat(np.arange(len(p)), [len(each) for each in p])

    def close(self, p: Floats, arc: NDArray[np.intp]) -> tuple[Floats, Booleans]:
        """Configurations (k, F) at parameters on arcs, closed with the crank held, and whether they were found."""
        column = int(self.linkage.columns_of([self.crank])[0])
        guess = np.zeros((len(p), self.linkage.coordinates))
        for k, each in enumerate(self.arcs):
            guess[arc == k] = each.path(p[arc == k])
            guess[arc == k, column] = each.crank(p[arc == k])
        if not len(p):
            return guess, np.zeros(0, dtype=np.bool_)
        found = close_loops_near(self.linkage, guess, fixed=[self.crank])
        moved = np.abs((found.theta - guess) / units(self.linkage)).max(axis=1)
        return found.theta, np.asarray(found.closed & (moved < JUMPED), dtype=np.bool_)

    def crosses(self, theta: Floats, p: Floats, arc: NDArray[np.intp]) -> Booleans:
        """(k,) whether branches cross so near to rows that the loops do not decide their rates; at no dead point."""
        values = decompositions.singular_values(loop_matrix(self.linkage, theta))
        least = values[:, self.linkage.coordinates - 2] if self.linkage.coordinates > 2 else values[:, 0]
        far = np.array([each.around for each in self.arcs])[arc]
        inside = far | ((p > NEAR_END) & (p < np.pi - NEAR_END))
        return np.asarray(inside & (least < CROSSING * values[:, 0]), dtype=np.bool_)


def _owners(linkage: Linkage) -> list[LinkageJoint]:
    """The joint of each coordinate."""
    places: list[int] = linkage.joint_of.tolist()
    return [linkage.joints[j] for j in places]


def _within_limits(
    linkage: Linkage, theta: Floats, column: int, closed: bool
) -> tuple[Floats, tuple[RangeEnd | None, RangeEnd | None], bool]:
    """Points of the curve within the limits of all joints, the ends that limits make, and whether that is all of it."""
    low, high = np.array([(each.lower, each.upper) for each in _owners(linkage)]).T
    beyond = (theta < low - TYPED) | (theta > high + TYPED)
    if beyond[0].any():
        raise InputError("mobility.beyond_limit", joint=linkage.coordinate_names[int(beyond[0].argmax())])
    if not beyond.any():
        return theta, (None, None), True

    def stop(inside: Floats, outside: Floats) -> RangeEnd:
        name = ""
        for _ in range(BISECTIONS):
            middle = close_loops_near(linkage, (inside + outside) / 2).theta
            over = (middle < low) | (middle > high)
            inside, outside = (inside, middle) if over.any() else (middle, outside)
            name = linkage.coordinate_names[int(over.argmax())] if over.any() else name
        return RangeEnd(float(inside[column]), inside, limit=name)

    bad = np.flatnonzero(beyond.any(axis=1))
    last = stop(theta[bad[0] - 1], theta[bad[0]])
    kept, first = [*theta[: bad[0]], last.theta], None
    if closed:
        period = theta[-1] - theta[0]
        first = stop(theta[bad[-1] + 1] - period, theta[bad[-1]] - period)
        kept = [first.theta, *(theta[bad[-1] + 1 : -1] - period), *kept]
    return np.array(kept), (first, last), False


def _cut(
    linkage: Linkage, crank: str, column: int, theta: Floats, stops: tuple[RangeEnd | None, RangeEnd | None],
    closed: bool, followed: TraceStatus,
) -> CrankRange:  # fmt: skip
    """Arcs between dead points of the crank and limits of joints."""
    rate = np.diff(theta[:, column])
    period = theta[-1] - theta[0] if closed else None
    reversals = np.flatnonzero(rate[:-1] * rate[1:] < 0) + 1
    dead = [_dead_point(linkage, column, theta[k - 1 : k + 2]) for k in reversals.tolist()]
    if period is not None and rate[-1] * rate[0] < 0:
        dead.append(_dead_point(linkage, column, np.array([theta[-2], theta[-1], theta[1] + period])))
        reversals = np.append(reversals, len(theta) - 1)
    if not len(reversals) and period is not None:
        turns = round(abs(float(period[column])) / (2 * np.pi))
        status = TurnStatus.ROUND if turns == 1 else TurnStatus.ROUND_SEVERAL
        return CrankRange(linkage, crank, status, turns, (_Arc.of(theta, column, period),), ())
    if period is not None:
        # From the first dead point once round to itself.
        k = int(reversals[0])
        theta = np.concatenate([theta[k:-1], theta[: k + 1] + period])
        ends = [*dead, RangeEnd(dead[0].crank, dead[0].theta + period, dead[0].moving, dead[0].in_line)]
        cuts = [*(reversals - k).tolist(), len(theta) - 1]
    else:
        ends = [RangeEnd(float(theta[0, column]), theta[0]), *dead, RangeEnd(float(theta[-1, column]), theta[-1])]
        cuts = [0, *reversals.tolist(), len(theta) - 1]
    arcs = [
        _Arc.of(np.concatenate([[a.theta], theta[i + 1 : j], [b.theta]]), column, None)
        for a, b, i, j in zip(ends, ends[1:], cuts, cuts[1:], strict=False)
    ]
    held = [each for each in (stops[0], *dead, stops[1]) if each is not None]
    going = period is None and followed is not TraceStatus.CLOSED and stops[1] is None
    incomplete = going and followed is TraceStatus.STUCK
    status = TurnStatus.INCOMPLETE if incomplete else TurnStatus.OPEN if going else TurnStatus.BETWEEN
    return CrankRange(linkage, crank, status, 0, tuple(arcs), tuple(held))


def _dead_point(linkage: Linkage, column: int, theta: Floats) -> RangeEnd:
    """Between three points (3, F) of which the crank goes farthest at the middle one; by bisection of its rate.

    The joints that move there, and whether three of them are pins on one line.
    """
    scale, along = units(linkage), theta[2] - theta[0]

    def tangent(here: Floats) -> Floats:
        null = np.linalg.svd(loop_matrix(linkage, here))[2][-1]
        return null * np.sign(null @ (along / scale))

    low, high = theta[0], theta[2]
    before = np.sign(theta[1, column] - theta[0, column])
    for _ in range(BISECTIONS):
        middle = close_loops_near(linkage, (low + high) / 2).theta
        low, high = (middle, high) if tangent(middle)[column] * before > 0 else (low, middle)
    here = (low + high) / 2
    rates = np.abs(tangent(here))
    moving: list[int] = np.unique(linkage.joint_of[rates > MOVES * rates.max()]).tolist()
    for loop in linkage.cycles:
        inside = [j for j in moving if loop[j]]
        if _on_one_line(linkage, here, inside):
            return RangeEnd(float(here[column]), here, tuple(linkage.joints[j].name for j in inside), True)
    return RangeEnd(float(here[column]), here, tuple(linkage.joints[j].name for j in moving))


def _on_one_line(linkage: Linkage, theta: Floats, joints: list[int]) -> bool:
    """Whether three joints are pins of a plane on one line."""
    if len(joints) != 3 or not linkage.planar or any(linkage.joints[j].kind is not Kind.REVOLUTE for j in joints):
        return False
    T = body_poses(linkage, theta)[linkage.ends[joints, 0]]
    places = np.array([X[:3, :3] @ linkage.joints[j].point + X[:3, 3] for X, j in zip(T, joints, strict=True)])
    spread = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
    return bool(spread[1] < IN_LINE * linkage.size)
