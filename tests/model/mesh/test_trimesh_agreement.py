"""Surfaces, what they weigh and their hulls equal trimesh's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mafsil.model import mesh
from mafsil.model.mass_properties import surface as solid
from mafsil.model.mesh import Surface
from mafsil.model.mjcf.mesh_asset import MeshInertia, hull_surface, mesh_mass

trimesh = pytest.importorskip("trimesh")

SHAPES = {
    "ball": lambda: trimesh.creation.icosphere(3, radius=0.2),
    "bracket": lambda: trimesh.util.concatenate(
        [trimesh.creation.box((0.1, 0.2, 0.3)), trimesh.creation.box((0.3, 0.1, 0.1)).apply_translation((0.5, 0, 0.1))]
    ),
    "ring": lambda: trimesh.creation.annulus(0.05, 0.1, 0.03),
    "cone": lambda: trimesh.creation.cone(0.1, 0.4, sections=40),
}


@pytest.fixture(params=SHAPES)
def shape(request: pytest.FixtureRequest) -> trimesh.Trimesh:
    T = trimesh.transformations.rotation_matrix(0.7, (1, 2, 3))
    T[:3, 3] = (0.3, -0.1, 0.2)
    return SHAPES[request.param]().apply_transform(T)


@pytest.mark.parametrize("form", ["stl", "obj"])
def test_files_give_the_same_triangles(shape: trimesh.Trimesh, form: str, tmp_path: Path) -> None:
    shape.export(tmp_path / f"a.{form}")
    own = mesh.read(tmp_path / f"a.{form}")
    other = trimesh.load(tmp_path / f"a.{form}", process=False)
    np.testing.assert_array_equal(own.vertices[own.faces], np.asarray(other.vertices)[other.faces])


def test_mass_properties(shape: trimesh.Trimesh) -> None:
    shape.density = 700.0
    own = solid(np.asarray(shape.vertices), np.asarray(shape.faces), density=700.0)
    np.testing.assert_allclose(own.mass, shape.mass, rtol=1e-12)
    np.testing.assert_allclose(own.com, shape.center_mass, atol=1e-13)
    np.testing.assert_allclose(own.inertia, shape.moment_inertia, atol=1e-12 * np.trace(shape.moment_inertia))
    surface = Surface(np.asarray(shape.vertices), np.asarray(shape.faces))
    exact = mesh_mass(surface, MeshInertia.EXACT)
    np.testing.assert_allclose(exact.volume, shape.volume, rtol=1e-12)
    np.testing.assert_allclose(700.0 * exact.inertia, own.inertia, atol=1e-12 * np.trace(own.inertia))


def test_hulls(shape: trimesh.Trimesh) -> None:
    points = np.asarray(shape.vertices)
    own, other = hull_surface(points), shape.convex_hull
    assert set(np.unique(own.faces)) >= {int(np.abs(points - p).sum(1).argmin()) for p in np.asarray(other.vertices)}
    np.testing.assert_allclose(mesh_mass(own, MeshInertia.EXACT).volume, other.volume, rtol=1e-12)
    np.testing.assert_allclose(mesh_mass(own, MeshInertia.CONVEX).com, other.center_mass, atol=1e-12)
