"""Row R21, covers of meshes, at the size of a pull request."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from mafsil.collision import Checker
from tests.reliability import mesh_cover


def robot(name):
    """A file of example-robot-data with its checker."""
    pytest.importorskip("cmeel")
    found = [file for file in mesh_cover.files() if file.stem == name]
    if not found:
        pytest.skip("example-robot-data is not installed")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return found[0], Checker(str(found[0]), samples=0)


@pytest.mark.row("R21")
@pytest.mark.capability("11-39")
def test_bodies_hold_every_vertex_that_pinocchio_reads():
    file, checker = robot("ur5_robot")
    counts = mesh_cover.covered(checker, mesh_cover.vertices_by_link(file))
    assert not any(value for name, value in counts.items() if name.startswith("bad_"))
    assert counts["meshes"] == 7
    assert counts["vertices"] > 1_000


@pytest.mark.capability("11-39")
def test_a_vertex_outside_would_be_seen():
    file, checker = robot("ur5_robot")
    theirs = mesh_cover.vertices_by_link(file)
    moved = {link: [vertices + np.array([1e-4, 0, 0]) for vertices in meshes] for link, meshes in theirs.items()}
    assert mesh_cover.covered(checker, moved)["bad_vertex"] > 7
    smaller = {link: [0.9 * vertices for vertices in meshes] for link, meshes in theirs.items()}
    assert mesh_cover.covered(checker, smaller)["bad_thickened"] > 0
    assert mesh_cover.covered(checker, {"no such link": theirs["forearm_link"]})["bad_link"] == 1
