"""Paths of a frame by name: lines, arcs, circles, screws, splines through poses, sequences; path points."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise
from typing import Any, Literal, TypeAlias, cast, get_args

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, RotationMatrix, as_batch, positive, require_kind, single
from mafsil.errors import InputError, InputWarning, warn
from mafsil.geometry import pose
from mafsil.trajectory.paths.cartesian_path import CartesianPath
from mafsil.trajectory.paths.joined import JoinedPath, join_legs
from mafsil.trajectory.paths.orientations import (
    AlongTangent,
    DirectionCosines,
    EulerAngles,
    FixedOrientation,
    OrientationLaw,
    RelativeAxis,
    RotationVectors,
    SuccessiveAxes,
    nearest_rotation_vectors,
    unwrapped_angles,
)
from mafsil.trajectory.paths.pose_path import PosePath, TipPath
from mafsil.trajectory.paths.positions import (
    ArcCurve,
    LineCurve,
    PositionCurve,
    SplineCurve,
    natural_spline,
    spline_knots,
)
from mafsil.trajectory.paths.rotation_curves import RotationSpline, Squad
from mafsil.trajectory.tolerances import GIVEN

Solver = Callable[[Floats, Floats], Any]
"""(pose (4, 4), (n,) configuration to stay near) -> an answer that is false where it found none, with q (n,)."""
Orientation: TypeAlias = Literal[
    "relative", "relative_long", "rotation_vector", "euler", "cosines", "fixed", "tangent", "squad", "spline"
]
"""Laws by which a frame turns along its path."""
TURN_WEIGHT = 0.25
"""Share of the spline's parameter that turning gets [m/rad]."""
LOCKED = 1e-3
"""Distance from gimbal lock at which angles are no more unique in practice [rad]."""


def line_path(
    T_start: ArrayLike,
    T_goal: ArrayLike,
    *,
    orientation: Orientation | OrientationLaw = "relative",
    sequence: str = "ZYX",
    up: ArrayLike = (0.0, 0.0, 1.0),
) -> PosePath:
    """The origin on a straight line at constant speed, turning by a law.

    Args:
        T_start, T_goal: (4, 4) in {s}.
        orientation: `relative`: R_0 exp([k] s), the short turn about one axis; `relative_long`: the other way round;
            `rotation_vector`: the vector K = axis times angle component by component, the 2 pi alternative nearest the
            one before; `euler`: angles of `sequence` component by component, unwrapped; `cosines`: the matrix component
            by component, projected back; `fixed`: as at the start; `tangent`: the tool keeps its angle to the path;
            `squad`, `spline`: as for many poses; or a law of one's own.
        sequence: of `euler`.
        up: (3,) of `tangent`, a direction in {s} that the path never has.

    Raises:
        InputError: no pose, an unknown law, or one that these orientations do not allow.
    """
    T = _poses("T_start", [T_start, T_goal])
    curve = LineCurve(T[0, :3, 3], T[1, :3, 3])
    return PosePath(curve, _law(orientation, T[:, :3, :3], np.array([0.0, 1.0]), curve, sequence, up))


def screw_path(T_start: ArrayLike, T_goal: ArrayLike) -> CartesianPath:
    """The screw motion from one pose to another: T_0 exp(s log(T_0^-1 T_1)).

    Args:
        T_start, T_goal: (4, 4) in {s}.
    """
    T = _poses("T_start", [T_start, T_goal])
    return CartesianPath(T[0], T[1], "screw")


def arc_path(
    T_start: ArrayLike,
    via: ArrayLike,
    T_goal: ArrayLike,
    *,
    orientation: Orientation | OrientationLaw = "relative",
    sequence: str = "ZYX",
    up: ArrayLike | None = None,
) -> PosePath:
    """The arc of a circle from a pose over a point to another pose.

    Args:
        T_start, T_goal: (4, 4) in {s}.
        via: (3,) a point on the way, in {s} [m].
        orientation, sequence: as of `line_path`; the goal's orientation counts for laws that have one.
        up: of `tangent`; the axis of the circle if None.

    Raises:
        InputError: the points lie on a line; as `line_path`.
    """
    T = _poses("T_start", [T_start, T_goal])
    curve = ArcCurve.through(T[0, :3, 3], via, T[1, :3, 3])
    upward = curve.axis if up is None else up
    return PosePath(curve, _law(orientation, T[:, :3, :3], np.array([0.0, 1.0]), curve, sequence, upward))


def circle_path(
    T_start: ArrayLike,
    centre: ArrayLike,
    axis: ArrayLike,
    angle: float = 2 * np.pi,
    *,
    orientation: Literal["fixed", "tangent"] | OrientationLaw = "fixed",
) -> PosePath:
    """Round an axis through a centre, a whole turn or any angle.

    Args:
        T_start: (4, 4) in {s}.
        centre: (3,) a point on the axis, in {s} [m].
        axis: (3,) of any length.
        angle: how far round; negative in the other sense [rad].
        orientation: `fixed` keeps the axes, `tangent` turns the tool with the circle; or a law of one's own.

    Raises:
        InputError: the start lies on the axis; an axis or angle of zero.
    """
    T = _poses("T_start", [T_start])
    curve = ArcCurve.about(T[0, :3, 3], centre, axis, angle)
    knots = np.array([0.0, 1.0])
    if orientation not in ("fixed", "tangent") and isinstance(orientation, str):
        raise InputError("input.choice", name="orientation", value=orientation, known="fixed, tangent")
    return PosePath(curve, _law(orientation, T[[0, 0], :3, :3], knots, curve, "ZYX", curve.axis))


def spline_path(
    poses: ArrayLike,
    *,
    orientation: Orientation | OrientationLaw = "spline",
    sequence: str = "ZYX",
    up: ArrayLike = (0.0, 0.0, 1.0),
    closed: bool = False,
) -> PosePath:
    """A smooth path through poses: cubic splines of the origin, the axes by a law.

    The parameter goes by the distances, turning counted in; with `squad` evenly, which its continuous rate wants.

    Args:
        poses: (k + 1, 4, 4) in {s}, none like the one before.
        orientation: `spline` (angular acceleration continuous), `squad`, `rotation_vector`, `euler`, `cosines` (splines
            of the components), `relative` (one axis after the other: corners in the turning), `fixed`, `tangent`.
        sequence, up: as of `line_path`.
        closed: the last pose is the first; the curve of the origin closes smoothly.

    Raises:
        InputError: fewer than two poses, two alike, a closed path that does not close; as `line_path`.
    """
    T = _poses("poses", poses)
    if len(T) < 2:
        raise InputError("input.shape", name="poses", expected="(k + 1, 4, 4), k >= 1", got=T.shape, hint="")
    if closed and np.abs(T[0] - T[-1]).max() > GIVEN:
        raise InputError("trajectory.not_closed", gap=float(np.abs(T[0] - T[-1]).max()))
    R, p = T[:, :3, :3], T[:, :3, 3]
    turns = np.linalg.norm(pose.error(T[:-1], T[1:])[:, :3], axis=-1)
    knots = spline_knots(p, TURN_WEIGHT * turns)
    if orientation == "squad":
        knots = np.linspace(0.0, 1.0, len(T))
    curve = SplineCurve(natural_spline(p, knots, closed=closed))
    return PosePath(curve, _law(orientation, R, knots, curve, sequence, up))


def joined_path(
    legs: Sequence[TipPath], *, blend: float | Sequence[float] | None = None, blend_angle: float | None = None
) -> JoinedPath:
    """Paths one after the other, as one path; corners are rounded if a deviation is allowed.

    Args:
        legs: each begins where the one before ends, within 1e-9.
        blend: largest distance of a rounded corner from the sharp one at the same s [m], one number or one for each
            leg but the last; None leaves corners sharp.
        blend_angle: largest angle between them [rad]; unbounded if None.

    Returns:
        The path; its `blends` say the deviation of every corner, `corners` which are still sharp.

    Raises:
        InputError: no legs, a gap between two of them, a deviation that is not positive.
    """
    for k, leg in enumerate(legs):
        require_kind(f"legs[{k}]", leg, "path of a frame", "poses", "twists", "breaks", "length", "angle")
    allowed = None if blend is None else _blends(blend, len(legs) - 1)
    return join_legs(tuple(legs), allowed, None if blend_angle is None else positive("blend_angle", blend_angle))


def _blends(blend: float | Sequence[float], corners: int) -> tuple[float, ...]:
    """The deviation allowed at each corner."""
    if not isinstance(blend, Sequence):
        return (positive("blend", blend),) * corners
    if len(blend) != corners:
        raise InputError("input.shape", name="blend", expected=(corners,), got=(len(blend),), hint="")
    return tuple(positive(f"blend[{k}]", each) for k, each in enumerate(blend))


def _poses(name: str, given: ArrayLike | list[ArrayLike]) -> PoseMatrix:
    """(k, 4, 4) poses, checked."""
    T = as_batch(name, _stack(name, cast("list[ArrayLike]", given)) if isinstance(given, list) else given, (4, 4))
    if T.ndim != 3:
        raise InputError("input.shape", name=name, expected="(k, 4, 4)", got=T.shape, hint="")
    return pose.check(T, name)


def _stack(name: str, given: list[ArrayLike]) -> Floats:
    return np.stack([single(name, one, (4, 4)) for one in given])


def _law(
    orientation: Orientation | OrientationLaw,
    R: RotationMatrix,
    knots: Floats,
    curve: PositionCurve,
    sequence: str,
    up: ArrayLike,
) -> OrientationLaw:
    """The law of this name through orientations (k + 1, 3, 3) at knots."""
    if not isinstance(orientation, str):
        require_kind("orientation", orientation, "orientation law", "at", "breaks")
        return orientation
    match orientation:
        case "fixed":
            return FixedOrientation(R[0])
        case "tangent":
            direction = single("up", up, (3,))
            size = float(np.linalg.norm(direction))
            if size == 0.0:
                raise InputError("trajectory.tangent", place=0.0, up=str(direction))
            return AlongTangent.from_start(curve, direction / size, R[0])
        case "relative" | "relative_long" if len(R) == 2:
            return RelativeAxis.between(R[0], R[1], long=orientation == "relative_long")
        case "rotation_vector":
            return RotationVectors(natural_spline(nearest_rotation_vectors(R), knots))
        case "euler":
            law = EulerAngles(natural_spline(unwrapped_angles(R, sequence), knots), sequence)
            if law.lock_distance < LOCKED:
                warn(InputWarning("trajectory.gimbal_lock", sequence=sequence, distance=law.lock_distance))
            return law
        case "cosines":
            return DirectionCosines(natural_spline(R.reshape(len(R), 9), knots))
        case "squad":
            return Squad.through(R, knots)
        case "spline":
            return RotationSpline.through(R, knots)
        case "relative":
            return SuccessiveAxes(tuple(RelativeAxis.between(a, b) for a, b in pairwise(R)), knots)
        case _:
            pass
    known = ", ".join(get_args(Orientation))
    raise InputError("input.choice", name="orientation", value=orientation, known=known)


class PointKind(Enum):
    """What a path point is."""

    INITIAL = "initial"
    VIA = "via"
    FINAL = "final"


@dataclass(frozen=True, eq=False)
class PathPoint:
    """One point of a path: where, not when.

    Attributes:
        kind: initial, via or final.
        q: (n,) [rad | m].
        index: in the path.
    """

    kind: PointKind
    q: Floats
    index: int


@dataclass(frozen=True, eq=False)
class PathPoints:
    """A path as points in joints, without time: durations make a trajectory of it.

    Attributes:
        points: from the initial to the final one.
        unsolved: indices of poses for which no configuration was found; then the path is false.
    """

    points: tuple[PathPoint, ...]
    unsolved: tuple[int, ...] = ()

    def __bool__(self) -> bool:
        return not self.unsolved

    def __len__(self) -> int:
        return len(self.points)

    @property
    def q(self) -> Floats:
        """(m, n) configurations; NaN where none was found [rad | m]."""
        return np.stack([point.q for point in self.points])


def joint_path(points: ArrayLike) -> PathPoints:
    """Path points from configurations.

    Args:
        points: (m, n) with m >= 2, the first initial, the last final, those between via [rad | m].

    Raises:
        InputError: a wrong shape, a number that is not finite.
    """
    q = as_batch("points", points, np.shape(points)[-1:], finite=True)
    if q.ndim != 2 or len(q) < 2:
        raise InputError("input.shape", name="points", expected="(m, n), m >= 2", got=q.shape, hint="")
    return PathPoints(tuple(PathPoint(_kind(k, len(q)), row, k) for k, row in enumerate(q)))


def tip_path(poses: ArrayLike, q_start: ArrayLike, solve: Solver) -> PathPoints:
    """Path points from poses {T_a}, {T_b} .. {T_c} of the tip in {s}: inverse kinematics at each, near the one before.

    Args:
        poses: (m, 4, 4) with m >= 2.
        q_start: (n,) configuration near which the first is solved [rad | m].
        solve: inverse kinematics, such as `lambda T, q: mf.solve_ik(robot, T, q)`.

    Returns:
        The path; false, with the indices of the poses that were not solved, if there are some.

    Raises:
        InputError: a wrong shape, a number that is not finite.
    """
    T = as_batch("poses", poses, (4, 4), finite=True)
    if T.ndim != 3 or len(T) < 2:
        raise InputError("input.shape", name="poses", expected="(m, 4, 4), m >= 2", got=T.shape, hint="")
    near = np.asarray(as_batch("q_start", q_start, np.shape(q_start)[-1:], finite=True))
    found: list[PathPoint] = []
    unsolved: list[int] = []
    for k, each in enumerate(T):
        answer = solve(each, near)
        if answer:
            near = np.asarray(answer.q, dtype=np.float64)
        else:
            unsolved.append(k)
        found.append(PathPoint(_kind(k, len(T)), near if answer else np.full_like(near, np.nan), k))
    return PathPoints(tuple(found), tuple(unsolved))


def _kind(index: int, count: int) -> PointKind:
    """Initial, via or final."""
    return {0: PointKind.INITIAL, count - 1: PointKind.FINAL}.get(index, PointKind.VIA)
