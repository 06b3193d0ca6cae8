"""Jacobians without units: a length of the arm makes turns and translations comparable."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.algebra.tolerance import DESCRIBED
from mafsil.arrays import Floats, Vector3, as_batch, positive
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.model import JointKind
from mafsil.model.appearance import reach
from mafsil.performance.tolerances import CLEAR, NO_LEVER, ROUNDOFF, TOLERANCE
from mafsil.performance.velocity.jacobians import tool_jacobian
from mafsil.performance.velocity.tasks import Task, task_rows
from mafsil.robot import Robot, of_robot
from mafsil.solvers.decompositions import symmetric_pinv

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
