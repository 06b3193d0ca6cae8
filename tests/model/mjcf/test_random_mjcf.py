"""Random MJCF files against MuJoCo's own compiler: poses, mass matrix and bias at random states."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mafsil.model import mjcf
from tests.corpus.mujoco_file import MuJoCoFile
from tests.model.mjcf.random_mjcf import RandomMjcf
from tests.sizes import few

mujoco = pytest.importorskip("mujoco")


TURNED = 1e-7
"""MuJoCo turns the inertia of a mesh to its principal axes with an error of some 1e-8 rad."""


@pytest.mark.row("R4")
@pytest.mark.parametrize("meshes", [False, True])
@pytest.mark.parametrize("seed", few(range(15), 4))
def test_random_files_are_read_as_mujoco_reads_them(seed: int, meshes: bool, tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text(RandomMjcf(seed, tmp_path, meshes=meshes).text())
    mechanism = mjcf.read(path)
    error, where = MuJoCoFile(path).difference(mechanism, 2)
    assert error < (TURNED if meshes else 1e-9), where
    assert any("M0722" in note and "cube" in note for note in mechanism.provenance.notes)


@pytest.mark.parametrize("rule", ["convex", "exact", "legacy", "shell"])
@pytest.mark.parametrize("seed", range(3))
def test_meshes_weigh_by_all_four_rules(rule: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform(-0.2, 0.2, (4, 3)).astype(np.float32)
    swap = np.linalg.det(points[1:] - points[0]) < 0
    faces = "0 1 2  0 3 1  0 2 3  1 3 2" if swap else "0 2 1  0 1 3  0 3 2  1 2 3"
    vertices = " ".join(f"{x:.9g}" for x in points.ravel())
    scale = " ".join(f"{x:.4f}" for x in rng.uniform(0.5, 1.5, 3))
    mesh = f'<mesh name="m" inertia="{rule}" vertex="{vertices}" face="{faces}" refpos="0.1 0.2 0.3" scale="{scale}"/>'
    body = '<body name="b"><joint/><geom type="mesh" mesh="m" pos="1 2 3" density="900"/></body>'
    text = f"<mujoco><asset>{mesh}</asset><worldbody>{body}</worldbody></mujoco>"
    model = mujoco.MjModel.from_xml_string(text)
    inertial = mjcf.read(text).link("b").inertial
    assert inertial is not None
    np.testing.assert_allclose(inertial.mass, model.body_mass[1], rtol=1e-12)
    np.testing.assert_allclose(inertial.com, model.body_ipos[1], rtol=1e-12)
    np.testing.assert_allclose(np.linalg.eigvalsh(inertial.inertia), np.sort(model.body_inertia[1]), rtol=1e-9)


@pytest.mark.parametrize(("kind", "size"), [("sphere", "0.1"), ("capsule", "0.1 0.2"), ("cylinder", "0.1 0.2"),
                                            ("box", "0.1 0.2 0.3"), ("ellipsoid", "0.1 0.2 0.3")])  # fmt: skip
def test_shells_weigh_as_in_mujoco(kind: str, size: str) -> None:
    geom = f'<geom type="{kind}" size="{size}" shellinertia="true" density="20"/>'
    text = f'<mujoco><worldbody><body name="b"><joint/>{geom}</body></worldbody></mujoco>'
    model = mujoco.MjModel.from_xml_string(text)
    inertial = mjcf.read(text).link("b").inertial
    assert inertial is not None
    rounding = 1e-7 if kind == "ellipsoid" else 1e-12  # the difference of two solids a micrometre apart
    np.testing.assert_allclose(inertial.mass, model.body_mass[1], rtol=1e-12)
    np.testing.assert_allclose(np.sort(np.diag(inertial.inertia)), np.sort(model.body_inertia[1]), rtol=rounding)
