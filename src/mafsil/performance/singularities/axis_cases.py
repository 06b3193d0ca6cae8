"""Why joint screws depend on each other: the smallest dependent sets of axes, and the geometry that ties them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from mafsil.arrays import Floats, Matrix3, Vector3
from mafsil.messages import say
from mafsil.performance.singularities.screw_parameters import canonical_direction, vector_text, wrench_screw
from mafsil.performance.tolerances import CLEAR, DEPENDENT
from mafsil.performance.velocity.scaling import prismatic_joints
from mafsil.robot import Robot

LOOSE = 100.0
"""Geometry is read this much more loosely than the rank: a rank drops faster than angles and distances close."""
MOST_JOINTS = 9
"""Arms with more joints have too many sets of axes to look at."""


@dataclass(frozen=True, eq=False)
class SingularityCause:
    """Axes that depend on each other, and how they lie.

    Attributes:
        case: `collinear_same`, `collinear_opposite` (case I), `parallel_coplanar` (II), `concurrent` (III), `coplanar`
            (IV), `one_line` (V); `pencil` (three through one point in one plane), `parallel_prismatic`,
            `coplanar_prismatic`, `prismatic_across` (a prismatic joint normal to the plane of two parallel axes),
            `coplanar_prismatic_normal` (coplanar axes and a prismatic joint normal to them), `planar_motion` (parallel
            axes and prismatic joints across them), `one_plane_of_directions` (all axes parallel to one plane),
            `ruled_surface` (four axes of one regulus), `complex` (all axes reciprocal to one screw), `parallel` (four
            parallel axes: concurrent at infinity), `dependent` (none of these); `factor_...`: a factor of the
            determinant of a part of the pose.
        joints: indices from 0 of all joints that share the geometry.
        names: of these joints.
        point: (3,) common point, or point of the common line, in {s} [m]; NaN if there is none.
        direction: (3,) common direction, normal or line; NaN if there is none.
        rates: (n,) joint rates of the dependent set that cancel.
        pitch: of the complex [m].
        prismatic: names of the prismatic joints among them.
        formula: of the factor of the determinant that vanishes.
    """

    case: str
    joints: tuple[int, ...]
    names: tuple[str, ...]
    point: Vector3
    direction: Vector3
    rates: Floats
    pitch: float = 0.0
    prismatic: tuple[str, ...] = ()
    formula: str = ""

    @property
    def number(self) -> str:
        """`I` .. `V` for the five named cases, else empty."""
        return _NUMBERS.get(self.case, "")

    def sentence(self, language: str | None = None) -> str:
        """What lies how."""
        if self.formula:
            meaning = say(f"performance.{self.case}", language=language, joints=", ".join(self.names))
            return say("performance.case_factor", language=language, formula=self.formula, meaning=meaning)
        key = "one_line_prismatic" if self.case == "one_line" and self.prismatic else self.case
        return say(
            f"performance.case_{key}",
            language=language,
            joints=", ".join(self.names),
            count=len(self.joints),
            point=vector_text(self.point),
            direction=vector_text(self.direction),
            pitch=self.pitch,
            prismatic=", ".join(self.prismatic),
        )


_NUMBERS = {
    "collinear_same": "I",
    "collinear_opposite": "I",
    "parallel_coplanar": "II",
    "concurrent": "III",
    "parallel": "III",
    "coplanar": "IV",
    "one_line": "V",
}


@dataclass(frozen=True, eq=False)
class Axes:
    """The joint screws of one configuration, linear parts at the point nearest to all axes, over a length.

    Attributes:
        screws: (6, n) without units, columns of unit size where that makes sense.
        prismatic, revolute: (n,) pure translations, pure rotations; helical and coupled joints are neither.
        names: of the joints.
        centre: (3,) where linear parts are taken, in {s} [m].
        length: [m].
        tolerance: of the rank.
    """

    screws: Floats
    prismatic: Sequence[bool]
    revolute: Sequence[bool]
    names: tuple[str, ...]
    centre: Vector3
    length: float
    tolerance: float

    @property
    def loose(self) -> float:
        """Tolerance of angles [rad] and of distances over the length."""
        return LOOSE * self.tolerance

    def w(self, i: int) -> Vector3:
        """(3,) unit direction of a revolute joint's axis, or of a prismatic joint."""
        part = self.screws[3:, i] if self.prismatic[i] else self.screws[:3, i]
        return part / np.linalg.norm(part)

    def p(self, i: int) -> Vector3:
        """(3,) point of a revolute joint's axis nearest to the centre, over the length."""
        w, v = self.screws[:3, i], self.screws[3:, i]
        return np.cross(w, v) / (w @ w)

    def place(self, p: Vector3) -> Vector3:
        """The point in {s} [m]."""
        return self.centre + self.length * p


def causes(axes: Axes, nullity: int) -> tuple[SingularityCause, ...]:
    """The smallest dependent sets of axes that account for all lost rank, each with its geometry.

    Args:
        axes: of one configuration.
        nullity: number of independent joint rates that move nothing.
    """
    found: list[SingularityCause] = []
    nulls: list[Floats] = []
    for joints, rates in _circuits(axes):
        if len(nulls) >= nullity:
            break
        if np.linalg.matrix_rank(np.array([*nulls, rates]), tol=DEPENDENT) <= len(nulls):
            continue
        nulls.append(rates)
        cause = _name(axes, joints, rates)
        if not any(cause.case == other.case and cause.joints == other.joints for other in found):
            found.append(cause)
    return tuple(found)


def _circuits(axes: Axes) -> Iterator[tuple[tuple[int, ...], Floats]]:
    """Dependent sets none of whose parts is dependent, small ones first, with the rates that cancel."""
    n = axes.screws.shape[1]
    size = np.linalg.norm(axes.screws, axis=0)
    moving = [i for i in range(n) if size[i] > 0]
    units = axes.screws / np.where(size > 0, size, 1.0)
    known: list[frozenset[int]] = []
    for count in range(2, min(len(moving), 7, MOST_JOINTS) + 1):
        for joints in combinations(moving, count):
            if any(small <= set(joints) for small in known):
                continue
            _, s, Vt = np.linalg.svd(units[:, joints], full_matrices=True)
            if count <= 6 and s[-1] > 10 * axes.tolerance * s[0]:
                continue
            known.append(frozenset(joints))
            rates = np.zeros(n)
            rates[list(joints)] = Vt[-1] / size[list(joints)]
            yield joints, rates / np.abs(rates).max()


def _name(axes: Axes, joints: tuple[int, ...], rates: Floats) -> SingularityCause:
    revolute = tuple(i for i in joints if axes.revolute[i])
    prismatic = tuple(i for i in joints if axes.prismatic[i])
    if len(revolute) + len(prismatic) < len(joints):
        return _general(axes, joints, rates)
    if not prismatic:
        return _of_revolute(axes, joints, rates)
    return _with_prismatic(axes, revolute, prismatic, rates)


def _of_revolute(axes: Axes, joints: tuple[int, ...], rates: Floats) -> SingularityCause:
    first = axes.w(joints[0])
    parallel = all(np.linalg.norm(np.cross(first, axes.w(i))) < axes.loose for i in joints)
    if len(joints) == 2:
        sense = "same" if first @ axes.w(joints[1]) > 0 else "opposite"
        return _cause(axes, f"collinear_{sense}", joints, rates, axes.p(joints[0]), first)
    point = None if parallel else common_point(axes, joints)
    normal = common_plane(axes, joints)
    if len(joints) == 3:
        if parallel:
            return _cause(axes, "parallel_coplanar", joints, rates, axes.p(joints[0]), normal)
        return _cause(axes, "pencil", joints, rates, point, normal)
    if parallel:
        return _cause(axes, "parallel", joints, rates, None, first)
    if point is not None:
        return _cause(axes, "concurrent", _through(axes, point), rates, point, None)
    if normal is not None:
        everyone = _in_plane(axes, axes.p(joints[0]), normal)
        return _cause(axes, "coplanar", everyone, rates, axes.p(joints[0]), normal)
    return _general(axes, joints, rates)


def _with_prismatic(axes: Axes, revolute: Sequence[int], prismatic: Sequence[int], rates: Floats) -> SingularityCause:
    joints = tuple(sorted((*revolute, *prismatic)))
    if not revolute:
        case = "parallel_prismatic" if len(prismatic) == 2 else "coplanar_prismatic"
        normal = (
            np.linalg.svd(np.array([axes.w(i) for i in prismatic]))[2][-1]
            if len(prismatic) > 2
            else axes.w(prismatic[0])
        )
        return _cause(axes, case, joints, rates, None, normal)
    first = axes.w(revolute[0])
    if len(revolute) > 1 and all(np.linalg.norm(np.cross(first, axes.w(i))) < axes.loose for i in revolute):
        across = all(abs(first @ axes.w(i)) < axes.loose for i in prismatic)
        if across:
            case = "prismatic_across" if len(joints) == 3 else "planar_motion"
            return _cause(axes, case, joints, rates, None, axes.w(prismatic[0]) if len(joints) == 3 else first)
    normal = common_plane(axes, revolute) if len(revolute) > 1 else None
    if normal is not None and all(np.linalg.norm(np.cross(normal, axes.w(i))) < axes.loose for i in prismatic):
        return _cause(axes, "coplanar_prismatic_normal", joints, rates, axes.p(revolute[0]), normal)
    return _general(axes, joints, rates)


def _general(axes: Axes, joints: tuple[int, ...], rates: Floats) -> SingularityCause:
    """One line met by all, one plane of directions, a ruled surface, or a linear complex."""
    U, s, _ = np.linalg.svd(axes.screws)
    rank = int((s > axes.tolerance * s[0]).sum())
    if rank == 5:
        reciprocal = U[:, -1]
        screw = wrench_screw(reciprocal, length=1.0)
        involved = tuple(i for i in range(axes.screws.shape[1]) if np.linalg.norm(axes.screws[:, i]) > 0)
        if np.linalg.norm(reciprocal[3:]) < axes.loose:
            direction = canonical_direction(reciprocal[:3] / np.linalg.norm(reciprocal[:3]))
            return _cause(axes, "one_plane_of_directions", involved, rates, None, direction)
        if abs(screw.pitch) < axes.loose:
            return _cause(axes, "one_line", involved, rates, screw.point, screw.direction)
        return _cause(axes, "complex", involved, rates, screw.point, screw.direction, pitch=screw.pitch * axes.length)
    case = "ruled_surface" if len(joints) == 4 and all(axes.revolute[i] for i in joints) else "dependent"
    return _cause(axes, case, joints, rates, None, None)


def _cause(
    axes: Axes,
    case: str,
    joints: tuple[int, ...],
    rates: Floats,
    point: Vector3 | None,
    direction: Vector3 | None,
    pitch: float = 0.0,
) -> SingularityCause:
    nowhere = np.full(3, np.nan)
    return SingularityCause(
        case,
        joints,
        tuple(axes.names[i] for i in joints),
        nowhere if point is None else axes.place(point),
        nowhere if direction is None else canonical_direction(direction),
        rates,
        pitch,
        tuple(axes.names[i] for i in joints if axes.prismatic[i]),
    )


def common_point(axes: Axes, joints: Sequence[int]) -> Vector3 | None:
    """The point (over the length, from the centre) through which all these axes pass, or None."""
    across = [np.eye(3) - np.outer(axes.w(i), axes.w(i)) for i in joints]
    moments = [A @ axes.p(i) for A, i in zip(across, joints, strict=True)]
    normal: Matrix3 = np.sum(across, axis=0)
    point: Vector3 = np.linalg.pinv(normal, rcond=CLEAR, hermitian=True) @ np.sum(moments, axis=0)
    distance = max(float(np.linalg.norm(A @ point - m)) for A, m in zip(across, moments, strict=True))
    return point if distance < axes.loose else None


def common_plane(axes: Axes, joints: Sequence[int]) -> Vector3 | None:
    """The unit normal of the plane in which all these axes lie, or None."""
    start = axes.p(joints[0])
    rows = [axes.w(i) for i in joints] + [axes.p(i) - start for i in joints[1:]]
    _, s, Vt = np.linalg.svd(np.array(rows))
    return Vt[-1] if s[-1] < axes.loose * max(1.0, s[0]) else None


def _through(axes: Axes, point: Vector3) -> tuple[int, ...]:
    """All revolute joints whose axes pass through a point."""
    near = [i for i, revolute in enumerate(axes.revolute) if revolute]
    return tuple(i for i in near if np.linalg.norm(np.cross(axes.w(i), point - axes.p(i))) < axes.loose)


def _in_plane(axes: Axes, point: Vector3, normal: Vector3) -> tuple[int, ...]:
    """All revolute joints whose axes lie in a plane."""
    near = [i for i, revolute in enumerate(axes.revolute) if revolute]
    return tuple(
        i for i in near if abs(normal @ axes.w(i)) < axes.loose and abs(normal @ (axes.p(i) - point)) < axes.loose
    )


@dataclass(frozen=True, eq=False)
class Lines:
    """All joint axes of a batch of configurations.

    Attributes:
        w: (*batch, n, 3) directions of axes and prismatic joints.
        p: (*batch, n, 3) points of the axes [m].
        prismatic: (n,).
        tip: (*batch, 3) [m].
    """

    w: Floats
    p: Floats
    prismatic: tuple[bool, ...]
    tip: Floats

    def velocity(self, i: int, point: Floats) -> Floats:
        """(*batch, 3) velocity of a point by unit rate of joint i."""
        return self.w[..., i, :] if self.prismatic[i] else np.cross(self.w[..., i, :], point - self.p[..., i, :])

    def meeting(self, joints: Sequence[int]) -> Floats:
        """(*batch, 3) the point nearest to these axes."""
        w, p = self.w[..., list(joints), :], self.p[..., list(joints), :]
        across = np.eye(3) - w[..., :, None] * w[..., None, :]
        total: Matrix3 = across.sum(axis=-3)
        moment: Floats = (across @ p[..., None]).sum(axis=-3)
        return np.asarray(np.linalg.solve(total, moment)[..., 0], dtype=np.float64)


def lines(robot: Robot, q: Floats) -> Lines:
    """The axes at q (*batch, n)."""
    J = np.swapaxes(robot.jacobian_space(q), -1, -2)
    w, v = J[..., :3], J[..., 3:]
    prismatic = tuple(bool(s) for s in prismatic_joints(robot))
    column = np.array(prismatic)[:, None]
    return Lines(
        np.where(column, v, w),
        np.where(column, 0.0, np.cross(w, v)),
        prismatic,
        robot.forward_kinematics(q)[..., :3, 3],
    )
