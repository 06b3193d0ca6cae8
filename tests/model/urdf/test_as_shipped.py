"""URDF files as makers ship them: left-over xacro, broken shapes, doubled elements, odd limits, other suffixes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import FileError
from mafsil.model import urdf
from mafsil.model.loading import load_mechanism
from mafsil.model.xacro.vocabulary import ROWS

BODY = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
LIMIT = '<limit lower="-1" upper="2" effort="5" velocity="2"/>'


def robot(inside: str = "", joint: str = LIMIT, top: str = "", kind: str = "revolute") -> str:
    return f"""<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{top}
<link name="a"/><link name="b">{BODY}{inside}</link>
<joint name="j" type="{kind}"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>{joint}</joint>
</robot>"""


def codes(text: str) -> set[str]:
    """Codes of the warnings, which all stand among the remarks of the mechanism."""
    mechanism = urdf.read(text)
    assert mechanism.n <= 1
    assert len(mechanism.links) == 2
    assert [remark.sentence("ar") for remark in mechanism.provenance.remarks]
    return {remark.code for remark in mechanism.provenance.remarks}


@pytest.mark.parametrize("suffix", ["urdf", "xml", "xacro", "txt", "model"])
def test_the_root_element_says_the_format(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"arm.{suffix}"
    path.write_text(f"<?xml version='1.0'?>\n<!-- an arm -->\n{robot()}")
    assert load_mechanism(path).joint_names == ("j",)
    assert mf.lint(path).ok
    path.write_text("<mujoco><worldbody><body><joint name='k'/><geom size='.1'/></body></worldbody></mujoco>")
    assert load_mechanism(path).joint_names == ("k",)
    path.write_text("<html/>")
    with pytest.raises(FileError):
        load_mechanism(path)


def test_left_over_definitions_are_ignored() -> None:
    top = '<xacro:property name="x" value="1"/><xacro:macro name="m" params="y"><link name="${y}"/></xacro:macro>'
    assert codes(robot(top=top)) == {"X1122"}


@pytest.mark.parametrize(
    ("shape", "code"),
    [
        ('<geometry><box size="0 1 1"/></geometry>', "G0603"),
        ('<geometry><cylinder radius="1" length="-1"/></geometry>', "G0603"),
        ('<geometry><sphere radius="big"/></geometry>', "N0202"),
        ('<geometry><box size="1 1"/></geometry>', "N0205"),
        ('<geometry><mesh filename="x.stl" scale="0 1 1"/></geometry>', "G0604"),
        ('<geometry><mesh filename="package://../../x.stl"/></geometry>', "G0610"),
        ('<geometry><mesh/></geometry>', "N0201"),
        ('<origin xyz="1 nan 0"/><geometry><sphere radius="1"/></geometry>', "N0203"),
        ('<origin rpy="1 2"/><geometry><sphere radius="1"/></geometry>', "N0205"),
        ("", "F0135"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("tag", ["visual", "collision"])
def test_broken_shapes_are_left_out(shape: str, code: str, tag: str) -> None:
    good = "<geometry><sphere radius='1'/></geometry>"
    text = robot(f"<{tag}>{shape}</{tag}><{tag}>{good}</{tag}>")
    assert codes(text) == {code}
    link = urdf.read(text).links[1]
    assert len(link.visuals if tag == "visual" else link.collisions) == 1


def test_a_broken_colour_leaves_the_shape() -> None:
    text = robot(
        '<visual><geometry><sphere radius="1"/></geometry><material name="m"><color rgba="red"/></material></visual>'
    )
    assert codes(text) == {"N0205"}
    (shape,) = urdf.read(text).links[1].visuals
    assert shape.colour is None


def test_numbers_of_the_mechanics_still_stop_it() -> None:
    with pytest.raises(FileError, match="N0202"):
        urdf.read(robot("<visual/>").replace('mass value="1"', 'mass value="heavy"'))


def test_of_doubled_elements_the_first_counts() -> None:
    text = robot(joint='<axis xyz="1 0 0"/>' + LIMIT + LIMIT.replace('"2"', '"7"', 1))
    assert codes(text) == {"F0134"}
    joint = urdf.read(text).joints[0]
    np.testing.assert_array_equal(joint.axis, [0, 0, 1])
    assert joint.limits.upper == 2.0
    twice = robot().replace("<inertia ", '<inertia ixx="2" ixy="0" ixz="0" iyy="2" iyz="0" izz="2"/><inertia ', 1)
    assert codes(twice) == {"F0134"}
    assert urdf.read(twice).links[1].inertial.inertia[0, 0] == 2.0


def test_limits_are_exchanged_only_around_zero() -> None:
    around = robot(joint='<limit lower="2" upper="-1" effort="5" velocity="2"/>')
    assert codes(around) == {"J0428"}
    limits = urdf.read(around).joints[0].limits
    assert (limits.lower, limits.upper) == (-1.0, 2.0)
    with pytest.raises(FileError, match="J0412"):
        urdf.read(robot(joint='<limit lower="2" upper="1" effort="5" velocity="2"/>'))
    with pytest.raises(FileError, match="J0412"):
        urdf.read(robot(joint='<limit lower="1" effort="5" velocity="2"/>'))


@pytest.mark.parametrize("kind", ["floating", "planar"])
def test_a_floating_base_is_fixed(kind: str) -> None:
    assert codes(robot(kind=kind, joint="")) == {"J0402"}
    behind = robot().replace(
        "</robot>",
        f'<link name="c"/><joint name="k" type="{kind}"><parent link="b"/><child link="c"/></joint></robot>',
    )
    with pytest.raises(FileError, match="J0403"):
        urdf.read(behind)


def test_an_axis_without_numbers_is_the_default_of_urdf() -> None:
    text = robot().replace('<axis xyz="0 0 1"/>', "<axis/>")
    assert codes(text) == {"J0406"}
    np.testing.assert_array_equal(urdf.read(text).joints[0].axis, [1, 0, 0])


def test_calls_of_macros_in_a_finished_file_are_ignored() -> None:
    top = '<xacro:cable_guide side="left"><origin/></xacro:cable_guide>'
    assert codes(robot(top=top)) == {"X1122"}
    text, changes = urdf.repair(robot(top=top))
    assert len(changes) == 1
    assert "xacro:cable" not in text
    assert codes(robot(top='<xacro:cable_guide side="${1 + 1}"/>')) == {"X1122"}


MISSPELT = (
    '<xacro:inclde filename="parts.xacro"/>',
    '<xacro:proprety name="x" value="1"/>',
    '<xacro:arg name="x" default="1"/><xacro:cable_guide/>',
    "<xacro:Macro name='m'/>",
)


@pytest.mark.parametrize("top", MISSPELT)
def test_a_misspelt_element_of_xacro_is_no_rest(top: str) -> None:
    (error,) = urdf.diagnose(robot(top=top)).errors
    assert error.code == "X1101"


@pytest.mark.parametrize("place", ROWS)
def test_misspelt_attributes_of_xacro(place: str) -> None:
    for name in ROWS[place].words:
        twin = name[1] + name[0] + name[2:]
        used = '<xacro:property name="p" value="1"/><material name="${p}"/>'
        text = robot(top=f'{used}<xacro:{place} {twin}="1" name="q" value="1" filename="f"/>')
        said = [d for d in urdf.diagnose(text) if d.code == "F0139" and d.details["attribute"] == twin]
        assert [name in str(d.details["known"]).split(", ") for d in said] == [True], twin
