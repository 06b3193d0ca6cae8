"""Distance of two bodies: the points nearest to each other, or how deep they lie in each other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, Scalar, Vector3
from mafsil.collision.scene import Obstacle, Scene
from mafsil.collision.shapes import Geometry, Plane
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.model.placement import checked_poses

if TYPE_CHECKING:
    import mafsil.collision.near_loops as near_loops
else:
    near_loops = lazily("mafsil.collision.near_loops")


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
    first, second = (x if isinstance(x, Obstacle) else Obstacle(x) for x in (a, b))
    if isinstance(first.geometry, Plane) and isinstance(second.geometry, Plane):
        raise InputError("collision.two_planes")
    poses = [_poses(n, T, x) for n, T, x in (("T_sa", T_sa, first), ("T_sb", T_sb, second))]
    T_a, T_b = np.broadcast_arrays(*poses)
    batch = T_a.shape[:-2]
    flipped = isinstance(first.geometry, Plane)
    moving, still = (second, first) if flipped else (first, second)
    pieces = Scene([Obstacle(moving.geometry)]).pieces
    around = Scene([Obstacle(still.geometry)]).surroundings
    out = np.empty((int(np.prod(batch)), 10))
    flat = [np.array(T.reshape(-1, 4, 4), order="C") for T in ((T_b, T_a) if flipped else (T_a, T_b))]
    near_loops.nearest_of_all(pieces, flat[0], around, flat[1], out)
    point_a, point_b, normal = (out[:, k : k + 3].reshape(*batch, 3) for k in (1, 4, 7))
    if flipped:
        point_a, point_b, normal = point_b, point_a, -normal
    kinds = tuple(x.name or type(x.geometry).__name__.lower() for x in (first, second))
    return Separation((kinds[0], kinds[1]), out[:, 0].reshape(batch), point_a, point_b, normal)


def _poses(name: str, given: ArrayLike | None, body: Obstacle) -> Floats:
    return body.T_so if given is None else checked_poses(name, given)
