"""What to draw of a robot: its own shapes where they are found, thinned out to a budget, else tubes and housings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeAlias

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.errors import FileError
from mafsil.model.link import Link
from mafsil.model.mechanism import Mechanism
from mafsil.model.mesh import Surface, read
from mafsil.model.mesh.decimation import decimate
from mafsil.model.shape import SHELL, Box, Capsule, Colour, Cylinder, Mesh, Shape, Sphere
from mafsil.model.skeleton import outline, tip_tubes, with_skeleton

MOST_TRIANGLES = 60_000
MOST_BYTES = 256 << 20
"""Mesh files of one robot beyond this size in all are not opened."""
FEWEST_TRIANGLES = 60
"""A surface is not thinned out below this."""
_SHARE = 0.7
"""Each surface gets its triangles in proportion to this power of what it has: small ones keep more of theirs."""
Drawable: TypeAlias = Box | Cylinder | Capsule | Sphere | Surface


@dataclass(frozen=True, eq=False, slots=True)
class Piece:
    """Something to draw in the frame of its link.

    Attributes:
        geometry: a primitive centred on its frame, or triangles.
        T_lg: (4, 4) pose of its frame in the link's.
        colour: red, green, blue, opacity in 0..1; the triangles' own colours go before it.
    """

    geometry: Drawable
    T_lg: PoseMatrix
    colour: Colour = SHELL


Pieces: TypeAlias = tuple[Piece, ...]


def pieces(mechanism: Mechanism, most_triangles: int = MOST_TRIANGLES) -> tuple[Pieces, ...]:
    """What to draw of each link, in the order of `mechanism.links`.

    The shapes of the description: what is meant to be seen, else what collides. If less than half of the moving parts
    have any that can be drawn, all links get the tubes and housings of `with_skeleton` instead; those of robots of the
    library the outline that they collide with.

    Args:
        mechanism: any robot.
        most_triangles: of all surfaces in files together; beyond it they are simplified.
    """
    files = _Files(most_triangles)
    of_outline = outline(mechanism)
    if of_outline is not None and not _shown_enough(mechanism, [files.seen(link) for link in mechanism.links]):
        own = [primitives(link.visuals) for link in of_outline.links]
        own[mechanism.link_names.index(mechanism.tip)] += primitives(tip_tubes(mechanism))
        return tuple(own)
    own = [files.of_link(link) for link in mechanism.links]
    if not _shown_enough(mechanism, own):
        bare = replace(mechanism, links=tuple(replace(link, visuals=()) for link in mechanism.links))
        return tuple(primitives(link.visuals) for link in with_skeleton(bare).links)
    own = list(files.within_budget(own))
    own[mechanism.link_names.index(mechanism.tip)] += primitives(tip_tubes(mechanism))
    return tuple(own)


def part_of(mechanism: Mechanism) -> tuple[int, ...]:
    """For each link the first link of the rigid part that it belongs to; links joined by fixed joints are one part."""
    heads = [0]
    for k, (joint, parent) in enumerate(zip(mechanism.joints, mechanism.parents, strict=True), start=1):
        heads.append(k if joint.moves else heads[parent])
    return tuple(heads)


def corners(piece: Piece) -> Floats:
    """(8, 3) corners of a box around a piece, in the frame of its link [m]."""
    match piece.geometry:
        case Box(size=size):
            half = np.array(size) / 2
        case Sphere(radius=radius):
            half = np.full(3, radius)
        case Cylinder(radius=radius, length=length):
            half = np.array([radius, radius, length / 2])
        case Capsule(radius=radius, length=length):
            half = np.array([radius, radius, length / 2 + radius])
        case Surface(vertices=vertices, faces=faces):
            used = vertices[faces.reshape(-1)]
            low, high = used.min(axis=0), used.max(axis=0)
            return _box(low, high) @ piece.T_lg[:3, :3].T + piece.T_lg[:3, 3]
    return _box(-half, half) @ piece.T_lg[:3, :3].T + piece.T_lg[:3, 3]


def _box(low: Floats, high: Floats) -> Floats:
    picks = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, -1).T
    return np.where(picks == 0, low, high)


def _shown_enough(mechanism: Mechanism, own: list[Pieces]) -> bool:
    heads = part_of(mechanism)
    moving = set(heads) - {0}
    shown = {heads[k] for k, of_link in enumerate(own) if of_link} & moving
    return bool(moving) and 2 * len(shown) >= len(moving)


def primitives(shapes: tuple[Shape, ...]) -> Pieces:
    """Those of the shapes that are no files."""
    return tuple(
        Piece(shape.geometry, shape.T_lg, shape.colour or SHELL)
        for shape in shapes
        if not isinstance(shape.geometry, Mesh)
    )


@dataclass(slots=True)
class _Files:
    """Reads each mesh file once and keeps no more triangles of it than may be drawn in all."""

    most: int
    bytes_left: int = MOST_BYTES
    surfaces: dict[tuple[Path, tuple[float, float, float]], Surface | None] = field(
        default_factory=dict[tuple[Path, tuple[float, float, float]], Surface | None]
    )

    def of_link(self, link: Link) -> Pieces:
        """The first of visuals and collision shapes that can be drawn whole, else what there is of the visuals."""
        found = [tuple(self.of_shapes(shapes)) for shapes in (link.visuals, link.collisions)]
        for given, drawn in zip((link.visuals, link.collisions), found, strict=True):
            if given and len(drawn) == len(given):
                return drawn
        return found[0] or found[1]

    def seen(self, link: Link) -> Pieces:
        """What there is of the visuals."""
        return tuple(self.of_shapes(link.visuals))

    def of_shapes(self, shapes: tuple[Shape, ...]) -> Iterator[Piece]:
        for shape in shapes:
            if isinstance(shape.geometry, Mesh):
                surface = self.surface(shape.geometry)
                if surface is not None:
                    yield Piece(surface, shape.T_lg, shape.colour or SHELL)
            else:
                yield Piece(shape.geometry, shape.T_lg, shape.colour or SHELL)

    def surface(self, mesh: Mesh) -> Surface | None:
        """Its triangles; None if the file is not found, not readable or empty."""
        if mesh.path is None:
            return None
        key = (mesh.path, mesh.scale)
        if key not in self.surfaces:
            self.surfaces[key] = self._read(mesh.path, mesh.scale)
        return self.surfaces[key]

    def _read(self, path: Path, scale: tuple[float, float, float]) -> Surface | None:
        try:
            self.bytes_left -= path.stat().st_size
            whole = read(path) if self.bytes_left >= 0 else None
        except (FileError, OSError):
            return None
        if whole is None or not len(whole.faces) or not np.abs(whole.vertices[whole.faces]).max() < 1e6:
            return None
        return decimate(whole.scale(scale), self.most)

    def within_budget(self, own: list[Pieces]) -> Iterator[Pieces]:
        """The same pieces with surfaces thinned out so that all together keep to the budget."""
        drawn = [p.geometry for of_link in own for p in of_link if isinstance(p.geometry, Surface)]
        total = sum(len(surface.faces) for surface in drawn)
        if total <= self.most:
            yield from own
            return
        allowed = _allowances([len(surface.faces) for surface in drawn], self.most)
        fewer = {id(s): s if len(s.faces) <= a else decimate(s, a) for s, a in zip(drawn, allowed, strict=True)}
        for of_link in own:
            yield tuple(
                replace(p, geometry=fewer[id(p.geometry)]) if isinstance(p.geometry, Surface) else p for p in of_link
            )


def _allowances(counts: list[int], most: int) -> list[int]:
    """How many triangles each surface may keep."""
    weights = np.array(counts, dtype=np.float64) ** _SHARE
    shares = most * weights / weights.sum()
    return [max(FEWEST_TRIANGLES, int(share)) for share in shares]
