"""From a path of the tip to a path of the joints on one branch, or to joint rates at a period; stops are named."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer
from mafsil.arrays import LARGEST, Floats, JointVector, not_negative, positive, single
from mafsil.errors import InputError
from mafsil.ik import Track, TrackTask, track
from mafsil.ik.tracking import TrackStatus
from mafsil.model.limits import MEASURED
from mafsil.robot import Robot, of_robot
from mafsil.solvers import Outcome, levenberg_marquardt
from mafsil.trajectory.motion import PlanStatus
from mafsil.trajectory.paths import TipPath
from mafsil.trajectory.paths.pose_path import (
    STRICTER,
    PathTask,
    multiply_rows,
    path_equations,
    path_error,
    path_rates,
    require_task,
)
from mafsil.trajectory.profiles.laws import LawName, rest_law
from mafsil.trajectory.profiles.polynomial import quintic_coefficients
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.tolerances import NEARBY, ON_PATH, REGULAR, ROUNDING, SINGULAR_VALUE

RatesBy = Literal["jacobian", "differences"]
WINDOW = 7
"""Positions through which a polynomial is laid to differentiate them: its rates have errors of order 6."""
CUTOFF = 1e-9
"""Singular values of a Jacobian below this share of the largest belong to motions that the arm does not have."""
FEWEST_PIECES, MOST_PIECES = 16, 1024
PLACING_PIECES = 256
"""Knots that place the end of a path that cannot be followed to its end."""
Followed = Outcome[PiecewisePolynomial | None]


class _Knot(NamedTuple):
    """An end of a piece: coordinates, q', q'', and the smallest singular value of the Jacobian of what counts."""

    q: JointVector
    rate: Floats
    slope: Floats
    margin: float


@of_robot
def follow(
    robot: Robot,
    path: TipPath,
    q_start: JointVector,
    *,
    frame: str | None = None,
    tolerance: float = 1e-6,
    task: PathTask = "pose",
    slack: float = 0.0,
) -> Followed:
    """The joint path over s in 0 .. 1 that moves a frame along `path`, starting at `q_start`.

    q' = J# V, the solution of least norm, integrated along the path and corrected onto it at every knot; quintics
    between the knots. Breaks of the path are knots, others are doubled until the frame keeps to the path between them.

    Args:
        robot: whose tip or `frame` moves.
        path: of the frame: a line, an arc, a screw motion, a spline, or several joined; its start is the frame's pose
            at q_start. At corners the rates jump.
        q_start: (n,) [rad | m].
        frame: name of a link; the tip if None.
        tolerance: largest deviation from the path [m, rad].
        task: what of the path the frame keeps to; the rest is left to the arm, and kept to only if the arm's own way
            fails: so a path that can be followed with more can be followed with less.
        slack: of arms that cannot keep to the path, its largest distance from what they can reach [m, rad]: they follow
            in the sense of least squares.

    Returns:
        The joint path, its residual the largest deviation (DEVIATES if that exceeds the tolerance), in its details the
        task that it keeps to; or None with NOT_FOUND, ORIENTATION_NOT_FOUND, SINGULAR or JOINT_LIMIT and the place s
        where the path ends.
    """
    tolerance, slack = positive("tolerance", tolerance), not_negative("slack", slack)
    if tolerance < ROUNDING:
        raise InputError("input.range", name="tolerance", value=tolerance, low=ROUNDING, high=LARGEST)
    require_task(task)
    first = _follow(_Tracker(robot, path, frame, task, slack), q_start, tolerance)
    if first.succeeded:
        return first
    others = (_follow(_Tracker(robot, path, frame, more, slack), q_start, tolerance) for more in STRICTER[task])
    return next((found for found in others if found.succeeded), first)


def _follow(tracker: _Tracker, q_start: JointVector, tolerance: float) -> Followed:
    """With as many pieces as it takes."""
    pieces, slack, kept = FEWEST_PIECES, tracker.slack, {"task": tracker.task}
    while True:
        outcome = tracker.march(q_start, pieces)
        if outcome.value is None:
            if pieces >= PLACING_PIECES:
                return outcome
            pieces = PLACING_PIECES
            continue
        deviation = tracker.deviation(outcome.value)
        if deviation <= tolerance + slack:
            return Outcome(outcome.value, PlanStatus.FOLLOWED, deviation, pieces, details=kept)
        if pieces >= MOST_PIECES:
            return Outcome(
                outcome.value, PlanStatus.DEVIATES, deviation, pieces, details={"tolerance": tolerance + slack}
            )
        pieces *= 2


@dataclass(frozen=True, eq=False)
class _Tracker:
    """One robot, one path."""

    robot: Robot
    path: TipPath
    frame: str | None
    task: PathTask
    slack: float

    def march(self, q_start: JointVector, pieces: int) -> Followed:
        """Knot by knot from the start."""
        q = np.array(q_start, dtype=np.float64)
        ends: list[tuple[_Knot, _Knot]] = []
        places = self._places(pieces)
        inner = set(self.path.breaks[1:-1].tolist())
        for begin, end in pairwise(places):
            # At a break the path has two twists: that of the piece counts.
            first = float(np.nextafter(begin, 1.0)) if begin in inner else begin
            last = float(np.nextafter(end, 0.0)) if end in inner else end
            before = ends[-1][1] if ends and first == begin else self._knot(first, q)
            if before.margin < SINGULAR_VALUE:
                return _end(PlanStatus.SINGULAR, begin, margin=before.margin)
            q = self._correct(self._predict(first, before, last - first), end)
            if np.isnan(q).any():
                return self._why_not(before, begin, end)
            outside = self._outside(q)
            if outside is not None:
                joint, limit = outside
                name, value = self.robot.joint_names[joint], float(q[joint])
                return _end(PlanStatus.JOINT_LIMIT, end, joint=name, value=value, limit=limit)
            ends.append((before, self._knot(last, q)))
        steps = np.diff(places).tolist()
        coefficients = [
            quintic_coefficients(a.q, b.q, a.rate, b.rate, a.slope, b.slope, h)
            for h, (a, b) in zip(steps, ends, strict=True)
        ]
        return Outcome(PiecewisePolynomial.from_pieces(steps, coefficients), PlanStatus.FOLLOWED)

    def _places(self, pieces: int) -> list[float]:
        """Knots: evenly spaced places, and the breaks of the path, where its twist may jump."""
        even = np.linspace(0.0, 1.0, pieces + 1)
        breaks = self.path.breaks[1:-1]
        # Where a break is, no even place is needed beside it.
        apart = np.abs(even[:, None] - breaks).min(axis=1, initial=np.inf) > 1.0 / (8 * pieces)
        apart[[0, -1]] = True
        return np.union1d(even[apart], breaks).tolist()

    def deviation(self, joints: PiecewisePolynomial) -> float:
        """Largest pose error in the middle of the pieces, where it is greatest."""
        middles = (joints.knots[1:] + joints.knots[:-1]) / 2
        return float(np.abs(self._error(joints.at(middles).u, self.path.poses(middles))).max())

    def _predict(self, s: float, knot: _Knot, h: float) -> JointVector:
        """One classical Runge-Kutta step of q' = J# V."""
        q, k1 = knot.q, knot.rate
        k2 = self._rate(s + h / 2, q + h / 2 * k1)
        k3 = self._rate(s + h / 2, q + h / 2 * k2)
        k4 = self._rate(s + h, q + h * k3)
        return q + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)

    def _correct(self, q: JointVector, s: float) -> JointVector:
        """Newton's method onto the path; NaN if it does not get there within a small distance."""
        target, start = self.path.poses(s), q
        for _ in range(8):
            error = self._error(q, target)
            size = np.abs(error).max()
            if size <= ON_PATH:
                return q
            step = _least_norm(self._equations(s, q)[0], error)
            if size <= self.slack and np.abs(step).max() <= ON_PATH:
                return q
            q = q + step
            if not np.abs(q - start).max() < 0.1:
                break
        return np.full_like(q, np.nan)

    def _rate(self, s: float, q: JointVector) -> Floats:
        return _least_norm(*self._equations(s, q))

    def _knot(self, s: float, q: JointVector) -> _Knot:
        """With q' = A# b and q'' = A# (b' - A' q') + (I - A# A) A'^T y, A^T y = q', the derivative of A# b."""
        J, T = self._jacobian(q), np.eye(4) if self.task == "pose" else self._pose(q)
        A, b = path_equations(T, J, self.path, s, self.task)
        shortest, _, _, singular_values = np.linalg.lstsq(A, b)
        rate: Floats = shortest.astype(np.float64, copy=False)
        A_rate, b_slope = path_rates(T, J, self._jacobian_rate(q, rate), rate, self.path, s, self.task)[2:]
        margin = float(singular_values.min(initial=np.inf))
        if A.shape[0] == A.shape[1] and margin > SINGULAR_VALUE:
            return _Knot(q, rate, _least_norm(A, b_slope - A_rate @ rate), margin)
        free = A_rate.T @ _least_norm(A.T, rate)
        return _Knot(q, rate, free + _least_norm(A, b_slope - A_rate @ rate - A @ free), margin)

    def _equations(self, s: float, q: JointVector) -> tuple[Floats, Floats]:
        """A q' = b along the path."""
        T = np.eye(4) if self.task == "pose" else self._pose(q)
        return path_equations(T, self._jacobian(q), self.path, s, self.task)

    def _error(self, q: JointVector, target: Floats) -> Floats:
        return path_error(self._pose(q), target, self.task)

    def _outside(self, q: JointVector) -> tuple[int, float] | None:
        """The joint that is farthest beyond its limit, and the limit."""
        limits = self.robot.limits
        excess = np.maximum(limits.lower - q, q - limits.upper)
        joint = int(excess.argmax())
        if excess[joint] <= MEASURED:
            return None
        return joint, float(limits.lower[joint] if q[joint] < limits.lower[joint] else limits.upper[joint])

    def _why_not(self, before: _Knot, begin: float, end: float) -> Followed:
        """Whether a search nearby reaches the next knot, past a singularity; else whether it reaches its position."""
        target, q = self.path.poses(end), before.q
        nearby = levenberg_marquardt(
            lambda x: (-self._error(x, target), self._equations(end, x)[0]), q, tolerance=NEARBY, iterations=200
        )
        if nearby.succeeded:
            return _end(PlanStatus.SINGULAR, begin, margin=before.margin)
        status, steps = PlanStatus.NOT_FOUND, nearby.iterations
        if self.task != "position":
            there = replace(self, task="position")
            alone = levenberg_marquardt(
                lambda x: (-there._error(x, target), there._equations(end, x)[0]), q, tolerance=NEARBY, iterations=200
            )
            status = PlanStatus.ORIENTATION_NOT_FOUND if alone.succeeded else status
        return _end(status, begin, nearby.residual, steps=steps)

    def _pose(self, q: JointVector) -> Floats:
        if self.frame is None:
            return self.robot.forward_kinematics(q)
        return self.robot.forward_kinematics(q, frame=self.frame)

    def _jacobian(self, q: JointVector) -> Floats:
        return self.robot.jacobian_body(q) if self.frame is None else self.robot.jacobian_body(q, frame=self.frame)

    def _jacobian_rate(self, q: JointVector, rate: Floats) -> Floats:
        if self.frame is None:
            return self.robot.jacobian_body_rate(q, rate)
        return self.robot.jacobian_body_rate(q, rate, frame=self.frame)


def _least_norm(A: Floats, b: Floats) -> Floats:
    """The shortest x that minimises |A x - b|; the only one that there is where A is square and regular."""
    if A.shape[0] == A.shape[1]:
        with suppress(np.linalg.LinAlgError):
            x: Floats = np.linalg.solve(A, b).astype(np.float64, copy=False)
            if np.abs(x).max() <= REGULAR * np.abs(b).max():
                return x
    return np.linalg.lstsq(A, b)[0].astype(np.float64, copy=False)


def _end(status: PlanStatus, place: float, residual: float = 0.0, **details: object) -> Followed:
    return Outcome(None, status, residual, details={"place": place, **details})


@dataclass(frozen=True, eq=False, repr=False)
class JointMotion(Answer, data="by times q qd qdd"):
    """Joints at every update of a motion of the tip; true if the branch was kept to the end.

    Attributes:
        times: (k,) of the updates [s].
        q, qd, qdd: (k, n) positions, rates and accelerations [rad | m, /s, /s^2]; NaN where the path was not reached.
        by: how the rates were computed.
        track: how inverse kinematics went along the path, with every switch of branch.
    """

    times: Floats
    q: JointVector
    qd: Floats
    qdd: Floats
    by: RatesBy
    track: Track

    @property
    def status(self) -> TrackStatus:
        """That of the track."""
        return self.track.status

    def explain(self, language: str | None = None) -> str:
        """How the path was tracked."""
        return self.track.explain(language)


@of_robot
def joint_motion(
    robot: Robot,
    path: TipPath,
    q_start: ArrayLike,
    duration: float,
    *,
    task: TrackTask = "pose",
    law: LawName = "quintic",
    rate: float = 500.0,
    by: RatesBy = "jacobian",
) -> JointMotion:
    """Move the tip along a path by a time law, and convert every update to joints on the branch of the start.

    1. s, ds/dt and d2s/dt2 of the law at every update, and the tip's poses there.
    2. Inverse kinematics of all poses, each from the one before (`ik.track`).
    3. jacobian:     q' = A# b,  q'' = A# (b' - A' q'),  of A q' = b: J q' = V of the path, or its rows that count;
                     qd = q' ds/dt,  qdd = q'' (ds/dt)^2 + q' d2s/dt2
       differences:  derivatives of the polynomial through seven neighbouring positions, none across a break of the
       path or a switch of branch.

    Both agree up to the rounding of the first and the order of the second. Of redundant arms the first has the rates of
    least norm at each configuration, the second those of the positions as tracked.

    Args:
        robot: whose tip moves.
        path: of the tip.
        q_start: (n,) near the beginning of the path [rad | m].
        duration: [s].
        task: `pose`, or `position`: the orientation is left to the arm.
        law: time law along the path, a name of `mafsil.trajectory.profiles.LAWS`.
        rate: of updates [Hz]; the last is at the end.
        by: `jacobian` or `differences`.

    Raises:
        InputError: a wrong shape, an unknown law or way, a duration or rate that is not positive.

    Reference: Craig, Introduction to Robotics, sec. 7.7: path generation at run time.
    """
    if by not in get_args(RatesBy):
        raise InputError("input.choice", name="by", value=by, known=", ".join(get_args(RatesBy)))
    T, updates, start = positive("duration", duration), positive("rate", rate), single("q_start", q_start, (robot.n,))
    # 1
    times: Floats = np.linspace(0.0, T, max(int(np.ceil(T * updates)), 2) + 1)
    s, speed, growth = rest_law(law).unit().scale_time(T).at(times)
    places = np.clip(s[:, 0], 0.0, 1.0)
    # 2
    found = track(robot, path.poses(places), start, times=times, task=task)
    if task == "position" and not found:  # a motion that keeps to the orientation keeps to the position
        other = track(robot, path.poses(places), start, times=times)
        found, task = (other, "pose") if other else (found, task)
    # 3
    if by == "jacobian":
        qd, qdd = _by_jacobian(robot, path, found.q, places, speed, growth, task)
    else:
        pieces = np.searchsorted(path.breaks[1:-1], places, side="right")
        for switch in found.switches:
            pieces[switch.index :] += len(path.breaks)
        qd, qdd = _by_differences(times, found.q, pieces)
    return JointMotion(times, found.q, qd, qdd, by, found)


def _by_jacobian(
    robot: Robot, path: TipPath, q: JointVector, s: Floats, speed: Floats, growth: Floats, task: PathTask
) -> tuple[Floats, Floats]:
    """(k, n) rates and accelerations from the equations A q' = b of the path and their derivatives; NaN where q is."""
    qd, qdd = np.full_like(q, np.nan), np.full_like(q, np.nan)
    done = np.isfinite(q[:, 0])
    at, places = q[done], s[done]
    T, J = robot.forward_kinematics(at), robot.jacobian_body(at)
    A, b = path_equations(T, J, path, places, task)
    inverse: Floats = np.asarray(np.linalg.pinv(A, rcond=CUTOFF), dtype=np.float64)
    slope = multiply_rows(inverse, b)
    _, _, A_rate, b_slope = path_rates(T, J, robot.jacobian_body_rate(at, slope), slope, path, places, task)
    qd[done] = slope * speed[done]
    qdd[done] = multiply_rows(inverse, b_slope - multiply_rows(A_rate, slope)) * speed[done] ** 2 + slope * growth[done]
    return qd, qdd


def _by_differences(times: Floats, q: JointVector, pieces: NDArray[np.intp]) -> tuple[Floats, Floats]:
    """(k, n) derivatives of polynomials through neighbouring positions of the same piece; NaN in pieces too short."""
    qd, qdd = np.full_like(q, np.nan), np.full_like(q, np.nan)
    h = float(times[1] - times[0])
    for piece in np.unique(pieces):
        (index,) = np.nonzero(pieces == piece)
        width = min(WINDOW, len(index))
        if width < 3:
            continue
        steps = np.arange(len(index))
        first = np.clip(steps - width // 2, 0, len(index) - width)
        around = first[:, None] + np.arange(width)
        slope, bend = np.moveaxis(_weights(width)[steps - first] @ q[index[around]], 1, 0)
        qd[index], qdd[index] = slope / h, bend / h**2
    return qd, qdd


def _weights(width: int) -> Floats:
    """(width, 2, width) what gives both derivatives at each of equally spaced places from the values at all of them."""
    places = np.arange(float(width))
    powers = (places[None, :] - places[:, None])[..., None] ** np.arange(width)
    return np.asarray(np.linalg.inv(powers)[:, 1:3], dtype=np.float64) * np.array([[1.0], [2.0]])
