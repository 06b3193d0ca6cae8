"""Moves of a job without a stop between, of which some are of the joints: their corners are rounded in the joints.

1. Each move is a curve of the coordinates: a straight one, or the one that follows its line. On lines two more count
   the way and the turn of the TCP, so that its limits hold there and nowhere else.
2. Where the TCP is nearer than `blend` to the end of a move, at most from its middle on, a quintic leads over to the
   next one: position, direction and curvature go on, so accelerations do.
3. The whole takes the shortest time.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial

import numpy as np

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.job.language.description import TIP_PATHS, Bounds, Move
from mafsil.job.planning.fitting import coordinates
from mafsil.job.planning.joint_motion import JointMove, require_within
from mafsil.job.planning.joint_moves import Configurations
from mafsil.job.planning.plan import Timing
from mafsil.job.planning.planned_remarks import decided_by
from mafsil.job.planning.quickest import along_line_and_joints, with_tip
from mafsil.job.planning.tip_moves import TipMoves, path_or_refusal
from mafsil.job.planning.walk import Walk
from mafsil.job.remark import Refused
from mafsil.job.tolerances import MOVED
from mafsil.messages.visible import visible
from mafsil.model import JointLimits
from mafsil.robot import Robot
from mafsil.trajectory.paths.cartesian_path import CartesianPath
from mafsil.trajectory.profiles.polynomial import quintic_coefficients
from mafsil.trajectory.splines import PiecewisePolynomial
from mafsil.trajectory.timing.path_following import follow

PLACES = 257
"""Of a curve at which is looked how far the TCP is from its end."""


@dataclass(frozen=True, eq=False, slots=True)
class _Curve:
    """One move: its curve with the way of the TCP, and how far from its end the next one may begin [m]."""

    curve: PiecewisePolynomial
    blend: float


class RoundedMoves:
    """Plans moves without a stop between.

    Args:
        walk: where the robot is.
        tip_moves: plans lines.
        configurations: chooses them for poses.
    """

    def __init__(self, walk: Walk, tip_moves: TipMoves, configurations: Configurations) -> None:
        self.walk, self.tip_moves, self.configurations = walk, tip_moves, configurations

    def last(self, first: int) -> int | None:
        """The last of the moves without a stop from one on; None where it is alone, or all are paths of the TCP."""
        last = self.tip_moves.last(first)
        mixed = any(move.path not in TIP_PATHS for move in self.walk.job.move[first : last + 1])
        return last if last > first and mixed else None

    def along(self, first: int, last: int) -> None:
        """Plan and append them."""
        walk, moves = self.walk, self.walk.job.move
        if any(move.carried for move in moves[first : last + 1]):
            raise Refused("job.frame_alone", move=walk.where(first), keys="blend")
        start, targets = walk.q, walk.targets(first, last, walk.q)
        curves, goals = list[_Curve](), list[JointVector]()
        for k, target in zip(range(first, last + 1), targets, strict=True):
            curves.append(self._curve(k, target))
            walk.q = curves[-1].curve.at(curves[-1].curve.duration).u[: walk.robot.n]
            goals.append(walk.q)
        walk.q = start
        whole, asked, where = _join(walk.robot, curves), self.tip_moves.merge_moves(first, last), walk.where(last)

        def within(limits: JointLimits, bounds: Bounds) -> JointMove:
            found = along_line_and_joints(whole, bounds, asked, limits, where)
            return require_within(walk.robot, found.motion, found.binding, asked, limits, where)

        limits, bounds, goal = walk.scaled_limits(asked), walk.bounds(asked), moves[last].pose
        planned = within(limits, bounds)
        walk.remarks += decided_by(walk.robot, planned.binding, where)
        timing = Timing(limits, bounds, None, lambda limits, bounds: within(limits, bounds).trajectory.duration)
        name, target = visible(moves[last].name), None if goal is None else targets[-1]
        task = "pose" if goal is None else goal.task
        walk.append(
            last, name, "blended", planned.trajectory, timing, target, task, first=first, targets=targets, goals=goals
        )
        if goal is None:
            walk.goals.forget()
        else:
            walk.note_arrival(last, goal, targets[-1])

    def _curve(self, index: int, target: PoseMatrix) -> _Curve:
        """The curve of a move from where the robot would be."""
        walk, move = self.walk, self.walk.job.move[index]
        if move.path in TIP_PATHS:
            return _Curve(self._line(index, move, target), move.blend)
        if move.pose is not None:
            goal = self.configurations.configuration(index, move.pose, target)
        else:
            goal = coordinates(walk.job, walk.robot, move.joints or ())
        way = np.append(goal - walk.q, [0.0, 0.0])
        length = float(np.linalg.norm(way))
        if length <= MOVED:
            raise Refused("job.blend_still", move=walk.where(index))
        start = np.append(walk.q, [0.0, 0.0])
        return _Curve(PiecewisePolynomial.from_pieces([length], np.stack([start, way / length])[None]), move.blend)

    def _line(self, index: int, move: Move, target: PoseMatrix) -> PiecewisePolynomial:
        walk, where = self.walk, self.walk.where(index)
        here = np.asarray(walk.robot.forward_kinematics(walk.q))
        path = path_or_refusal(here, [move], [target], walk.degrees, where)
        if path is None:
            raise Refused("job.blend_still", move=where)
        assert isinstance(path, CartesianPath)
        task = "pose" if move.pose is None else move.pose.task
        found = follow(walk.robot, path, walk.q, task=task, slack=self.tip_moves.slack(index))
        if found.value is None or not found.succeeded:
            raise Refused("job.no_path", move=where, reason=found)
        steps = np.diff(found.value.at(np.linspace(0.0, 1.0, PLACES)).u, axis=0)
        return with_tip(found.value, path).scale_time(float(np.linalg.norm(steps, axis=1).sum()))


def _join(robot: Robot, curves: list[_Curve]) -> PiecewisePolynomial:
    """One curve of all, its corners rounded."""
    pieces, begin, offset = list[PiecewisePolynomial](), 0.0, np.zeros(robot.n + 2)
    for k, one in enumerate(curves):
        curve = _later(one.curve, offset)
        end = curve.duration if k == len(curves) - 1 else curve.duration - _cut(robot, one.curve, one.blend, -1)
        pieces.append(_part(curve, begin, end))
        if k < len(curves) - 1:
            offset[robot.n :] = curve.at(curve.duration).u[robot.n :]
            begin = _cut(robot, curves[k + 1].curve, one.blend, 0)
            before, after = curve.at(end), _later(curves[k + 1].curve, offset).at(begin)
            length = curve.duration - end + begin
            corner = quintic_coefficients(before.u, after.u, before.v, after.v, before.a, after.a, length)
            pieces.append(PiecewisePolynomial.from_pieces([length], corner[None]))
    most = max(piece.degree for piece in pieces)
    rows = [np.pad(one.coefficients, ((0, 0), (0, most - one.degree), (0, 0))) for one in pieces]
    return PiecewisePolynomial.from_pieces(np.concatenate([np.diff(one.knots) for one in pieces]), np.concatenate(rows))


def _part(curve: PiecewisePolynomial, begin: float, end: float) -> PiecewisePolynomial:
    """The curve between two places: the piece in which it begins is expanded there."""
    first, last = int(np.searchsorted(curve.knots, begin, side="right")), int(np.searchsorted(curve.knots, end))
    knots = np.concatenate([[begin], curve.knots[first:last], [end]])
    start = [curve.derivative(begin, k) / factorial(k) for k in range(curve.degree + 1)]
    rows = np.concatenate([np.stack(start)[None], curve.coefficients[first:last]])
    return PiecewisePolynomial.from_pieces(np.diff(knots), rows)


def _later(curve: PiecewisePolynomial, offset: Floats) -> PiecewisePolynomial:
    """The same with other coordinates at its start."""
    coefficients = np.array(curve.coefficients)
    coefficients[:, 0] += offset
    return PiecewisePolynomial(curve.knots, coefficients)


def _cut(robot: Robot, curve: PiecewisePolynomial, blend: float, end: int) -> float:
    """How much of a curve, at most half, the TCP is nearer than `blend` to its end, -1 or 0."""
    s = np.linspace(0.0, curve.duration / 2.0, PLACES)
    places = curve.duration - s if end == -1 else s
    p = np.asarray(robot.forward_kinematics(curve.at(places).u[:, : robot.n]))[:, :3, 3]
    far = np.flatnonzero(np.linalg.norm(p - p[0], axis=1) >= blend)
    return float(s[far[0]] if len(far) else s[-1])
