"""The determinant of an arm's Jacobian as a product of geometric factors: areas and triple products of its axes.

Three axes that always meet in one point (a wrist), or are always parallel, split the determinant in two; pairs of
parallel or meeting axes split it further. What is always so is found by looking at the axes at a few configurations,
and every product is compared with the determinant itself before it is handed out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.performance.singularities.axis_cases import Lines, SingularityCause, lines
from mafsil.performance.singularities.trigonometric_form import TrigonometricForm, fit_trigonometric_form
from mafsil.performance.tolerances import CLEAR, ROUNDOFF
from mafsil.performance.velocity.scaling import (
    characteristic_length,
    prismatic_joints,
    random_configurations,
    task_jacobian,
    task_rows,
)
from mafsil.robot import Robot, of_robot

CHECKS = 200
"""Random configurations at which a product is compared with the determinant."""
LONGEST = 12
"""Terms of a form that are written in full in explanations."""


@dataclass(frozen=True, eq=False)
class DeterminantFactor:
    """One factor of a determinant.

    Attributes:
        kind: `directions` (three axes through one point become coplanar), `triangle` (three parallel axes), `elbow` (a
            point in the plane of two parallel axes), `meeting_plane` (a point in the plane of two axes that meet),
            `shoulder` (a point's velocity by one joint, along a direction), `boom` (the same, along the line to it),
            `turned` (two axes and a normal become coplanar), `velocities` (three velocities of a point), `whole`.
        joints: indices of the joints named.
        formula: in z_i (directions), p_i (points of axes), c or o (meeting points), t (tip).
        value: of the lines of any batch.
        names: of the joints.
        form: written out in the joint coordinates, or None if it is too long.
    """

    kind: str
    joints: tuple[int, ...]
    formula: str
    value: Callable[[Lines], Floats]
    names: tuple[str, ...]
    form: TrigonometricForm | None = None

    @property
    def written(self) -> str:
        """A sign of equality and the form in the coordinates, or nothing."""
        return "" if self.form is None else f" = {self.form.text(LONGEST)}"

    def sentence(self, language: str | None = None) -> str:
        """What it means geometrically that the factor vanishes."""
        joints = ", ".join(self.names)
        return say(
            f"performance.factor_{self.kind}",
            language=language,
            joints=joints,
            first=self.names[0],
            others=", ".join(self.names[1:]),
        )


@dataclass(frozen=True, eq=False)
class DeterminantFactors:
    """det J = sign * product of factors.

    Attributes:
        task: `pose`, `position`, `orientation`, `planar`, `planar_position` or `schoenflies`: the rows of J.
        sign: +1 or -1.
        factors: all of them.
        error: largest difference from the determinant at random configurations, over its largest value there.
    """

    robot: Robot
    task: str
    sign: float
    factors: tuple[DeterminantFactor, ...]
    error: float

    def evaluate(self, q: ArrayLike) -> Floats:
        """(*batch) the product at q (*batch, n)."""
        return self.sign * np.prod(list(self.each(q)), axis=0)

    def each(self, q: ArrayLike) -> tuple[Floats, ...]:
        """The factors' values (*batch) at q (*batch, n)."""
        at = lines(self.robot, as_batch("q", q, (self.robot.n,)))
        return tuple(np.asarray(factor.value(at)) for factor in self.factors)

    def explain(self, language: str | None = None) -> str:
        """The product, then each factor with its meaning and its form in the coordinates."""
        head = say(
            "performance.determinant",
            language=language,
            robot=self.robot.name,
            task=self.task,
            formula=("- " if self.sign < 0 else "") + " * ".join(f"[{f.formula}]" for f in self.factors),
            error=self.error,
        )
        rows = [f"  [{f.formula}]{f.written}: {f.sentence(language)}" for f in self.factors]
        return "\n".join([head, *rows])


def vanishing_factors(robot: Robot, task: str, q: Floats, tolerance: float) -> tuple[SingularityCause, ...]:
    """The factors of a determinant that are zero at one configuration, as causes of its singularity.

    Args:
        robot: the arm.
        task: rows of a square Jacobian.
        q: (n,) joint coordinates.
        tolerance: share of its largest value at random configurations below which a factor counts as zero.

    Raises:
        InputError: as `determinant_factors`.
    """
    found = _factors(robot, task)
    everywhere = found.each(random_configurations(robot, CHECKS, limited=False))
    nowhere = np.full(3, np.nan)
    return tuple(
        SingularityCause(f"factor_{f.kind}", f.joints, f.names, nowhere, nowhere, np.zeros(robot.n), formula=f.formula)
        for f, values, here in zip(found.factors, everywhere, found.each(q), strict=True)
        if abs(float(here)) <= 100 * tolerance * float(np.abs(values).max())
    )


@lru_cache(maxsize=32)
def _factors(robot: Robot, task: str) -> DeterminantFactors:
    return determinant_factors(robot, task)


@of_robot
def determinant_factors(robot: Robot, task: str | None = None) -> DeterminantFactors:
    """The determinant of the Jacobian, factored into geometric conditions, each verified.

    Args:
        robot: an arm whose Jacobian for the task is square.
        task: `pose`, `position`, `orientation`, `planar`, `planar_position` or `schoenflies`; the natural one if None.

    Raises:
        InputError: the Jacobian is not square.

    Reference: spherical and planar groups: Hunt, Kinematic Geometry of Mechanisms, 1978; Pieper 1968.
    """
    chosen = natural_task(robot) if task is None else task
    q = random_configurations(robot, CHECKS, limited=False)
    J = task_jacobian(robot, q, chosen)
    if J.shape[-1] != J.shape[-2]:
        raise InputError("performance.not_square", robot=robot.name, n=robot.n)
    truth, at = np.linalg.det(J), lines(robot, q)
    if float(np.abs(truth).max()) < ROUNDOFF * characteristic_length(robot) ** _lengths_in(chosen):
        raise InputError("performance.always_singular", robot=robot.name, task=chosen)
    for candidate in (*_candidates(robot, chosen, at), _whole(robot, chosen)):
        values = np.prod([f.value(at) for f in candidate], axis=0)
        sign = 1.0 if float(values @ truth) >= 0 else -1.0
        error = float(np.abs(sign * values - truth).max() / max(float(np.abs(truth).max()), LEAST_DIVISOR))
        if error < CLEAR:
            return DeterminantFactors(robot, chosen, sign, tuple(_written(robot, f) for f in candidate), error)
    raise InputError("performance.not_square", robot=robot.name, n=robot.n)


def _lengths_in(task: str) -> int:
    """Power of a length in the determinant of a task."""
    return sum(row >= 3 for row in task_rows(task))


def _candidates(robot: Robot, task: str, at: Lines) -> list[list[DeterminantFactor]]:
    make = _Factory(robot, at)
    everyone = tuple(range(robot.n))
    match task:
        case "pose":
            return make.of_pose(everyone)
        case "position":
            return [make.of_velocities(everyone, lambda x: x.tip, "t")]
        case "orientation" if not any(at.prismatic):
            return [[make.directions(everyone)]]
        case "planar_position":
            return [[make.elbow(everyone, lambda x: x.tip, "t")]]
        case _:
            revolute = tuple(i for i in everyone if not at.prismatic[i])
            return [[make.triangle(revolute)]] if len(revolute) == 3 else []


def _whole(robot: Robot, task: str) -> list[DeterminantFactor]:
    """The determinant itself, from the lines."""

    def value(x: Lines) -> Floats:
        v = np.stack([x.velocity(i, x.tip) for i in range(robot.n)], axis=-1)
        w = np.stack([0.0 * x.w[..., i, :] if x.prismatic[i] else x.w[..., i, :] for i in range(robot.n)], axis=-1)
        return np.linalg.det(np.concatenate([w, v], axis=-2)[..., list(task_rows(task)), :])

    return [DeterminantFactor("whole", tuple(range(robot.n)), "det J", value, robot.joint_names)]


def _written(robot: Robot, factor: DeterminantFactor) -> DeterminantFactor:
    form = fit_trigonometric_form(
        lambda q: np.asarray(factor.value(lines(robot, q))),
        robot.n,
        prismatic_joints(robot).tolist(),
        characteristic_length(robot),
    )
    return DeterminantFactor(factor.kind, factor.joints, factor.formula, factor.value, factor.names, form)


def _parallel(at: Lines, i: int, j: int) -> bool:
    return bool(np.linalg.norm(np.cross(at.w[..., i, :], at.w[..., j, :]), axis=-1).max() < CLEAR)


def _concurrent(at: Lines, joints: Sequence[int]) -> bool:
    if any(at.prismatic[i] for i in joints) or all(_parallel(at, joints[0], i) for i in joints[1:]):
        return False
    c = at.meeting(joints)
    return all(float(np.linalg.norm(at.velocity(i, c), axis=-1).max()) < CLEAR for i in joints)


Point = Callable[[Lines], Floats]


class _Factory:
    """Makes factors of one robot; `at` are its axes at probing configurations."""

    def __init__(self, robot: Robot, at: Lines) -> None:
        self.names, self.at = robot.joint_names, at

    def of_pose(self, joints: tuple[int, ...]) -> list[list[DeterminantFactor]]:
        """All splittings by a spherical or planar group of three, those with most factors first."""
        found: list[list[DeterminantFactor]] = []
        for three in combinations(joints, 3):
            rest = tuple(i for i in joints if i not in three)
            if _concurrent(self.at, three):
                point: Point = lambda x, three=three: x.meeting(three)  # noqa: E731
                found.append([*self.of_velocities(rest, point, "c"), self.directions(three)])
            elif not any(self.at.prismatic[i] for i in three) and all(
                _parallel(self.at, three[0], i) for i in three[1:]
            ):
                found.append([self.triangle(three), *self.of_quotient(rest, three[0])])
        return sorted(found, key=len, reverse=True)

    def of_velocities(self, joints: tuple[int, ...], point: Point, letter: str) -> list[DeterminantFactor]:
        """Det of three velocities of a point."""
        pairs = [(a, b) for a, b in combinations(joints, 2) if not (self.at.prismatic[a] or self.at.prismatic[b])]
        for a, b in pairs:
            if _parallel(self.at, a, b):
                (c,) = (i for i in joints if i not in (a, b))
                along: Point = lambda x, a=a: x.w[..., a, :]  # noqa: E731
                shoulder = self.speed("shoulder", c, point, along, f"z{a + 1} . {self.point_velocity(c, letter)}")
                return [shoulder, self.elbow((a, b), point, letter)]
        for a, b in pairs:
            if _concurrent(self.at, (a, b)):
                (c,) = (i for i in joints if i not in (a, b))
                return self._of_meeting(a, b, c, point, letter)
        return [self.velocities(joints, point, letter)]

    def _of_meeting(self, a: int, b: int, c: int, point: Point, letter: str) -> list[DeterminantFactor]:
        """(za x r) x (zb x r) = r [za zb r], r from the meeting point o of the axes a, b."""

        def arm(x: Lines) -> Floats:
            return point(x) - x.meeting((a, b))

        def plane(x: Lines) -> Floats:
            return _triple(x.w[..., a, :], x.w[..., b, :], arm(x))

        formula = f"(z{a + 1} x z{b + 1}) . ({letter} - o)"
        return [
            DeterminantFactor("meeting_plane", (a, b), formula, plane, self._names(a, b)),
            self.speed("boom", c, point, arm, f"({letter} - o) . {self.point_velocity(c, letter)}"),
        ]

    def of_quotient(self, joints: tuple[int, ...], parallel: int) -> list[DeterminantFactor]:
        """What three joints do besides moving in the plane normal to z: turn about two axes in it, move along z."""
        z: Point = lambda x: x.w[..., parallel, :]  # noqa: E731
        for a, b in combinations(joints, 2):
            if _concurrent(self.at, (a, b)):
                (c,) = (i for i in joints if i not in (a, b))
                point: Point = lambda x, a=a, b=b: x.meeting((a, b))  # noqa: E731
                turned = DeterminantFactor(
                    "turned",
                    (a, b),
                    f"(z{a + 1} x z{b + 1}) . z{parallel + 1}",
                    lambda x, a=a, b=b: _triple(x.w[..., a, :], x.w[..., b, :], z(x)),
                    self._names(a, b),
                )
                return [self.speed("shoulder", c, point, z, f"z{parallel + 1} . {self.point_velocity(c, 'c')}"), turned]
        return []

    def point_velocity(self, i: int, letter: str) -> str:
        """The velocity of a point by joint i, in letters."""
        return f"z{i + 1}" if self.at.prismatic[i] else f"(z{i + 1} x ({letter} - p{i + 1}))"

    def speed(self, kind: str, c: int, point: Point, along: Point, formula: str) -> DeterminantFactor:
        """How fast joint c moves a point along a direction."""

        def value(x: Lines) -> Floats:
            return (along(x) * x.velocity(c, point(x))).sum(axis=-1)

        return DeterminantFactor(
            f"{kind}_prismatic" if self.at.prismatic[c] else kind, (c,), formula, value, self._names(c)
        )

    def elbow(self, pair: tuple[int, ...], point: Point, letter: str) -> DeterminantFactor:
        """Twice the area of the triangle of two parallel axes and a point."""
        a, b = pair

        def value(x: Lines) -> Floats:
            c = point(x)
            return _triple(x.w[..., a, :], c - x.p[..., a, :], c - x.p[..., b, :])

        formula = f"z{a + 1} . (({letter} - p{a + 1}) x ({letter} - p{b + 1}))"
        return DeterminantFactor("elbow", (a, b), formula, value, self._names(a, b))

    def triangle(self, three: tuple[int, ...]) -> DeterminantFactor:
        """Twice the area of the triangle of three parallel axes."""
        a, b, c = three

        def value(x: Lines) -> Floats:
            return _triple(x.w[..., a, :], x.p[..., b, :] - x.p[..., a, :], x.p[..., c, :] - x.p[..., a, :])

        formula = f"z{a + 1} . ((p{b + 1} - p{a + 1}) x (p{c + 1} - p{a + 1}))"
        return DeterminantFactor("triangle", three, formula, value, self._names(*three))

    def directions(self, three: tuple[int, ...]) -> DeterminantFactor:
        """Triple product of the directions of three axes through one point."""
        a, b, c = three

        def value(x: Lines) -> Floats:
            return _triple(x.w[..., a, :], x.w[..., b, :], x.w[..., c, :])

        return DeterminantFactor("directions", three, f"(z{a + 1} x z{b + 1}) . z{c + 1}", value, self._names(*three))

    def velocities(self, three: tuple[int, ...], point: Point, letter: str) -> DeterminantFactor:
        """Triple product of the velocities that three joints give to a point."""

        def value(x: Lines) -> Floats:
            c = point(x)
            return _triple(*(x.velocity(i, c) for i in three))

        a, b, c = (self.point_velocity(i, letter) for i in three)
        return DeterminantFactor("velocities", three, f"({a} x {b}) . {c}", value, self._names(*three))

    def _names(self, *joints: int) -> tuple[str, ...]:
        return tuple(self.names[i] for i in joints)


def _triple(a: Floats, b: Floats, c: Floats) -> Floats:
    """(a x b) . c."""
    return (np.cross(a, b) * c).sum(axis=-1)


@of_robot
def natural_task(robot: Robot) -> str:
    """The task for which the arm's Jacobian is square: pose (6 joints), planar, Schoenflies, position, orientation.

    Three axes through one point keep the tip on a sphere, so a spherical wrist is asked for its orientation.

    Args:
        robot: the arm.

    Raises:
        InputError: there is none.
    """
    at = lines(robot, random_configurations(robot, 3, limited=False))
    revolute = [i for i in range(robot.n) if not at.prismatic[i]]
    parallel = all(_parallel(at, revolute[0], i) for i in revolute[1:]) if revolute else False
    up = bool(np.allclose(np.abs(at.w[:, revolute, 2]), 1.0)) if revolute else False
    match robot.n:
        case 6:
            return "pose"
        case 4 if parallel and up:
            return "schoenflies"
        case 3 if _concurrent(at, range(3)):
            return "orientation"
        case 3:
            return "planar" if parallel and up else "position"
        case 2 if parallel and up:
            return "planar_position"
        case _:
            raise InputError("performance.not_square", robot=robot.name, n=robot.n)
