"""Moves of a job along paths of the tip, some of them without a stop between.

Moves of a job as paths of the tip: lines, arcs, splines and screws, and several of them without a stop between.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import msgspec
import numpy as np

from mafsil.arrays import JointVector, PoseMatrix
from mafsil.errors import MafsilError
from mafsil.geometry import rotation
from mafsil.job.language.description import JOINT_BOUNDS, TIP_BOUNDS, Bounds, Move, Pose
from mafsil.job.language.units import pose_matrix, tolerances
from mafsil.job.planning.closed_moves import ClosedMoves
from mafsil.job.planning.goals import FIXES
from mafsil.job.planning.plan import Timing
from mafsil.job.planning.planned_remarks import decided_by, slowed_lines
from mafsil.job.planning.tip_motion import TipMotion, motion_along, tip_motion
from mafsil.job.planning.walk import Walk
from mafsil.job.remark import Refused
from mafsil.job.tolerances import ARRIVED
from mafsil.messages.visible import visible
from mafsil.model import JointLimits
from mafsil.trajectory.paths import TipPath, arc_path, joined_path, spline_path
from mafsil.trajectory.paths.cartesian_path import CartesianPath
from mafsil.trajectory.tolerances import GIVEN


class TipMoves:
    """Plans paths of the tip, each from one configuration once.

    Args:
        walk: where the robot is.
        closed: what keeps its loops closed, if it has some.
    """

    def __init__(self, walk: Walk, closed: ClosedMoves | None = None) -> None:
        self.walk = walk
        self.motion = tip_motion if closed is None else closed.on_tip_path
        self.lines: dict[tuple[object, ...], TipMotion] = {}

    def along(self, first: int) -> int:
        """On a path of the tip, and on those after it as long as corners are rounded; the index of the last one."""
        moves = self.walk.job.move
        last = self.last(first)
        if any(move.carried for move in moves[first : last + 1]):
            raise Refused("job.frame_alone", move=self.walk.where(first), keys="blend")
        planned = self.line(first, last, self.walk.q)
        if isinstance(planned, Refused):
            raise planned
        goal, where = moves[last].pose, self.walk.where(last)
        assert goal is not None
        self.walk.remarks += slowed_lines(self.walk.robot, planned, where)
        if moves[last].profile is not None or moves[last].path == "spline" or first < last:
            self.walk.remarks += decided_by(self.walk.robot, planned.binding, where)
        targets = self.walk.targets(first, last, self.walk.q)
        target = targets[-1]
        kind = moves[last].path if first == last else "blended"
        name, timing = visible(moves[last].name), self.timing_on_path(first, last, planned)
        self.walk.append(last, name, kind, planned.trajectory, timing, target, goal.task, first=first, targets=targets)
        self.walk.note_arrival(last, goal, target)
        return last

    def last(self, first: int) -> int:
        """The last move of those that follow a move as long as corners are rounded."""
        while self.walk.job.move[first].blend > 0.0:
            first += 1
        return first

    def line(self, first: int, last: int, q: JointVector) -> TipMotion | Refused:
        """The motion along the paths of some moves from q; planned once."""
        moves, targets = self.walk.job.move[first : last + 1], self.walk.targets(first, last, q)
        asked = self.merge_moves(first, last)
        key = (
            self.walk.load.equipment,
            q.tobytes(),
            *(target.tobytes() for target in targets),
            *(_ask(move) for move in moves),
        )
        if key not in self.lines:
            where = self.walk.where(last)
            start = np.asarray(self.walk.robot.forward_kinematics(q))
            try:
                path = path_or_refusal(start, moves, targets, self.walk.degrees, where)
                limits, slack = self.walk.scaled_limits(asked), self.slack(last)
                self.lines[key] = self.motion(
                    self.walk.robot, q, path, self.walk.bounds(asked), asked, limits, slack, where
                )
            except Refused as no:
                return no
        return self.lines[key]

    def merge_moves(self, first: int, last: int) -> Move:
        """Some moves without a stop between as one: the lowest of their limits, limited jerk if one asks for it."""
        moves = self.walk.job.move[first : last + 1]
        smooth = any(move.profile == "jerk_limited" for move in moves)
        profile = "jerk_limited" if smooth else self.walk.with_profile(moves[-1]).profile
        lowest = {name: _lowest(getattr(self.walk.bounds(move), name) for move in moves) for name in TIP_BOUNDS}
        lowest |= {name: _lowest(getattr(move, name) for move in moves) for name in JOINT_BOUNDS}
        speed = min(move.speed for move in moves)
        return msgspec.structs.replace(moves[-1], speed=speed, profile=profile, **lowest)

    def timing_on_path(self, first: int, last: int, planned: TipMotion) -> Timing | None:
        """What limits a motion along a path of the tip; None where the path leads nowhere."""
        along, asked, where = planned.along, self.merge_moves(first, last), self.walk.where(last)
        if along is None:
            return None

        def again(limits: JointLimits, bounds: Bounds) -> float:
            return motion_along(self.walk.robot, *along, bounds, asked, limits, where).trajectory.duration

        return Timing(self.walk.scaled_limits(asked), self.walk.bounds(asked), asked.speed, again)

    def slack(self, index: int) -> float:
        """How far from what it can reach a line may lead an arm that has fewer joints than its task needs."""
        goal = self.walk.job.move[index].pose
        if goal is None or self.walk.robot.n >= FIXES[goal.task]:
            return 0.0
        allowed = tolerances(self.walk.job, self.walk.robot, index)
        return min(allowed.position, allowed.orientation)


def _lowest(values: Iterable[float | None]) -> float | None:
    return min((value for value in values if value is not None), default=None)


def _ask(move: Move) -> tuple[object, ...]:
    """What of a move its motion along a path depends on, besides its goal."""
    limits = (getattr(move, name) for name in (*TIP_BOUNDS, *JOINT_BOUNDS))
    own = (move.path, move.via, move.blend, move.speed, move.profile, move.duration, move.pose and move.pose.task)
    return (*own, *limits)


def tip_path(start: PoseMatrix, moves: Sequence[Move], goals: Sequence[PoseMatrix], degrees: bool) -> TipPath | None:
    """The path of one move, or of several whose corners are rounded; None if it leads nowhere.

    Args:
        start: (4, 4) pose of the tip where it begins, in {s}.
        moves: with a path of the tip each.
        goals: (4, 4) where each ends.
        degrees: whether angles of the job are degrees.

    Raises:
        InputError: an arc over points of a line, a corner that cannot be rounded.
    """
    legs: list[TipPath] = []
    blends: list[float] = []
    here = start
    for move, goal in zip(moves, goals, strict=True):
        leg = _leg(here, move, goal, degrees)
        if leg.length >= GIVEN or leg.angle >= GIVEN:
            legs.append(leg)
            blends.append(move.blend)
        here = goal
    if len(legs) < 2:
        return legs[0] if legs else None
    return joined_path(legs, blend=blends[:-1])


def path_or_refusal(
    start: PoseMatrix, moves: Sequence[Move], goals: Sequence[PoseMatrix], degrees: bool, where: object
) -> TipPath | None:
    """As `tip_path`.

    Raises:
        Refused: there is no such path; the reason says why.
    """
    try:
        return tip_path(start, moves, goals, degrees)
    except MafsilError as error:
        raise Refused("job.no_path", move=where, reason=_Reason(error)) from None


class _Reason:
    """An error that explains itself, as outcomes do."""

    def __init__(self, error: MafsilError) -> None:
        self._error = error

    def explain(self, *, language: str | None = None) -> str:
        """Its sentence."""
        return self._error.message(language)


def _leg(start: PoseMatrix, move: Move, goal: PoseMatrix, degrees: bool) -> TipPath:
    points = [via for via in move.via if isinstance(via, Pose)]
    match move.path:
        case "arc":
            return arc_path(start, points[0].position, goal)
        case "spline":
            T = _poses(start, points, goal, degrees)
            # The first point may be where the line to it has ended.
            stands = bool(np.abs(T[1] - start).max() <= ARRIVED) and len(T) > 2
            return spline_path(np.delete(T, 1, axis=0) if stands else T)
        case _:
            return CartesianPath(start, goal, "screw" if move.path == "screw" else "straight")


def _poses(start: PoseMatrix, points: Sequence[Pose], goal: PoseMatrix, degrees: bool) -> PoseMatrix:
    """(k, 4, 4) poses of a spline; where a point names no orientation the tip is on its turn from start to goal."""
    places = np.array([start[:3, 3], *(point.position for point in points), goal[:3, 3]])
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))])
    turn = rotation.log(start[:3, :3].T @ goal[:3, :3])
    between = [
        pose_matrix(point, degrees=degrees, orientation=start[:3, :3] @ rotation.exp(share * turn))
        for point, share in zip(points, way[1:-1] / max(way[-1], GIVEN), strict=True)
    ]
    return np.stack([start, *between, goal])
