"""Solids to draw, and the same as the plain data that the scripts of the scene read."""

from __future__ import annotations

import base64
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.messages.visible import visible
from mafsil.model.mesh import Surface

Colour: TypeAlias = tuple[float, float, float, float]


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
