"""Straight lines of the tip within the limits of the tip and of the joints."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mafsil.arrays import JointVector, PoseMatrix
from mafsil.job.description import Bounds, Move
from mafsil.job.quickest import Share, along_line
from mafsil.job.remark import Refused
from mafsil.model import JointLimits
from mafsil.robot import Robot
from mafsil.trajectory import PiecewisePolynomial, Trajectory, rest
from mafsil.trajectory.cartesian_path import CartesianPath
from mafsil.trajectory.laws import rest_law
from mafsil.trajectory.motion import Stretchable
from mafsil.trajectory.path_following import follow
from mafsil.trajectory.path_motion import PathMotion
from mafsil.trajectory.path_timing import Slowest, dilated, slowest

SHORTEST = 1e-3
"""Duration of a line without length [s]."""


@dataclass(frozen=True, eq=False, slots=True)
class Line:
    """A planned straight line.

    Attributes:
        trajectory: of the joints.
        brisk: duration that the bounds of the tip alone would allow [s].
        slowest: where the joints ask for more time, and which of them; None where they do not.
        configuration: (n,) there [rad | m].
        margin: smallest singular value of the body Jacobian there.
        binding: which limits decide how fast it is, where that is known.
    """

    trajectory: Trajectory
    brisk: float
    slowest: Slowest | None = None
    configuration: JointVector | None = None
    margin: float = np.inf
    binding: tuple[Share, ...] = ()

    @property
    def factor(self) -> float:
        """How many times as long as the bounds of the tip ask for the line takes."""
        return self.trajectory.duration / self.brisk


def straight_line(
    robot: Robot,
    q: JointVector,
    goal: PoseMatrix,
    bounds: Bounds,
    move: Move,
    limits: JointLimits,
    slack: float,
    where: object,
) -> Line:
    """The joint motion whose tip goes straight from where it is at q to a goal.

    It is slowed only where the joints need it, unless a duration is asked for that suits everywhere.

    Args:
        robot: with its tool.
        q: (n,) where the line begins [rad | m].
        goal: (4, 4) pose of the tip at its end, in {s}.
        bounds: of the tip's speed, acceleration and turn rate.
        move: task, duration, speed and law of time.
        limits: of the joints, for this move.
        slack: how far from what it can reach the line may lead an arm with few joints [m, rad].
        where: how the move is called in a refusal.

    Raises:
        Refused: a point of the line cannot be reached, it passes a singularity or a limit, or it is to be driven
            faster than the limits allow.
    """
    task = "pose" if move.pose is None else move.pose.task
    path = CartesianPath(np.asarray(robot.forward_kinematics(q)), goal)
    if path.length < 1e-9 and path.angle < 1e-9:
        return Line(rest(q, move.duration or SHORTEST), move.duration or SHORTEST)
    joints = follow(robot, path, q, task=task, slack=slack)
    if joints.value is None or not joints.succeeded:
        raise Refused("job.no_path", move=where, reason=joints)
    rate, growth = _tip_bounds(path, bounds, move)
    if move.profile == "time_optimal":
        return _quickest(robot, joints.value, path, bounds, move, limits, where)
    brisk = PathMotion(joints.value, _time_law(rate, growth, move))
    uniform = brisk.stretched(max(brisk.stretch_needed(limits) * (1 + 1e-9), 1.0))
    if move.duration is not None and move.duration >= uniform.duration:
        return Line(uniform.stretched(move.duration / uniform.duration), move.duration)
    motion = dilated(brisk, limits, growth)
    if move.duration is not None:
        if move.duration < motion.duration * (1 - 1e-9):
            raise too_fast(where, motion.duration)
        motion = motion.stretched(move.duration / motion.duration)
    return _judged(robot, motion, brisk, limits)


def _quickest(
    robot: Robot,
    joints: PiecewisePolynomial,
    path: CartesianPath,
    bounds: Bounds,
    move: Move,
    limits: JointLimits,
    where: object,
) -> Line:
    """The line in the shortest time that joints and tip allow."""
    found = along_line(joints, path, bounds, move, limits, where)
    motion = found.motion
    if move.duration is not None:
        if move.duration < motion.duration * (1 - 1e-9):
            raise too_fast(where, motion.duration)
        return Line(motion.stretched(move.duration / motion.duration), move.duration)
    law = rest_law("trapezoid")
    rate, growth = _tip_bounds(path, bounds, move)
    brisk = PathMotion(joints, law.fastest(np.zeros(1), np.ones(1), velocity=rate, acceleration=growth))
    return replace(_judged(robot, motion, brisk, limits), binding=found.binding)


def _judged(robot: Robot, motion: PathMotion, brisk: PathMotion, limits: JointLimits) -> Line:
    """The line, and where the joints ask for more time than the bounds of the tip."""
    if motion.duration <= brisk.duration * (1 + 1e-6):
        return Line(motion, brisk.duration)
    at = slowest(brisk, limits)
    configuration = np.asarray(brisk.path.at(at.place).u)
    margin = float(np.linalg.svd(robot.jacobian_body(configuration), compute_uv=False)[-1])
    return Line(motion, brisk.duration, at, configuration, margin)


def too_fast(where: object, shortest: float) -> Refused:
    """The refusal of a duration below the shortest one [s], which is said rounded up: it can be typed."""
    return Refused("job.too_fast", move=where, shortest=f"{np.ceil(shortest * 1e3) / 1e3:.3f}")


def _tip_bounds(path: CartesianPath, bounds: Bounds, move: Move) -> tuple[float, float]:
    """Largest s' [1/s] and |s''| [1/s^2] that the tip's speed, turn rate and acceleration allow."""
    length, angle = max(path.length, 1e-12), max(path.angle, 1e-12)
    rate = move.speed * min(bounds.tip_speed / length, bounds.tip_turn_rate / angle)
    # The turn has no acceleration bound of its own: it speeds up in the time that the line would take.
    turn_acceleration = bounds.tip_acceleration * bounds.tip_turn_rate / bounds.tip_speed
    return rate, move.speed**2 * min(bounds.tip_acceleration / length, turn_acceleration / angle)


def _time_law(rate: float, growth: float, move: Move) -> Stretchable:
    """s(t) from 0 to 1, as fast as the bounds of s' and s'' allow."""
    assert move.profile != "time_optimal"
    assert move.profile != "jerk_limited"
    law = rest_law(move.profile or "quintic")
    return law.fastest(np.zeros(1), np.ones(1), velocity=rate, acceleration=growth)
