"""What a shape weighs that is filled evenly."""

from __future__ import annotations

import numpy as np

from mafsil.errors import FileError, ModelError
from mafsil.model.link import Box, Capsule, Cylinder, Geometry, Inertial, Mesh, Sphere
from mafsil.model.mass_properties import box, capsule, cylinder, sphere, surface
from mafsil.model.mesh import read


def fill_shape(geometry: Geometry, density: float = 1.0) -> Inertial | None:
    """A shape filled evenly, in its own frame; None of a mesh that cannot be read or is not closed.

    Args:
        geometry: of a link.
        density: [kg/m^3].
    """
    match geometry:
        case Box(size):
            return box(density * float(np.prod(size)), size)
        case Sphere(r):
            return sphere(density * 4 / 3 * np.pi * r**3, r)
        case Cylinder(r, h):
            return cylinder(density * np.pi * r * r * h, r, h)
        case Capsule(r, h):
            return capsule(density * np.pi * r * r * (h + 4 / 3 * r), r, h)
        case Mesh(_, path, scale):
            try:
                inside = None if path is None else read(path).scale(scale)
                return None if inside is None else surface(inside.vertices, inside.faces, density=density)
            except (FileError, ModelError):
                return None
