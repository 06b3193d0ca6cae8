"""Straight lines of the tip within the limits of the tip and of the joints."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import JointVector, PoseMatrix
from mafsil.job.description import Bounds, Move
from mafsil.job.remark import Refused
from mafsil.model import JointLimits
from mafsil.robot import Robot
from mafsil.trajectory import PiecewisePolynomial, Trajectory, quintic, rest, trapezoid
from mafsil.trajectory.cartesian_path import CartesianPath
from mafsil.trajectory.path_following import follow
from mafsil.trajectory.path_motion import PathMotion

SHORTEST = 1e-3
"""Duration of a line without length [s]."""


def straight_line(
    robot: Robot, q: JointVector, goal: PoseMatrix, bounds: Bounds, move: Move, limits: JointLimits, where: str
) -> Trajectory:
    """The joint motion whose tip goes straight from where it is at q to a goal.

    Args:
        robot: with its tool.
        q: (n,) where the line begins [rad | m].
        goal: (4, 4) pose of the tip at its end, in {s}.
        bounds: of the tip's speed, acceleration and turn rate.
        move: duration, speed and law of time.
        limits: of the joints, for this move.
        where: how the move is called in a refusal.

    Raises:
        Refused: a point of the line cannot be reached, it passes a singularity or a limit, or it is to be driven
            faster than the limits allow.
    """
    path = CartesianPath(np.asarray(robot.forward_kinematics(q)), goal)
    if path.length < 1e-9 and path.angle < 1e-9:
        return rest(q, move.duration or SHORTEST)
    joints = follow(robot, path, q)
    if joints.value is None or not joints.succeeded:
        raise Refused("job.no_path", move=where, reason=joints)
    motion = PathMotion(joints.value, _time_law(path, bounds, move))
    factor = max(motion.stretch_needed(limits) * (1 + 1e-9), 1.0)
    shortest = factor * motion.duration
    if move.duration is None:
        return motion.stretched(factor)
    if move.duration < shortest * (1 - 1e-9):
        raise Refused("job.line_too_fast", move=where, shortest=shortest)
    return motion.stretched(move.duration / motion.duration)


def _time_law(path: CartesianPath, bounds: Bounds, move: Move) -> PiecewisePolynomial:
    """s(t) from 0 to 1, as fast as the tip's speed, turn rate and acceleration allow."""
    length, angle = max(path.length, 1e-12), max(path.angle, 1e-12)
    rate = move.speed * min(bounds.tip_speed / length, bounds.tip_turn_rate / angle)
    # The turn has no acceleration bound of its own: it speeds up in the time that the line would take.
    turn_acceleration = bounds.tip_acceleration * bounds.tip_turn_rate / bounds.tip_speed
    growth = move.speed**2 * min(bounds.tip_acceleration / length, turn_acceleration / angle)
    if move.profile == "trapezoid":
        return trapezoid(0.0, 1.0, velocity=rate, acceleration=growth).value
    return quintic(0.0, 1.0, max(15 / 8 / rate, float(np.sqrt(10 / 3**0.5 / growth))))
