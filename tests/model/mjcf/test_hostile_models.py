"""Hostile MJCF models get their code, their line and their repair, in both languages; includes stay inside."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mafsil.errors import FileError
from mafsil.model import JointKind, mjcf
from tests.model.mjcf.hostile_models import BODY, CASES, equality, model
from tests.model.urdf.hostile_files import Case

pytestmark = pytest.mark.row("F2")


def test_the_sound_model_is_sound() -> None:
    assert mjcf.diagnose(model()).codes == ()


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_code_line_and_repair(case: Case) -> None:
    report = mjcf.diagnose(case.data)
    found = [d for d in report if d.code == case.code]
    assert found, report.lines()
    assert found[0].line == case.line
    assert (found[0].repair is not None) == case.repair
    assert report.ok == case.accepted
    assert all(d.line_of_text("en") != d.line_of_text("ar") for d in report)
    text, _ = mjcf.repair(case.data)
    assert mjcf.diagnose(text).ok == case.mended
    if not report.ok:
        with pytest.raises(FileError, match=report.errors[0].code):
            mjcf.read(case.data)


def test_ball_becomes_three_hinges() -> None:
    (case,) = [case for case in CASES if case.name == "ball joint"]
    for repair in (False, True):
        mechanism = mjcf.read(case.data, repair=repair)
        assert mechanism.joint_names == ("j_x", "j_y", "j_z")
        assert any("M0711" in note for note in mechanism.provenance.notes)


def test_weld_is_a_loop_with_the_drawn_pose() -> None:
    text = equality('<weld body1="a" body2="b"/>\n').replace(b'<body name="b">', b'<body name="b" pos="1 2 3">')
    (loop,) = mjcf.read(text).loops
    assert (loop.kind, loop.parent, loop.child) == (JointKind.FIXED, "a", "b")
    np.testing.assert_array_equal(loop.T_pj[:3, 3], [1, 2, 3])


def test_joint_without_actuator_is_passive() -> None:
    text = equality("").replace(b"</mujoco>", b'<actuator><motor joint="k"/></actuator></mujoco>')
    mechanism = mjcf.read(text)
    assert dict(zip(mechanism.joint_names, mechanism.actuated, strict=True)) == {"j": False, "k": True}


def included(folder: Path, main: bytes, **files: str) -> Path:
    for name, text in files.items():
        (folder / f"{name}.xml").write_text(text)
    path = folder / "main.xml"
    path.write_bytes(main)
    return path


def test_include_is_put_in_place(tmp_path: Path) -> None:
    path = included(tmp_path, model('<include file="arm.xml"/>\n'), arm=f"<mujocoinclude>{BODY}</mujocoinclude>")
    assert mjcf.read(path).joint_names == ("j",)


def test_fault_in_an_included_file_names_that_file(tmp_path: Path) -> None:
    broken = f"<mujocoinclude>\n{BODY}</mujocoinclude>".replace("0 0 1", "0 0 0")
    report = mjcf.diagnose(included(tmp_path, model('<include file="arm.xml"/>\n'), arm=broken))
    (error,) = report.errors
    assert (error.file, error.line, error.repair) == ("arm.xml", 3, None)
    assert "arm.xml:3" in error.line_of_text()


@pytest.mark.parametrize("name", ["../out.xml", "/etc/passwd", "none.xml", "link.xml", "."])
def test_include_does_not_leave_the_folder(tmp_path: Path, name: str) -> None:
    (tmp_path / "out.xml").write_text(f"<mujocoinclude>{BODY}</mujocoinclude>")
    folder = tmp_path / "model"
    folder.mkdir()
    (folder / "link.xml").symlink_to(tmp_path / "out.xml")
    report = mjcf.diagnose(included(folder, model(before=f'<include file="{name}"/>\n')))
    assert "M0703" in report.codes


def test_include_of_itself_ends(tmp_path: Path) -> None:
    path = included(tmp_path, model(before='<include file="a.xml"/>\n'), a='<x><include file="a.xml"/></x>')
    assert "M0704" in mjcf.diagnose(path).codes
