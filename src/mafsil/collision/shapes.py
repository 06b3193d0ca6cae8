"""Geometries of obstacles, beside those of robot files (`Box`, `Cylinder`, `Capsule`, `Sphere`, `Mesh`)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, as_batch, frozen, number, real_array
from mafsil.errors import InputError
from mafsil.fields import check_fields, real
from mafsil.model import mesh, scan
from mafsil.model.link import Box, Capsule, Cylinder, Mesh, Sphere
from mafsil.model.mesh.surface import clean_surface

MOST_LENGTH = 1e6
"""Largest length, and farthest coordinate of a point, that a geometry may have: beyond it digits are lost [m]."""
THICK = 0.1
"""Of ground from a file below its lowest height [m]."""


@dataclass(frozen=True, slots=True)
class Cone:
    """A cone, axis along z, its base at z = -length/2, its apex at z = length/2 [m]."""

    radius: float
    length: float
    __post_init__ = check_fields(radius=number, length=number)


@dataclass(frozen=True, slots=True)
class Plane:
    """A half space: everything at z <= 0 of its frame, such as a floor."""


@dataclass(frozen=True, eq=False, slots=True)
class ConvexHull:
    """The convex hull of points.

    Attributes:
        points: (k, 3) [m].
        rounding: everything so near to the hull belongs to it; below zero all distances of the hull count larger by
            that, so that it may come nearer than a clearance, but not meet anything [m].
    """

    points: Floats
    rounding: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", _points("points", self.points))
        _require_length("rounding", abs(real("rounding", self.rounding)), zero=True)


@dataclass(frozen=True, eq=False, slots=True)
class TriangleMesh:
    """A surface of triangles, closed or not; what lies inside a closed one without touching it does not collide.

    Attributes:
        vertices: (v, 3) [m].
        faces: (f, 3) indices into them.
    """

    vertices: Floats
    faces: NDArray[np.int64]

    def __post_init__(self) -> None:
        vertices = _points("vertices", self.vertices)
        faces = real_array("faces", self.faces)
        whole = faces.ndim == 2 and faces.shape[1:] == (3,) and len(faces) > 0
        if not whole or (faces != np.floor(faces)).any() or faces.min() < 0 or faces.max() >= len(vertices):
            raise InputError("collision.faces", got=faces.shape, count=len(vertices))
        indices = faces.astype(np.int64)
        indices.flags.writeable = False
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "faces", indices)

    @classmethod
    def from_file(cls, path: str | Path, *, scale: float = 1.0) -> TriangleMesh:
        """The triangles of an STL, OBJ, Collada or MSH file.

        Args:
            path: of the file.
            scale: factor, such as 0.001 for a file in millimetres.

        Raises:
            FileError: no such file, another format, a damaged one.
        """
        surface = mesh.read(path)
        whole = clean_surface(surface.vertices * scale, surface.faces)
        return cls(whole.vertices, whole.faces)


@dataclass(frozen=True, eq=False, slots=True)
class PointCloud:
    """Points of a camera or scanner, each as a ball.

    Attributes:
        points: (k, 3) [m].
        radius: of the ball that each point stands for [m]: half the distance of neighbours leaves no gap.
    """

    points: Floats
    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", _points("points", self.points))
        _require_length("radius", self.radius, zero=True)

    @classmethod
    def from_file(cls, path: str | Path, radius: float, *, scale: float = 1.0) -> PointCloud:
        """The points of an .npy, .ply, .xyz, .txt or .csv file.

        Args:
            path: of the file.
            radius: of the ball that each point stands for [m].
            scale: factor, such as 0.001 for a file in millimetres.

        Raises:
            FileError: no such file, another format, too large, a damaged one.
        """
        return cls(scale * scan.read_points(path), radius)


@dataclass(frozen=True, eq=False, slots=True)
class HeightMap:
    """Ground of varying height, solid from its surface down to `base`.

    Attributes:
        heights: (rows, columns) at a regular grid; rows along y, columns along x, centred on the frame [m].
        size: (x, y) full extent of the grid [m].
        base: height of the underside, below all heights [m].
    """

    heights: Floats
    size: tuple[float, float]
    base: float = 0.0

    def __post_init__(self) -> None:
        heights = frozen(as_batch("heights", self.heights, (), finite=True))
        if heights.ndim != 2 or min(heights.shape) < 2:
            raise InputError("input.shape", name="heights", expected="(rows, columns)", got=heights.shape, hint="")
        require_near("heights", heights)
        base = real_array("base", self.base)
        if base.ndim or not -MOST_LENGTH <= base < heights.min():
            raise InputError("collision.base", base=self.base, least=float(heights.min()))
        _require_lengths("size", self.size, 2)
        object.__setattr__(self, "heights", heights)

    @classmethod
    def from_file(
        cls, path: str | Path, size: tuple[float, float], *, scale: float = 1.0, base: float | None = None
    ) -> HeightMap:
        """The heights of an .npy, .csv or .txt file, or of a grey .png picture.

        Args:
            path: of the file.
            size: (x, y) full extent of the grid [m].
            scale: factor of its numbers, such as 0.001 for millimetres; of a picture the height of white [m].
            base: height of the underside [m]; THICK below the lowest height if None.

        Raises:
            FileError: no such file, another format, too large, a damaged one.
        """
        heights = scale * scan.read_heights(path)
        return cls(heights, size, float(heights.min()) - THICK if base is None else base)


Geometry: TypeAlias = (
    Box | Cylinder | Capsule | Sphere | Mesh | Cone | Plane | ConvexHull | TriangleMesh | PointCloud | HeightMap
)


def checked_geometry(name: str, geometry: object) -> None:
    """Refuse what is no geometry, and lengths that are none.

    Raises:
        InputError: naming the argument and the length.
    """
    match geometry:
        case Box(size=size):
            for value in size:
                _require_length(f"{name}: size", value)
        case Sphere(radius=radius):
            _require_length(f"{name}: radius", radius)
        case Cylinder(radius=radius, length=length) | Capsule(radius=radius, length=length):
            _require_length(f"{name}: radius", radius)
            _require_length(f"{name}: length", length, zero=isinstance(geometry, Capsule))
        case Cone(radius=radius, length=length):
            _require_length(f"{name}: radius", radius)
            _require_length(f"{name}: length", length)
        case Plane() | ConvexHull() | TriangleMesh() | PointCloud() | HeightMap() | Mesh():
            pass
        case _:
            known = "Box, Sphere, Cylinder, Capsule, Cone, Plane, ConvexHull, TriangleMesh, PointCloud, HeightMap, Mesh"
            raise InputError("collision.geometry", name=name, got=type(geometry).__name__, known=known)


def _points(name: str, value: ArrayLike) -> Floats:
    array = as_batch(name, value, (3,), finite=True)
    if array.ndim != 2 or len(array) == 0:
        raise InputError("input.shape", name=name, expected="(k, 3), k > 0", got=array.shape, hint="")
    return frozen(require_near(name, array))


def require_near(name: str, array: Floats) -> Floats:
    """The array itself, if no coordinate is beyond MOST_LENGTH.

    Raises:
        InputError: one is.
    """
    if array.shape == (3,):  # On which NumPy spends ten times as long.
        x, y, z = array.tolist()
        largest = max(abs(x), abs(y), abs(z))
    else:
        largest = float(np.abs(array).max(initial=0.0))
    if largest > MOST_LENGTH:
        raise InputError("collision.far", name=name, value=largest, most=MOST_LENGTH)
    return array


def _require_lengths(name: str, values: object, count: int) -> None:
    lengths = real_array(name, values)  # pyright: ignore[reportArgumentType] what a user gave may be anything
    if lengths.shape != (count,):
        raise InputError("input.shape", name=name, expected=(count,), got=lengths.shape, hint="")
    for value in lengths.tolist():
        _require_length(name, value)


def _require_length(name: str, value: float, *, zero: bool = False) -> None:
    if type(value) is float and 0.0 < value <= MOST_LENGTH:
        return
    number = real_array(name, value)
    if number.ndim or not 0.0 <= number <= MOST_LENGTH or (number == 0.0 and not zero):
        raise InputError("collision.length", name=name, value=value, most=MOST_LENGTH)
