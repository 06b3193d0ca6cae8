"""Xacro: every rule of the language, hostile files, and the files of rtb-data against the xacro of ROS."""

from __future__ import annotations

import math
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.cli.main import main
from mafsil.errors import FileError, InputError
from mafsil.model import urdf
from mafsil.model.diagnostics import Severity
from mafsil.model.loading import RobotFile, load_mechanism
from tests.budget import within
from tests.model.xacro.hostile_xacros import CASES, HEAD, Case


def links(body: str, **arguments: str) -> list[str]:
    """Names of the links of a xacro after `a`, which is in every file: each is reported to hang on nothing."""
    report = urdf.file_reader(arguments=arguments).diagnose(f"{HEAD}{body}\n</robot>")
    assert {d.code for d in report.errors} <= {"S0308"}, report.lines()
    return [str(d.details["second"]) for d in report.errors]


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("1 + 2 * 3", "7"), ("2 ** 0.5", repr(2**0.5)), ("7 // 2", "3"), ("-7 % 3", "2"), ("1 < 2 <= 2", "True"),
        ("'b' if 1 > 2 else 'c'", "c"), ("not False and 1", "1"), ("[10, 20, 30][-1]", "30"),
        ("radians(180) == pi", "True"), ("math.cos(0)", "1.0"), ("degrees(pi)", "180.0"), ("max(1, 2, 3)", "3"),
        ("[2*i for i in range(3)][2]", "4"), ("sum([i for i in [1, 2, 3] if i != 2])", "4"),
        ("'a_b'.split('_')[1]", "b"),
        ("dict(x=3).x", "3"), ("len('abc')", "3"), ("'x' in ['x', 'y']", "True"), ("str(1) + 'm'", "1m"),
        ("'%s_%d' % ('l', 3)", "l_3"), ("python.round(2.567, 1)", "2.6"), ("xacro.tokenize('p;q')[1]", "q"),
        ("[x + y for x, y in zip([1], [2])][0]", "3"), ("abs(-3)", "3"),
        ("python.set('left right'.split()) - python.set(['left'])", "{'right'}"),
        ("python.set([1, 2]) | python.set([3])", "{1, 2, 3}"), ("python.set([1, 2]) ^ python.set([2, 3])", "{1, 3}"),
        ("len(python.set([1, 2]).intersection([2]))", "1"), ("python.frozenset([1]) <= python.set([1, 2])", "True"),
        ("python.set(['b', 'a', 'c'])", "{'a', 'b', 'c'}"), ("list(python.set(['b', 'a']))", "['a', 'b']"),
        ("python.isinstance('a', (python.int, python.str))", "True"), ("python.isinstance(True, python.int)", "True"),
        ("python.isinstance(1, python.str)", "False"), ("python.type('a') is python.str", "True"),
        ("python.type(1) == float", "False"), ("python.issubclass(python.bool, python.int)", "True"),
        ("python.complex(1, 2) * python.complex(0, 1)", "(-2+1j)"), ("python.complex(1, 2).imag", "2.0"),
        ("python.hash(5)", "5"), ("[1, 2, 3, 4][python.slice(1, 3)]", "[2, 3]"), ("python.hash('a')", "3904355907"),
    ],
)  # fmt: skip
def test_expressions(expression: str, expected: str) -> None:
    text = expression.replace("<", "&lt;").replace('"', "&quot;")
    assert links(f'<link name="${{{text}}}"/>') == [expected]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ('<xacro:property name="x" value="1"/><link name="n${x}"/>', ["n1"]),
        # evaluated at first use, so the order of definitions does not matter
        ('<xacro:property name="y" value="${2*x}"/><xacro:property name="x" value="4"/><link name="n${y}"/>', ["n8"]),
        ('<xacro:property name="x" value="1"/><xacro:property name="y" value="${x}" lazy_eval="false"/>'
         '<xacro:property name="x" value="2"/><link name="n${y}"/>', ["n1"]),
        ('<xacro:property name="x" default="1"/><xacro:property name="x" default="2"/><link name="n${x}"/>', ["n1"]),
        ('<xacro:property name="x"><link name="p"/><link name="q"/></xacro:property>'
         '<xacro:insert_block name="x"/>', ["p", "q"]),
        ('<xacro:property name="x" value="1"/><xacro:macro name="m"><xacro:property name="x" value="2"/>'
         '<link name="in${x}"/></xacro:macro><xacro:m/><link name="out${x}"/>', ["in2", "out1"]),
        ('<xacro:macro name="m"><xacro:property name="x" value="2" scope="parent"/></xacro:macro><xacro:m/>'
         '<link name="n${x}"/>', ["n2"]),
        ('<xacro:macro name="o"><xacro:macro name="m"><xacro:property name="x" value="3" scope="global"/></xacro:macro>'
         '<xacro:m/></xacro:macro><xacro:o/><link name="n${x}"/>', ["n3"]),
        ('<xacro:property name="x" value="true"/><xacro:if value="${x}"><link name="yes"/></xacro:if>'
         '<xacro:unless value="${x}"><link name="no"/></xacro:unless>', ["yes"]),
        ('<xacro:macro name="m" params="n k:=3 t:=\'a b\'"><link name="${n}${k}${t}"/></xacro:macro><xacro:m n="x"/>',
         ["x3a b"]),
        ('<xacro:property name="n" value="up"/><xacro:macro name="m" params="n:=^ o:=^|low"><link name="${n}${o}"/>'
         '</xacro:macro><xacro:m/>', ["uplow"]),
        ('<xacro:macro name="m" params="*one **many"><xacro:insert_block name="one"/><xacro:insert_block name="many"/>'
         '</xacro:macro><xacro:m><link name="p"/><many><link name="q"/><link name="s"/></many></xacro:m>',
         ["p", "q", "s"]),
        ('<xacro:macro name="m" params="n"><link name="l${n}"/><xacro:if value="${n}">'
         '<xacro:m n="${n - 1}"/></xacro:if></xacro:macro><xacro:m n="2"/>', ["l2", "l1", "l0"]),
        ('<xacro:macro name="xacro:m"><link name="p"/></xacro:macro><xacro:call macro="${\'m\'}"/>', ["p"]),
        ('<xacro:arg name="side" default="left"/><link name="$(arg side)_arm"/>', ["left_arm"]),
        ('<link name="$(optenv MAFSIL_IS_NOT_SET b)"/>', ["b"]),
        ('<link name="$(eval 1 + 2)"/>', ["3"]),
        ('<link name="$${x}"/>', ["${x}"]),
        ('<xacro:element xacro:name="link" name="p"/>', ["p"]),
        ('<link><xacro:attribute name="name" value="p"/></link>', ["p"]),
    ],
)  # fmt: skip
def test_rules(body: str, expected: list[str]) -> None:
    assert links(body) == expected


@pytest.mark.row("F2")
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_hostile_files_are_refused_in_time(case: Case) -> None:
    report = within(3.0, lambda: urdf.diagnose(case.data))
    found = [d for d in report if d.code == case.code]
    assert found, report.lines()
    assert found[0].line == case.line
    assert found[0].line_of_text("en") != found[0].line_of_text("ar")
    assert report.ok == (found[0].severity is not Severity.ERROR)


ARM = """<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="prefix" default=""/>
  <xacro:include filename="$(find my_arm)/urdf/parts/segment.xacro" ns="parts"/>
  <xacro:property name="config" value="${xacro.load_yaml('$(find my_arm)/config/arm.yaml')}"/>
  <link name="$(arg prefix)base"/>
  <xacro:property name="parent" value="$(arg prefix)base"/>
  <xacro:parts.segment name="$(arg prefix)l1" parent="${parent}" length="${config['lengths'][0]}"
      range="${config.limits.shoulder}"/>
  <gazebo><plugin filename="$(find gazebo_that_is_not_here)/x.so"/></gazebo>
</robot>
"""
SEGMENT = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="segment" params="name parent length range">
    <link name="${name}">
      <visual><geometry><mesh filename="package://meshes_that_are_not_here/a.stl"/></geometry></visual>
    </link>
    <joint name="${name}_joint" type="revolute">
      <parent link="${parent}"/><child link="${name}"/><origin xyz="${length} 0 0" rpy="0 0 ${pi/2}"/>
      <axis xyz="0 0 1"/><limit lower="${-range}" upper="${range}" effort="1" velocity="1"/>
    </joint>
  </xacro:macro>
</robot>
"""
YAML = "# the arm\nlengths: [0.25, 0.5]\nlimits:\n  shoulder: !degrees 90.0\n"


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    """A package whose folder is called otherwise than itself."""
    package = tmp_path / "arm_checkout"
    (package / "urdf" / "parts").mkdir(parents=True)
    (package / "config").mkdir()
    (package / "package.xml").write_text("<package><name>my_arm</name></package>")
    (package / "urdf" / "arm.urdf.xacro").write_text(ARM)
    (package / "urdf" / "parts" / "segment.xacro").write_text(SEGMENT)
    (package / "config" / "arm.yaml").write_text(YAML)
    return package / "urdf" / "arm.urdf.xacro"


def test_packages_includes_yaml_and_arguments(arm: Path) -> None:
    mechanism = load_mechanism(arm, xacro_args={"prefix": "left_"})
    (joint,) = mechanism.joints
    assert (joint.name, joint.parent, joint.child) == ("left_l1_joint", "left_base", "left_l1")
    np.testing.assert_array_equal(joint.T_pj[:3, 3], [0.25, 0, 0])
    assert joint.limits.upper == pytest.approx(math.pi / 2, abs=1e-15)
    assert mf.load(RobotFile(str(arm), {"prefix": "left_"})).joint_names == ("left_l1_joint",)


def test_places_of_faults_in_included_files(arm: Path) -> None:
    part = arm.parent / "parts" / "segment.xacro"
    part.write_text(SEGMENT.replace("${-range}", "${-rage}"))
    with pytest.raises(FileError, match=r"urdf/parts/segment.xacro:8:\d+: X1107 'rage'.*range"):
        mf.load(arm)
    (arm.parents[1] / "config" / "arm.yaml").write_text("a: !secret 1\n")
    with pytest.raises(FileError, match=r"X1119 config/arm.yaml, line 1"):
        mf.load(arm)


def test_arguments_of_the_root_element() -> None:
    text = '<robot name="$(arg n)" xmlns:xacro="x">%s<link name="a"/></robot>'
    assert urdf.read(text % '<xacro:arg name="n" default="ur"/>').name == "ur"
    (error,) = urdf.diagnose(text % "").errors
    assert (error.code, error.line) == ("X1110", 1)


def test_a_name_with_blanks_that_stands_nowhere_in_the_file() -> None:
    text = '<robot name="r" xmlns:xacro="x"><xacro:property name="x" value="b"/><link name=" ${x}"/></robot>'
    assert "S0302" in urdf.diagnose(text).codes


def test_a_circle_of_includes_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "a.xacro"
    file.write_text(f'{HEAD}<xacro:include filename="a.xacro"/></robot>')
    with pytest.raises(FileError, match="X1114"):
        mf.load(file)


def test_arguments_that_nobody_takes(arm: Path, tmp_path: Path) -> None:
    assert "X1121" in [r.code for r in load_mechanism(arm, xacro_args={"no": 1}).provenance.remarks]
    plain = tmp_path / "plain.urdf"
    plain.write_text('<robot name="r"><link name="a"/></robot>')
    with pytest.raises(FileError, match="F0138"):
        load_mechanism(plain, xacro_args={"no": 1})
    with pytest.raises(InputError, match="takes no arguments"):
        load_mechanism("puma560", xacro_args={"no": 1})


def test_on_the_command_line(arm: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show", str(arm), "--xacro-arg", "prefix:=right_"]) == 0
    assert "right_l1_joint" in capsys.readouterr().out
    assert main(["show", str(arm), "--xacro-arg", "prefix"]) == 2


def test_expanded_elements_offer_no_repairs(arm: Path) -> None:
    part = arm.parent / "parts" / "segment.xacro"
    part.write_text(SEGMENT.replace('xyz="0 0 1"', 'xyz="0 0 2"'))
    report = mf.lint(arm)
    found = [d for d in report if d.code == "J0405"]
    assert found[0].file == "urdf/parts/segment.xacro"
    assert all(d.repair is None for d in report)
    with pytest.raises(InputError):
        mf.repair(arm)


def test_the_same_as_the_xacro_of_ros(arm: Path) -> None:
    xacro = pytest.importorskip("xacro")
    body = '<link name="l${1e-3 * 7}"/><xacro:property name="x" value="0.1"/><link name="m${3 * x}"/>'
    text = f"{HEAD}{body}</robot>"
    file = arm.parent / "other.xacro"
    file.write_text(text)
    document = xacro.process_file(str(file)).documentElement
    names = [e.getAttribute("name") for e in document.getElementsByTagName("link")]
    assert names[1:] == links(body)


def test_a_name_that_python_lacks_is_said_with_what_looks_like_it() -> None:
    (error,) = urdf.diagnose(f'{HEAD}<link name="${{python.st([1])}}"/></robot>').errors
    assert error.details == {"name": "python.st", "close": "set, str"}
    for wrong in ("python.isinstance(1, 2)", "python.hash([1])", "set([1])", "python.type(1)(2).__class__"):
        assert not urdf.diagnose(f'{HEAD}<link name="${{{wrong}}}"/></robot>').ok


_TWICE = '<xacro:m n="${n-1}"/>' * 2
_BODY = f'{{}}<xacro:if value="${{n>0}}">{_TWICE}</xacro:if>'
_MACRO = f'<xacro:macro name="m" params="n">{_BODY}</xacro:macro><xacro:m n="40"/>'
_MANY = " ".join(f"k{k}" for k in range(90))
BOMBS = {
    "two calls": _MACRO.replace("{}", ""),
    "many attributes": _MACRO.replace("{}", "<a " + " ".join(f'k{k}="x"' for k in range(90)) + "/>"),
    "many parameters": f'<xacro:macro name="m" params="{_MANY.replace(" ", ":=1 ")}:=1"/>' + "<xacro:m/>" * 20_000,
    "large texts": "<link name=\"${sorted([('a'*100000) for i in range(9000)])[0][0]}\"/>",
    "wide texts": "<link name=\"${len([('\U0001f600'*100000) for i in range(9000)])}\"/>",
    "text of a list": "<xacro:property name='x' value=\"${'a'*100000}\"/><link name='${len(str([x]*1000))}'/>",
    "rounding": "<link name='${round(5, -100000000)}'/>",
    "padding": "<link name=\"${'%(a)100000000d' % dict(a=1)}\"/>",
    "padding behind brackets": "<link name=\"${'%(a(b)c)100000000d' % dict(a=1)}\"/>",
    "columns": f"<xacro:property name='p' value='${{list(range(90000))}}'/><link name='${{zip(p{',p' * 20})}}'/>",
    "unused expressions": "".join(f"<a b='${{0 and ({k}{'+1' * 1900})}}'/>" for k in range(1500)),
    "large integers": "<link name='${len([2**4000+i for i in range(90000)])}'/>",
}


@pytest.mark.row("F1")
@pytest.mark.parametrize("name", BOMBS)
def test_bombs_take_two_seconds_and_256_megabytes_at_most(name: str) -> None:
    text = f"{HEAD}{BOMBS[name]}</robot>".encode()
    report = within(2.0, lambda: urdf.diagnose(text))
    assert {"X1113", "X1106"} & set(report.codes)
    if "calls" in name or "many" in name or "expressions" in name:
        return  # nothing large is made; the tracing takes longer
    tracemalloc.start()
    urdf.diagnose(text)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 256e6
