"""Straight lines of the tip, turned into joint motion that keeps its branch and the limits."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.geometry import pose, rotation
from mafsil.ik import solve_ik
from mafsil.job.description import Bounds, Move
from mafsil.job.remark import Refused
from mafsil.model import JointLimits
from mafsil.robot import Robot
from mafsil.trajectory import PiecewisePolynomial, Trajectory, cubic_through, quintic, rest, trapezoid

SPACING, TURN = 0.005, 0.02
"""Largest distance [m] and turn [rad] of the tip between two points at which inverse kinematics is solved."""
JUMP = 0.35
"""A joint that moves further than this between neighbouring points has left its branch [rad | m]."""


def straight_line(
    robot: Robot, q: JointVector, goal: PoseMatrix, bounds: Bounds, move: Move, limits: JointLimits, where: str
) -> Trajectory:
    """The joint motion whose tip goes straight from where it is at q to a goal.

    Raises:
        Refused: a point of the line cannot be reached, the branch cannot be kept, or the wanted duration is too short.
    """
    origin = np.asarray(robot.forward_kinematics(q))
    length = float(np.linalg.norm(goal[:3, 3] - origin[:3, 3]))
    turn = float(rotation.angle_between(origin[:3, :3], goal[:3, :3]))
    if length < 1e-9 and turn < 1e-9:
        return rest(q, 1e-3)
    law = _time_law(length, turn, bounds, move)
    count = max(8, int(np.ceil(max(length / SPACING, turn / TURN))))
    t = np.linspace(0.0, law.duration, count + 1)
    s = law.at(t).u[:, 0]
    path = _followed(robot, q, np.asarray(pose.interpolate_decoupled(origin, goal, s)), s, where)
    joints = cubic_through(path, np.diff(t))
    factor = _stretch(joints, limits)
    if factor <= 1.0:
        return joints
    if move.duration is not None:
        raise Refused("job.line_too_fast", move=where, shortest=factor * joints.duration)
    return joints.stretched(factor)


def _time_law(length: float, turn: float, bounds: Bounds, move: Move) -> PiecewisePolynomial:
    """s(t) from 0 to 1 within the tip's speed, turn rate and acceleration."""
    rate = move.speed * min(bounds.tip_speed / max(length, 1e-12), bounds.tip_turn_rate / max(turn, 1e-12))
    growth = (
        move.speed**2 * bounds.tip_acceleration / max(length, turn * bounds.tip_speed / bounds.tip_turn_rate, 1e-12)
    )
    if move.profile == "trapezoid":
        return trapezoid(0.0, 1.0, velocity=rate, acceleration=growth, duration=move.duration).value
    shortest = max(15 / 8 / rate, float(np.sqrt(10 / 3**0.5 / growth)))
    return quintic(0.0, 1.0, move.duration or shortest)


def _followed(robot: Robot, q: JointVector, line: PoseMatrix, s: Floats, where: str) -> JointVector:
    """(points, n) coordinates along the line, each found from the one before."""
    found = [q]
    for k in range(1, len(line)):
        answer = solve_ik(robot, line[k], found[-1], restarts=0)
        if not answer.all_solved:
            raise Refused("job.line_lost", move=where, share=100 * float(s[k]), reason=answer)
        step = np.abs(np.asarray(answer.q) - found[-1])
        if step.max() > JUMP:
            joint = robot.joint_names[int(step.argmax())]
            raise Refused("job.line_jump", move=where, share=100 * float(s[k]), joint=joint, step=float(step.max()))
        found.append(np.asarray(answer.q))
    return np.array(found)


def _stretch(joints: PiecewisePolynomial, limits: JointLimits) -> float:
    """How much slower the motion must be to keep the limits; at most one if it does."""
    motion = joints.at(np.linspace(0.0, joints.duration, 20 * len(joints.knots)))
    fast = (np.abs(motion.v) / limits.velocity).max()
    hard = np.sqrt((np.abs(motion.a) / limits.acceleration).max())
    return float(max(fast, hard))
