"""Repairs touch what was asked, leave no choice, and never take a freedom from a robot."""

from __future__ import annotations

from pathlib import Path

import pytest

import mafsil as mf
from mafsil.cli.main import main
from mafsil.errors import FileError, InputError

TRIANGLE = '<inertia ixx="5" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
"""A warning, I0506, with a repair."""
BODY = f"<inertial><mass value='1'/>{TRIANGLE}</inertial>"


def robot(kind: str = "revolute", extra: str = "", link: str = "b") -> str:
    return f"""<robot name="r">
<link name="a"/>
<link name="b">{BODY}{extra}</link>
<joint name="j" type="{kind}">
<parent link="a"/><child link="{link}"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="5" velocity="2"/>
</joint>
</robot>
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "robot.urdf"


@pytest.mark.parametrize(
    ("word", "meant"),
    [("revolut", "revolute"), ("prizmatic", "prismatic"), ("Continous", "continuous"), ("hinge", "revolute")],
)
def test_a_misspelt_type_takes_the_nearest_word(file: Path, word: str, meant: str) -> None:
    file.write_text(robot(word))
    fixed = file.with_name("fixed.urdf")
    assert main(["lint", str(file), "--fix", str(fixed)]) == 0
    assert f'type="{meant}"' in fixed.read_text()
    assert mf.load(fixed).n == 1
    with pytest.raises(FileError, match=f'set type="{meant}"'):
        mf.load(file)


@pytest.mark.parametrize("word", ["wobbly", "", "floatin", "6dof"])
def test_a_type_that_nobody_can_guess_stays(file: Path, word: str) -> None:
    file.write_text(robot(word))
    fixed = file.with_name("fixed.urdf")
    assert main(["lint", str(file), "--fix", str(fixed)]) == 1
    assert fixed.read_text() == file.read_text()
    with pytest.raises(FileError) as refusal:
        mf.load(file)
    assert "fixed" not in str(refusal.value).partition("[")[2]


def test_only_errors_are_touched(file: Path) -> None:
    file.write_text(robot("revolut"))
    text, changes = mf.repair(file)
    assert [change.diagnostic.code for change in changes] == ["J0401"]
    assert TRIANGLE in text
    text, changes = mf.repair(file, only=["I0506"])
    assert [change.diagnostic.code for change in changes] == ["I0506"]
    assert 'type="revolut"' in text


def test_a_warning_is_mended_when_its_code_is_asked_for(file: Path) -> None:
    file.write_text(robot())
    assert mf.repair(file) == (robot(), ())
    text, changes = mf.repair(file, only=["I0506"])
    assert [change.diagnostic.code for change in changes] == ["I0506"]
    assert TRIANGLE not in text
    with pytest.raises(InputError, match="I0506"):
        mf.repair(file, only=["I05O6"])


def test_a_guess_is_made_only_on_request_and_told(file: Path) -> None:
    file.write_text(robot().replace('effort="5"', 'effort="-5"'))
    fixed = file.with_name("fixed.urdf")
    assert main(["lint", str(file), "--fix", str(fixed)]) == 1
    assert 'effort="-5"' in fixed.read_text()
    assert main(["lint", str(file), "--fix", str(fixed), "--only", "J0417"]) == 1
    assert 'effort="5"' in fixed.read_text()


@pytest.mark.parametrize(
    "text",
    [
        robot(link="c"),
        robot().replace('<child link="b"/>', ""),
        robot().replace('<axis xyz="0 0 1"/>', '<axis xyz="0 0 0"/>'),
        robot().replace("</robot>", '<link name="lonely"/></robot>'),
        robot().replace('<parent link="a"/>', '<parent link="b"/>'),
    ],
)
def test_no_repair_takes_a_joint_or_a_link(file: Path, text: str) -> None:
    file.write_text(text)
    mended, changes = mf.repair(file)
    assert (mended, changes) == (text, ())
    assert main(["lint", str(file), "--fix", str(file.with_name("fixed.urdf"))]) == 1
