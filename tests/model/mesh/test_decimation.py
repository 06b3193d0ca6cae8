"""Fewer triangles, the same surface."""

import numpy as np
import pytest

from mafsil.model import Box, Capsule, Cylinder, Sphere
from mafsil.model.mesh import Surface
from mafsil.model.mesh.decimation import decimate
from mafsil.model.mesh.surface import triangles


def area_and_volume(surface):
    a, b, c = np.moveaxis(surface.vertices[surface.faces], 1, 0)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2, np.einsum("ij,ij->", a, np.cross(b, c)) / 6


def finer(surface, times):
    for _ in range(times):
        a, b, c = np.moveaxis(surface.vertices[surface.faces], 1, 0)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        corners = np.concatenate([np.stack(t, 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
        colours = None if surface.colours is None else np.tile(surface.colours, (4, 1))
        surface = Surface(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3), colours)
    return surface


@pytest.mark.parametrize(
    ("primitive", "area", "volume"),
    [
        (Box((0.3, 0.2, 0.5)), 2 * (0.06 + 0.15 + 0.1), 0.03),
        (Cylinder(0.1, 0.4), 2 * np.pi * 0.1 * 0.5, np.pi * 0.01 * 0.4),
        (Capsule(0.1, 0.4), 2 * np.pi * 0.1 * 0.4 + 4 * np.pi * 0.01, np.pi * 0.01 * 0.4 + 4 / 3 * np.pi * 1e-3),
        (Sphere(0.2), 4 * np.pi * 0.04, 4 / 3 * np.pi * 0.008),
    ],
)
def test_primitives_are_closed_and_face_outwards(primitive, area, volume):
    found = area_and_volume(triangles(primitive))
    # Corners lie on the round surface: the polyhedron is inside it, by no more than the arcs of 15 degrees cut off.
    assert 0.96 * area <= found[0] <= area * (1 + 1e-9)
    assert 0.96 * volume <= found[1] <= volume * (1 + 1e-9)


@pytest.mark.parametrize("primitive", [Box((0.3, 0.2, 0.5)), Cylinder(0.1, 0.4), Sphere(0.2)])
def test_shape_is_kept(primitive):
    whole = finer(triangles(primitive), 3)
    few = decimate(whole, 600)
    assert len(few.faces) <= 600 < len(whole.faces)
    np.testing.assert_allclose(area_and_volume(few), area_and_volume(whole), rtol=0.04)
    np.testing.assert_allclose(few.vertices.max(axis=0), whole.vertices.max(axis=0), atol=0.02)


def test_corners_of_a_box_stay_sharp():
    few = decimate(finer(triangles(Box((2.0, 2.0, 2.0))), 5), 300)
    assert np.abs(few.vertices).max() == pytest.approx(1.0, abs=1e-9)
    corners = np.abs(few.vertices).min(axis=1) > 1 - 1e-9
    assert corners.sum() == 8


def test_colours_follow_their_triangles():
    whole = triangles(Box((2.0, 2.0, 2.0)))
    x = whole.vertices[whole.faces].mean(axis=1)[:, :1]
    whole = finer(Surface(whole.vertices, whole.faces, np.hstack([x > 0.9, x < 0.9, x * 0, x * 0 + 1.0])), 4)
    few = decimate(whole, 400)
    assert few.colours is not None
    right = few.vertices[few.faces].mean(axis=1)[:, 0] > 0.95
    np.testing.assert_array_equal(few.colours[right][:, 0], 1.0)


def test_few_triangles_stay_as_they_are():
    whole = triangles(Sphere(1.0))
    assert decimate(whole, len(whole.faces)) is whole


def test_a_point_cloud_of_one_cell_does_not_fail():
    tiny = Surface(np.random.default_rng(0).normal(size=(300, 3)) * 1e-200, np.arange(300).reshape(-1, 3))
    assert np.isfinite(decimate(tiny, 10).vertices).all()
