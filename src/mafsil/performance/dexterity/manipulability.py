"""How well an arm moves and pushes at a configuration: ellipsoids, and measures that do not depend on units."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, as_batch, positive
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.performance.singularities.ranks import resolved_task
from mafsil.performance.tolerances import CLEAR
from mafsil.performance.velocity.jacobians import jacobian_hessian
from mafsil.performance.velocity.scaling import (
    Task,
    characteristic_length,
    prismatic_joints,
    scaled_jacobian,
    task_jacobian,
)
from mafsil.robot import Robot, of_robot
from mafsil.solvers import decompositions

Part = Literal["linear", "angular", "planar"]
_TASK_OF: Mapping[str, Task] = MappingProxyType(
    {"linear": "position", "angular": "orientation", "planar": "planar_position"}
)


@dataclass(frozen=True, eq=False)
class Ellipsoid:
    """The image of the unit sphere of joint rates (or efforts).

    Attributes:
        axes: (*batch, m, k) principal directions as columns, in {s}, longest first; k = min(m, n).
        lengths: (*batch, k) semi-axes; zero for directions that are lost, for forces infinite.
        joint_vectors: (*batch, n, k) unit joint rates (or efforts) that reach the ends of the axes, as columns.
        prismatic: names of prismatic joints whose rates in m/s share the sphere with rates of revolute joints in rad/s,
            no weights being given: lengths, axes and ratio then change with the unit of length. Empty where they do
            not.
        length: [m] by which the rates of prismatic joints were divided.
        characteristic: the arm's characteristic length [m], which would make them comparable; NaN if not known.
    """

    axes: Floats
    lengths: Floats
    joint_vectors: Floats
    prismatic: tuple[str, ...] = ()
    length: float = 1.0
    characteristic: float = float("nan")

    @property
    def unit_dependent(self) -> bool:
        """Whether the shape would be another one with lengths in millimetres."""
        return bool(self.prismatic)

    @property
    def ratio(self) -> Floats:
        """(*batch) longest over shortest axis: 1 is isotropic, infinite is singular; NaN where joints are too few."""
        if self.axes.shape[-1] < self.axes.shape[-2]:
            return np.full(self.lengths.shape[:-1], np.nan)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = self.lengths.max(axis=-1) / self.lengths.min(axis=-1)
        return np.where(np.isnan(ratio), np.inf, ratio)

    @property
    def dimension(self) -> NDArray[np.int64]:
        """(*batch) 3 an ellipsoid, 2 an elliptic disc, 1 a segment, 0 a point (of velocities)."""
        return (self.lengths > CLEAR * np.maximum(self.lengths.max(axis=-1, keepdims=True), LEAST_DIVISOR)).sum(axis=-1)

    def normals(self) -> Floats:
        """(m, m - dimension) unit directions that are lost, as columns; of one configuration.

        Raises:
            InputError: a batch.
        """
        if self.lengths.ndim != 1:
            raise InputError("performance.one_configuration", name="ellipsoid", got=self.lengths.shape)
        kept = self.axes[:, self.lengths > CLEAR * max(float(self.lengths.max(initial=0.0)), LEAST_DIVISOR)]
        return np.linalg.svd(kept, full_matrices=True)[0][:, kept.shape[1] :]

    def isotropic(self, tolerance: float = 1e-6) -> NDArray[np.bool_]:
        """(*batch) whether all axes are equal within the tolerance."""
        return self.ratio <= 1.0 + tolerance

    def explain(self, language: str | None = None) -> str:
        """Semi-axes and ratio of one configuration, and whether they depend on the unit of length.

        Raises:
            InputError: a batch.
        """
        if self.lengths.ndim != 1:
            raise InputError("performance.one_configuration", name="ellipsoid", got=self.lengths.shape)
        lengths = ", ".join(f"{x:.4g}" for x in self.lengths)
        lines = [say("performance.ellipsoid", language=language, lengths=lengths, ratio=float(self.ratio))]
        if self.unit_dependent:
            details = {
                "prismatic": ", ".join(self.prismatic),
                "length": self.length,
                "characteristic": self.characteristic,
            }
            lines.append(say("performance.unit_dependent", language=language, **details))
        return "\n".join(lines)


def ellipsoid_of(J: ArrayLike) -> Ellipsoid:
    """The ellipsoid x' (J J')^-1 x = 1 of any Jacobian.

    Semi-axes are the singular values of J, the square roots of the eigenvalues of J J'.

    Args:
        J: (*batch, m, n) with m <= n, rows of one unit.

    Raises:
        InputError: more rows than columns: there is no ellipsoid with an interior.
    """
    shape = np.shape(J)[-2:]
    A = as_batch("J", J, shape if len(shape) == 2 else (1, 1))
    m, n = A.shape[-2:]
    if m > n:
        raise InputError("performance.too_many_rows", rows=m, n=n)
    return _image(A)


def _image(A: Floats) -> Ellipsoid:
    U, s, Vt = decompositions.svd(A)
    return Ellipsoid(U, s, np.swapaxes(Vt, -1, -2))


@of_robot
def velocity_ellipsoid(
    robot: Robot,
    q: ArrayLike,
    part: Part = "linear",
    *,
    point: ArrayLike | None = None,
    weighted: bool = False,
    length: float | None = None,
) -> Ellipsoid:
    """Velocities of the tip (linear, planar or angular) for joint rates of unit size.

    In arms with revolute and prismatic joints a sphere of joint rates mixes rad/s with m/s, so that the ellipsoid
    depends on the unit of length unless `weighted` or `length` says how they compare; the answer's `prismatic` then
    names them.

    Args:
        robot: the arm; with fewer joints than rows of the part the ellipsoid is flat.
        q: (*batch, n) joint coordinates [rad | m].
        part: `linear` (of the tip's point), `planar` (its x, y), or `angular`; never mixed: their units differ.
        point: (3,) point of the tip frame [m]; its origin if None.
        weighted: whether each joint rate counts in shares of its limit.
        length: [m] by which rates of prismatic joints are divided before they join those of revolute joints; 1 m, and
            said to be arbitrary, if None. `characteristic_length(robot)` is a choice that belongs to the arm.

    Returns:
        Axes in {s}; lengths [m/s per rad/s] or [1]; [m/s] or [rad/s] if weighted.

    Reference: Lynch & Park, Modern Robotics, sec. 5.4; Yoshikawa, Manipulability of robotic mechanisms, 1985.
    """
    J = rate_jacobian(robot, q, part, point=point, weighted=weighted, length=length)
    return _with_units(_image(J), robot, weighted, length)


@of_robot
def force_ellipsoid(
    robot: Robot,
    q: ArrayLike,
    part: Part = "linear",
    *,
    point: ArrayLike | None = None,
    weighted: bool = False,
    length: float | None = None,
) -> Ellipsoid:
    """Forces (or moments) at the tip for joint efforts of unit size: same axes, reciprocal lengths.

    Arguments as `velocity_ellipsoid`; with `weighted` each effort counts in shares of its limit, and the axes are
    those of the weighted efforts. Forces of prismatic joints are multiplied by `length` before they join torques.

    Raises:
        InputError: fewer joints than rows: some forces are carried whatever the efforts.
    """
    J = task_jacobian(robot, q, _part(part), point=point)
    J = J / _shares(robot, "effort") if weighted else J * _prismatic_factors(robot, length)
    found = ellipsoid_of(J)
    with np.errstate(divide="ignore"):
        lengths = np.where(found.lengths == 0, np.inf, 1.0 / found.lengths)
    backwards = Ellipsoid(found.axes[..., ::-1], lengths[..., ::-1], found.joint_vectors[..., ::-1])
    return _with_units(backwards, robot, weighted, length)


def rate_jacobian(
    robot: Robot,
    q: ArrayLike,
    part: Part = "linear",
    *,
    point: ArrayLike | None = None,
    weighted: bool = False,
    length: float | None = None,
) -> Floats:
    """(*batch, m, n) the Jacobian of a part, its columns for joint rates of unit size; arguments as there.

    Args:
        robot: the arm.
        q: (*batch, n) joint coordinates [rad | m].
        part: `linear`, `planar` or `angular`.
        point: (3,) point of the tip frame [m]; its origin if None.
        weighted: whether each joint rate counts in shares of its limit.
        length: [m] by which rates of prismatic joints are divided; 1 m if None.
    """
    J = task_jacobian(robot, q, _part(part), point=point)
    return J * (_shares(robot, "velocity") if weighted else _prismatic_factors(robot, length))


def _prismatic_factors(robot: Robot, length: float | None) -> Floats:
    """(n,) columns of prismatic joints are multiplied by the length that divides their rates."""
    return np.where(prismatic_joints(robot), 1.0 if length is None else positive("length", length), 1.0)


def _with_units(found: Ellipsoid, robot: Robot, weighted: bool, length: float | None) -> Ellipsoid:
    """The ellipsoid with the names of prismatic joints that make it depend on the unit of length."""
    prismatic = prismatic_joints(robot)
    if weighted or length is not None or not prismatic.any() or prismatic.all():
        return found if length is None else replace(found, length=float(length))
    names = tuple(name for name, is_prismatic in zip(robot.joint_names, prismatic, strict=True) if is_prismatic)
    return replace(found, prismatic=names, characteristic=characteristic_length(robot))


def _part(part: str) -> Task:
    if part not in _TASK_OF:
        raise InputError("input.choice", name="part", value=part, known=", ".join(_TASK_OF))
    return _TASK_OF[part]


def _shares(robot: Robot, what: str) -> Floats:
    limits = np.asarray(getattr(robot.limits, what))
    if not np.isfinite(limits).all():
        joint = robot.joint_names[int(np.argmax(~np.isfinite(limits)))]
        raise InputError("performance.no_limit", robot=robot.name, joint=joint, what=what)
    return limits


@dataclass(frozen=True, eq=False)
class PlanarEllipse:
    """alpha x^2 + beta x y + gamma y^2 = 1, the image of the unit circle of joint rates.

    Attributes:
        alpha, beta, gamma: (*batch) entries of (J J')^-1; beta is twice the mixed one.
        discriminant: (*batch) beta^2 - 4 alpha gamma = -4 / det(J J') < 0.
    """

    alpha: Floats
    beta: Floats
    gamma: Floats

    @property
    def discriminant(self) -> Floats:
        """(*batch) negative for an ellipse."""
        return self.beta**2 - 4 * self.alpha * self.gamma


def planar_ellipse(J: ArrayLike) -> PlanarEllipse:
    """The equation of the velocity ellipse of a planar Jacobian; infinite coefficients where it is singular.

    Args:
        J: (*batch, 2, n).
    """
    A = as_batch("J", J, (2, np.shape(J)[-1] if np.ndim(J) else 1))
    G = A @ np.swapaxes(A, -1, -2)
    det = G[..., 0, 0] * G[..., 1, 1] - G[..., 0, 1] ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        return PlanarEllipse(G[..., 1, 1] / det, -2 * G[..., 0, 1] / det, G[..., 0, 0] / det)


def _yoshikawa(s: Floats) -> Floats:
    return np.prod(s, axis=-1)


def _inverse_condition(s: Floats) -> Floats:
    none = s[..., 0] == 0
    return np.where(none, 0.0, s[..., -1] / np.where(none, 1.0, s[..., 0]))


def _smallest(s: Floats) -> Floats:
    return s[..., -1]


def _isotropy(s: Floats) -> Floats:
    """Geometric over arithmetic mean of the squared singular values: 1 isotropic, 0 singular."""
    mean = (s**2).mean(axis=-1)
    none = mean == 0
    return np.where(none, 0.0, np.prod(s**2, axis=-1) ** (1 / s.shape[-1]) / np.where(none, 1.0, mean))


MEASURES: Mapping[str, Callable[[Floats], Floats]] = MappingProxyType(
    {"yoshikawa": _yoshikawa, "inverse_condition": _inverse_condition, "smallest": _smallest, "isotropy": _isotropy}
)
"""Measures of singular values (*batch, k), all zero at singularities."""


@of_robot
def manipulability(
    robot: Robot,
    q: ArrayLike,
    measure: str = "yoshikawa",
    *,
    task: Task | None = None,
    length: float | None = None,
) -> Floats:
    """Manipulability: one number for the distance from singularities.

    Args:
        robot: the arm.
        q: (*batch, n) joint coordinates [rad | m].
        measure: `yoshikawa` (product of singular values), `inverse_condition` (smallest over largest),
            `smallest`, or `isotropy` (geometric over arithmetic mean of their squares).
        task: rows that count; the arm's `default_task` if None. Where angles and lengths meet, lengths are divided by
            `length`.
        length: [m]; the arm's characteristic length if None. `length=1.0` gives the plain numbers in SI units.

    Returns:
        (*batch).

    Reference: Yoshikawa 1985; Angeles, Fundamentals of Robotic Mechanical Systems, sec. 5.8 (characteristic length).
    """
    scaled = scaled_jacobian(robot, q, task=_rows(robot, task), length=length)
    return _measure(measure)(decompositions.singular_values(scaled.J))


def manipulability_of(J: ArrayLike, measure: str = "yoshikawa") -> Floats:
    """(*batch) a measure of any Jacobian, such as that of a closed chain.

    Args:
        J: (*batch, m, n), rows of one unit, m <= n for a number that is not zero everywhere.
        measure: as for `manipulability`.

    Raises:
        InputError: no matrix; an unknown measure.
    """
    shape = np.shape(J)[-2:]
    A = as_batch("J", J, shape if len(shape) == 2 else (1, 1))
    return _measure(measure)(decompositions.singular_values(A))


@of_robot
def manipulability_gradient(
    robot: Robot,
    q: ArrayLike,
    measure: str = "yoshikawa",
    *,
    task: Task | None = None,
    length: float | None = None,
) -> Floats:
    """(*batch, n) gradient of a measure, analytic: d sigma_k = u_k' dJ v_k.

    Where singular values coincide or vanish the measure has a kink and one of its one-sided slopes is returned;
    arguments as `manipulability`.
    """
    scaled = scaled_jacobian(robot, q, task=_rows(robot, task), length=length)
    U, s, Vt = decompositions.svd(scaled.J)
    dJ = jacobian_hessian(robot, q)[..., list(scaled.rows), :] * (scaled.row_factors[:, None] * scaled.columns)
    slopes = np.einsum("...ik,...cij,...kj->...ck", U, dJ, Vt)
    return np.einsum("...ck,...k->...c", slopes, _slope(_measure(measure), s))


def _rows(robot: Robot, task: Task | None) -> Task:
    return resolved_task(robot).task if task is None else task


def _slope(measure: Callable[[Floats], Floats], s: Floats) -> Floats:
    """(*batch, k) derivative of a measure by the singular values."""
    if measure is _yoshikawa:
        return np.stack([np.prod(np.delete(s, k, axis=-1), axis=-1) for k in range(s.shape[-1])], axis=-1)
    slope = np.zeros_like(s)
    if measure is _smallest:
        slope[..., -1] = 1.0
    elif measure is _inverse_condition:
        slope[..., -1], slope[..., 0] = 1.0 / s[..., 0], -s[..., -1] / s[..., 0] ** 2
    else:
        value, squares = _isotropy(s)[..., None], (s**2).sum(axis=-1, keepdims=True)
        slope = value * 2 * (1.0 / (s.shape[-1] * np.maximum(s, LEAST_DIVISOR)) - s / squares)
    return slope


def _measure(name: str) -> Callable[[Floats], Floats]:
    if name not in MEASURES:
        raise InputError("input.choice", name="measure", value=name, known=", ".join(MEASURES))
    return MEASURES[name]
