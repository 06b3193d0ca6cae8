"""How much a pose can push and carry: largest forces along directions, payloads, and polytopes of limits."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, as_batch
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.performance.dexterity.isotropy import unit_direction
from mafsil.performance.tolerances import CLEAR, ROUNDOFF
from mafsil.performance.velocity.jacobians import tool_jacobian
from mafsil.performance.velocity.scaling import Task, require_one, task_jacobian, task_rows
from mafsil.robot import Robot, of_robot


@dataclass(frozen=True, eq=False)
class LoadCapacity:
    """The largest multiple of a load that the joint efforts allow.

    Attributes:
        largest: (*batch) multiple [N | kg]; infinite if no bounded joint feels it, NaN where gravity alone exceeds the
            limits.
        limiting_joint: (*batch) index of the joint that reaches its limit; -1 if none.
    """

    largest: Floats
    limiting_joint: NDArray[np.int64]


@of_robot
def largest_force(
    robot: Robot, q: ArrayLike, direction: ArrayLike, *, point: ArrayLike | None = None, gravity: bool = True
) -> LoadCapacity:
    """The largest force [N] that the tip can exert along a direction within the effort limits.

    Args:
        robot: the arm.
        q: (*batch, n) joint coordinates [rad | m].
        direction: (*batch, 3) in {s}, any length but zero.
        point: (3,) point of the tip frame at which it pushes [m]; its origin if None.
        gravity: whether the arm's own weight uses up efforts.
    """
    along = unit_direction(direction)
    J_v = tool_jacobian(robot, q, point=point)[..., 3:, :]
    return _capacity(robot, q, np.einsum("...ij,...i->...j", J_v, along), gravity)


@of_robot
def largest_payload(robot: Robot, q: ArrayLike, centre: ArrayLike = (0.0, 0.0, 0.0)) -> LoadCapacity:
    """The largest mass [kg] that the arm can hold still at a pose, within the effort limits, its own weight counted.

    Args:
        robot: the arm, with effort limits.
        q: (*batch, n) joint coordinates [rad | m].
        centre: (3,) of mass of the payload in the tip frame [m].

    Raises:
        InputError: the mechanism has no gravity.
    """
    g = np.asarray(robot.mechanism.gravity)
    if not g.any():
        raise InputError("performance.no_gravity", robot=robot.name)
    J_v = tool_jacobian(robot, q, point=centre)[..., 3:, :]
    return _capacity(robot, q, np.einsum("...ij,i->...j", J_v, -g), True)


def _capacity(robot: Robot, q: ArrayLike, load: Floats, gravity: bool) -> LoadCapacity:
    """Largest s >= 0 with |g + s load| <= limits."""
    weight = robot.gravity_torque(q) if gravity else np.zeros_like(load)
    limits = np.asarray(robot.limits.effort)
    with np.errstate(divide="ignore", invalid="ignore"):
        multiples = np.where(load > 0, limits - weight, limits + weight) / np.abs(load)
    bears = np.abs(load) > ROUNDOFF * np.maximum(np.abs(load).max(axis=-1, keepdims=True), LEAST_DIVISOR)
    multiples = np.where(bears, multiples, np.where(np.isnan(load) | np.isnan(weight), np.nan, np.inf))
    joint = multiples.argmin(axis=-1)
    largest = multiples.min(axis=-1)
    too_weak = (np.abs(weight) > limits).any(axis=-1)
    return LoadCapacity(np.where(too_weak, np.nan, largest), np.where(np.isinf(largest), -1, joint))


@dataclass(frozen=True, eq=False)
class Polytope:
    """A convex set {x : A x <= b}, with its corners.

    Attributes:
        A, b: (k, m), (k,) the half-spaces, rows of A of unit length.
        vertices: (v, m) corners; of planar sets in order around.
    """

    A: Floats
    b: Floats
    vertices: Floats

    def contains(self, x: ArrayLike, tolerance: float = 1e-9) -> NDArray[np.bool_]:
        """(*batch) whether points (*batch, m) lie in the set."""
        points = as_batch("x", x, (self.A.shape[1],))
        return (points @ self.A.T <= self.b + tolerance * np.abs(self.b).max()).all(axis=-1)

    @property
    def volume(self) -> float:
        """Area or volume."""
        from scipy.spatial import ConvexHull

        return float(ConvexHull(self.vertices).volume)


@of_robot
def velocity_polytope(robot: Robot, q: ArrayLike, task: Task = "position") -> Polytope:
    """All velocities of the tip that the rate limits allow: the image of the box of joint rates.

    Args:
        robot: the arm, with rate limits.
        q: (n,) joint coordinates [rad | m].
        task: two or three rows of (omega, v) in the axes of {s}.

    Raises:
        InputError: a joint has no rate limit, or the set is flat (a singular configuration).
    """
    J = task_jacobian(robot, require_one("q", q, robot.n), task)
    corners = np.array(list(product((-1.0, 1.0), repeat=robot.n))) * _joint_limits(robot, "velocity")
    return _hull(robot, corners @ J.T)


@of_robot
def force_polytope(robot: Robot, q: ArrayLike, task: Task = "position", *, gravity: bool = True) -> Polytope:
    """All tip forces (task rows of the wrench, in the axes of {s}) that the effort limits allow.

    Args:
        robot: the arm, with effort limits.
        q: (n,) joint coordinates [rad | m].
        task: two or three rows of (m, f), numbered as those of (omega, v).
        gravity: whether the arm's own weight uses up efforts.

    Raises:
        InputError: a joint has no effort limit, gravity alone exceeds them, or the set is unbounded (singular).
    """
    from scipy.spatial import HalfspaceIntersection, QhullError

    configuration = require_one("q", q, robot.n)
    J, limits = task_jacobian(robot, configuration, task), _joint_limits(robot, "effort")
    weight = robot.gravity_torque(configuration) if gravity else np.zeros(robot.n)
    if (np.abs(weight) >= limits).any():
        worst = robot.joint_names[int((np.abs(weight) - limits).argmax())]
        raise InputError("performance.too_weak", robot=robot.name, joint=worst)
    A, b = np.concatenate([J.T, -J.T]), np.concatenate([limits - weight, limits + weight])
    size = np.linalg.norm(A, axis=1)
    if np.linalg.matrix_rank(J, tol=CLEAR * size.max(initial=LEAST_DIVISOR)) < len(task_rows(task)):
        raise InputError("performance.flat", robot=robot.name)
    A, b = A[size > ROUNDOFF] / size[size > ROUNDOFF, None], b[size > ROUNDOFF] / size[size > ROUNDOFF]
    unknowns: int = A.shape[1]
    try:
        found = HalfspaceIntersection(np.column_stack([A, -b]), np.zeros(unknowns)).intersections
    except QhullError:
        raise InputError("performance.flat", robot=robot.name) from None
    return Polytope(A, b, _order(np.unique(np.round(found, 12), axis=0)))


def _joint_limits(robot: Robot, what: str) -> Floats:
    limits = np.asarray(getattr(robot.limits, what))
    if not np.isfinite(limits).all():
        joint = robot.joint_names[int(np.argmax(~np.isfinite(limits)))]
        raise InputError("performance.no_limit", robot=robot.name, joint=joint, what=what)
    return limits


def _hull(robot: Robot, points: Floats) -> Polytope:
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except QhullError:
        raise InputError("performance.flat", robot=robot.name) from None
    equations = np.unique(np.round(hull.equations, 10), axis=0)
    return Polytope(equations[:, :-1], -equations[:, -1], _order(points[hull.vertices]))


def _order(vertices: Floats) -> Floats:
    """Corners of planar sets in order around their middle."""
    if vertices.shape[1] != 2:
        return vertices
    away = vertices - vertices.mean(axis=0)
    return vertices[np.argsort(np.arctan2(away[:, 1], away[:, 0]))]
