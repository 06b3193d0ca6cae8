"""What an arm keeps on its way: a tool upright, a point on a line or in a plane, an orientation, a loop closed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, Vector3, positive, single
from mafsil.collision.joints import joints_of
from mafsil.errors import InputError
from mafsil.fields import check_fields, or_none, vector
from mafsil.geometry import rotation
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.model import Mechanism

if TYPE_CHECKING:
    import mafsil.collision.layout as layout
    import mafsil.planning.kept_loops as kept_loops
    from mafsil.collision import Checker
    from mafsil.collision.arm_loops import Arm
else:
    layout = lazily("mafsil.collision.layout")
    kept_loops = lazily("mafsil.planning.kept_loops")

AIM = 0.02
"""Share of a tolerance to which configurations are projected."""
AIM_OF_REGION = 0.9
"""The same for a region that may be used up to its limit."""
Scalar = TypeVar("Scalar", bound=np.generic)
Row: TypeAlias = tuple[int, int, int, Vector3, Vector3, Floats]
"""POINT or AXIS, link, other link or -1, vector in the link, where it should be, (3, 3) projector."""


class Constraint(Protocol):
    """What a path keeps: rows of `kept_loops.Kept` that are measured together, and what their measure means."""

    def rows(self, mechanism: Mechanism, poses: Floats) -> list[Row]:
        """Rows, for an arm whose links stand at `poses` (L, 4, 4) at the start."""
        ...

    def limits(self) -> tuple[float, float]:
        """Largest measure, and the share of it that projections aim at."""
        ...

    def amount(self, measure: float) -> float:
        """The measure in radians or metres."""
        ...

    def sentence(self, measure: float, language: str | None = None) -> str:
        """What is kept, and within what."""
        ...


@dataclass(frozen=True, eq=False)
class Upright:
    """Path constraint: an axis of a frame stays within an angle of a direction.

    Attributes:
        angle: largest [rad], above 0, below pi.
        axis: (3,) in the frame.
        direction: (3,) in {s}; where the axis points at the start if None.
        frame: a link; the tip if None.
    """

    angle: float
    axis: ArrayLike = (0.0, 0.0, 1.0)
    direction: ArrayLike | None = None
    frame: str | None = None
    __post_init__ = check_fields(angle=positive, axis=vector(3), direction=or_none(vector(3)))

    def rows(self, mechanism: Mechanism, poses: Floats) -> list[Row]:
        """One direction."""
        link, T = _frame(mechanism, self.frame)
        axis = T[:3, :3] @ _unit("axis", self.axis)
        wanted = poses[link][:3, :3] @ axis if self.direction is None else _unit("direction", self.direction)
        return [(1, link, -1, axis, wanted, np.eye(3))]

    def limits(self) -> tuple[float, float]:
        """Of the chord between the two directions."""
        if not self.angle < np.pi:
            raise InputError("input.range", name="angle", value=self.angle, low=0.0, high=np.pi)
        return 2.0 * float(np.sin(self.angle / 2.0)), AIM_OF_REGION

    def amount(self, measure: float) -> float:
        """The angle of a chord [rad]."""
        return 2.0 * float(np.arcsin(min(measure / 2.0, 1.0)))

    def sentence(self, measure: float, language: str | None = None) -> str:
        """The angle, in degrees."""
        given = {"got": np.degrees(self.amount(measure)), "limit": np.degrees(self.angle)}
        return say("planning.keeps_upright", language=language, **given)


@dataclass(frozen=True, eq=False)
class FixedOrientation:
    """Path constraint: the orientation of a frame is constant.

    Attributes:
        R: (3, 3) in {s}; that of the start if None.
        tolerance: angle by which it may differ [rad].
        frame: a link; the tip if None.
    """

    R: ArrayLike | None = None
    tolerance: float = 0.01
    frame: str | None = None
    __post_init__ = check_fields(R=or_none(vector(3, 3)), tolerance=positive)

    def rows(self, mechanism: Mechanism, poses: Floats) -> list[Row]:
        """The three axes; the sum of their squared chords is 8 sin(theta / 2)^2."""
        link, T = _frame(mechanism, self.frame)
        given = None if self.R is None else single("R", self.R, (3, 3))
        wanted = poses[link][:3, :3] @ T[:3, :3] if given is None else rotation.check(given)
        return [(1, link, -1, T[:3, k], wanted[:, k], np.eye(3)) for k in range(3)]

    def limits(self) -> tuple[float, float]:
        """Of the Frobenius norm of the difference."""
        if not self.tolerance < np.pi:
            raise InputError("input.range", name="tolerance", value=self.tolerance, low=0.0, high=np.pi)
        return float(np.sqrt(8.0) * np.sin(self.tolerance / 2.0)), AIM

    def amount(self, measure: float) -> float:
        """The angle [rad]."""
        return 2.0 * float(np.arcsin(min(measure / np.sqrt(8.0), 1.0)))

    def sentence(self, measure: float, language: str | None = None) -> str:
        """The angle, in degrees."""
        given = {"got": np.degrees(self.amount(measure)), "limit": np.degrees(self.tolerance)}
        return say("planning.keeps_orientation", language=language, **given)


class _Place:
    """A point of a frame whose distance from where it should be is measured."""

    tolerance: float
    key = ""

    def limits(self) -> tuple[float, float]:
        """The tolerance [m]."""
        return self.tolerance, AIM

    def amount(self, measure: float) -> float:
        """The distance [m]."""
        return measure

    def sentence(self, measure: float, language: str | None = None) -> str:
        """The distance, in millimetres."""
        return say(self.key, language=language, got=1e3 * measure, limit=1e3 * self.tolerance)


@dataclass(frozen=True, eq=False)
class OnLine(_Place):
    """Path constraint: a point of a frame stays on a straight line.

    Attributes:
        direction: (3,) of the line, in {s}.
        point: (3,) on the line, in {s}; where the point is at the start if None.
        tolerance: distance from the line that is allowed [m].
        at: (3,) the point that stays, in the frame [m].
        frame: a link; the tip if None.
    """

    direction: ArrayLike
    point: ArrayLike | None = None
    tolerance: float = 0.001
    at: ArrayLike = (0.0, 0.0, 0.0)
    frame: str | None = None
    key = "planning.keeps_line"
    __post_init__ = check_fields(direction=vector(3), point=or_none(vector(3)), tolerance=positive, at=vector(3))

    def rows(self, mechanism: Mechanism, poses: Floats) -> list[Row]:
        """What is across the line."""
        d = _unit("direction", self.direction)
        return [_point(mechanism, poses, self.frame, self.at, self.point, np.eye(3) - np.outer(d, d))]


@dataclass(frozen=True, eq=False)
class InPlane(_Place):
    """Path constraint: a point of a frame stays in a plane.

    Attributes:
        normal: (3,) of the plane, in {s}.
        point: (3,) in the plane, in {s}; where the point is at the start if None.
        tolerance: distance from the plane that is allowed [m].
        at: (3,) the point that stays, in the frame [m].
        frame: a link; the tip if None.
    """

    normal: ArrayLike
    point: ArrayLike | None = None
    tolerance: float = 0.001
    at: ArrayLike = (0.0, 0.0, 0.0)
    frame: str | None = None
    key = "planning.keeps_plane"
    __post_init__ = check_fields(normal=vector(3), point=or_none(vector(3)), tolerance=positive, at=vector(3))

    def rows(self, mechanism: Mechanism, poses: Floats) -> list[Row]:
        """What is along the normal."""
        normal = _unit("normal", self.normal)
        return [_point(mechanism, poses, self.frame, self.at, self.point, np.outer(normal, normal))]


@dataclass(frozen=True, eq=False)
class LoopClosed(_Place):
    """A point of one link stays on a point of another one, as the pin of a closed loop holds them.

    Attributes:
        frame, other: links.
        at, other_at: (3,) the points, in the frames of their links [m].
        tolerance: distance between them that is allowed [m].
        aim: share of the tolerance to which points of the path close it.
    """

    frame: str
    other: str
    at: ArrayLike = (0.0, 0.0, 0.0)
    other_at: ArrayLike = (0.0, 0.0, 0.0)
    tolerance: float = 0.001
    aim: float = AIM
    key = "planning.keeps_loop"
    __post_init__ = check_fields(at=vector(3), other_at=vector(3), tolerance=positive, aim=positive)

    def limits(self) -> tuple[float, float]:
        """The tolerance [m], and the share of it that is aimed at."""
        return self.tolerance, self.aim

    def rows(self, mechanism: Mechanism, poses: Floats) -> list[Row]:
        """The difference of the two points."""
        del poses
        link, other = (_frame(mechanism, name)[0] for name in (self.frame, self.other))
        return [(0, link, other, single("at", self.at, (3,)), single("other_at", self.other_at, (3,)), np.eye(3))]


def _frame(mechanism: Mechanism, name: str | None) -> tuple[int, Floats]:
    """A link's index, and the pose of the frame in it."""
    if name is None:
        return mechanism.link_names.index(mechanism.tip), np.asarray(mechanism.T_lt)
    return mechanism.link_names.index(mechanism.link(name).name), np.eye(4)


def _unit(name: str, value: ArrayLike) -> Vector3:
    vector = single(name, value, (3,))
    length = float(np.linalg.norm(vector))
    if length == 0.0:
        raise InputError("planning.constraint_direction", name=name)
    return vector / length


def _point(
    mechanism: Mechanism, poses: Floats, frame: str | None, at: ArrayLike, point: ArrayLike | None, P: Floats
) -> Row:
    link, T = _frame(mechanism, frame)
    own = T[:3, :3] @ single("at", at, (3,)) + T[:3, 3]
    wanted = poses[link][:3, :3] @ own + poses[link][:3, 3] if point is None else single("point", point, (3,))
    return 0, link, -1, own, wanted, P


def kept_of(
    checker: Checker, constraints: Constraint | Iterable[Constraint], start: JointVector, bounds: tuple[Floats, Floats]
) -> tuple[tuple[Constraint, ...], kept_loops.Kept]:
    """Constraints as a tuple, and as the arrays that the compiled loops read.

    Args:
        checker: the arm.
        constraints: one or several constraints.
        start: (n,) from which what is not given is taken.
        bounds: (n,) lower and upper limits of the search.

    Raises:
        InputError: no constraint; numbers that cannot be.
        ModelError: no such link.
    """
    each = tuple(constraints) if isinstance(constraints, Iterable) else (constraints,)
    for one in each:
        if not all(hasattr(one, name) for name in ("rows", "limits", "amount", "sentence")):
            raise InputError("planning.constraint_kind", got=type(one).__name__)
    mechanism, poses = checker.robot.mechanism, np.asarray(checker.robot.link_poses(start))
    grouped = [one.rows(mechanism, poses) for one in each]
    limits = np.array([one.limits() for one in each]).reshape(-1, 2)
    rows = [(k, *row) for k, some in enumerate(grouped) for row in some]
    table = [[kind, a, b, k, *x, *to, *P.ravel()] for k, kind, a, b, x, to, P in rows]
    joints = joints_of(mechanism)
    motion = layout.motion_of(mechanism, joints, _points_as_bodies(checker, rows))
    motion.joints[:, 4] = (joints.screw[:, :3] * joints.screw[:, 3:]).sum(axis=1)
    bend = np.array([np.sqrt(2.0) if len(some) > 1 else 1.0 for some in grouped])
    arrays = kept_loops.Kept(
        np.array(table, np.float64).reshape(len(rows), 19), limits[:, 0].copy(), limits[:, 0] * limits[:, 1], bend,
        motion.joints, _by_row(motion.moves), _by_row(motion.reach), _by_row(motion.stretch), *bounds,
    )  # fmt: skip
    return each, arrays


def _points_as_bodies(checker: Checker, rows: Sequence[tuple[int, int, int, int, Vector3, Vector3, Floats]]) -> Arm:
    """An arm whose bodies are the points of the rows, each with that of the other link behind it."""
    table = np.zeros((2 * len(rows), 8))
    for r, (_, _, link, other, x, to, _) in enumerate(rows):
        table[2 * r, 0], table[2 * r, 4:7] = link, x
        table[2 * r + 1, 0], table[2 * r + 1, 4:7] = max(other, 0), to if other >= 0 else 0.0
    return checker.arm._replace(bodies=table, pairs=checker.arm.pairs[:0])


def _by_row(array: NDArray[Scalar]) -> NDArray[Scalar]:
    """(j, 2 m, ...) -> (2 m, j, ...)."""
    return np.ascontiguousarray(np.swapaxes(array, 0, 1))
