"""Moves of a job as paths of the tip: lines, arcs, splines and screws, and several of them without a stop between."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mafsil.arrays import PoseMatrix
from mafsil.errors import MafsilError
from mafsil.geometry import rotation
from mafsil.job.description import Move, Pose
from mafsil.job.poses import pose_matrix
from mafsil.job.remark import Refused
from mafsil.trajectory.paths import TipPath, arc_path, joined_path, spline_path
from mafsil.trajectory.paths.cartesian_path import CartesianPath
from mafsil.trajectory.tolerances import GIVEN


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
            return spline_path(_poses(start, points, goal, degrees))
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
