"""Every example script runs as it stands, in an empty folder."""

import re
import runpy
from pathlib import Path

import pytest

SCRIPTS = sorted((Path(__file__).parents[2] / "examples" / "python").glob("*.py"))


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_script_runs(script, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(script), run_name="__main__")
    assert len(capsys.readouterr().out.splitlines()) >= 3
    assert len(script.read_text("utf-8").splitlines()) < 100
    assert not list(tmp_path.iterdir())


def test_the_course_names_every_script_in_order() -> None:
    page = (Path(__file__).parents[2] / "docs" / "course.md").read_text("utf-8")
    named = re.findall(r"\[(\d\d_\w+\.py)\]", page)
    assert named == [script.name for script in SCRIPTS]
    assert len(named) >= 15
