"""Solids to draw, and the same as the plain data that the scripts of the scene read."""

from __future__ import annotations

import base64
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
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
