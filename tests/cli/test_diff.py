"""`mafsil diff`: what changed between two runs, computed from their results."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from mafsil.cli.main import main
from mafsil.errors import FileError
from mafsil.report import compare_results

JOB = """
robot = "planar2r"
title = "there and back"
[[move]]
name = "there"
joints = [0.8, -0.4]
profile = "{profile}"
[[move]]
name = "back"
joints = [0, 0.3]
"""


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    for name, text in (
        ("slow", JOB.format(profile="quintic")),
        ("quick", JOB.format(profile="time_optimal")),
        ("longer", JOB.format(profile="quintic") + "[[move]]\npause = 0.5\n"),
    ):
        (folder / f"{name}.toml").write_text(text)
        assert main(["run", str(folder / f"{name}.toml"), "--out", str(folder / name)]) == 0
    return folder


def test_a_run_and_itself_are_the_same(runs, capsys):
    capsys.readouterr()
    assert compare_results(runs / "slow", runs / "slow" / "results.json")
    assert main(["diff", str(runs / "slow"), str(runs / "slow")]) == 0
    assert "no changes" in capsys.readouterr().out


def test_what_changed_is_said_with_both_numbers(runs, capsys):
    found = compare_results(runs / "slow", runs / "quick")
    assert not found
    before, after = (json.loads((runs / name / "results.json").read_text()) for name in ("slow", "quick"))
    (cycle,) = [each for each in found.numbers if each.name == "cycle"]
    assert (cycle.before, cycle.after) == (before["numbers"]["cycle"], after["numbers"]["cycle"])
    assert cycle.share == pytest.approx(cycle.after / cycle.before - 1)
    assert cycle.share < 0
    times = {each.of for each in found.numbers if each.name == "time"}
    assert times == {"there"}, "the way back takes as long as before"
    efforts = {each.of for each in found.numbers if each.name == "peak_effort"}
    assert efforts == {each["name"] for each in before["joints"]}
    assert [line for line in found.job if line[:1] in "+-"][2:] == [
        '-profile = "quintic"', '+profile = "time_optimal"'
    ]  # fmt: skip
    assert any("what decides" in each["sentence"]["en"] for each in found.new)
    assert main(["diff", str(runs / "slow"), str(runs / "quick"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["status"] == "different"
    english, arabic = found.explain("en"), found.explain("ar")
    assert english != arabic
    assert f"({100 * cycle.share:+.3g} %)" in english


def test_moves_that_one_run_has_alone(runs):
    found = compare_results(runs / "slow", runs / "longer")
    (added,) = [each for each in found.numbers if each.before is None]
    assert added.name == "time"
    assert added.after == pytest.approx(0.5)
    assert added.share is None
    assert "none -> " in found.explain("en")


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"format": "mafsil-results-1"}', "[" * 100_000, "\x00"])
def test_what_is_no_result_is_refused(tmp_path: Path, runs: Path, text: str):
    (tmp_path / "results.json").write_text(text)
    with pytest.raises(FileError, match="not a result"):
        compare_results(tmp_path, runs / "slow")
    with pytest.raises(FileError, match="cannot be read"):
        compare_results(tmp_path / "nowhere", runs / "slow")


@pytest.mark.parametrize("joints", [[{}], [{"name": []}], [{"name": None}]])
def test_joints_without_names_are_no_results(runs, tmp_path, joints):
    data = json.loads((runs / "slow" / "results.json").read_text())
    (tmp_path / "results.json").write_text(json.dumps(data | {"joints": joints}))
    with pytest.raises(FileError):
        compare_results(tmp_path, tmp_path)


def test_whole_numbers_without_end_are_compared(runs, tmp_path):
    data = json.loads((runs / "slow" / "results.json").read_text())
    data["numbers"]["cycle"] = 10**400
    (tmp_path / "results.json").write_text(json.dumps(data))
    assert not compare_results(tmp_path, runs / "slow")
