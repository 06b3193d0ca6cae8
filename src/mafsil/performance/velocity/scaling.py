"""Jacobians of a task without units: the rows that count, and a length of the arm that makes turns comparable."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, TypeAlias
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.algebra.tolerance import DESCRIBED
from mafsil.arrays import Floats, Vector3, as_batch, positive
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import rotation
from mafsil.model import JointKind
from mafsil.model.appearance import reach
from mafsil.model.loading import RobotLike
from mafsil.performance.tolerances import CLEAR, NO_LEVER, ROUNDOFF, TOLERANCE
from mafsil.performance.velocity.jacobians import tool_jacobian
from mafsil.robot import Robot, as_robot, of_robot
from mafsil.solvers.decompositions import symmetric_pinv

TASKS: Mapping[str, tuple[int, ...]] = MappingProxyType(
    {
        "pose": (0, 1, 2, 3, 4, 5),
        "orientation": (0, 1, 2),
        "position": (3, 4, 5),
        "planar": (2, 3, 4),
        "planar_position": (3, 4),
        "schoenflies": (2, 3, 4, 5),
    }
)
"""Rows of (omega_x, omega_y, omega_z, v_x, v_y, v_z), in the axes of {s}, by name."""
Task: TypeAlias = str | Sequence[int]
"""A name of TASKS, or row numbers 0 .. 5."""
SAMPLES = 256
"""Configurations over which lengths and generic ranks are taken."""
SEED = 20


@dataclass(frozen=True, eq=False)
class _Lengths:
    tip: float
    axes: float


_known: WeakKeyDictionary[Robot, _Lengths] = WeakKeyDictionary()


def prismatic_joints(robot: Robot) -> NDArray[np.bool_]:
    """(n,) which coordinates are translations."""
    return np.array([joint.kind is JointKind.PRISMATIC for joint in robot.mechanism.coordinates], dtype=bool)


def ranges(robot: Robot, *, limited: bool = True) -> tuple[Floats, Floats]:
    """Where configurations are drawn from: joint limits, a full turn where there are none.

    Slides without limits move by the size of the arm to both sides.

    Args:
        robot: the arm.
        limited: whether its limits are kept; revolute joints make a full turn otherwise.

    Returns:
        lower, upper (n,) [rad | m].
    """
    size = sum(float(np.linalg.norm(joint.T_pj[:3, 3])) for joint in robot.mechanism.joints)
    free = np.where(prismatic_joints(robot), max(size, 0.1), np.pi)
    lower, upper = np.array(robot.limits.lower), np.array(robot.limits.upper)
    if not limited:
        lower, upper = (np.where(prismatic_joints(robot), x, s * np.inf) for x, s in ((lower, -1), (upper, 1)))
    lower, upper = np.where(np.isinf(lower), -free, lower), np.where(np.isinf(upper), free, upper)
    return lower, np.maximum(lower, upper)


@of_robot
def random_configurations(robot: Robot, count: int, seed: int = SEED, *, limited: bool = True) -> Floats:
    """(count, n) configurations, uniform within `ranges`; the same for the same seed.

    Args:
        robot: the arm.
        count: how many.
        seed: of the generator.
        limited: as for `ranges`.
    """
    lower, upper = ranges(robot, limited=limited)
    return np.random.default_rng(seed).uniform(lower, upper, (count, robot.n))


@of_robot
def characteristic_length(robot: Robot, about: Literal["tip", "axes"] = "tip") -> float:
    """A length [m] of the arm that divides translations so that they compare with angles.

    Root mean square, over configurations, of the lever arms of the revolute joints: about the tip, or about the point
    nearest to all axes, which depends on neither tool nor base. An arm whose lever arms are below `NO_LEVER` of its
    reach has its reach for a length: axes typed with six digits that meet in one point have levers of rounding only.
    Without revolute joints the length is 1.

    Args:
        robot: the arm.
        about: `tip` or `axes`.
    """
    if robot not in _known:
        q = random_configurations(robot, SAMPLES)
        J_s, size = robot.jacobian_space(q), reach(robot.mechanism)
        levers = _rms_lever(tool_jacobian(robot, q), size), _rms_lever(at_point(J_s, central_point(J_s)), size)
        _known[robot] = _Lengths(*levers)
    return getattr(_known[robot], about)


def _rms_lever(J: Floats, size: float) -> float:
    """Root mean square of the levers [m]; the size of the arm [m] where they are none beside it."""
    revolute = np.abs(J[:, :3]).max(axis=(0, 1)) > ROUNDOFF
    if not revolute.any():
        return 1.0
    lever = float(np.sqrt((J[:, 3:, revolute] ** 2).sum(axis=1).mean()))
    return lever if lever > NO_LEVER * size else size


def central_point(J_s: Floats) -> Vector3:
    """(*batch, 3) the point nearest to all joint axes: least sum of squared distances [m], in {s}.

    Args:
        J_s: (*batch, 6, n).
    """
    w, v = J_s[..., :3, :], J_s[..., 3:, :]
    normal = np.einsum("...in,...in->...", w, w)[..., None, None] * np.eye(3) - w @ np.swapaxes(w, -1, -2)
    toward = np.cross(w, v, axis=-2).sum(axis=-1)
    return (symmetric_pinv(normal, CLEAR) @ toward[..., None])[..., 0]


def at_point(J_s: Floats, point: Floats) -> Floats:
    """(*batch, 6, n) the columns with their linear part at a point (*batch, 3) [m] of {s}, axes of {s}."""
    w, v = J_s[..., :3, :], J_s[..., 3:, :]
    return np.concatenate([w, v + np.cross(w, point[..., None], axis=-2)], axis=-2)


@dataclass(frozen=True, eq=False)
class Scaled:
    """A Jacobian without units, and the way back.

    Attributes:
        J: (*batch, m, n), rows of (omega, v / length); columns of prismatic joints times length.
        rows: of (omega, v), the task's.
        point: (*batch, 3) where the linear part is taken, in {s} [m].
        length: [m].
        columns: (n,) qd = columns * rates of J.
        q: (*batch, n) the configurations.
    """

    J: Floats
    rows: tuple[int, ...]
    point: Vector3
    length: float
    columns: Floats
    q: Floats

    @property
    def row_factors(self) -> Floats:
        """(m,) J = row_factors * unscaled rows * columns."""
        return np.array([1.0 if row < 3 else 1.0 / self.length for row in self.rows])


@of_robot
def scaled_jacobian(
    robot: Robot, q: ArrayLike, *, task: Task = "pose", length: float | None = None, at: Literal["tip", "axes"] = "tip"
) -> Scaled:
    """The Jacobian of a task made free of units by a length.

    Args:
        robot: the arm.
        q: (*batch, n) joint coordinates [rad | m].
        task: rows that count.
        length: [m]; the arm's characteristic length if None.
        at: where the linear part is taken: at the `tip`, or at the point nearest to all `axes`.

    Raises:
        InputError: the length is not positive.
    """
    if length is None:
        length = characteristic_length(robot, at)
    length = positive("length", length)
    rows = task_rows(task)
    if at == "axes":
        J_s = robot.jacobian_space(q)
        point = central_point(J_s)
        J = at_point(J_s, point)
    else:
        J = tool_jacobian(robot, q)
        point = robot.forward_kinematics(q)[..., :3, 3]
    columns = np.where(prismatic_joints(robot), length, 1.0)
    factors = np.array([1.0 if row < 3 else 1.0 / length for row in rows])[:, None] * columns
    return Scaled(J[..., list(rows), :] * factors, rows, point, float(length), columns, np.asarray(q, dtype=float))


def rank_of(singular_values: Floats, tolerance: float = TOLERANCE) -> NDArray[np.int64]:
    """(*batch) how many singular values (*batch, k) exceed tolerance times the largest; -1 where they are NaN."""
    largest = singular_values[..., :1]
    count = (singular_values > np.maximum(tolerance * largest, LEAST_DIVISOR)).sum(axis=-1)
    return np.where(np.isnan(singular_values).any(axis=-1), -1, count)


def rank_in_doubt(singular_values: Floats, tolerance: float = TOLERANCE) -> NDArray[np.bool_]:
    """(*batch) whether a description of six digits leaves open how many singular values (*batch, k) `rank_of` counts.

    One of them is as near to the tolerance as rounding moves it: within the factor DESCRIBED / TOLERANCE, 20, of it.
    """
    factor = DESCRIBED / TOLERANCE
    limit = tolerance * singular_values[..., :1]
    near = (singular_values > limit / factor) & (singular_values < limit * factor)
    return np.asarray(near.any(axis=-1), dtype=np.bool_)


def require_one(name: str, q: ArrayLike, n: int) -> Floats:
    """The single configuration (n,), finite.

    Args:
        name: of the argument.
        q: what was given.
        n: how many coordinates it must have.

    Raises:
        InputError: a batch or a wrong shape.
    """
    value = as_batch(name, q, (n,), finite=True)
    if value.ndim != 1:
        raise InputError("performance.one_configuration", name=name, got=value.shape)
    return value


def task_rows(task: Task) -> tuple[int, ...]:
    """Row numbers of a task.

    Args:
        task: a name of TASKS, or row numbers.

    Raises:
        InputError: no such task, or rows that are not different numbers 0 .. 5.
    """
    if isinstance(task, str):
        if task not in TASKS:
            raise InputError("input.choice", name="task", value=task, known=", ".join(TASKS))
        return TASKS[task]
    rows = tuple(int(row) for row in task)
    if not rows or len(set(rows)) < len(rows) or not all(0 <= row <= 5 for row in rows):
        raise InputError("performance.task_rows", rows=rows)
    return rows


def task_coordinates(robot: RobotLike, q: ArrayLike, task: Task = "pose", *, frame: str | None = None) -> Floats:
    """Forward kinematics of the rows that a task asks for, such as (x, y) or (phi, x, y) of a planar arm.

    Args:
        robot: the arm.
        q: (*batch, n) joint coordinates [rad | m].
        task: a name of TASKS, or row numbers: positions 3, 4, 5; of turns all three (a rotation vector) or only the one
            about z (an angle, of arms that turn about nothing else).
        frame: name of a link; the tip frame if None.

    Returns:
        (*batch, m) in the order of the rows [rad, m].

    Raises:
        InputError: other rows of turns, which have no coordinates of their own, or an arm that turns about x or y.
    """
    rows = task_rows(task)
    T = as_robot(robot).forward_kinematics(q, frame=frame)
    turns = [row for row in rows if row < 3]
    if turns == [2]:
        if np.abs(T[..., :2, 2]).max(initial=0.0) > CLEAR:
            raise InputError("performance.turn_rows", rows=rows)
        r = np.zeros((*T.shape[:-2], 3))
        r[..., 2] = np.arctan2(T[..., 1, 0], T[..., 0, 0])
    elif not turns or sorted(turns) == [0, 1, 2]:
        r = rotation.log(T[..., :3, :3])
    else:
        raise InputError("performance.turn_rows", rows=rows)
    return np.concatenate([r, T[..., :3, 3]], axis=-1)[..., list(rows)]


@of_robot
def task_jacobian(
    robot: Robot, q: ArrayLike, task: Task = "pose", *, frame: str | None = None, point: ArrayLike | None = None
) -> Floats:
    """The rows of the tool-point Jacobian that a task asks for.

    Args:
        robot: the arm.
        q: (*batch, n) joint coordinates [rad | m].
        task: a name of TASKS, or row numbers 0 .. 5 of (omega, v) in the axes of {s}.
        frame: name of a link; the tip frame if None.
        point: (3,) point of that frame [m]; its origin if None.

    Returns:
        (*batch, m, n).
    """
    return tool_jacobian(robot, q, frame=frame, point=point)[..., list(task_rows(task)), :]
