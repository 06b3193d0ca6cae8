"""Motions of all joints together: from rest to rest, or through points, in the time asked for or the shortest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, Integers, JointVector
from mafsil.job.language.description import QUICKEST, Move
from mafsil.job.planning.quickest import (
    UNKNOWN,
    Deciding,
    along_joints,
    along_path,
    different,
    straight,
    with_limited_jerk,
)
from mafsil.job.planning.tip_motion import SHORTEST, too_fast
from mafsil.job.remark import Refused
from mafsil.job.tolerances import SAME_TIME, WITHIN_LIMITS
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible
from mafsil.model import JointKind, JointLimits
from mafsil.robot import Robot
from mafsil.trajectory import JointPath, Trajectory, check, cubic_through
from mafsil.trajectory.checks import Violation
from mafsil.trajectory.motion import Stretchable
from mafsil.trajectory.profiles import rest
from mafsil.trajectory.profiles.laws import QUINTIC, rest_law
from mafsil.trajectory.splines import PiecewisePolynomial

PEAK_MARGIN = 1e-9
"""Share of time on top of the shortest: a peak equals its limit only up to rounding."""
STILL = 1e-9
"""A joint motion that goes less far is a rest [rad | m]."""


@dataclass(frozen=True, eq=False, slots=True)
class JointMove:
    """A planned motion of all joints.

    Attributes:
        trajectory: of the joints.
        binding: which limits decide how fast it is, where that is known.
    """

    trajectory: Trajectory
    binding: Deciding = UNKNOWN


def joint_motion(
    robot: Robot, points: list[JointVector], move: Move, limits: JointLimits, where: object,
    columns: Integers | None = None,
) -> JointMove:  # fmt: skip
    """From the first point to the last, through those between them without a stop.

    Args:
        robot: whose joints move.
        points: (n,) each, two or more [rad | m].
        move: duration and law of time.
        limits: of the joints, for this move.
        where: how the move is called in a refusal.
        columns: which joints these are; all if None.

    Raises:
        Refused: it is to be driven faster than the limits allow, or leaves the range of a joint between the points.
    """
    way = different(points)
    if np.abs(way - way[0]).max(initial=0.0) < STILL:
        return JointMove(rest(way[-1], move.duration or SHORTEST))
    return require_within(robot, *_shortest(way, move, limits, where), move, limits, where, columns)


def motion_on_path(
    robot: Robot, path: JointPath, move: Move, limits: JointLimits, where: object, columns: Integers | None = None
) -> JointMove:
    """Along a path of the joints in the shortest time, or in the time that the move names.

    Args:
        robot: whose joints move.
        path: of the joints.
        move: its duration.
        limits: of the joints, for this move.
        where: how the move is called in a refusal.
        columns: which joints these are; all if None.

    Raises:
        Refused: it is to be driven faster than the limits allow, or leaves the range of a joint.
    """
    found = along_path(path, limits, where)
    return require_within(robot, found.motion, found.binding, move, limits, where, columns)


def require_within(
    robot: Robot, shortest: Stretchable, binding: Deciding, move: Move, limits: JointLimits, where: object,
    columns: Integers | None = None,
) -> JointMove:  # fmt: skip
    """The motion in the time that the move names, if any; refused where that is too fast or a range is left."""
    motion = shortest
    if move.duration is not None:
        if move.duration < shortest.duration * (1 - SAME_TIME):
            raise too_fast(where, shortest.duration)
        motion, binding = shortest.scale_time(move.duration / shortest.duration), UNKNOWN
    verdict = check(motion, limits, tolerance=WITHIN_LIMITS)
    if not verdict:
        worst = verdict.violations[0]
        raise _beyond(robot, int(worst.joint) if columns is None else int(columns[int(worst.joint)]), worst, where)
    return JointMove(motion, binding)


def _shortest(points: Floats, move: Move, limits: JointLimits, where: object) -> tuple[Stretchable, Deciding]:
    """The motion through points (k, n) in the shortest time that its profile allows, and what limits it."""
    if move.profile == "jerk_limited":
        return with_limited_jerk(points, limits, move.duration, where), UNKNOWN
    if move.profile not in (None, "time_optimal"):
        return _by_law(points, move, limits), UNKNOWN
    if move.profile is None and move.duration is not None:
        quintic = _by_law(points, move, limits)
        slow = quintic.scale_time(max(move.duration / quintic.duration, 1.0))
        if slow.duration <= move.duration * (1 + PEAK_MARGIN) and check(slow, limits, tolerance=WITHIN_LIMITS):
            return quintic, UNKNOWN
    if len(points) == 2 and move.profile is None:
        return straight(points, limits, where), UNKNOWN
    found = along_joints(points, limits, where)
    return found.motion, found.binding


def _by_law(points: Floats, move: Move, limits: JointLimits) -> Stretchable:
    """The motion through points (k, n) by the time law of the move, a quintic if it names none."""
    if len(points) > 2:
        return _through(points, limits)
    law = rest_law("quintic" if move.profile in (None, *QUICKEST) else move.profile)
    bounds = {"velocity": limits.velocity, "acceleration": limits.acceleration}
    return law.fastest(points[0], points[-1], **bounds, margin=PEAK_MARGIN, least=SHORTEST)


def _beyond(robot: Robot, joint: int, worst: Violation, where: object) -> Refused:
    """The refusal of a curve that leaves the range of a joint between its points, all of them within it."""
    unit = "m" if robot.mechanism.coordinates[joint].kind is JointKind.PRISMATIC else "rad"
    details = {
        "value": quantity(worst.value, unit),
        "limit": quantity(worst.limit, unit),
        "time": quantity(worst.time, "s"),
    }
    return Refused("job.leaves_range", move=where, joint=visible(robot.joint_names[joint]), **details)


def _through(points: Floats, limits: JointLimits) -> PiecewisePolynomial:
    """A smooth curve through points, stretched until it keeps the limits."""
    steps = np.diff(points, axis=0)
    shortest = [QUINTIC.shortest_duration(step, limits.velocity, limits.acceleration) for step in steps]
    durations = [max(each * (1.0 + PEAK_MARGIN), 1e-3) for each in shortest]
    curve = cubic_through(points, durations)
    t = np.linspace(0.0, curve.duration, 2000)
    motion = curve.at(t)
    fast = (np.abs(motion.v) / limits.velocity).max()
    hard = np.sqrt((np.abs(motion.a) / limits.acceleration).max())
    stretch = float(max(fast, hard)) * 1.001
    return curve.scale_time(stretch) if stretch > 0.0 else curve
