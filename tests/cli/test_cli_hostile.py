"""Hostile words, files and places: one sentence, the right exit code, nothing left behind."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from mafsil.cli.main import FAILED, WRONG_INPUT, main

JOB = 'robot = "planar2r"\n[[move]]\njoints = [0.1, 0.2]\n'


def refused(capsys, *words: str) -> str:
    """The one line on stderr, after the same call in Arabic has said something in Arabic."""
    assert main([*words, "--lang", "ar"]) != 0
    assert any("\u0600" <= c <= "\u06ff" for c in capsys.readouterr().err)
    code = main([*words, "--lang", "en"])
    err = capsys.readouterr().err
    assert code in (WRONG_INPUT, FAILED)
    assert err.startswith("mafsil: ")
    assert err.count("\n") == 1
    assert "internal" not in err
    return err


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
@pytest.mark.parametrize("words", [("show",), ("run",), ("fk",)])
@pytest.mark.parametrize("ending", ["toml", "urdf", "xml"])
def test_pipes_are_not_waited_for(words, ending, tmp_path: Path, capsys):
    os.mkfifo(tmp_path / f"pipe.{ending}")
    refused(capsys, *words, str(tmp_path / f"pipe.{ending}"))


def test_devices_that_never_end_are_not_read(capsys):
    assert "regular" in refused(capsys, "run", "/dev/zero")


@pytest.mark.parametrize(
    "extra",
    [
        "duration = 1e9",
        "duration = 1e300",
        "duration = 1e-300",
        "speed = 1e-300",
        "[[move]]\npause = 1e9",
        "[[move]]\npick = { mass = 1e300 }",
        "[[move]]\npick = { mass = 1, size = [1e200, 1, 1] }",
        "[simulation]\nsettle = 1e9",
        "[simulation]\nstep = 1e-300",
        "[simulation]\nstep = 1e-9",
        "[simulation.noise]\nseed = -1",
        "[simulation.noise]\nposition = 1e300",
        "[controller]\nfrequency = 1e300",
        "[tool]\nmass = 1e300",
        "[limits]\nvelocity = 1e-12",
        "[[disturbance]]\nstart = 0\nduration = 1\nwrench = [1e300, 0, 0, 0, 0, 0]",
    ],
)
def test_absurd_numbers_of_a_job_are_refused_before_memory_is_taken(extra, tmp_path: Path, capsys):
    (tmp_path / "job.toml").write_text(JOB + extra)
    refused(capsys, "run", str(tmp_path / "job.toml"), "--out", str(tmp_path / "out"))
    assert sorted(p.name for p in tmp_path.iterdir()) == ["job.toml"]


def test_via_points_may_repeat(tmp_path: Path, capsys):
    (tmp_path / "job.toml").write_text(JOB + "via = [[0, 0], [0, 0], [0.1, 0.2]]")
    assert main(["run", str(tmp_path / "job.toml"), "--out", str(tmp_path / "out")]) == 0
    assert not capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "close"), [(("fkk",), "fk"), (("show", "pandaa"), "panda"), (("show", "UR55"), "ur5")]
)
def test_close_names_are_offered(words, close, capsys):
    assert f"did you mean: {close}" in refused(capsys, *words)


@pytest.mark.parametrize("name", ["a" * 5000, "x\0y", "pi/" + "9" * 400])
def test_long_and_broken_words(name, capsys):
    refused(capsys, "show", name)
    refused(capsys, "fk", "planar2r", name.replace("pi/", "x"), "0")


@pytest.mark.parametrize("out", ["", "/proc/nowhere", "/dev/null/x", "a" * 300])
def test_places_that_cannot_be_written(out, tmp_path: Path, capsys):
    (tmp_path / "job.toml").write_text(JOB)
    refused(capsys, "run", str(tmp_path / "job.toml"), "--out", out)


def test_errors_and_infinities_are_json_too(capsys):
    assert main(["show", "nix", "--json"]) == WRONG_INPUT
    error = json.loads(capsys.readouterr().out)["error"]
    assert error["code"] == "robot.no_file"
    assert set(error["sentence"]) == {"en", "ar"}
    q = ["0"] * 7
    assert main(["dynamics", "panda", "--q", *q, "--qd", *["1e200"] * 7, "--json"]) == WRONG_INPUT
    assert "inverse_dynamics" in json.loads(capsys.readouterr().out)["error"]["sentence"]["en"]


@pytest.mark.parametrize("lang", ["en", "ar"])
def test_a_terminal_without_unicode_gets_codes(lang):
    environment = {**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0", "LC_ALL": "C"}
    command = [sys.executable, "-m", "mafsil", "show", "planar2r", "--lang", lang]
    done = subprocess.run(command, env=environment, capture_output=True, check=False)
    assert done.returncode == 0
    assert done.stdout.isascii()
    assert done.stderr == b""
