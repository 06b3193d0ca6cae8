"""Every example script runs as it stands, in an empty folder."""

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


def test_there_are_examples():
    assert {script.stem for script in SCRIPTS} >= {"urdf_to_answer", "dh_homework", "log_to_model"}
