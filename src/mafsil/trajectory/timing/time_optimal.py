"""The shortest time in which joints can follow a path within their limits."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast, overload

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, frozen, positive, real_array, require_finite, require_kind, whole
from mafsil.errors import InputError
from mafsil.model.limits import MEASURED
from mafsil.model.loading import require_no_loops
from mafsil.robot import Robot
from mafsil.trajectory.checks.limit_check import extremes
from mafsil.trajectory.motion_limits import Limits, MotionLimits, motion_limits
from mafsil.trajectory.path import JointPath
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.timing.sampled_limits import EffortLimit, SampledLimit, TipLimit
from mafsil.trajectory.timing.sampled_timing import ALLOWED, MOST_ROUNDS, timed_within
from mafsil.trajectory.timing.timing_answer import TimeOptimal, TimeOptimalBatch, TimingStatus, with_jerk
from mafsil.trajectory.timing.timing_problem import FREE, Timing, TimingProblem, Timings, limits_of_each, solve_timing

NEVER = 1e100
"""A duration beyond which a motion does not move [s]."""

Path = JointPath | PiecewisePolynomial


@overload
def time_optimal(
    path: Path,
    limits: Limits,
    *,
    start_path_velocity: ArrayLike = ...,
    end_path_velocity: ArrayLike = ...,
    robot: Robot | None = ...,
    tip_speed: float = ...,
    tip_acceleration: float = ...,
    tip_angular_speed: float = ...,
    frame: str | None = ...,
    intervals: int | None = ...,
) -> TimeOptimal: ...
@overload
def time_optimal(
    path: Sequence[Path],
    limits: Limits,
    *,
    start_path_velocity: ArrayLike = ...,
    end_path_velocity: ArrayLike = ...,
    robot: Robot | None = ...,
    tip_speed: float = ...,
    tip_acceleration: float = ...,
    tip_angular_speed: float = ...,
    frame: str | None = ...,
    intervals: int | None = ...,
) -> TimeOptimalBatch: ...
def time_optimal(
    path: Path | Sequence[Path],
    limits: Limits,
    *,
    start_path_velocity: ArrayLike = 0.0,
    end_path_velocity: ArrayLike = 0.0,
    robot: Robot | None = None,
    tip_speed: float = np.inf,
    tip_acceleration: float = np.inf,
    tip_angular_speed: float = np.inf,
    frame: str | None = None,
    intervals: int | None = None,
) -> TimeOptimal | TimeOptimalBatch:
    """The shortest time in which joints follow a path within limits of velocity, acceleration, jerk, effort and tip.

    The square of the path velocity is linear between the places of a grid, and the limits hold everywhere between them:
    the joints' velocities and accelerations there are polynomials, whose Bernstein coefficients keep the limits.
    Directions that jump, as at corners of lines, are passed at rest.

    Efforts (the robot's inverse dynamics with rotors, payload and friction) and the tip are no polynomials of s: they
    are imposed at both ends and in the middle of each interval, measured at nine places of it, and where they exceed a
    limit there it is lowered and the timing repeated; `excess` is then what was measured.

    With a finite limit of jerk the motion begins and ends at rest and stops where direction or curvature of the path
    jump; it is a local optimum of a finite spline (`jerk_timing`), and the limits are measured along it.

    Args:
        path: geometry over s, or many such paths of equally many coordinates.
        limits: of the coordinates: position is looked at, velocity, acceleration, jerk and effort are kept.
            Acceleration or effort must be finite somewhere.
        start_path_velocity, end_path_velocity: ds/dt at the ends, not negative, a number or one for each path; zero
            with limits of jerk.
        robot: whose dynamics the efforts and whose tip the limits of the tip mean; `limits` itself if it is a robot.
        tip_speed, tip_acceleration: of the origin of the tip frame, or of `frame` [m/s, m/s^2].
        tip_angular_speed: of its axes [rad/s].
        frame: name of the link whose frame is meant.
        intervals: of the grid, at least two for each polynomial of the path; None for about 600, denser where needed.

    Returns:
        For one path a `TimeOptimal`: `.trajectory`, `.duration`, `.bindings`, or why and where there is none. For many
        paths a `TimeOptimalBatch` of them.

    Raises:
        InputError: wrong shapes, negative velocities, velocities at the ends and limits of jerk, no finite limit of
            acceleration or effort, or limits of effort or of the tip without a robot.
        ModelError: limits of effort of a robot without masses.

    Reference: Pham and Pham, A New Approach to Time-Optimal Path Parameterization Based on Reachability Analysis, IEEE
        Transactions on Robotics 2018.
    """
    single = isinstance(path, (JointPath, PiecewisePolynomial))
    paths = [_path("path", path)] if single else _paths(path)
    if not paths:
        return TimeOptimalBatch(0, _no_answer)
    bounds = motion_limits(limits, paths[0].n)
    if not (np.isfinite(bounds.acceleration).any() or np.isfinite(bounds.effort).any()):
        raise InputError("trajectory.no_acceleration_limit")
    whose = limits if robot is None and isinstance(limits, Robot) else robot
    sampled = _sample(bounds, whose, (tip_speed, tip_acceleration, tip_angular_speed), frame)
    asked = {"start_path_velocity": start_path_velocity, "end_path_velocity": end_path_velocity}
    ends = [_velocity(name, v, len(paths)) for name, v in asked.items()]
    smooth = bool(np.isfinite(bounds.jerk).any())
    if smooth and max(float(v.max()) for v in ends) > 0.0:
        raise InputError("trajectory.jerk_from_rest")
    count = None if intervals is None else whole("intervals", intervals, least=1)
    problem = TimingProblem(paths, *limits_of_each(bounds, len(paths)), ends[0], ends[1], count)
    timings = _each_within(problem, sampled) if sampled else solve_timing(problem)

    bounded = bool(np.isfinite(bounds.position).any())

    def answer(b: int) -> TimeOptimal:
        worst = _position_beyond(paths[b], bounds) if bounded and _hull_leaves(paths[b], bounds) else None
        found = _answer(paths[b], bounds, timings[b], (float(ends[0][b]), float(ends[1][b])), sampled, worst)
        return with_jerk(found) if smooth and found else found

    if single:
        return answer(0)
    known = None if bounded or smooth or isinstance(timings, list) else _durations(timings)
    return TimeOptimalBatch(len(paths), answer, known)


def _paths(given: object) -> list[JointPath]:
    """Many paths of equally many coordinates."""
    paths = [_path(f"path[{k}]", part) for k, part in enumerate(_several(given))]
    counts = {one.n for one in paths}
    if len(counts) > 1:
        raise InputError("trajectory.paths_differ", counts=", ".join(str(count) for count in sorted(counts)))
    return paths


def _durations(timings: Timings) -> Floats:
    """(paths,) [s]; infinite where there is no timing, as `_why` says."""
    timed = (timings.stopped < 0) & (timings.durations < NEVER) & (timings.excess <= ALLOWED)
    return frozen(np.where(timed, timings.durations, np.inf))


def _no_answer(index: int) -> TimeOptimal:
    """Of no paths."""
    raise IndexError(index)


def _sample(
    limits: MotionLimits, robot: Robot | None, tip: tuple[float, float, float], frame: str | None
) -> list[SampledLimit]:
    """Limits that need a robot."""
    found: list[SampledLimit] = []
    if np.isfinite(limits.effort).any():
        if robot is None:
            raise InputError("trajectory.effort_needs_robot")
        require_no_loops(robot.mechanism)
        found.append(EffortLimit(_fitting(robot, limits.n), limits.effort))
    given = zip(("tip_speed", "tip_acceleration", "tip_angular_speed"), tip, strict=True)
    bounds = [bound if bound == np.inf else positive(name, bound) for name, bound in given]
    if min(bounds) < np.inf:
        if robot is None:
            raise InputError("trajectory.tip_needs_robot")
        found.append(TipLimit(_fitting(robot, limits.n), bounds[0], bounds[1], bounds[2], frame))
    return found


def _fitting(robot: Robot, n: int) -> Robot:
    """The robot, if it has n coordinates."""
    if robot.n != n:
        raise InputError("input.shape", name="robot", expected=(n,), got=(robot.n,), hint="")
    return robot


def _each_within(problem: TimingProblem, sampled: list[SampledLimit]) -> list[Timing]:
    """The timing of each path under sampled limits."""
    return [timed_within(problem.of(b), sampled) for b in range(len(problem.paths))]


def _several(path: object) -> Sequence[Path]:
    """Many paths."""
    if isinstance(path, (list, tuple)):
        return cast(Sequence[Path], path)
    raise InputError(
        "input.kind", name="path", expected="JointPath, PiecewisePolynomial or a list of them", got=type(path).__name__
    )


def _path(name: str, path: object) -> JointPath:
    """A path, of a polynomial over s too."""
    if isinstance(path, PiecewisePolynomial):
        return JointPath(path)
    require_kind(name, path, "JointPath", "curve", "length")
    assert isinstance(path, JointPath)
    return path


def _velocity(name: str, value: ArrayLike, count: int) -> Floats:
    """(count,) velocities that are not negative."""
    if isinstance(value, float) and 0.0 <= value < np.inf:
        return np.full(count, value)
    array = require_finite(name, real_array(name, value))
    if array.shape not in ((), (count,)):
        raise InputError("input.shape", name=name, expected=(count,), got=array.shape, hint="")
    each = np.full(count, array)
    if min(each) < 0.0:
        raise InputError("input.range", name=name, value=array.min(), low=0.0, high=np.inf)
    return each


def _hull_leaves(path: JointPath, limits: MotionLimits) -> bool:
    """Whether a position, or the sum of all powers beyond the constant one, exceeds the limits of position.

    |u(s) - u(s_i)| <= sum_k |c_k| h^k on the piece that begins at s_i.
    """
    rows, h = path.curve.coefficients, np.diff(path.curve.knots)
    reach = np.zeros(rows[:, 0].shape)
    for k in range(rows.shape[1] - 1, 0, -1):
        reach = (reach + np.abs(rows[:, k])) * h[:, None]
    low, high = limits.position
    return bool((rows[:, 0] + reach > high + MEASURED).any() or (rows[:, 0] - reach < low - MEASURED).any())


def _answer(
    path: JointPath,
    limits: MotionLimits,
    timing: Timing,
    velocities_at_ends: tuple[float, float],
    sampled: list[SampledLimit],
    beyond: dict[str, object] | None,
) -> TimeOptimal:
    """The answer to one path: the motion, or the reason and the place; `beyond` of `_position_beyond`."""
    if beyond is not None:
        return TimeOptimal(TimingStatus.POSITION, path, limits, timing, beyond)
    effort = next((limit for limit in sampled if isinstance(limit, EffortLimit)), None)
    status, details = _why(path, limits, timing, *velocities_at_ends, effort)
    return TimeOptimal(status, path, limits, timing, details, tuple(sampled), velocities_at_ends)


def _position_beyond(path: JointPath, limits: MotionLimits) -> dict[str, object] | None:
    """The joint and the place where the path is farthest beyond a limit of position."""
    places, u = extremes(path.curve, 0)
    excess = np.maximum(u - limits.position[1], limits.position[0] - u)
    row, joint = (int(k) for k in np.unravel_index(int(excess.argmax()), excess.shape))
    if excess[row, joint] <= MEASURED:
        return None
    side = limits.position[1] if u[row, joint] > limits.position[1, joint] else limits.position[0]
    return {"joint": joint, "value": float(u[row, joint]), "place": float(places[row]), "limit": float(side[joint])}


def _why(
    path: JointPath, limits: MotionLimits, timing: Timing, start: float, end: float, effort: EffortLimit | None
) -> tuple[TimingStatus, dict[str, object]]:
    """How the passes ended and what the sentence mentions."""
    last, stopped = len(timing.s) - 1, timing.stopped
    if stopped == last and last:
        return TimingStatus.END_VELOCITY, {"velocity": end, "highest": float(np.sqrt(timing.caps[-1]))}
    if stopped == 0 and timing.high[0] >= 0.0:
        lowest, highest = np.sqrt(timing.low[0]), np.sqrt(timing.high[0])
        return TimingStatus.START_VELOCITY, {"velocity": start, "lowest": float(lowest), "highest": float(highest)}
    if stopped >= 0:
        weak = _weak(path, timing, effort) if effort else None
        return weak or (TimingStatus.BLOCKED, {"place": float(timing.s[stopped])})
    if timing.duration < NEVER and timing.excess > ALLOWED:
        return TimingStatus.EXCEEDED, {"excess": timing.excess, "rounds": MOST_ROUNDS}
    if timing.duration < NEVER:
        return TimingStatus.TIMED, {"duration": timing.duration, "intervals": last, "excess": timing.excess}
    pairs = np.maximum(timing.x[:-1], timing.x[1:])
    k = int(np.flatnonzero(pairs <= pairs.min())[0])
    return TimingStatus.NO_MOTION, {"place": float(timing.s[k]), "joint": _standing(path, limits, timing, k)}


def _weak(path: JointPath, timing: Timing, effort: EffortLimit) -> tuple[TimingStatus, dict[str, object]] | None:
    """The joint and the place where rest alone needs most beyond a limit of effort; None if rest is possible."""
    here = path.at(timing.s)
    still = np.zeros(len(timing.s))
    excess = effort.excess(here, still, still)
    row, column = (int(k) for k in np.unravel_index(int(excess.argmax()), excess.shape))
    if excess[row, column] <= 0.0:
        return None
    joint, side = column % path.n, 0 if column >= path.n else 1
    value = float(effort.torque(here, still, still)[row, joint])
    details: dict[str, object] = {
        "joint": joint,
        "value": value,
        "place": float(timing.s[row]),
        "limit": float(effort.effort[side, joint]),
    }
    return TimingStatus.NO_REST, details


def _standing(path: JointPath, limits: MotionLimits, timing: Timing, k: int) -> int:
    """The joint whose limits allow no motion on interval k."""
    forth = path.at((timing.s[k] + timing.s[k + 1]) / 2.0).slope
    allowed = [FREE] * path.n
    for j in np.flatnonzero(forth):
        ahead, behind = (1, 0) if forth[j] > 0.0 else (0, 1)
        bounds = (limits.velocity[ahead, j], limits.acceleration[ahead, j], limits.acceleration[behind, j])
        allowed[int(j)] = min(abs(float(bound)) for bound in bounds)
    return int(np.argmin(allowed))
