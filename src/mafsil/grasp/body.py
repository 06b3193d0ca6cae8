"""Bodies to be held: of triangles, with where contacts can be and which way is in; or contacts by their equation.

A body's equation gives the normal and the curvature of a contact on it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, as_batch, frozen
from mafsil.errors import InputError
from mafsil.grasp import loops
from mafsil.grasp.contact import Contact, single
from mafsil.grasp.tolerances import ON_MESH, ON_OUTLINE, SAME_PLACE, TYPED
from mafsil.model.mesh import read
from mafsil.model.mesh.surface import clean_surface


@dataclass(frozen=True, eq=False)
class GraspedBody:
    """A closed surface of triangles.

    Attributes:
        corners: (f, 3, 3) corners of the triangles, counter-clockwise from outside [m].
        normals: (f, 3) unit normals into the body.
        areas: (f,) [m^2].
        centre: (3,) centre of mass of the uniform body [m].
        size: half the diagonal of its box [m].
        open_edges: edges that belong to one triangle only; with any, inside and outside are a guess.
    """

    corners: Floats
    normals: Floats
    areas: Floats
    centre: Floats
    size: float
    open_edges: int

    @staticmethod
    def of(given: Any) -> GraspedBody:
        """A body from a mesh file, or from anything with `vertices` and `faces` (a trimesh object, a `Surface`).

        Args:
            given: path of an STL, OBJ or Collada file [m], or the object.

        Raises:
            FileError: the file cannot be read.
            InputError: no triangles with an area.
        """
        if isinstance(given, GraspedBody):
            return given
        surface = read(given) if isinstance(given, str | Path) else given
        if not (hasattr(surface, "vertices") and hasattr(surface, "faces")):
            raise InputError("grasp.no_mesh", got=type(given).__name__)
        return GraspedBody.from_triangles(surface.vertices, surface.faces)

    @staticmethod
    def from_triangles(vertices: ArrayLike, faces: ArrayLike) -> GraspedBody:
        """A body from corners and triangles; turned inside out if its volume is negative.

        Args:
            vertices: (v, 3) [m].
            faces: (f, 3) indices, all counter-clockwise from one side.
        """
        points = as_batch("vertices", vertices, (3,), finite=True)
        indices = np.asarray(faces, np.int64)
        if indices.ndim != 2 or indices.shape[1:] != (3,) or not len(indices):
            raise InputError("input.shape", name="faces", expected="(f, 3)", got=indices.shape, hint="")
        if indices.min() < 0 or indices.max() >= len(points):
            raise InputError("grasp.face_index", got=int(indices.max()), limit=len(points))
        surface = clean_surface(points, indices)
        if not len(surface.faces):
            raise InputError("grasp.no_area")
        return _body(points, surface.faces)

    def contacts(self, count: int, mu: float = 0.0, gamma: float = 0.0, seed: int = 0) -> list[Contact]:
        """Contacts spread evenly over the surface.

        Args:
            count: how many.
            mu, gamma: of all of them.
            seed: of the random places.
        """
        points, face = self.sample(count, np.random.default_rng(seed))
        return [self.contact(p, k, mu, gamma) for p, k in zip(points, face.tolist(), strict=True)]

    def contact(self, point: Floats, face: int, mu: float, gamma: float) -> Contact:
        """A contact at a point of a triangle.

        Args:
            point: (3,) [m].
            face: the triangle.
            mu, gamma: friction.
        """
        return Contact(point, self.normals[face], mu, gamma, name=f"face {face}")

    def sample(self, count: int, rng: np.random.Generator) -> tuple[Floats, NDArray[np.int64]]:
        """Points spread evenly over the surface, and their triangles.

        Args:
            count: how many.
            rng: source of randomness.
        """
        face = rng.choice(len(self.areas), size=count, p=self.areas / self.areas.sum())
        drawn: Floats = rng.uniform(size=(2, count))
        u, v = np.where(drawn.sum(axis=0) > 1, 1 - drawn, drawn)
        a, b, c = np.swapaxes(self.corners[face], 0, 1)
        return a + u[:, None] * (b - a) + v[:, None] * (c - a), face

    def opposite(self, points: Floats, directions: Floats) -> tuple[Floats, NDArray[np.int64]]:
        """How far rays run through the body, and the triangles through which they leave it (-1: none).

        Args:
            points: (r, 3) starts on the surface [m].
            directions: (r, 3) unit vectors into the body.
        """
        distance, face = np.empty(len(points)), np.empty(len(points), np.int64)
        rays = np.ascontiguousarray(points), np.ascontiguousarray(directions)
        loops.ray_loops.exits(self.corners, *rays, TYPED * self.size, distance, face)
        return distance, face

    def distance(self, point: Floats) -> float:
        """Distance of a point from the surface [m].

        Args:
            point: (3,) [m].
        """
        a, b, c = np.swapaxes(self.corners, 0, 1)
        height = np.einsum("fi,fi->f", point - a, self.normals)
        foot = point - height[:, None] * self.normals
        inside = np.ones(len(a), bool)
        edges = np.inf
        for p, q in ((a, b), (b, c), (c, a)):
            inside &= np.einsum("fi,fi->f", np.cross(q - p, foot - p), self.normals) <= 0.0
            edges = min(edges, _to_segments(point, p, q))
        return min(edges, float(np.abs(height[inside]).min(initial=np.inf)))

    def require_on(self, contacts: list[Contact]) -> None:
        """Refuse contacts off the surface.

        Args:
            contacts: in space.

        Raises:
            InputError: one is further off than a ten-thousandth of the size.
        """
        for index, contact in enumerate(contacts):
            off = self.distance(contact.point)
            if off > ON_MESH * self.size:
                raise InputError("grasp.off_surface", index=index, distance=off)


def _body(points: Floats, faces: NDArray[np.int64]) -> GraspedBody:
    corners = points[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    origin = 0.5 * (points.min(axis=0) + points.max(axis=0))
    volumes = np.einsum("fi,fi->f", corners[:, 0] - origin, cross) / 6
    if volumes.sum() < 0:
        corners, cross, volumes = corners[:, ::-1], -cross, -volumes
    length = np.linalg.norm(cross, axis=1)
    size = 0.5 * float(np.linalg.norm(np.ptp(points[faces].reshape(-1, 3), axis=0)))
    opened = _open_edges(points, faces, size)
    if opened or volumes.sum() <= TYPED * size**3:
        centre = np.average(corners.mean(axis=1), axis=0, weights=length)
    else:
        centre = np.average(0.75 * corners.mean(axis=1) + 0.25 * origin, axis=0, weights=volumes)
    return GraspedBody(
        frozen(np.ascontiguousarray(corners)), frozen(-cross / length[:, None]), frozen(0.5 * length), frozen(centre),
        size, opened,
    )  # fmt: skip


def _open_edges(points: Floats, faces: NDArray[np.int64], size: float) -> int:
    """Edges of one triangle only, corners at one place counting as one (STL repeats them)."""
    _, same = np.unique(np.round(points / (SAME_PLACE * size)), axis=0, return_inverse=True)
    joined = same.reshape(-1)[faces]
    ends = np.sort(np.concatenate([joined[:, [0, 1]], joined[:, [1, 2]], joined[:, [2, 0]]]), axis=1)
    _, uses = np.unique(ends[ends[:, 0] != ends[:, 1]], axis=0, return_counts=True)
    return int((uses == 1).sum())


def _to_segments(point: Floats, p: Floats, q: Floats) -> float:
    edge = q - p
    along = np.clip(np.einsum("fi,fi->f", point - p, edge) / np.einsum("fi,fi->f", edge, edge), 0.0, 1.0)
    return float(np.linalg.norm(p + along[:, None] * edge - point, axis=1).min())


def level_set_curvature(gradient: ArrayLike, hessian: ArrayLike) -> Floats:
    """Curvature of the surface F = const of a body {F <= const}, positive where it bulges [1/m].

    P H P / |g|,  P = I - g g' / |g|^2

    Args:
        gradient: (d,) of F at the point, pointing out of the body.
        hessian: (d, d) of F at the point.

    Returns:
        (d, d) tensor across the normal; in the plane its only eigenvalue that is not zero is the curvature.
    """
    g = as_batch("gradient", gradient, (np.size(gradient),), finite=True)
    H = as_batch("hessian", hessian, (len(g), len(g)), finite=True)
    size = float(np.linalg.norm(g))
    if not size > 0:
        raise InputError("grasp.zero_normal", name="gradient", point=str(g.tolist()))
    P = np.eye(len(g)) - np.outer(g, g) / size**2
    return P @ (0.5 * (H + H.T)) @ P / size


def ellipsoid_contact(
    axes: ArrayLike, point: ArrayLike, mu: float = 0.0, gamma: float = 0.0,
    finger_curvature: float | ArrayLike = float("inf"), name: str = "",
) -> Contact:  # fmt: skip
    """A contact on an ellipsoid (or ellipse) about the origin, with its normal and curvature.

    Args:
        axes: (d,) half axes [m]; all equal for a sphere or circle.
        point: (d,) on the surface [m].
        mu, gamma: coefficients.
        finger_curvature: of the finger [1/m].
        name: for reports.

    Raises:
        InputError: axes not positive, or a point off the surface.
    """
    p = single("point", point, (np.size(point),))
    a = single("axes", axes, p.shape)
    if not (a > 0).all():
        raise InputError("input.positive", name="axes", value=float(a.min()))
    level = float(((p / a) ** 2).sum())
    if abs(level - 1.0) > ON_OUTLINE:
        raise InputError("grasp.off_ellipsoid", level=level)
    gradient, hessian = 2 * p / a**2, np.diag(2 / a**2)
    K = level_set_curvature(gradient, hessian)
    bend = float(np.trace(K)) if len(p) == 2 else K
    return Contact(p, -gradient, mu, gamma, curvature=bend, finger_curvature=finger_curvature, name=name)
