"""Statuses of collision checks and the answers that carry them.

Distance of two bodies: the points nearest to each other, or how deep they lie in each other.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, PoseMatrix, Scalar, Truth, Vector3, frozen
from mafsil.collision.scene import Obstacle, Scene
from mafsil.collision.shapes import Geometry, Plane, checked_geometry
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.model.link import Mesh
from mafsil.model.placement import checked_poses

if TYPE_CHECKING:
    import mafsil.collision.arm_loops as near_loops
else:
    near_loops = lazily("mafsil.collision.arm_loops")


HERE = frozen(np.eye(4))
"""Where a geometry without a place stands."""


class CheckStatus(Status):
    """Whether an arm is free at a configuration."""

    FREE = ("collision.free", True)
    ALONE = ("collision.alone", True)
    COLLIDING = ("collision.colliding", False)


SMALLEST_GAP = 1e-3
"""Distance below which nothing counts as safely passed where no error of the motion is known [m].

Arms are mounted, measured and driven within about a millimetre; a smaller gap in a model is none in a cell.
"""


@dataclass(frozen=True, eq=False, slots=True)
class ContactPair:
    """A body of the arm and the body that it collides with, or is closest to.

    Attributes:
        first: name of the body.
        second: name of the obstacle or of the other body.
        distance: [m]; minus the depth where they overlap.
        point_first, point_second: (3,) the points nearest to each other, in {s} [m].
        normal: (3,) unit direction in which the first one leaves the second.
    """

    first: str
    second: str
    distance: float
    point_first: Vector3
    point_second: Vector3
    normal: Vector3

    @property
    def place(self) -> Vector3:
        """(3,) the middle between the two points, in {s} [m]."""
        return (self.point_first + self.point_second) / 2

    def sentence(self, language: str | None = None) -> str:
        """What meets what, by how much, where."""
        key = "collision.hits" if self.distance <= 0.0 else "collision.near"
        return say(
            key, language=language, first=self.first, second=self.second,
            millimetres=1e3 * abs(self.distance), place=place_of(self.place),
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "first": self.first, "second": self.second, "distance": self.distance,
            "point_first": self.point_first.tolist(), "point_second": self.point_second.tolist(),
            "normal": self.normal.tolist(),
        }  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class CollisionCheck(Answer, data="q clearance contacts"):
    """Collisions of an arm at a configuration; true if it is collision-free.

    Attributes:
        status: free; alone (there is nothing to meet); colliding.
        q: (n,) the configuration.
        clearance: the clearance that was asked for [m].
        contacts: every pair within the clearance, deepest first; of a free configuration the nearest pair.
        unchecked: keys of sentences about what was not looked at.
    """

    status: CheckStatus
    q: Floats
    clearance: float
    contacts: tuple[ContactPair, ...]
    unchecked: tuple[str, ...] = ()

    def explain(self, language: str | None = None) -> str:
        """A sentence for the verdict, one for each contact; if free, what was not looked at."""
        head = self.status.sentence(language, count=len(self.contacts), millimetres=1e3 * self.clearance)
        lines = [head, *(each.sentence(language) for each in self.contacts)]
        return "\n".join([*lines, *(say(key, language=language) for key in self.unchecked if self)])

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return Answer.to_dict(self) | {"unchecked": unchecked_as_data(self.unchecked)}


def unchecked_as_data(unchecked: tuple[str, ...]) -> list[str]:
    """What was not looked at, as plain data: itself, around."""
    return [key.rpartition("_")[2] for key in unchecked]


@dataclass(frozen=True, eq=False, repr=False)
class Clearance(Answer, data="distance free point_first point_second normal gradient first second"):
    """Smallest distance of an arm at each of many configurations; true where all are free.

    Attributes:
        q: (*batch, n).
        clearance: clearance that makes a configuration free [m].
        distance: (*batch) [m]; minus the depth of the deepest pair, infinite where there is nothing to meet.
        point_first, point_second: (*batch, 3) the points nearest to each other, in {s}.
        normal: (*batch, 3) unit direction in which the first body leaves the second.
        gradient: (*batch, n) of the distance by q [m/rad | 1], as far as one pair stays the nearest.
        first, second: (*batch) names of the nearest pair.
        verdict: (*batch) whether each is free, where another clearance counts between bodies of the arm.
    """

    q: JointVector
    clearance: float
    distance: Scalar
    point_first: Vector3
    point_second: Vector3
    normal: Vector3
    gradient: JointVector
    first: Any
    second: Any
    verdict: Truth | None = None

    @property
    def free(self) -> Any:
        """(*batch) whether each configuration is free."""
        return self.distance > self.clearance if self.verdict is None else self.verdict

    @property
    def status(self) -> Any:
        """A CheckStatus, or an array (*batch) of them."""
        members = np.array([CheckStatus.COLLIDING, CheckStatus.FREE, CheckStatus.ALONE])
        return members[np.where(np.isinf(self.distance), 2, np.asarray(self.free).astype(int))]

    def __bool__(self) -> bool:
        return bool(np.all(self.free))

    def __len__(self) -> int:
        return self.distance.size

    def __iter__(self) -> Iterator[ContactPair]:
        rows = (x.reshape(-1, 3) for x in (self.point_first, self.point_second, self.normal))
        names = (np.reshape(self.first, -1), np.reshape(self.second, -1))
        for first, second, distance, a, b, n in zip(*names, self.distance.reshape(-1), *rows, strict=True):
            yield ContactPair(str(first), str(second), float(distance), a, b, n)

    def explain(self, language: str | None = None) -> str:
        """A sentence for each configuration."""
        alone = CheckStatus.ALONE.sentence(language)
        return "\n".join(alone if np.isinf(each.distance) else each.sentence(language) for each in self)


class SeparationStatus(Status):
    """Whether two bodies are apart."""

    APART = ("collision.apart", True)
    MEETING = ("collision.meeting", False)


@dataclass(frozen=True, eq=False, repr=False)
class Separation(Answer, data="names distance point_a point_b normal"):
    """Distance of two bodies, for one pose of each or a batch; true where all of them are apart.

    Attributes:
        names: of the two bodies a and b.
        distance: (*batch) [m]; where they overlap, minus the length of the shortest translation that parts them; for
            bodies of several convex pieces that of the deepest pair of pieces.
        point_a, point_b: (*batch, 3) the points nearest to each other, in {s}; point_a - point_b = distance * normal.
        normal: (*batch, 3) unit direction from b to a.
    """

    names: tuple[str, str]
    distance: Scalar
    point_a: Vector3
    point_b: Vector3
    normal: Vector3

    @property
    def status(self) -> Any:
        """Whether they are apart; of a batch an array (*batch)."""
        if self.distance.ndim == 0:
            return SeparationStatus.APART if self.distance > 0.0 else SeparationStatus.MEETING
        members = np.array([SeparationStatus.MEETING, SeparationStatus.APART])
        return members[(self.distance > 0.0).astype(int)]

    def __bool__(self) -> bool:
        return bool((self.distance > 0.0).all())

    def __len__(self) -> int:
        return self.distance.size

    def __iter__(self) -> Iterator[Separation]:
        rows = (x.reshape(-1, 3) for x in (self.point_a, self.point_b, self.normal))
        for distance, a, b, n in zip(self.distance.reshape(-1), *rows, strict=True):
            yield Separation(self.names, np.array(distance), a, b, n)

    def explain(self, language: str | None = None) -> str:
        """A sentence for each pose: the distance or the depth, and where."""
        if self.distance.ndim:
            return "\n".join(each.explain(language) for each in self)
        return self.status.sentence(
            language, first=self.names[0], second=self.names[1],
            millimetres=1e3 * abs(float(self.distance)), place=place_of((self.point_a + self.point_b) / 2),
        )  # fmt: skip


def place_of(point: Floats) -> str:
    """A point for a sentence, in metres to the millimetre."""
    return "(" + ", ".join(f"{x + 0.0:.3f}" for x in np.round(point, 3)) + ")"


def distance(
    a: Obstacle | Geometry, b: Obstacle | Geometry, T_sa: ArrayLike | None = None, T_sb: ArrayLike | None = None
) -> Separation:
    """Distance of two bodies, with the points nearest to each other and, where they overlap, how deep.

    Balls, capsules, boxes and half spaces against each other by closed forms where these are exact, else by GJK to
    1e-12 of the bodies' size (the bound; cylinders and cones 1e-9). Depths of balls, capsules, boxes and hulls are
    exact too; those of cylinders and cones are no less than the true ones, by 1e-4 of the bodies' size at most.

    Args:
        a, b: obstacles, or geometries.
        T_sa, T_sb: (*batch, 4, 4) poses in {s} in place of the obstacle's own.

    Raises:
        InputError: no geometry, no pose, NaN or infinities, two half spaces.
    """
    (first, place_a, name_a), (second, place_b, name_b) = _body(a), _body(b)
    flipped = isinstance(first, Plane)
    if flipped and isinstance(second, Plane):
        raise InputError("collision.two_planes")
    T_a = place_a if T_sa is None else checked_poses("T_sa", T_sa)
    T_b = place_b if T_sb is None else checked_poses("T_sb", T_sb)
    if T_a.shape != T_b.shape:
        T_a, T_b = np.broadcast_arrays(T_a, T_b)
    batch = T_a.shape[:-2]
    moving, still = (second, first) if flipped else (first, second)
    out = np.empty((prod(batch), 10))
    flat = [np.ascontiguousarray(T).reshape(-1, 4, 4) for T in ((T_b, T_a) if flipped else (T_a, T_b))]
    near_loops.nearest_of_all(_alone(moving).pieces, flat[0], _alone(still).surroundings, flat[1], out)
    point_a, point_b, normal = (out[:, k : k + 3].reshape(*batch, 3) for k in (1, 4, 7))
    if flipped:
        point_a, point_b, normal = point_b, point_a, -normal
    return Separation((name_a, name_b), out[:, 0].reshape(batch), point_a, point_b, normal)


def _body(given: Obstacle | Geometry) -> tuple[Geometry, PoseMatrix, str]:
    """A geometry, its place and how answers call it."""
    if not isinstance(given, Obstacle):
        checked_geometry("geometry", given)
        return given, HERE, type(given).__name__.lower()
    return given.geometry, given.T_so, given.name or type(given.geometry).__name__.lower()


def _alone(geometry: Geometry) -> Scene:
    """A geometry as the loops read it, kept for the next question; but what a file holds may change."""
    return Scene([geometry]) if isinstance(geometry, Mesh) else _kept_alone(geometry)


@lru_cache(maxsize=8)
def _kept_alone(geometry: Geometry) -> Scene:
    return Scene([geometry])
