"""`mafsil design`: every question about the example, in both languages, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import mafsil as mf
from mafsil.cli import registry
from mafsil.cli.design import QUESTIONS
from mafsil.cli.main import main

FILE = Path(__file__).parents[2] / "examples" / "design" / "arm.toml"
DRIVES = FILE.with_name("drives.csv")


def _run(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    code = main(["design", *words])
    shown = capsys.readouterr()
    return code, shown.out, shown.err


@pytest.mark.parametrize("language", ["en", "ar"])
@pytest.mark.parametrize("what", ["robot", "tasks", "accuracy", "allocate", "drives"])
def test_questions(capsys: pytest.CaptureFixture[str], what: str, language: str) -> None:
    before = mf.language()
    try:
        mf.language(language)
        more = ("--catalogue", str(DRIVES)) if what == "drives" else ()
        code, out, err = _run(capsys, what, str(FILE), *more)
    finally:
        mf.language(before)
    assert code == 0, err
    assert out


def test_the_command_line_offers_every_question() -> None:
    design = next(one for one in registry.OPERATIONS if one.name == "design")
    assert set(next(one for one in design.parameters if one.name == "what").choices) == QUESTIONS.keys()


def test_reach_and_its_picture(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    code, out, err = _run(capsys, "reach", str(FILE), "--out", str(tmp_path / "reach.svg"))
    assert code == 0, err
    assert "reach.svg" in out
    assert (tmp_path / "reach.svg").read_text("utf-8").startswith("<")


def test_data_for_machines(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    out = tmp_path / "arm.urdf"
    code, shown, _ = _run(capsys, "robot", str(FILE), "--values", "upper=0.5", "--out", str(out), "--json")
    assert code == 0
    data = json.loads(shown)
    assert data["design"]["upper"] == 0.5
    assert sum(link.inertial.mass for link in mf.load(out).mechanism.links if link.inertial) == pytest.approx(
        data["mass"]
    )
    code, shown, _ = _run(capsys, "accuracy", str(FILE), "--json")
    worst = json.loads(shown)
    assert worst["poses"][worst["worst"]]["rms"] == max(pose["rms"] for pose in worst["poses"])


def test_search(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "arm.toml"
    file.write_text(
        FILE.read_text("utf-8").replace('"mass", "deflection"', '"mass"').replace("generations = 4", "generations = 1")
    )
    code, out, err = _run(capsys, "search", str(file))
    assert code == 0, err
    assert "1 proved" in out


def test_refusals(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    text, file = FILE.read_text("utf-8"), tmp_path / "arm.toml"
    for change, words, said in (
        (("[tasks]", "[task]"), ("tasks",), "task"),
        (("[tolerances]", "[[tolerances]]"), ("accuracy",), "tolerances"),
        (("zero = 1e-4", "zeros = 1e-4"), ("accuracy",), "zeros"),
        (("wanted = 1e-4", ""), ("allocate",), "wanted"),
        (("period = 4.5", ""), ("drives", "--catalogue", str(DRIVES)), "period"),
        (("points = 3", "point = 3"), ("search",), "point"),
        (("[0.55, 0.15, 0.30", "[5.5, 0.15, 0.30"), ("accuracy",), "poses 0"),
        (("", ""), ("drives",), "catalogue"),
        (("", ""), ("robot", "--values", "upper"), "NAME=VALUE"),
        (("", ""), ("robot", "--values", "upper=9"), "upper"),
        (("[arm]", "[arms]"), ("robot",), "arm"),
    ):
        file.write_text(text.replace(*change))
        code, _, err = _run(capsys, words[0], str(file), *words[1:])
        assert code != 0, words
        assert said in err, (said, err)
    file.write_text(text.replace("[0.55, 0.15, 0.30", "[5.5, 0.15, 0.30"))
    code, _, err = _run(capsys, "tasks", str(file))
    assert code == 1
    assert "poses 0 of 3" in err
