"""Pictures of performance: each is drawn, in both languages, the same numbers give the same bytes."""

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.figures.singular_surfaces import save_singular_surfaces
from mafsil.figures.velocity_ellipses import save_ellipsoid, save_planar_ellipses
from mafsil.figures.workspace_slice import save_workspace
from mafsil.performance import workspace_map


@pytest.mark.capability("05-89")
@pytest.mark.parametrize("language", ["en", "ar"])
def test_pictures_are_drawn(tmp_path, language):
    arm, puma = mf.load("planar2r"), mf.load("puma560")
    save_planar_ellipses(arm, [[0.3, 0.5], [1.2, 1.9], [0.0, 0.0]], tmp_path / "1.png", language=language)
    save_ellipsoid(puma, [0.3, 0.6, -0.2, 0.4, 0.7, 0.1], tmp_path / "2.png", language=language)
    radial = workspace_map(puma, 60_000, view="radial", dexterous=True)
    save_workspace(radial, tmp_path / "3.png", language=language)
    save_singular_surfaces(puma, tmp_path / "4.png", language=language)
    for k in range(1, 5):
        assert (tmp_path / f"{k}.png").stat().st_size > 10_000


def test_same_numbers_same_bytes(tmp_path):
    for name in ("a.svg", "b.svg"):
        save_planar_ellipses(mf.load("planar2r"), np.array([[0.3, 0.5]]), tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


def test_a_spatial_map_is_not_drawn(tmp_path):
    with pytest.raises(InputError, match="spatial"):
        save_workspace(workspace_map(mf.load("planar3r"), 1000), tmp_path / "x.png")
