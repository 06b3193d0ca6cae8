"""One robot of a world by its name; masses that SDFormat lets the shapes give, against libsdformat in Drake."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import FileError, InputError
from mafsil.model import sdf
from mafsil.model.filled_shape import fill_shape
from mafsil.model.link import Capsule
from mafsil.model.mjcf.geom import moments, volume
from tests.model.drake_reader import plant_of
from tests.model.sdf.test_sdf import joint, link

TWO = """<sdf version="1.9"><world name="w"><gravity>0 0 -1.6</gravity>
<model name="left"><pose>0 1 0 0 0 0</pose>{arm}</model><model name="right"><pose>0 -1 0 0 0 0.3</pose>{arm}</model>
<model name="table">{table}</model></world></sdf>""".format(
    arm=link("a")
    + link("b", "<pose>0 0 1 0 0 0</pose>")
    + joint("w", "world", "a", "fixed", "")
    + joint("j", "a", "b"),
    table=link("top"),
)
SHAPES = {
    "box": "<box><size>0.1 0.2 0.3</size></box>",
    "sphere": "<sphere><radius>0.15</radius></sphere>",
    "cylinder": "<cylinder><radius>0.1</radius><length>0.4</length></cylinder>",
    "capsule": "<capsule><radius>0.1</radius><length>0.4</length></capsule>",
}


def collision(name: str, shape: str, density: str = "", pose: str = "0.1 0.2 -0.3 0.3 0.4 -0.5") -> str:
    rho = f"<density>{density}</density>" if density else ""
    return f'<collision name="{name}"><pose>{pose}</pose>{rho}<geometry>{shape}</geometry></collision>'


def automatic(inside: str, inertial: str = "", flag: str = "true") -> str:
    """A body whose mass its shapes give, on a hinge."""
    auto = f'<link name="b"><pose>0 0 1 0 0 0</pose><inertial auto="{flag}">{inertial}</inertial>{inside}</link>'
    model = link("a") + auto + joint("w", "world", "a", "fixed", "") + joint("j", "a", "b")
    return f'<sdf version="1.11"><model name="m">{model}</model></sdf>'


@pytest.mark.parametrize(("name", "y"), [("left", 1.0), ("right", -1.0)])
def test_one_robot_of_a_world(name: str, y: float, tmp_path: Path) -> None:
    (tmp_path / "two.world").write_text(TWO)
    with pytest.raises(FileError, match=r"D1204.*left, right.*model="):
        mf.load(tmp_path / "two.world")
    robot = mf.load(tmp_path / "two.world", model=name)
    assert robot.name == name
    np.testing.assert_allclose(robot.forward_kinematics([0.0])[:3, 3], [0, y, 1], atol=1e-15)
    np.testing.assert_array_equal(robot.mechanism.gravity, [0, 0, -1.6])
    assert sdf.read(TWO, model=name).joint_names == ("j",)


def test_a_model_that_is_not_there_is_said(tmp_path: Path) -> None:
    (tmp_path / "two.world").write_text(TWO)
    with pytest.raises(FileError, match=r"D1215.*'rihgt'.*left, right, table"):
        mf.load(tmp_path / "two.world", model="rihgt")
    assert mf.load(tmp_path / "two.world", model="table").n == 0


def test_only_sdformat_has_several_models(tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text('<robot name="r"><link name="a"/></robot>')
    with pytest.raises(FileError, match="F0142"):
        mf.load(tmp_path / "r.urdf", model="left")
    with pytest.raises(InputError, match="'left'"):
        mf.load("panda", model="left")


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(
    ("densities", "inertial"),
    [(("", ""), ""), (("", "700"), "<density>500</density>"), (("300", ""), "<mass>2.5</mass>")],
)
def test_masses_of_shapes_as_libsdformat_computes_them(shape: str, densities: tuple[str, str], inertial: str) -> None:
    inside = collision("c", SHAPES[shape], densities[0]) + collision("d", SHAPES["box"], densities[1], "0 0 1 0 0 0")
    text = automatic(inside, inertial)
    body = plant_of(text).GetBodyByName("b").default_spatial_inertia()
    about_com = body.Shift(body.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
    ours = sdf.read(text).link("b").inertial
    assert ours is not None
    assert ours.mass == pytest.approx(body.get_mass(), rel=1e-12)
    np.testing.assert_allclose(ours.com, body.get_com(), atol=1e-12)
    np.testing.assert_allclose(ours.inertia, about_com, atol=1e-12)
    one = sdf.read(text.replace('auto="true"', 'auto="1"')).link("b").inertial
    assert one is not None
    assert one.mass == ours.mass


@pytest.mark.parametrize(
    "inside",
    [
        "",
        collision("c", SHAPES["box"]) + collision("d", "<plane/>"),
        collision("c", SHAPES["box"]) + collision("d", "<mesh><uri>model://nowhere/a.stl</uri></mesh>"),
        collision("c", SHAPES["box"], "0"),
    ],
)
def test_shapes_that_are_not_known_leave_no_mass(inside: str) -> None:
    report = sdf.diagnose(automatic(inside))
    assert report.ok, report.lines()
    assert "D1212" in [remark.code for remark in report.warnings]
    assert report.mechanism is not None
    assert report.mechanism.link("b").inertial is None


def test_a_mass_of_zero_or_less_is_an_error() -> None:
    report = sdf.diagnose(automatic(collision("c", SHAPES["box"]), "<mass>-1</mass>"))
    assert [each.code for each in report.errors] == ["I0503"]


def test_a_capsule_of_our_lengths_is_that_of_mujoco_in_half_lengths() -> None:
    radius, length = 0.3, 0.8
    body = fill_shape(Capsule(radius, length), 1000.0)
    assert body is not None
    assert body.mass == pytest.approx(1000.0 * volume("capsule", (radius, length / 2), shell=False), rel=1e-14)
    three = moments("capsule", (radius, length / 2), body.mass, shell=False)
    np.testing.assert_allclose(body.inertia, np.diag(three), rtol=1e-13)
