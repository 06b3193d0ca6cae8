"""`lint` calls an error what urdfdom refuses, and its repair makes a file that urdfdom takes."""

from __future__ import annotations

from pathlib import Path

import pinocchio as pin
import pytest

import mafsil as mf
from mafsil.cli.main import main
from mafsil.model.limits import Limits
from tests.model.urdf.real_files import robots

REFUSALS = {"P0916", "P0917"}
ROBOT = """<robot name="r"><link name="a"/><link name="b"/>
<joint name="j" type="{kind}"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
  {limit}
</joint></robot>"""
LIMITS = {
    "none": "",
    "empty": "<limit/>",
    "no effort": '<limit lower="-1" upper="1" velocity="2"/>',
    "no velocity": '<limit lower="-1" upper="1" effort="2"/>',
    "whole": '<limit lower="-1" upper="1" effort="2" velocity="2"/>',
    "no range": '<limit effort="2" velocity="2"/>',
}


def taken_by_urdfdom(text: str) -> bool:
    try:
        pin.buildModelFromXML(text)
    except ValueError:
        return False
    return True


@pytest.mark.parametrize("kind", ["revolute", "continuous", "prismatic", "fixed"])
@pytest.mark.parametrize("limit", LIMITS)
def test_errors_are_what_urdfdom_refuses(tmp_path: Path, kind: str, limit: str) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(ROBOT.format(kind=kind, limit=LIMITS[limit]))
    report = mf.lint(path)
    refusals = [item for item in report.errors if item.code in REFUSALS]
    assert bool(refusals) != taken_by_urdfdom(path.read_text())
    assert report.ok, "our own reader takes it"
    assert all(item.line > 1 and item.repair is not None for item in refusals)
    codes = {item.code for item in refusals}
    if not codes:
        return
    assert "Pinocchio" in refusals[0].sentence("en")
    assert "Pinocchio" in refusals[0].sentence("ar")
    before = mf.load(path).limits
    text, _ = mf.mend(path, only=codes)
    assert taken_by_urdfdom(text)
    again = mf.urdf.read(text)
    for name in ("lower", "upper", "velocity", "effort"):
        assert getattr(again.limits, name).tolist() == getattr(before, name).tolist()


@pytest.mark.parametrize("path", robots(), ids=lambda path: path.stem)
def test_published_files(path: Path) -> None:
    refused = REFUSALS.intersection(mf.lint(path).codes)
    if refused:
        assert not taken_by_urdfdom(path.read_text())
    elif not mf.lint(path).errors:
        assert taken_by_urdfdom(path.read_text())


def test_the_command_refuses_and_fixes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, fixed = tmp_path / "arm.urdf", tmp_path / "fixed.urdf"
    path.write_text(ROBOT.format(kind="revolute", limit=LIMITS["no effort"]))
    assert main(["lint", str(path)]) == 1
    assert "P0917" in capsys.readouterr().out
    assert main(["lint", str(path), "--fix", str(fixed)]) == 0
    assert taken_by_urdfdom(fixed.read_text())
    assert mf.load(fixed).mechanism.joints[0].limits == Limits(-1, 1, 2)
    path.write_text(ROBOT.format(kind="revolute", limit=LIMITS["none"]))
    assert main(["lint", str(path), "--fix", str(fixed)]) == 1, "what the joint is remains for its owner to say"
