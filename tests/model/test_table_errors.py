"""Robot tables that are wrong say where and what was meant; degrees and millimetres are remarked."""

from __future__ import annotations

from pathlib import Path

import pytest

import mafsil as mf
from mafsil.cli.main import main
from mafsil.errors import FileError
from mafsil.model import table

GOOD = """convention = "classic"
units = { angle = "rad" }

[[joint]]
a = 0.4
limits = { lower = -1.0, upper = 1.0 }
[joint.inertial]
mass = 1.0
"""


@pytest.mark.parametrize(
    ("old", "new", "line", "sentence"),
    [
        ("convention", "convension", 1, "did you mean: convention"),
        ("angle", "angel", 2, "did you mean: angle"),
        ("a = 0.4", "alfa = 0.4", 5, "did you mean: alpha"),
        ("lower", "lowr", 6, "did you mean: lower"),
        ("mass", "maas", 8, "did you mean: mass"),
        ("mass = 1.0", "qqqq = 1.0", 8, "known there: mass, com, inertia"),
        ("mass = 1.0", 'mass = "one"', 8, "docs/robot_tables.md"),
    ],
)
def test_keys(old: str, new: str, line: int, sentence: str) -> None:
    table.parse(GOOD)
    with pytest.raises(FileError, match=sentence) as error:
        table.parse(GOOD.replace(old, new), "arm.toml")
    assert f"line {line}" in str(error.value)
    assert error.value.message("ar") != error.value.message("en")


def test_a_job_is_told_from_a_robot(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = tmp_path / "job.toml"
    job.write_text('title = "a job"\nrobot = "puma560"\n[[move]]\njoints = [0, 0, 0, 0, 0, 0]\n')
    assert main(["show", str(job)]) == 2
    assert "this is a job" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("rows", "codes"),
    [
        ([mf.DHRow(alpha=90.0)], {"T1301"}),
        ([mf.DHRow(theta=-180.0), mf.DHRow(offset=45.0)], {"T1301"}),
        ([mf.DHRow(a=431.8), mf.DHRow()], {"P0915"}),
        ([mf.DHRow(d=671.8)], {"P0915"}),
        ([mf.DHRow(alpha=1.5707963), mf.DHRow(theta=-3.0, d=0.4)], set()),
        ([mf.DHRow(kind="P", offset=8.0)], set()),
        ([mf.DHRow(alpha=2.0, theta=6.0)], set()),
    ],
)
@pytest.mark.parametrize("convention", ["classic", "modified"])
def test_degrees_and_millimetres(rows: list[mf.DHRow], codes: set[str], convention: str) -> None:
    robot = mf.Robot.from_dh(rows, convention)
    found = {diagnostic.code for diagnostic in mf.lint(robot)}
    assert found & {"T1301", "P0915"} == codes
    assert {remark.code for remark in robot.mechanism.provenance.remarks} == codes & {"T1301"}


def test_degrees_in_a_file(tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    path.write_text(GOOD.replace("a = 0.4", "a = 0.4\nalpha = 90.0"))
    assert "T1301" in mf.lint(path).codes
    path.write_text(path.read_text().replace('"rad"', '"deg"'))
    assert "T1301" not in mf.lint(path).codes
