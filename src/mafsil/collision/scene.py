"""What stands around an arm: obstacles as values, and a scene of them, laid out for the compiled loops at first use."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import PoseMatrix, frozen, real_array, require_finite
from mafsil.collision.shapes import Geometry, checked_geometry, require_near
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.model.placement import checked_pose

if TYPE_CHECKING:
    import mafsil.collision.piece_loops as tree_loops
    import mafsil.collision.pieces as pieces
    from mafsil.collision.piece_loops import Pieces, Surroundings
else:
    pieces = lazily("mafsil.collision.pieces")
    tree_loops = lazily("mafsil.collision.piece_loops")


@dataclass(frozen=True, eq=False, slots=True)
class Obstacle:
    """A geometry at a pose.

    Attributes:
        geometry: what it is: `Box`, `Sphere`, `Cylinder`, `Capsule`, `Cone`, `Plane`, `ConvexHull`, `TriangleMesh`,
            `PointCloud`, `HeightMap`, or a robot file's `Mesh`.
        T_so: (4, 4) pose of its frame in {s}; (3,) is a position.
        name: how answers call it; a scene numbers those without.

    Raises:
        InputError: no geometry, a length that is none, no pose, a name that is no text.
    """

    geometry: Geometry
    T_so: PoseMatrix = field(default_factory=lambda: frozen(np.eye(4)))
    name: str = ""

    def __post_init__(self) -> None:
        name = cast("object", self.name)
        if not isinstance(name, str):
            raise InputError("collision.obstacle_name", got=type(name).__name__)
        checked_geometry(self.name or "geometry", self.geometry)
        object.__setattr__(self, "T_so", as_pose(f"{self.name or type(self.geometry).__name__}: T_so", self.T_so))


def as_pose(name: str, place: ArrayLike) -> PoseMatrix:
    """A pose (4, 4), of a pose or of a position (3,)."""
    array = real_array(name, place)
    if array.shape != (3,):
        T = frozen(checked_pose(name, array))
        require_near(name, T[:3, 3])
        return T
    x, y, z = require_near(name, require_finite(name, array)).tolist()
    return frozen([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]])


class Scene:
    """Obstacles around an arm, in {s}; a value: `with_obstacle` and `without` give another one.

    Args:
        obstacles: Obstacle each, or a geometry that stands in {s} itself.

    Raises:
        InputError: something else, or a name that is used twice.
    """

    def __init__(self, obstacles: Iterable[Obstacle | Geometry] = ()) -> None:
        self._given = as_obstacles("obstacles", obstacles)
        names = [each.name for each in self._given if each.name]
        if len(set(names)) < len(names):
            twice = next(name for name in names if names.count(name) > 1)
            raise InputError("collision.named_twice", name=twice)

    @cached_property
    def obstacles(self) -> tuple[Obstacle, ...]:
        """All of them, with names: those without are called by kind and number."""
        return _named(self._given)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Of the obstacles."""
        return tuple(each.name for each in self.obstacles)

    def with_obstacle(self, geometry: Geometry, T_so: ArrayLike | None = None, name: str = "") -> Scene:
        """The scene with one more obstacle; arguments as `Obstacle`."""
        more = Obstacle(geometry, np.eye(4) if T_so is None else cast("PoseMatrix", T_so), name)
        return Scene((*self.obstacles, more))

    def without(self, name: str) -> Scene:
        """The scene without the obstacle of that name.

        Raises:
            InputError: there is none.
        """
        self.index(name)
        return Scene(each for each in self.obstacles if each.name != name)

    def index(self, name: str) -> int:
        """Place of the obstacle of that name among the obstacles.

        Raises:
            InputError: there is none.
        """
        if name not in self.names:
            raise InputError("collision.no_obstacle", name=name, known=", ".join(self.names) or "-")
        return self.names.index(name)

    @cached_property
    def pieces(self) -> Pieces:
        """All convex pieces, posed in {s}; `body` is the obstacle's index."""
        return pieces.pieces_of([(each.geometry, each.T_so, i) for i, each in enumerate(self._given)])

    @cached_property
    def surroundings(self) -> Surroundings:
        """The pieces with a tree of boxes around them."""
        return tree_loops.surround(self.pieces)

    def __len__(self) -> int:
        return len(self._given)

    def __iter__(self) -> Iterator[Obstacle]:
        return iter(self.obstacles)

    def __repr__(self) -> str:
        return f"Scene({', '.join(self.names)})"

    def __reduce__(self) -> tuple[Any, ...]:
        return Scene, (self.obstacles,)


def as_obstacles(name: str, given: Iterable[Obstacle | Geometry]) -> tuple[Obstacle, ...]:
    """Obstacles, of which those without a place are given as geometries.

    Args:
        name: the argument's name, for the error.
        given: what a caller gave.

    Raises:
        InputError: no list.
    """
    if not isinstance(cast(object, given), Iterable):
        raise InputError("input.kind", name=name, expected="list of obstacles", got=type(given).__name__)
    return tuple(each if isinstance(each, Obstacle) else Obstacle(each) for each in given)


def _named(given: tuple[Obstacle, ...]) -> tuple[Obstacle, ...]:
    used, named = {each.name for each in given}, list[Obstacle]()
    counts: dict[str, int] = {}
    for each in given:
        name = each.name
        while not name or (not each.name and name in used):
            kind = type(each.geometry).__name__.lower()
            counts[kind] = counts.get(kind, 0) + 1
            name = f"{kind} {counts[kind]}"
        named.append(each if each.name else _call(each, name))
    return tuple(named)


def _call(obstacle: Obstacle, name: str) -> Obstacle:
    """The same with a name; what was looked at when it was made is not looked at again."""
    other = object.__new__(Obstacle)
    for word, value in (("geometry", obstacle.geometry), ("T_so", obstacle.T_so), ("name", name)):
        object.__setattr__(other, word, value)
    return other
