"""What a mesh weighs by the four rules of MuJoCo, and the box and the frame that it is fitted by."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, frozen
from mafsil.errors import ModelError
from mafsil.model.mesh.surface import Faces, Surface

SMALLEST = 1e-15
"""Volume [m^3] or area [m^2] from which a mesh counts, as in MuJoCo."""


class MeshInertia(Enum):
    """How a surface of triangles stands for matter."""

    CONVEX = "convex"
    EXACT = "exact"
    LEGACY = "legacy"
    SHELL = "shell"


@dataclass(frozen=True, eq=False, slots=True)
class MeshMass:
    """Mass properties of a mesh of unit density, per volume or, for a shell, per area.

    Attributes:
        volume: [m^3], or area [m^2] of a shell.
        com: (3,) centre of mass [m].
        inertia: (3, 3) about it, of density one.
        vertices: (k, 3) points, for the box that encloses them.
    """

    volume: float
    com: Floats
    inertia: Floats
    vertices: Floats

    @property
    def frame(self) -> PoseMatrix:
        """(4, 4) centre of mass and principal axes, the largest moment first."""
        T = np.eye(4)
        _, axes = np.linalg.eigh(self.inertia)
        axes = axes[:, ::-1]
        T[:3, :3] = axes * np.array([1.0, 1.0, np.sign(np.linalg.det(axes))])
        T[:3, 3] = self.com
        return frozen(T)

    @property
    def box(self) -> Floats:
        """(3,) half lengths of the box with the same inertia, along the principal axes."""
        moments = np.linalg.eigvalsh(self.inertia)[::-1]
        return np.sqrt(np.maximum(6 * (moments.sum() - 2 * moments) / self.volume, 0.0)) / 2

    def bounds(self) -> tuple[Floats, Floats]:
        """(3,) middle and half lengths, along the principal axes, of the box that encloses the points."""
        T = self.frame
        inside = (self.vertices - T[:3, 3]) @ T[:3, :3]
        low, high = inside.min(axis=0), inside.max(axis=0)
        return (low + high) / 2, (high - low) / 2


def mesh_mass(surface: Surface, rule: MeshInertia) -> MeshMass:
    """Mass properties of a surface for density one.

    1. The middle of the faces is the tip of a pyramid over every face; by the rule a pyramid counts with its sign, as
       if it were positive, or its face alone counts.
    2. The pyramids give volume and centre of mass; about that centre new pyramids give the second moments. By the rule
       `legacy` that is another volume, and the second one counts.

    Args:
        surface: triangles in the frame of the mesh.
        rule: `exact` wants a closed surface; `convex` takes the hull.

    Raises:
        ModelError: no area or volume, inside out, faces that contradict each other.
    """
    faces = _hull(surface.vertices) if rule is MeshInertia.CONVEX else surface.faces
    if rule is MeshInertia.EXACT:
        _require_consistent(surface)
    points = surface.vertices
    corners = points[surface.faces]
    areas, middles, _ = _faces(corners)
    if areas.sum() < SMALLEST:
        raise ModelError("mesh.no_area", area=float(areas.sum()))
    centre = areas @ middles / areas.sum()
    weights, tops = _pyramids(points[faces] - centre, rule)
    volume = float(weights.sum())
    if volume < SMALLEST:
        raise ModelError("mesh.no_volume", volume=volume)
    com = centre + weights @ tops * (3 / 4) / volume
    about = points[faces] - com
    weights, _ = _pyramids(about, rule)
    second = _second_moments(about, weights, 12 if rule is MeshInertia.SHELL else 20)
    inertia = np.trace(second) * np.eye(3) - second
    return MeshMass(float(weights.sum()), frozen(com), frozen((inertia + inertia.T) / 2), points)


def _faces(corners: Floats) -> tuple[Floats, Floats, Floats]:
    """(f,) areas, (f, 3) middles, (f, 3) normals of twice the area."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.linalg.norm(normals, axis=1) / 2, corners.mean(axis=1), normals


def _pyramids(corners: Floats, rule: MeshInertia) -> tuple[Floats, Floats]:
    """(f,) what each pyramid over a face from the origin counts, and the middle of its face."""
    areas, middles, normals = _faces(corners)
    if rule is MeshInertia.SHELL:
        return areas, middles
    volumes = np.einsum("fi,fi->f", middles, normals) / 6
    return np.abs(volumes) if rule is MeshInertia.LEGACY else volumes, middles


def _second_moments(corners: Floats, weights: Floats, divisor: int) -> Floats:
    """(3, 3) integral of r r' over pyramids from the origin, or over their faces."""
    total = corners.sum(axis=1)
    products = np.einsum("fki,fkj,f->ij", corners, corners, weights) + np.einsum("fi,fj,f->ij", total, total, weights)
    return products / divisor


def _hull(points: Floats) -> Faces:
    """(f, 3) triangles of the convex hull, seen from outside counter-clockwise."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points, qhull_options="Qt")
    except (QhullError, ValueError):
        raise ModelError("mesh.no_volume", volume=0.0) from None
    faces = hull.simplices.astype(np.int64)
    corners = points[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inwards = np.einsum("fi,fi->f", normals, hull.equations[:, :3]) < 0
    faces[inwards] = faces[inwards][:, ::-1]
    return faces


def hull_surface(points: Floats) -> Surface:
    """The convex hull of points as a surface: a mesh without faces."""
    return Surface(points, _hull(points))


def _require_consistent(surface: Surface) -> None:
    """No edge is run through twice in one direction."""
    _, same = np.unique(surface.vertices, axis=0, return_inverse=True)
    corners = same.ravel()[surface.faces]
    ways = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    count = len(np.unique(ways, axis=0))
    if count < len(ways):
        raise ModelError("mesh.orientation", edges=len(ways) - count)
