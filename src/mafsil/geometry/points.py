"""Points of a rigid body: frames from points, distances that a motion keeps, and the motion between two point sets.

Lines of space: distance, angle, and the common normal of two of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, PoseMatrix, Scalar, Truth, Vector3, as_batch
from mafsil.errors import InputError
from mafsil.geometry import pose, rotation
from mafsil.geometry.tolerances import ON_A_LINE, ROUNDOFF, SPECIAL

MIRRORED = 10.0
"""By how much a rotation must leave more than a reflection leaves, both squared, before a set is called mirrored."""


def body_coordinates(dimension: int) -> int:
    """Independent coordinates of a rigid body: n(n + 1)/2, that is 3 in the plane and 6 in space.

    In space: three points have 9 coordinates, and 3 distances between them are fixed.
    """
    return dimension * (dimension + 1) // 2


def pairwise_distances(points: ArrayLike) -> Floats:
    """(*batch, k, k) distances [m] between the k points (*batch, k, 3)."""
    p = np.asarray(points, dtype=np.float64)
    return np.linalg.norm(p[..., :, None, :] - p[..., None, :, :], axis=-1)


def rigidity_residual(before: ArrayLike, after: ArrayLike) -> Scalar:
    """(*batch) largest change of a distance [m] between points (*batch, k, 3).

    Zero for a rigid body, but for its mirror image too: `rigid_motion` tells them apart.
    """
    return np.abs(pairwise_distances(after) - pairwise_distances(before)).max((-1, -2), initial=0.0)


class RigidMotionStatus(Status):
    """Whether one rigid motion takes one set of points to another."""

    MOTION = ("geometry.rigid", True)
    """One does."""
    ON_A_LINE = ("geometry.rigid_line", True)
    """The points lie on one line: further rotations about it do too."""
    MIRRORED = ("geometry.rigid_mirrored", False)
    """The second set is the mirror image of the first."""
    DEFORMED = ("geometry.rigid_not", False)
    """Distances between points change."""


@dataclass(frozen=True)
class RigidMotion(Answer, data="T residual stretch tolerance mirrored"):
    """Whether one rigid motion takes a set of points to another.

    Attributes:
        T: (4, 4) the motion with the least squares of residuals, after = T before; None where the points lie on one
            line, which leaves a rotation open.
        residual: largest distance between a point and where the motion puts it [m]; of points on one line the largest
            change of a distance.
        stretch: largest change of a distance between two points [m].
        mirrored: whether the second set is the mirror image of the first: all distances agree, volumes change sign.
        tolerance: largest residual [m] that counts as none.
    """

    T: PoseMatrix | None
    residual: float
    stretch: float
    mirrored: bool
    tolerance: float

    @property
    def status(self) -> RigidMotionStatus:
        """Whether there is a rigid motion, and of what kind the difference is."""
        if self.residual <= self.tolerance:
            return RigidMotionStatus.MOTION if self.T is not None else RigidMotionStatus.ON_A_LINE
        return RigidMotionStatus.MIRRORED if self.mirrored else RigidMotionStatus.DEFORMED

    def __bool__(self) -> bool:
        return self.residual <= self.tolerance

    def explain(self, language: str | None = None) -> str:
        """The verdict and what it rests on."""
        details = {"residual": self.residual, "stretch": self.stretch, "tolerance": self.tolerance}
        return self.status.sentence(language, **details)


def rigid_motion(before: ArrayLike, after: ArrayLike, tolerance: float | None = None) -> RigidMotion:
    """Are two sets of points one body before and after a rigid motion?

    Distances alone do not tell: a mirror image keeps them all, and turns the sign of every volume
    det[x1 - x0, x2 - x0, x3 - x0]. Points in one plane are moved to their mirror image by a rotation.

    Args:
        before, after: (k, 3) the same points in the same order [m].
        tolerance: largest distance [m] that counts as none; 1e-9 of the size of the sets if None.
    """
    x, y = _same_points(before, after)
    size = max(float(np.abs(x - x.mean(0)).max()), float(np.abs(y - y.mean(0)).max()))
    limit = SPECIAL * size if tolerance is None else tolerance
    stretch = float(rigidity_residual(x, y))
    correlation, s = _correlation(x, y)
    if s[1] <= ON_A_LINE * s[0]:
        return RigidMotion(None, stretch, stretch, False, limit)
    T = _fit(x, y, correlation)
    residual = float(np.linalg.norm(pose.act(T, x) - y, axis=-1).max())
    mirrored = bool(_mirror(x, y, correlation, s)) and residual > limit
    return RigidMotion(T, residual, stretch, mirrored, limit)


def frame_from_points(origin: ArrayLike, on_x: ArrayLike, beside_x: ArrayLike) -> PoseMatrix:
    """Pose of the frame attached to three points of a body.

    Args:
        origin: (*batch, 3) origin of the frame [m].
        on_x: (*batch, 3) a point of its x axis, on the positive side [m].
        beside_x: (*batch, 3) a point of its x-y plane with y > 0 [m].

    Returns:
        (*batch, 4, 4).

    Raises:
        InputError: the points lie on one line.
    """
    o, a, b = as_batch("origin", origin, (3,)), as_batch("on_x", on_x, (3,)), as_batch("beside_x", beside_x, (3,))
    along, beside = a - o, b - o
    normal = np.cross(along, beside)
    size = np.linalg.norm(along, axis=-1) * np.linalg.norm(beside, axis=-1)
    sine = np.linalg.norm(normal, axis=-1) / np.where(size > 0, size, 1.0)
    if np.any(sine <= SPECIAL):
        raise InputError("geometry.collinear", name="points", sine=float(np.min(sine)))
    x = along / np.linalg.norm(along, axis=-1, keepdims=True)
    z = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
    return pose.from_rotation_translation(rotation.project(np.stack([x, np.cross(z, x), z], axis=-1)), o)


def fit(points_b: ArrayLike, points_a: ArrayLike) -> PoseMatrix:
    """The pose T_ab that best takes points seen from {b} to the same points seen from {a}, in least squares.

    Args:
        points_b, points_a: (*batch, k, 3) [m], k >= 3 and not on one line.

    Returns:
        (*batch, 4, 4).

    Raises:
        InputError: the points lie on one line, so that a turn about it stays open; or they fit a mirror image better
            than any rotation, which is no rigid motion.

    Reference: Horn, Closed-form solution of absolute orientation using unit quaternions, J. Opt. Soc. Am. A 4, 1987.
    """
    b, a = _same_points(points_b, points_a)
    correlation, s = _correlation(b, a)
    loose = s[..., 1] <= ON_A_LINE * s[..., 0]
    if np.any(loose):
        raise InputError("geometry.line_of_points", name="points", row=_row(loose))
    mirrored = _mirror(b, a, correlation, s)
    if np.any(mirrored):
        raise InputError("geometry.mirrored", name="points", row=_row(mirrored))
    return _fit(b, a, correlation)


def _same_points(first: ArrayLike, second: ArrayLike) -> tuple[Floats, Floats]:
    """Both sets as arrays (*batch, k, 3) of one k."""
    x, y = as_batch("points", first, (3,)), as_batch("points", second, (3,))
    if x.ndim < 2 or y.ndim < 2 or x.shape[-2] != y.shape[-2]:
        raise InputError("input.shape", name="points", expected="(*batch, k, 3)", got=(x.shape, y.shape), hint="")
    return x, y


def _correlation(b: Floats, a: Floats) -> tuple[Floats, Floats]:
    """Sum of (a - mean)(b - mean)', (*batch, 3, 3), and its singular values; NaN rows have zeros."""
    from_b, from_a = b - b.mean(-2, keepdims=True), a - a.mean(-2, keepdims=True)
    correlation = np.einsum("...ki,...kj->...ij", from_a, from_b)
    known = np.where(np.isfinite(correlation).all((-1, -2), keepdims=True), correlation, np.eye(3))
    return correlation, np.asarray(np.linalg.svd(known, compute_uv=False))


def _mirror(b: Floats, a: Floats, correlation: Floats, s: Floats) -> Any:
    """(*batch) whether the best reflection leaves far less than the best rotation.

    Sums of squares left: total - 2 (s1 + s2 + s3) and, the determinant being negative, total - 2 (s1 + s2 - s3). Of
    points in a plane that are only thick by noise, both are of the size of the noise.
    """
    total = sum((np.square(x - x.mean(-2, keepdims=True)).sum((-1, -2)) for x in (a, b)), start=np.float64(0.0))
    reflected = np.maximum(total - 2 * s.sum(-1), ON_A_LINE * total)
    with np.errstate(invalid="ignore"):
        opposite = np.linalg.det(correlation) < 0
    return opposite & (4 * s[..., 2] > MIRRORED * reflected)


def _fit(b: Floats, a: Floats, correlation: Floats) -> PoseMatrix:
    R = rotation.project(correlation)
    return pose.from_rotation_translation(R, a.mean(-2) - rotation.apply(R, b.mean(-2)))


def _row(failing: Any) -> str:
    """`[i, j]` of the first row of a batch, or nothing."""
    index = np.argwhere(np.asarray(failing))[0]
    return f"[{', '.join(str(int(i)) for i in index)}]" if len(index) else ""


@dataclass(frozen=True, eq=False)
class CommonNormal:
    """The shortest connection of two lines, normal to both.

    Attributes:
        first, second: (*batch, 3) its ends on the two lines [m].
        direction: (*batch, 3) unit vector from the first line to the second; of lines that meet the normal of their
            plane, d1 x d2; of lines that coincide NaN: every normal will do.
        distance: (*batch) [m].
        angle: (*batch) from d1 to d2 about the direction, in [0, pi] for lines that meet [rad].
        parallel: (*batch) whether there are infinitely many: the one through the first line's point is given.
    """

    first: Vector3
    second: Vector3
    direction: Vector3
    distance: Scalar
    angle: Scalar
    parallel: Truth


def common_normal(
    point_1: ArrayLike, direction_1: ArrayLike, point_2: ArrayLike, direction_2: ArrayLike
) -> CommonNormal:
    """The common normal of two lines; distance and angle are the a and the alpha of a Denavit-Hartenberg link.

    Args:
        point_1, point_2: (*batch, 3) a point of each line [m].
        direction_1, direction_2: (*batch, 3) along them, any lengths but zero.

    Raises:
        InputError: a direction is zero.
    """
    p, r = as_batch("point_1", point_1, (3,)), as_batch("point_2", point_2, (3,))
    d, e = _unit("direction_1", direction_1), _unit("direction_2", direction_2)
    p, r, d, e = np.broadcast_arrays(p, r, d, e)
    across, step = np.cross(d, e), r - p
    sine = np.linalg.norm(across, axis=-1)
    parallel = sine <= ROUNDOFF
    square = np.where(parallel, 1.0, sine**2)[..., None]
    along = cast("Floats", np.sum(np.cross(step, e) * across, axis=-1, keepdims=True)) / square
    back = cast("Floats", np.sum(np.cross(step, d) * across, axis=-1, keepdims=True)) / square
    flat = parallel[..., None]
    first = p + np.where(flat, 0.0, along) * d
    beside = cast("Floats", np.sum(step * d, axis=-1, keepdims=True)) * d
    second = np.where(flat, p + step - beside, r + back * e)
    gap = second - first
    distance = np.linalg.norm(gap, axis=-1)
    size = ROUNDOFF * (np.linalg.norm(step, axis=-1) + np.linalg.norm(p, axis=-1))
    apart = (distance > size)[..., None]
    with np.errstate(invalid="ignore", divide="ignore"):
        normal = np.where(apart, gap / distance[..., None], np.where(flat, np.nan, across / sine[..., None]))
    projected = cast("Floats", np.sum(across * normal, axis=-1))
    signed = np.where(np.isnan(normal[..., 0]), sine, projected)
    angle = np.arctan2(signed, np.sum(d * e, axis=-1))
    return CommonNormal(first, second, normal, np.where(apart[..., 0], distance, 0.0), angle, parallel)


def _unit(name: str, direction: ArrayLike) -> Floats:
    d = as_batch(name, direction, (3,))
    size = np.linalg.norm(d, axis=-1, keepdims=True)
    if np.any(size == 0.0):
        raise InputError("geometry.axis", name=name, value=d[tuple(np.argwhere(size[..., 0] == 0.0)[0])].tolist())
    return d / size
