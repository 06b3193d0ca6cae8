"""All profiles on the same way: how long each takes within the limits, and how hard it drives the joints."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer
from mafsil.arrays import Floats, as_batch
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.messages.tables import joint_units, number, table
from mafsil.robot import Robot
from mafsil.trajectory.checks.limit_check import check
from mafsil.trajectory.checks.requirements import continuity
from mafsil.trajectory.jerk import JerkLimitedMotion, jerk_limited, jerk_limited_through
from mafsil.trajectory.motion import ComparisonStatus, Trajectory
from mafsil.trajectory.motion_limits import Limits, MotionLimits, motion_limits
from mafsil.trajectory.path import JointPath
from mafsil.trajectory.profiles.laws import LAWS
from mafsil.trajectory.profiles.polynomial import sequence
from mafsil.trajectory.timing.time_optimal import time_optimal
from mafsil.trajectory.tolerances import ROUNDING

SAMPLES = 2001
"""Even times at which a motion is looked at, besides both sides of its breaks."""
COLUMNS = ("profile", "duration", "exceeds", "velocity_used", "acceleration_used", "jerk", "effort_used", "effort_mean")
QUANTITIES = {
    "lower": "coordinate",
    "upper": "coordinate",
    "velocity": "velocity_used",
    "acceleration": "acceleration_used",
    "jerk": "jerk_used",
    "effort": "effort_used",
}
"""Heads of columns that name quantities."""
KEPT = 1e-6
"""Excess of a limit, relative to max(1, limit), that is still allowed: `time_optimal` keeps limits to it."""


@dataclass(frozen=True, eq=False, slots=True)
class ProfileRun:
    """One profile of the comparison.

    Attributes:
        name: of `LAWS`, or `jerk_limited` or `time_optimal`.
        trajectory: the motion.
        velocity, acceleration: the largest share of a limit that is used; 0 where nothing is limited.
        jerk: the largest [rad/s^3 | m/s^3]; infinite where the acceleration jumps.
        effort: the largest share of an effort limit; NaN without a robot that has some.
        mean_effort: root of the mean square of that share over time; NaN likewise.
        exceeds: quantities whose limits it breaks: `lower`, `upper`, `velocity`, `acceleration`, `jerk`, `effort`.
    """

    name: str
    trajectory: Trajectory
    velocity: float
    acceleration: float
    jerk: float
    effort: float
    mean_effort: float
    exceeds: tuple[str, ...] = ()

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return self.trajectory.duration


@dataclass(frozen=True, eq=False, repr=False)
class ProfileComparison(Answer, entries="runs"):
    """Time profiles compared on the same path, the fastest first; true if one keeps all limits, efforts included.

    Attributes:
        runs: one for each profile.
        limits: that each is held against.
    """

    runs: tuple[ProfileRun, ...]
    limits: MotionLimits

    def __getitem__(self, name: str) -> ProfileRun:
        return {run.name: run for run in self.runs}[name]

    @property
    def status(self) -> ComparisonStatus:
        """COMPARED; TOO_WEAK where every profile exceeds a limit of effort, NONE_KEEPS where each exceeds some."""
        if not all(run.exceeds for run in self.runs):
            return ComparisonStatus.COMPARED
        weak = all("effort" in run.exceeds for run in self.runs)
        return ComparisonStatus.TOO_WEAK if weak else ComparisonStatus.NONE_KEEPS

    def explain(self, language: str | None = None) -> str:
        """A sentence, and a row for each profile; without a column for efforts where there are none."""
        keeping = [run for run in self.runs if not run.exceeds]
        first, least = (keeping or self.runs)[0], min(run.effort for run in self.runs)
        details: dict[str, object] = {"count": len(self), "kept": len(keeping), "effort": 100.0 * least}
        details |= {"quickest": first.name, "duration": first.duration}
        columns = COLUMNS if np.isfinite(least) else COLUMNS[:-2]
        head = [say(f"trajectory.column_{name}", language=language) for name in columns]
        rows = [_cells(run, language)[: len(columns)] for run in self.runs]
        return "\n".join(
            [self.status.sentence(language, **details), *table(head, rows, language, joint_units(columns))]
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain data: status, and the numbers of each profile."""
        names = ("duration", "velocity", "acceleration", "jerk", "effort", "mean_effort", "exceeds")
        runs = {run.name: {name: getattr(run, name) for name in names} for run in self.runs}
        return {"status": self.status.name.lower(), "runs": runs}


def compare_profiles(points: ArrayLike, limits: Limits, *, robot: Robot | None = None) -> ProfileComparison:
    """Every profile through the same points, as quick as velocity and acceleration allow, and the limits it breaks.

    1. The laws of `LAWS` stop at each point.
    2. `jerk_limited` passes the points between; where the jerk of every coordinate is limited.
    3. `time_optimal` passes them on a spline, whatever the jerk: the bound of what is possible on that path. Another
       path through the points may take less.
    4. Each motion is held against all limits by `check`, and against those of effort.

    Args:
        points: (k, n), two or more [rad | m].
        limits: of the n coordinates; velocity and acceleration finite.
        robot: whose inverse dynamics say the efforts; `limits` itself if it is a robot.

    Raises:
        InputError: fewer than two points, points that do not differ, a limit that is not finite, or a robot of another
            number of joints.
    """
    q = as_batch("points", points, np.shape(points)[-1:], finite=True)
    if q.ndim != 2 or len(q) < 2:
        raise InputError("input.shape", name="points", expected="(k, n), k >= 2", got=q.shape, hint="")
    if not np.ptp(q, axis=0).any():
        raise InputError("trajectory.nowhere_to_go")
    bounds = motion_limits(limits, q.shape[1])
    for name in ("velocity", "acceleration"):
        missing = np.flatnonzero(~np.isfinite(getattr(bounds, name)).all(axis=0))
        if len(missing):
            raise InputError("trajectory.no_limit", quantity=name, index=int(missing[0]))
    arm = limits if robot is None and isinstance(limits, Robot) else robot
    if arm is not None and arm.n != bounds.n:
        raise InputError("input.shape", name="robot", expected=(bounds.n,), got=(arm.n,), hint="")
    runs = [_run(name, motion, bounds, arm) for name, motion in _motions(q, bounds).items()]
    return ProfileComparison(tuple(sorted(runs, key=lambda run: run.duration)), bounds)


def _motions(q: Floats, limits: MotionLimits) -> dict[str, Trajectory]:
    """The motion of each profile."""
    velocity, acceleration = (np.abs(side).min(axis=0) for side in (limits.velocity, limits.acceleration))
    legs = [pair for pair in pairwise(q) if np.ptp(np.array(pair), axis=0).any()]
    motions: dict[str, Trajectory] = {}
    for name, law in LAWS.items():
        parts = [law.fastest(a, b, velocity=velocity, acceleration=acceleration) for a, b in legs]
        motions[name] = parts[0] if len(parts) == 1 else sequence(*parts)
    if np.isfinite(limits.jerk).all():
        if len(legs) == 1:
            alone = jerk_limited(legs[0][0], legs[0][1], limits)
            assert isinstance(alone, JerkLimitedMotion)
            motions["jerk_limited"] = alone.polynomial()
        else:
            through = jerk_limited_through(np.array([legs[0][0], *(b for _, b in legs)]), limits)
            assert not isinstance(through, tuple)
            motions["jerk_limited"] = through.motion.polynomial()
    path = JointPath.through(np.array([legs[0][0], *(b for _, b in legs)]), "lines" if len(legs) == 1 else "spline")
    inner = MotionLimits.of(limits.n, velocity=tuple(limits.velocity), acceleration=tuple(limits.acceleration))
    quickest = time_optimal(path, inner).trajectory
    assert quickest is not None
    motions["time_optimal"] = quickest
    return motions


def _run(name: str, motion: Trajectory, limits: MotionLimits, robot: Robot | None) -> ProfileRun:
    """What one motion uses of each limit."""
    breaks = motion.breaks()
    inside = np.concatenate([np.linspace(0.0, motion.duration, SAMPLES), breaks, np.nextafter(breaks, 0.0)])
    t = np.unique(np.clip(inside, 0.0, np.nextafter(motion.duration, 0.0)))
    here = motion.at(t)
    # A jump of the acceleration, at the ends or inside, is a jerk without bound.
    smooth = continuity(motion).order >= 2
    jerk = float(np.abs(motion.jerk(t)).max()) if smooth else np.inf
    shares = np.full((1, 1), np.nan)
    if robot is not None and np.isfinite(robot.limits.effort).any():
        effort = robot.inverse_dynamics(here.u, here.v, here.a) + robot.friction_torque(here.v)
        shares = np.abs(effort) / robot.limits.effort
    worst = shares.max(axis=1)
    mean = float(np.sqrt(np.trapezoid(worst**2, t) / motion.duration)) if len(worst) > 1 else np.nan
    used = (_share(here.v, limits.velocity), _share(here.a, limits.acceleration))
    exceeds = list(dict.fromkeys(violation.quantity for violation in check(motion, limits, tolerance=KEPT)))
    if worst.max() > 1.0 + ROUNDING:
        exceeds.append("effort")
    return ProfileRun(name, motion, *used, jerk, float(worst.max()), mean, tuple(exceeds))


def _share(values: Floats, bound: Floats) -> float:
    """The largest share of the limit in the direction of each value."""
    shares = np.maximum(values / bound[1], values / bound[0])
    return float(shares.max())


def _cells(run: ProfileRun, language: str | None) -> list[str]:
    shares = (f"{100.0 * share:.0f} %" for share in (run.velocity, run.acceleration))
    efforts = (f"{100.0 * share:.0f} %" for share in (run.effort, run.mean_effort))
    jerk = number(run.jerk) if np.isfinite(run.jerk) else "\N{INFINITY}"
    names = (f"trajectory.column_{QUANTITIES[name]}" for name in run.exceeds)
    exceeds = ", ".join(dict.fromkeys(say(name, language=language) for name in names)) or "-"
    return [run.name, f"{number(run.duration)} s", exceeds, *shares, jerk, *efforts]
