"""Motions along paths of the tip within the limits of the tip and of the joints."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from mafsil.arrays import JointVector
from mafsil.job.language.description import QUICKEST, Bounds, Move
from mafsil.job.planning.quickest import UNKNOWN, Deciding, along_curve, along_line, line_at_tip_bounds
from mafsil.job.remark import Refused
from mafsil.job.tolerances import SAME_TIME, SLOWED
from mafsil.model import JointLimits
from mafsil.robot import Robot
from mafsil.trajectory import Trajectory
from mafsil.trajectory.motion import Stretchable
from mafsil.trajectory.path import PathMotion
from mafsil.trajectory.paths import JoinedPath, TipPath
from mafsil.trajectory.paths.cartesian_path import CartesianPath
from mafsil.trajectory.profiles import rest
from mafsil.trajectory.profiles.laws import rest_law
from mafsil.trajectory.splines import PiecewisePolynomial
from mafsil.trajectory.timing.path_following import follow
from mafsil.trajectory.timing.path_timing import Slowest, dilate_time, slowest
from mafsil.trajectory.tolerances import ROUNDING

SHORTEST = 1e-3
"""Duration of a path without length [s]."""
ACROSS = 0.8
"""Share of the tip's acceleration for what keeps it on a curve; 0.6 are left along it, for both are at right angles."""
LOOK = 129
"""Places at which the bend of a curve is looked at."""


@dataclass(frozen=True, eq=False, slots=True)
class TipMotion:
    """A planned motion along a path of the tip.

    Attributes:
        trajectory: of the joints.
        brisk: duration that the bounds of the tip alone would allow [s].
        slowest: where the joints ask for more time, and which of them; None where they do not.
        configuration: (n,) there [rad | m].
        margin: smallest singular value of the body Jacobian there.
        binding: which limits decide how fast it is, where that is known.
        along: the path of the joints, and of the tip; None of a rest.
    """

    trajectory: Trajectory
    brisk: float
    slowest: Slowest | None = None
    configuration: JointVector | None = None
    margin: float = np.inf
    binding: Deciding = UNKNOWN
    along: tuple[PiecewisePolynomial, TipPath] | None = None

    @property
    def factor(self) -> float:
        """How many times as long as the bounds of the tip ask for the motion takes."""
        return self.trajectory.duration / self.brisk


def tip_motion(
    robot: Robot,
    q: JointVector,
    path: TipPath | None,
    bounds: Bounds,
    move: Move,
    limits: JointLimits,
    slack: float,
    where: object,
) -> TipMotion:
    """The joint motion whose tip keeps to a path from where it is at q.

    It is slowed only where the joints need it, unless a duration is asked for that suits everywhere.

    Args:
        robot: with its tool.
        q: (n,) where the path begins [rad | m].
        path: of the tip; None if it leads nowhere.
        bounds: of the tip's speed, acceleration and turn rate.
        move: task, duration, speed and law of time.
        limits: of the joints, for this move.
        slack: how far from what it can reach the path may lead an arm with few joints [m, rad].
        where: how the move is called in a refusal.

    Raises:
        Refused: a point of the path cannot be reached, it passes a singularity or a limit, or it is to be driven
            faster than the limits allow.
    """
    task = "pose" if move.pose is None else move.pose.task
    if path is None:
        return TipMotion(rest(q, move.duration or SHORTEST), move.duration or SHORTEST)
    joints = follow(robot, path, q, task=task, slack=slack)
    if joints.value is None or not joints.succeeded:
        raise Refused("job.no_path", move=where, reason=joints)
    found = motion_along(robot, joints.value, path, bounds, move, limits, where)
    return replace(found, along=(joints.value, path))


def motion_along(
    robot: Robot,
    joints: PiecewisePolynomial,
    path: TipPath,
    bounds: Bounds,
    move: Move,
    limits: JointLimits,
    where: object,
) -> TipMotion:
    """The motion along a path that the joints follow, in time.

    Args:
        robot: with its tool.
        joints: (n) coordinates over the share of the path, 0 .. 1.
        path: of the tip.
        bounds: of the tip's speed, acceleration and turn rate.
        move: duration, speed and law of time.
        limits: of the joints, for this move.
        where: how the move is called in a refusal.

    Raises:
        Refused: it is to be driven faster than the limits allow.
    """
    if move.profile in QUICKEST or isinstance(path, JoinedPath) or move.path == "spline":
        return _quickest(robot, joints, path, bounds, move, limits, where)
    if move.profile is not None:
        return _by_law(robot, joints, path, bounds, move, limits, where)
    if move.duration is not None and bounds.tip_jerk is None:
        with suppress(Refused):
            return _by_law(robot, joints, path, bounds, move, limits, where)
    return _quickest(robot, joints, path, bounds, move, limits, where)


def _by_law(
    robot: Robot,
    joints: PiecewisePolynomial,
    path: TipPath,
    bounds: Bounds,
    move: Move,
    limits: JointLimits,
    where: object,
) -> TipMotion:
    """The path by the time law of the move, a quintic if it names none, slower where joints need more time."""
    rate, growth = tip_rates(path, bounds, move)
    brisk = PathMotion(joints, time_law(rate, growth, move))
    uniform = brisk.scale_time(max(brisk.stretch_needed(limits) * (1 + SAME_TIME), 1.0))
    if move.duration is not None and move.duration >= uniform.duration:
        return TipMotion(uniform.scale_time(move.duration / uniform.duration), move.duration)
    motion = dilate_time(brisk, limits, growth)
    if move.duration is not None:
        if move.duration < motion.duration * (1 - SAME_TIME):
            raise too_fast(where, motion.duration)
        motion = motion.scale_time(move.duration / motion.duration)
    return _judge(robot, motion, brisk, limits)


def _quickest(
    robot: Robot,
    joints: PiecewisePolynomial,
    path: TipPath,
    bounds: Bounds,
    move: Move,
    limits: JointLimits,
    where: object,
) -> TipMotion:
    """The path in the shortest time that joints and tip allow."""
    if isinstance(path, CartesianPath) and path.interpolation == "straight":
        if move.profile is None and move.duration is None:
            most = move.speed**3 * (bounds.tip_jerk or np.inf) / max(path.length, ROUNDING)
            ruled_by_tip = line_at_tip_bounds(joints, *tip_rates(path, bounds, move), limits, most)
            if ruled_by_tip.is_within(limits):
                return TipMotion(ruled_by_tip, ruled_by_tip.duration)
        found = along_line(joints, path, bounds, move, limits, where)
    else:
        found = along_curve(robot, joints, bounds, move, limits, where)
    motion = found.motion
    if move.duration is not None:
        if move.duration < motion.duration * (1 - SAME_TIME):
            raise too_fast(where, motion.duration)
        return TipMotion(motion.scale_time(move.duration / motion.duration), move.duration)
    law = rest_law("trapezoid")
    rate, growth = tip_rates(path, bounds, move)
    brisk = PathMotion(joints, law.fastest(np.zeros(1), np.ones(1), velocity=rate, acceleration=growth))
    return replace(_judge(robot, motion, brisk, limits), binding=found.binding)


def _judge(robot: Robot, motion: PathMotion, brisk: PathMotion, limits: JointLimits) -> TipMotion:
    """The line, and where the joints ask for more time than the bounds of the tip."""
    if motion.duration <= brisk.duration * (1 + SLOWED):
        return TipMotion(motion, brisk.duration)
    at = slowest(brisk, limits)
    configuration = np.asarray(brisk.path.at(at.place).u)
    margin = float(np.linalg.svd(robot.jacobian_body(configuration), compute_uv=False)[-1])
    return TipMotion(motion, brisk.duration, at, configuration, margin)


def too_fast(where: object, shortest: float) -> Refused:
    """The refusal of a duration below the shortest one [s], which is said rounded up: it can be typed."""
    return Refused("job.too_fast", move=where, shortest=f"{np.ceil(shortest * 1e3) / 1e3:.3f}")


def tip_rates(path: TipPath, bounds: Bounds, move: Move) -> tuple[float, float]:
    """Largest s' [1/s] and |s''| [1/s^2] that the tip's speed, turn rate and acceleration allow."""
    V, slope = path.twists(np.linspace(0.0, 1.0, LOOK))
    speed, rotation = (max(float(np.linalg.norm(part, axis=-1).max()), ROUNDING) for part in (V[:, 3:], V[:, :3]))
    bend = float(np.linalg.norm(slope[:, 3:] + np.cross(V[:, :3], V[:, 3:]), axis=-1).max())
    rate = move.speed * min(bounds.tip_speed / speed, bounds.tip_angular_speed / rotation)
    # The turn has no acceleration bound of its own: it speeds up in the time that the way would take.
    turn_acceleration = bounds.tip_acceleration * bounds.tip_angular_speed / bounds.tip_speed
    growth = move.speed**2 * min(bounds.tip_acceleration / speed, turn_acceleration / rotation)
    if bend <= ROUNDING * speed:
        return rate, growth
    across = move.speed * np.sqrt(ACROSS * bounds.tip_acceleration / bend)
    return min(rate, float(across)), growth * np.sqrt(1.0 - ACROSS**2)


def time_law(rate: float, growth: float, move: Move) -> Stretchable:
    """s(t) from 0 to 1, as fast as the bounds of s' and s'' allow."""
    law = rest_law("quintic" if move.profile in (None, *QUICKEST) else move.profile)
    return law.fastest(np.zeros(1), np.ones(1), velocity=rate, acceleration=growth)
