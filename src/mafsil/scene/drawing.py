"""A robot's appearance as solids of the page, and the space that they take.

Solids to draw, and the same as the plain data that the scripts of the scene read.
"""

from __future__ import annotations

import base64
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, PoseMatrix
from mafsil.geometry import rotation
from mafsil.model import Box, Capsule, Cylinder, Mechanism, Sphere
from mafsil.model.appearance import Piece, corners, part_of, pieces, primitives
from mafsil.model.mesh import Surface
from mafsil.model.skeleton import reach, stand

Colour: TypeAlias = tuple[float, float, float, float]
MOST_COLOURS = 16
"""A surface with more colours keeps the commonest; its other triangles get the nearest of these."""


class Drawing:
    """What is drawn of a mechanism; files are read once.

    Attributes:
        mechanism: the robot.
        pieces: of each link, in the order of `mechanism.links`.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.pieces = pieces(mechanism)

    def bodies(self, floor: float, poses: PoseMatrix) -> tuple[Body, ...]:
        """What to draw of each link; a base that hangs above the floor gets a column.

        Args:
            floor: its height [m].
            poses: (L, 4, 4) of the links in {s}.
        """
        solids = [tuple(solid for piece in of_link for solid in _solids(piece)) for of_link in self.pieces]
        to_base = cast("Floats", np.linalg.inv(poses[0]))
        for piece in primitives(stand(self.mechanism, self.lowest(poses, base=True), floor)):
            solids[0] += tuple(_solids(replace(piece, T_lg=to_base @ piece.T_lg)))
        names = self.mechanism.link_names
        return tuple(Body(name, of_link) for name, of_link in zip(names, solids, strict=True))

    def lowest(self, poses: PoseMatrix, *, base: bool = False) -> float:
        """Height of the lowest point of the robot, or of the part of it that never moves [m]."""
        return min(float(self.mechanism.T_sb[2, 3]), float(self.box(poses, base=base)[:, 2].min(initial=np.inf)))

    def box(self, poses: PoseMatrix, *, base: bool = False) -> Floats:
        """(k, 3) corners of boxes around the pieces, or around those that never move, in {s} [m]."""
        heads = part_of(self.mechanism)
        found = [
            corners(piece) @ poses[k, :3, :3].T + poses[k, :3, 3]
            for k, of_link in enumerate(self.pieces)
            for piece in of_link
            if not base or heads[k] == 0
        ]
        return np.concatenate([np.zeros((0, 3)), *found])

    def extent(self, points: Floats, poses: PoseMatrix) -> tuple[tuple[float, float, float], float, float]:
        """Middle of the scene, its radius, and the height of the floor.

        Args:
            points: (k, 3) that must be seen, in {s} [m].
            poses: (L, 4, 4) of the links in {s} in one configuration.

        Returns:
            (3,) centre, radius and floor [m].
        """
        every = np.vstack([points, self.mechanism.T_sb[:3, 3], self.box(poses)])
        low, high = every.min(axis=0), every.max(axis=0)
        centre = (low + high) / 2
        size = max(float(np.linalg.norm(high - low)) * 0.62, 0.45 * reach(self.mechanism), 1e-3)
        return (float(centre[0]), float(centre[1]), float(centre[2])), size, float(low[2])


def compact(T: Floats) -> Floats:
    """Position and quaternion (w, x, y, z) of poses.

    Args:
        T: (*batch, 4, 4).

    Returns:
        (*batch, 7).
    """
    return np.concatenate([T[..., :3, 3], rotation.to_quaternion(T[..., :3, :3])], axis=-1)


def _solids(piece: Piece) -> Iterator[Solid]:
    pose = tuple(float(x) for x in compact(piece.T_lg))
    match piece.geometry:
        case Box(size=size):
            yield Solid("box", size, pose, piece.colour)
        case Sphere(radius=radius):
            yield Solid("sphere", (radius,), pose, piece.colour)
        case Cylinder(radius=radius, length=length):
            yield Solid("cylinder", (radius, length), pose, piece.colour)
        case Capsule(radius=radius, length=length):
            yield Solid("capsule", (radius, length), pose, piece.colour)
        case Surface() as surface:
            for colour, part in _by_colour(surface, piece.colour):
                yield Solid("surface", (), pose, colour, part)


def _by_colour(surface: Surface, default: Colour) -> Iterator[tuple[Colour, Surface]]:
    """Parts of one colour each."""
    if surface.colours is None:
        yield default, surface
        return
    steps = np.round(np.clip(surface.colours, 0.0, 1.0) * 32).astype(np.int64)
    kinds, of_face = np.unique(steps, axis=0, return_inverse=True)
    of_face = of_face.reshape(-1)
    common = [kind for kind, _ in Counter(of_face.tolist()).most_common(MOST_COLOURS)]
    away = np.abs(kinds[:, None] - kinds[common][None]).sum(axis=2)
    nearest = np.array(common)[away.argmin(axis=1)][of_face]
    for kind in common:
        r, g, b, a = (float(x) / 32 for x in kinds[kind])
        yield (r, g, b, a), Surface(surface.vertices, surface.faces[nearest == kind])


@dataclass(frozen=True, eq=False, slots=True)
class Solid:
    """Something to draw.

    Attributes:
        kind: box, sphere, cylinder, capsule, cone or surface.
        size: edge lengths; radius; radius and length (a capsule's without its ends) [m].
        pose: position [m] and quaternion (w, x, y, z) in the frame of its body.
        colour: red, green, blue, opacity in 0..1.
        surface: the triangles of a surface.
    """

    kind: str
    size: tuple[float, ...]
    pose: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    colour: Colour = (0.8, 0.8, 0.8, 1.0)
    surface: Surface | None = None


@dataclass(frozen=True, eq=False, slots=True)
class Body:
    """Solids that move together."""

    name: str
    solids: tuple[Solid, ...]


def as_data(bodies: Iterable[Body]) -> dict[str, Any]:
    """`surfaces` and `bodies` for the scripts; equal surfaces stand there once."""
    found = tuple(bodies)
    solids = [solid for body in found for solid in body.solids]
    surfaces = list({id(s.surface): s.surface for s in solids if s.surface is not None}.values())
    places = {id(surface): k for k, surface in enumerate(surfaces)}

    def drawn(solid: Solid) -> dict[str, Any]:
        form = {"kind": solid.kind, "size": solid.size, "pose": solid.pose, "colour": solid.colour}
        return form if solid.surface is None else form | {"surface": places[id(solid.surface)]}

    return {
        "surfaces": [_surface(surface) for surface in surfaces],
        "bodies": [{"shapes": [drawn(solid) for solid in body.solids]} for body in found],
    }


def packed(array: Floats) -> str:
    """Little-endian float32, base64."""
    return _encode(np.ascontiguousarray(array, dtype="<f4"))


def _surface(surface: Surface) -> dict[str, Any]:
    """Triangles with corners rounded to 1/65535 of their box: two bytes a coordinate, two or four an index."""
    used, faces = np.unique(surface.faces, return_inverse=True)
    points = surface.vertices[used]
    low, high = points.min(axis=0), points.max(axis=0)
    step: Floats = np.maximum((high - low) / 65535, 1e-12)
    wide = len(used) > 65536
    return {
        "low": low.tolist(),
        "step": step.tolist(),
        "points": _encode(cast("Floats", np.round((points - low) / step)).astype("<u2")),
        "faces": _encode(faces.reshape(-1).astype("<u4" if wide else "<u2")),
        "wide": wide,
    }


def _encode(array: NDArray[Any]) -> str:
    return base64.b64encode(array.tobytes()).decode("ascii")
