"""Configurations of a linkage of mobility 1 followed as a curve: closed or not, with branch points and dead points.

Prediction along the tangent, correction back to closed loops by Newton's method; the step follows the correction.

All curves of configurations of a linkage of mobility 1 that a search finds: traced, told apart, counted.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, positive, whole
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.messages.tables import number, table
from mafsil.mobility.finite import all_are_real, require_motions
from mafsil.mobility.instantaneous import instantaneous_mobility, null_space
from mafsil.mobility.linkages.linkage import Linkage, on_linkage
from mafsil.mobility.linkages.loop_closure import body_poses, close_loops_near, configuration, loop_matrix, units

SHORTEST = 1e-5
LONGEST = 0.1
TOO_FAR = 0.2
"""Share of a step that its correction may be; beyond it the step is halved."""
EASY = 0.02
"""Share below which the next step is longer."""
BISECTIONS = 40
AROUND_BRANCH = 0.25
"""Branch points nearer than this share of a step to each other are one."""


class TraceStatus(Status):
    """How following a curve ended."""

    CLOSED = ("mobility.trace_closed", True)
    OPEN = ("mobility.trace_open", True)
    STUCK = ("mobility.trace_stuck", False)


@dataclass(frozen=True, eq=False, repr=False)
class Trace(Answer, data="length theta branch_points"):
    """A curve of configurations; true if it was followed to its end or as far as was allowed.

    Attributes:
        linkage: of mobility 1.
        status: closed (back at the start), open (the number of steps is spent), stuck.
        theta: (k, F) coordinates along it [rad | m]; angles are not wrapped.
        tangents: (k, F) unit rates, translations over the size of the linkage.
        branch_points: (b, F) configurations where the orientation of the constraints reverses: another curve crosses.
    """

    linkage: Linkage
    status: TraceStatus
    theta: Floats
    tangents: Floats
    branch_points: Floats

    @property
    def length(self) -> float:
        """Length in the coordinates [rad, sizes]."""
        steps = np.diff(self.theta, axis=0) / units(self.linkage)
        return float(np.linalg.norm(steps, axis=1).sum())

    def dead_points(self, joint: str) -> Floats:
        """(d, F) configurations at which the rate of a joint changes its sign: it drives nothing there."""
        column = int(self.linkage.columns_of([joint])[0])
        rate = self.tangents[:, column]
        places = np.flatnonzero(rate[:-1] * rate[1:] < 0)
        low, high, tangents = self.theta[places], self.theta[places + 1], self.tangents[places]
        for _ in range(BISECTIONS if len(places) else 0):
            middle = close_loops_near(self.linkage, (low + high) / 2).theta
            here = np.linalg.svd(loop_matrix(self.linkage, middle))[2][:, -1]
            sense = np.sign(np.sum(here * tangents, axis=-1))
            before = (sense * here[:, column] * tangents[:, column] > 0)[:, None]
            low, high = np.where(before, middle, low), np.where(before, high, middle)
        return (low + high) / 2

    def explain(self, language: str | None = None) -> str:
        """How it ended, its length, and the branch points."""
        return self.status.sentence(
            language, points=len(self.theta), length=self.length, branches=len(self.branch_points)
        )


@on_linkage
def trace_motion(
    linkage: Linkage, theta: ArrayLike | None = None, *, step: float = LONGEST, steps: int = 4000
) -> Trace:
    """Follow the configurations of a linkage of mobility 1 from a regular one, until they lead back.

    1. The tangent is the null vector of the loop matrix, turned to go on as before.
    2. A step along it, closed again by Newton's method; halved where the correction is large, longer where it is small.
    3. The sign of det [kept rows; tangent] is that of before unless a branch point was passed; bisection finds it.
    4. Back within a step of the start, where the bodies stand as they did: closed.

    Args:
        linkage: of mobility 1; spherical joints must keep away from the middle of their three axes' lock.
        theta: (F,) start [rad | m]; as drawn if None.
        step: longest step [rad, sizes].
        steps: at most.

    Raises:
        InputError: the mobility by rank is not 1 at the start, or the only first-order motion is none.
    """
    scale, here = units(linkage), configuration(linkage, theta)
    largest, most = positive("step", step), whole("steps", steps, 1)
    if largest > np.pi:
        raise InputError("input.range", name="step", value=step, low=0.0, high=np.pi)
    frame = _Frame.at(linkage, here, None)
    require_motions(linkage, here, 1)
    path, tangents, branches = [here], [frame.tangent], list[Floats]()
    begin, h, status = body_poses(linkage, here), largest / 4, TraceStatus.OPEN
    for _ in range(most):
        moved = close_loops_near(linkage, here + h * frame.tangent * scale)
        gone = (moved.theta - here) / scale
        correction = float(np.linalg.norm(gone - h * frame.tangent)) / h
        if not moved or correction > TOO_FAR:
            h /= 2
            if h < SHORTEST:
                status = TraceStatus.STUCK
                break
            continue
        after = _Frame.at(linkage, moved.theta, frame)
        if frame.reversed_by(linkage, moved.theta, after.tangent):
            branches.append(_branch_point(linkage, here, moved.theta, frame))
        here, frame = moved.theta, after
        path.append(here)
        tangents.append(frame.tangent)
        back = _apart(linkage, here, begin)
        if len(path) > 4 and back < 2 * h * np.sqrt(linkage.coordinates) and _passes_start(linkage, path, begin, scale):
            status = TraceStatus.CLOSED
            break
        h = min(largest, 1.5 * h) if correction < EASY else h
    return Trace(linkage, status, np.array(path), np.array(tangents), _distinct(branches, linkage.coordinates))


@dataclass(frozen=True, eq=False)
class _Frame:
    """Tangent and independent rows at a point of the curve.

    Attributes:
        tangent: (F,) unit.
        rows: (F - 1, 6 L) orthonormal combinations of the rows of the loop matrix that are independent here.
        sign: of det [rows A; tangent].
    """

    tangent: Floats
    rows: Floats
    sign: float

    @classmethod
    def at(cls, linkage: Linkage, theta: Floats, before: _Frame | None) -> _Frame:
        A = loop_matrix(linkage, theta)
        if before is None:
            rank, basis, _, _ = null_space(A)
            if basis.shape[1] != 1:
                raise InputError("mobility.trace_one", mobility=basis.shape[1])
            tangent = basis[:, 0]
        else:
            tangent = np.linalg.svd(A)[2][-1]
            tangent = tangent * (1.0 if float(tangent @ before.tangent) >= 0 else -1.0)
            rank = len(before.rows)
        rows = np.linalg.svd(A)[0][:, :rank].T
        return cls(tangent, rows, _orientation(rows @ A, tangent))

    def reversed_by(self, linkage: Linkage, theta: Floats, tangent: Floats) -> bool:
        """Whether the orientation, measured in these rows, is the opposite there."""
        return _orientation(self.rows @ loop_matrix(linkage, theta), tangent) * self.sign < 0


def _orientation(rows: Floats, tangent: Floats) -> float:
    return float(np.sign(np.linalg.det(np.vstack([rows, tangent]))))


def _branch_point(linkage: Linkage, start: Floats, end: Floats, frame: _Frame) -> Floats:
    """Where between two points the orientation reverses, by bisection along the chord."""
    low, high = start, end
    for _ in range(BISECTIONS):
        middle = close_loops_near(linkage, (low + high) / 2).theta
        after = _Frame.at(linkage, middle, frame)
        if frame.reversed_by(linkage, middle, after.tangent):
            high = middle
        else:
            low = middle
    return (low + high) / 2


def _passes_start(linkage: Linkage, path: list[Floats], begin: Floats, scale: Floats) -> bool:
    """Whether the last step passes the configuration of the start: the nearest point of the chord closes onto it."""
    chord = (path[-1] - path[-2]) / scale
    ends = [_apart(linkage, path[-2] + share * chord * scale, begin) for share in np.linspace(0.0, 1.0, 9)]
    return min(ends) < 0.2 * float(np.linalg.norm(chord))


def _apart(linkage: Linkage, theta: Floats, begin: Floats) -> float:
    T = body_poses(linkage, theta)
    shift = np.abs(T[..., :3, 3] - begin[..., :3, 3]).max() / linkage.size
    return float(max(np.abs(T[..., :3, :3] - begin[..., :3, :3]).max(), shift))


def _distinct(points: list[Floats], F: int) -> Floats:
    kept: list[Floats] = []
    for point in points:
        if all(float(np.abs(point - other).max()) > AROUND_BRANCH * LONGEST for other in kept):
            kept.append(point)
    return np.array(kept).reshape(-1, F)


ON_CURVE = 0.75
"""Times the square of the longest step, for each body: as far as a curve of curvature up to 6 bends off its chords."""


class CurvesStatus(Status):
    """Whether curves were found; a search never says that there is no other."""

    FOUND = ("mobility.curves_found", True)
    NOT_FOUND = ("mobility.curves_not_found", False)


@dataclass(frozen=True, eq=False, repr=False)
class ConfigurationCurves(Answer, data="hits others curves", entries="curves"):
    """Curves of configurations, each with its branch points; true if there are any, iterable over them.

    Attributes:
        curves: traced from the first configuration that was met on each.
        hits: how many starts led to each curve.
        others: configurations met that are singular or of another mobility; no curve was traced from them.
    """

    curves: tuple[Trace, ...]
    hits: tuple[int, ...]
    others: int

    @property
    def status(self) -> CurvesStatus:
        """Found or not found."""
        return CurvesStatus.FOUND if self.curves else CurvesStatus.NOT_FOUND

    def __bool__(self) -> bool:
        return len(self.curves) > 0

    def _table(self) -> list[str]:
        head = (
            say("mobility.curve_head"),
            say("mobility.hits_head"),
            say("mobility.length_head"),
            say("mobility.branches_head"),
        )
        rows = [
            (str(k + 1), str(hits), number(curve.length), str(len(curve.branch_points)))
            for k, (hits, curve) in enumerate(zip(self.hits, self.curves, strict=True))
        ]
        return table(head, rows) if rows else []

    def explain(self, language: str | None = None) -> str:
        """How many curves, how many of them closed, how rare the rarest was."""
        closed = sum(curve.status.name == "CLOSED" for curve in self.curves)
        return self.status.sentence(
            language, count=len(self.curves), closed=closed, fewest=min(self.hits, default=0), others=self.others
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return Answer.to_dict(self) | {"count": len(self.curves)}


@on_linkage
def configuration_curves(
    linkage: Linkage, *, starts: int = 64, step: float = LONGEST, steps: int = 4000, seed: int = 0
) -> ConfigurationCurves:
    """The curves that make up the configurations of a linkage of mobility 1, as far as random starts find them.

    1. Random coordinates, closed by Newton's method, all at once.
    2. Each configuration that lies on no curve yet is the start of the next.

    Branch points join curves that are counted apart here: a curve goes straight on through them.

    Args:
        linkage: as drawn.
        starts: random starts; where it is drawn is the first.
        step, steps: of the curves, see `trace_motion`.
        seed: of the starts.
    """
    count, longest = whole("starts", starts, 1, 10_000), positive("step", step)
    scale = units(linkage)
    start = np.random.default_rng(seed).uniform(-np.pi, np.pi, (count, linkage.coordinates))
    start = start * np.where(scale == 1.0, 1.0, linkage.size / np.pi)
    start[0] = 0.0
    closed = close_loops_near(linkage, start)
    curves: list[Trace] = []
    hits: list[int] = []
    others = 0
    for theta in closed.theta[closed.closed]:
        on = [k for k, curve in enumerate(curves) if _lies_on(linkage, theta, curve, longest)]
        if on:
            hits[on[0]] += 1
        elif instantaneous_mobility(linkage, theta).mobility != 1 or not all_are_real(linkage, theta, 1):
            others += 1
        else:
            curves.append(trace_motion(linkage, theta, step=longest, steps=steps))
            hits.append(1)
    return ConfigurationCurves(tuple(curves), tuple(hits), others)


def _lies_on(linkage: Linkage, theta: Floats, curve: Trace, step: float) -> bool:
    """Whether the bodies stand as somewhere on a curve: the nearest point of its chords, in places of the bodies."""
    scale = np.append(np.ones(9), np.full(3, 1 / linkage.size))

    def places(value: Floats) -> Floats:
        T = body_poses(linkage, value)
        rows = np.concatenate([T[..., :3, :3].reshape(*T.shape[:-2], 9), T[..., :3, 3]], axis=-1) * scale
        return rows.reshape(*rows.shape[:-2], -1)

    here, path = places(theta), places(curve.theta)
    chord = np.diff(path, axis=0)
    size = np.maximum(np.sum(chord**2, axis=1), LEAST_DIVISOR)
    along = np.clip(np.sum((here - path[:-1]) * chord, axis=1) / size, 0.0, 1.0)
    apart = np.linalg.norm(here - path[:-1] - along[:, None] * chord, axis=1)
    return bool((apart < ON_CURVE * step**2 * np.sqrt(len(linkage.bodies))).any())
