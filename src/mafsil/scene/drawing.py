"""A robot's appearance as solids of the page, and the space that they take.

Solids to draw, and the same as the plain data that the scripts of the scene read.
"""

from __future__ import annotations

import base64
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, replace
from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, PoseMatrix
from mafsil.geometry import rotation
from mafsil.messages.visible import visible
from mafsil.model import Box, Capsule, Cylinder, JointKind, Mechanism, Sphere
from mafsil.model.appearance import THIN, Piece, Pieces, corners, part_of, pieces, primitives, reach, stand
from mafsil.model.mesh import Surface

Colour: TypeAlias = tuple[float, float, float, float]
SLIDING = (JointKind.PRISMATIC, JointKind.CYLINDRICAL)
MOST_COLOURS = 16
"""A surface with more colours keeps the commonest; its other triangles get the nearest of these."""


class Drawing:
    """The drawing of a mechanism; files are read once.

    Attributes:
        mechanism: the robot.
        pieces: of each link, in the order of `mechanism.links`.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.pieces = pieces(mechanism)

    def bodies(self, floor: float, poses: PoseMatrix) -> tuple[Body, ...]:
        """What to draw of each link; a base above the floor gets a column, unless the robot reaches through it.

        Args:
            floor: its height [m].
            poses: (L, 4, 4) of the links in {s}.
        """
        solids = [tuple(solid for piece in of_link for solid in _solids(piece)) for of_link in self.pieces]
        to_base = cast("Floats", np.linalg.inv(poses[0]))
        column = primitives(stand(self.mechanism, self.lowest(poses, base=True), floor))
        if not self._reaches(column, poses):
            solids[0] += tuple(solid for one in column for solid in _solids(replace(one, T_lg=to_base @ one.T_lg)))
        named = enumerate(zip(self.mechanism.link_names, solids, strict=True))
        return tuple(Body(name, of_link, self.rod(k)) for k, (name, of_link) in named)

    def _reaches(self, column: Pieces, poses: PoseMatrix) -> bool:
        """Whether a piece that moves is among others, which are given in {s}, as far as boxes around them tell."""
        boxes, heads = [corners(one) for one in column], part_of(self.mechanism)
        moving = (
            corners(piece) @ poses[k, :3, :3].T + poses[k, :3, 3]
            for k, of_link in enumerate(self.pieces)
            for piece in of_link
            if heads[k] != 0
        )
        return any(np.all((a.min(0) < b.max(0)) & (b.min(0) < a.max(0))) for a in moving for b in boxes)

    def rod(self, k: int) -> Rod | None:
        """The rod on which a link slides in the one before, where both are drawn of simple shapes; else None.

        Args:
            k: place of the link.
        """
        names, joints = self.mechanism.link_names, (*self.mechanism.joints, *self.mechanism.loops)
        joint = next((one for one in joints if one.child == names[k] and one.kind in SLIDING), None)
        if joint is None:
            return None
        parent = names.index(joint.parent)
        drawn = (*self.pieces[parent], *self.pieces[k])
        if any(isinstance(piece.geometry, Surface) for piece in drawn):
            return None
        round_ones = [one.geometry.radius for one in drawn if isinstance(one.geometry, Capsule | Cylinder)]
        begin = _on_axis(self.pieces[parent], joint.T_pj[:3, 3], joint.T_pj[:3, :3] @ joint.axis)
        end = _on_axis(self.pieces[k], np.zeros(3), joint.axis)
        return Rod(parent, begin, end, 0.7 * min(round_ones, default=THIN * reach(self.mechanism)))

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


def _on_axis(pieces: Pieces, origin: Floats, axis: Floats) -> tuple[float, float, float]:
    """The point of an axis that is nearest to its origin and inside one of some solids; the origin where none is."""
    places = [np.inf]
    for piece in pieces:
        corner = corners(piece)
        low, high = corner.min(axis=0), corner.max(axis=0)
        middle, half = (low + high) / 2.0, float(np.abs(corner - (low + high) / 2.0).dot(np.abs(axis)).max())
        along = float((middle - origin) @ axis)
        aside = float(np.linalg.norm(middle - origin - along * axis))
        thick = float(np.sort((high - low) / 2.0)[0])
        if aside <= thick:
            places.append(float(np.clip(0.0, along - max(half - thick, 0.0), along + max(half - thick, 0.0))))
    nearest = min(places, key=abs)
    x, y, z = (origin + (nearest if np.isfinite(nearest) else 0.0) * axis).tolist()
    return x, y, z


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
class Rod:
    """A rod between a body and the one that it slides in, as long as it has come out.

    Attributes:
        parent: place of the other body in the list.
        place: where the rod begins in the other [m].
        end: where it ends in its own [m].
        radius: of the rod [m].
    """

    parent: int
    place: tuple[float, float, float]
    end: tuple[float, float, float]
    radius: float


@dataclass(frozen=True, eq=False, slots=True)
class Body:
    """Solids that move together, and the rod on which they slide."""

    name: str
    solids: tuple[Solid, ...]
    rod: Rod | None = None


def as_data(bodies: Iterable[Body]) -> dict[str, Any]:
    """`surfaces` and `bodies` for the scripts; equal surfaces stand there once."""
    found = tuple(bodies)
    solids = [solid for body in found for solid in body.solids]
    surfaces = list({id(s.surface): s.surface for s in solids if s.surface is not None}.values())
    places = {id(surface): k for k, surface in enumerate(surfaces)}

    def drawn(solid: Solid) -> dict[str, Any]:
        form = {"kind": solid.kind, "size": solid.size, "pose": solid.pose, "colour": solid.colour}
        return form if solid.surface is None else form | {"surface": places[id(solid.surface)]}

    def whole(body: Body) -> dict[str, Any]:
        form: dict[str, Any] = {"name": visible(body.name), "shapes": [drawn(solid) for solid in body.solids]}
        return form if body.rod is None else form | {"rod": asdict(body.rod)}

    return {"surfaces": [_surface(surface) for surface in surfaces], "bodies": [whole(body) for body in found]}


def pack_floats(array: Floats) -> str:
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
