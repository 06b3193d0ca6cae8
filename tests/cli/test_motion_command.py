"""`mafsil dynamics --duration`: the library's motion, printed and written as it is."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.cli.main import main

STATE = ["puma560", "--q", "0.2", "-0.4", "0.6", "0.3", "-0.5", "0.1"]


def run(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    code = main(["dynamics", *STATE, *words])
    printed = capsys.readouterr()
    return code, printed.out, printed.err


@pytest.mark.capability("09-7")
def test_the_motion_is_the_library_s(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path, tau = tmp_path / "fall.csv", ["1", "2", "3", "0", "0", "0"]
    code, out, _ = run(capsys, "--tau", *tau, "--duration", "0.5", "--out", str(path), "--json")
    found = json.loads(out)
    moved = mf.simulation.forward_dynamics_trajectory(
        mf.load("puma560"), found_start(), tau=np.array(tau, float), duration=0.5
    )
    assert code == 0
    np.testing.assert_array_equal(found["q"], moved.q[-1])
    np.testing.assert_array_equal(found["qd"], moved.qd[-1])
    table = np.genfromtxt(path, delimiter=",", names=True, deletechars="")
    assert len(table) == 51
    np.testing.assert_allclose(table["q[joint2]"], moved.at(table["t"]).u[:, 1], rtol=1e-15)
    np.testing.assert_array_equal(table["tau[joint3]"], 3.0)


def found_start() -> np.ndarray:
    return np.array([float(word) for word in STATE[2:]])


@pytest.mark.parametrize("language", ["en", "ar"])
def test_people_read_the_end_and_the_energy(capsys: pytest.CaptureFixture[str], language: str, tmp_path: Path) -> None:
    path = tmp_path / "fall.csv"
    code, out, _ = run(capsys, "--duration", "0.2", "--frictionless", "--lang", language, "--out", str(path))
    assert code == 0
    assert "joint6" in out
    assert str(path) in out
    assert "-4.910597" in out


@pytest.mark.parametrize(
    ("words", "mentions"),
    [
        (["--duration", "-1"], "--duration"),
        (["--duration", "x"], "--duration"),
        (["--frictionless"], "--duration"),
        (["--out", "x.csv"], "--duration"),
        (["--duration", "1", "--qdd", *"000000"], "--duration"),
        (["--duration", "0.1", "--out", "/nowhere/at/all.csv"], "/nowhere/at/all.csv"),
    ],
)
@pytest.mark.parametrize("language", ["en", "ar"])
def test_what_cannot_be_is_refused(
    capsys: pytest.CaptureFixture[str], words: list[str], mentions: str, language: str
) -> None:
    code, out, err = run(capsys, *words, "--lang", language)
    assert code == 2
    assert not out
    assert mentions in err
    assert err.count("\n") == 1


def test_an_unfinished_motion_is_an_honest_no(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mafsil.cli.dynamics.PATIENCE", 1e-3)
    code, out, err = run(capsys, "--duration", "1000")
    assert code == 1
    assert "puma560" in out
    assert "1000 s" in err
