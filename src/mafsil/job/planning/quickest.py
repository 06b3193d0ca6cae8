"""Motions of a job in the shortest time: along their path within all limits, or with limited jerk."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, JointVector, frozen
from mafsil.job.language.description import Bounds, Move
from mafsil.job.remark import Refused
from mafsil.job.tolerances import LEAST_SLOPE, MOVED
from mafsil.model import JointLimits
from mafsil.robot import Robot
from mafsil.trajectory import JointPath, MotionLimits, PathMotion, jerk_limited, jerk_limited_through, time_optimal
from mafsil.trajectory.jerk import JerkLimitedMotion
from mafsil.trajectory.motion import Stretchable
from mafsil.trajectory.paths.cartesian_path import CartesianPath
from mafsil.trajectory.profiles import trapezoid
from mafsil.trajectory.splines import PiecewisePolynomial
from mafsil.trajectory.timing import TimeOptimal

TIP = ("tip_distance", "tip_turn")
"""Coordinates added to those of the joints on a straight line: how far the tip has come, and how far it has turned."""

OF_TIP = {"tip_speed": (0, "velocity"), "tip_angular_speed": (1, "velocity"), "tip_acceleration": (0, "acceleration")}
"""Limits of the tip on any path as those of the coordinates added on a line."""


@dataclass(frozen=True, eq=False, slots=True)
class Share:
    """How long one limit decides how fast a move is.

    Attributes:
        joint: index of the joint; n and n + 1 for the distance and the turn of the tip.
        quantity: `velocity` or `acceleration`.
        share: of the move's duration.
    """

    joint: int
    quantity: str
    share: float


@dataclass(frozen=True, eq=False, slots=True)
class Deciding:
    """Which limits decide how fast a move is, the one that does so longest first.

    Attributes:
        shares: of the move's time.
    """

    shares: tuple[Share, ...] = ()


UNKNOWN = Deciding()
"""Of motions whose time is not ruled by limits, or not known to be."""


@dataclass(frozen=True, eq=False, slots=True)
class Quickest:
    """A move in the shortest time.

    Attributes:
        motion: of the joints.
        binding: which limits decide.
    """

    motion: PathMotion
    binding: Deciding


def along_joints(points: Floats, limits: JointLimits, where: object) -> Quickest:
    """Through points (k, n) of the joints: on a straight line between two, on a spline through more.

    Raises:
        Refused: there is no motion within the limits; the reason names the place.
    """
    path = JointPath.through(points, kind="lines" if len(points) == 2 else "spline")
    return _time(path, _of_joints(limits), path.curve, where)


def straight(points: Floats, limits: JointLimits, where: object) -> Stretchable:
    """From rest to rest on the straight line between two points (2, n), by the formula of its shortest time.

    Raises:
        Refused: there is no motion within the limits; the reason names the joint.
    """
    start, goal = points
    limited = np.isfinite(limits.jerk)
    if not limited.any():
        velocity, acceleration = limits.velocity, limits.acceleration
        return trapezoid(start, goal, velocity=velocity, acceleration=acceleration, synchronise="phase").value
    if not limited.all():
        return along_joints(points, limits, where).motion
    found = jerk_limited(start, goal, _of_joints(limits), synchronise="phase")
    assert isinstance(found, JerkLimitedMotion)
    if not found:
        raise Refused("job.no_motion", move=where, reason=found)
    return found.polynomial()


def along_path(path: JointPath, limits: JointLimits, where: object) -> Quickest:
    """Along a path of the joints.

    Raises:
        Refused: there is no motion within the limits; the reason names the place.
    """
    return _time(path, _of_joints(limits), path.curve, where)


def along_line(
    joints: PiecewisePolynomial, tip: CartesianPath, bounds: Bounds, move: Move, limits: JointLimits, where: object
) -> Quickest:
    """Along a straight line of the tip, whose speed and turn rate are limited, too.

    Args:
        joints: (n) coordinates over the share of the line, 0 .. 1.
        tip: the line.
        bounds: of the tip.
        move: whose share of the speed counts.
        limits: of the joints, for this move.
        where: how the move is called in a refusal.

    Raises:
        Refused: there is no motion within the limits; the reason names the place.
    """
    return along_line_and_joints(with_tip(joints, tip), bounds, move, limits, where)


def along_line_and_joints(
    curve: PiecewisePolynomial, bounds: Bounds, move: Move, limits: JointLimits, where: object
) -> Quickest:
    """Along curves of the joints and, where the TCP is on lines, of its way and its turn.

    Args:
        curve: (n + 2) coordinates; the last ones stand still where no limit of the TCP counts.
        bounds: of the tip.
        move: whose share of the speed counts.
        limits: of the joints, for this move.
        where: how the move is called in a refusal.

    Raises:
        Refused: there is no motion within the limits; the reason names the place.
    """
    own, n = _of_joints(limits), curve.n - 2
    turn_acceleration = bounds.tip_acceleration * bounds.tip_angular_speed / bounds.tip_speed
    limits_of_all = MotionLimits.of(
        n + 2,
        velocity=np.append(own.velocity[1], [move.speed * bounds.tip_speed, move.speed * bounds.tip_angular_speed]),
        acceleration=np.append(
            own.acceleration[1], move.speed**2 * np.array([bounds.tip_acceleration, turn_acceleration])
        ),
        jerk=np.append(own.jerk[1], [move.speed**3 * (bounds.tip_jerk or np.inf), np.inf]),
    )
    joints = PiecewisePolynomial(curve.knots, curve.coefficients[..., :n])
    return _time(JointPath(curve), limits_of_all, joints, where)


def line_at_tip_bounds(
    joints: PiecewisePolynomial, rate: float, growth: float, limits: JointLimits, most: float = np.inf
) -> PathMotion:
    """Along a straight line as fast as the tip may go, by formula; the joints may not follow where they are slow.

    The jerk along the line is half of what the joint that is nearest to its limit allows: the other half is left for
    the bend of its path.

    Args:
        joints: (n) coordinates over the share of the line, 0 .. 1.
        rate, growth: largest speed and acceleration of that share [1/s, 1/s^2].
        limits: of the joints, for this move.
        most: jerk of that share [1/s^3].
    """
    ends = (np.zeros(1), np.ones(1))
    slopes = np.abs(joints.at(np.linspace(0.0, 1.0, 65)).v).max(axis=0)
    jerk = min(most, 0.5 * float((limits.jerk / np.maximum(slopes, LEAST_SLOPE)).min()))
    if np.isinf(jerk):
        return PathMotion(joints, trapezoid(*ends, velocity=rate, acceleration=growth).value)
    found = jerk_limited(*ends, MotionLimits.of(1, velocity=rate, acceleration=growth, jerk=jerk))
    assert isinstance(found, JerkLimitedMotion)
    return PathMotion(joints, found.polynomial())


def along_curve(
    robot: Robot, joints: PiecewisePolynomial, bounds: Bounds, move: Move, limits: JointLimits, where: object
) -> Quickest:
    """Along any path of the tip, whose speed, turn rate and acceleration are limited, too.

    Args:
        robot: with its tool.
        joints: (n) coordinates over the share of the path, 0 .. 1.
        bounds: of the tip.
        move: whose share of the speed counts.
        limits: of the joints, for this move.
        where: how the move is called in a refusal.

    Raises:
        Refused: there is no motion within the limits; the reason names the place.
    """
    found = time_optimal(
        JointPath(joints),
        _of_joints(limits),
        robot=robot,
        tip_speed=move.speed * bounds.tip_speed,
        tip_acceleration=move.speed**2 * bounds.tip_acceleration,
        tip_angular_speed=move.speed * bounds.tip_angular_speed,
    )
    return _quickest(found, joints, where)


def with_limited_jerk(
    points: Floats, limits: JointLimits, duration: float | None, where: object
) -> PiecewisePolynomial:
    """Through points (k, n) of the joints, at rest at both ends, the jerk never beyond its limit.

    Raises:
        Refused: there is no motion within the limits; the reason says which joint forbids it.
    """
    bounds = MotionLimits.of_joints(limits)
    if len(points) == 2:
        found = jerk_limited(points[0], points[1], bounds, minimum_duration=duration or 0.0)
        assert isinstance(found, JerkLimitedMotion)
        if not found:
            raise Refused("job.no_motion", move=where, reason=found)
        return found.polynomial()
    through = jerk_limited_through(points, bounds)
    assert not isinstance(through, tuple)
    if not through:
        raise Refused("job.no_motion", move=where, reason=through)
    return through.motion.polynomial()


def _of_joints(limits: JointLimits) -> MotionLimits:
    """Of the rates alone: positions are judged where the path is made."""
    rates = {"velocity": limits.velocity, "acceleration": limits.acceleration, "jerk": limits.jerk}
    return MotionLimits.of(len(limits.lower), **rates)


def _time(path: JointPath, limits: MotionLimits, joints: PiecewisePolynomial, where: object) -> Quickest:
    """The path in the shortest time; of the motion only the joints."""
    return _quickest(time_optimal(path, limits), joints, where)


def _quickest(found: TimeOptimal, joints: PiecewisePolynomial, where: object) -> Quickest:
    """The motion of an answer."""
    if not found or found.trajectory is None:
        raise Refused("job.no_motion", move=where, reason=found)
    motion = found.trajectory
    return Quickest(PathMotion(joints, motion.law, motion.places), Deciding(_shares(found)))


def with_tip(joints: PiecewisePolynomial, tip: CartesianPath) -> PiecewisePolynomial:
    """The joints over the share s of the line, and the distance s length and the turn s angle."""
    both = np.array([tip.length, tip.angle])
    added = np.zeros((*joints.coefficients.shape[:-1], 2))
    added[:, 0] = joints.knots[:-1, None] * both
    added[:, 1] = both
    return PiecewisePolynomial(joints.knots, frozen(np.concatenate([joints.coefficients, added], axis=-1)))


def _shares(found: TimeOptimal) -> tuple[Share, ...]:
    total: dict[tuple[int, str], float] = {}
    n = found.path.n
    for binding in found.bindings:
        key = _key(binding.joint, binding.quantity, n)
        total[key] = total.get(key, 0.0) + (binding.end - binding.begin) / found.duration
    order = sorted(total.items(), key=lambda item: -item[1])
    return tuple(Share(joint, quantity, share) for (joint, quantity), share in order)


def _key(joint: int, quantity: str, n: int) -> tuple[int, str]:
    """Index and quantity as in `Share`: limits of the tip as those of coordinates n and n + 1."""
    part, name = OF_TIP.get(quantity, (joint - n, quantity))
    return n + part, name


def different(points: list[JointVector]) -> Floats:
    """Points (k, n) less those that do not differ from the one before; two are always left."""
    rows = np.array(points)
    moved = np.abs(np.diff(rows, axis=0)).max(axis=1) > MOVED
    kept = rows[np.concatenate([[True], moved])]
    return kept if len(kept) > 1 else rows[:2]
