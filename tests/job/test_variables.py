"""Variables of job files: replaced everywhere, set from outside, and said where they are missing."""

from __future__ import annotations

import json

import pytest

from mafsil.cli.main import main
from mafsil.errors import JobError
from mafsil.job import parse_job

JOB = """
robot = "planar2r"
lengths = "millimetres"
[variables]
reach = 1500
law = "pid"
goal = [0.3, 0.2]
[controller]
kind = "$law"
[pose.far]
position = ["$reach", 0, 0]
task = "position"
[[move]]
repeat = 2
do = [ { joints = "$goal" }, { pose = "far" } ]
"""


def test_a_name_stands_for_its_value_wherever_it_is():
    job = parse_job(JOB)
    assert job.controller.kind == "pid"
    assert job.move[0].joints == (0.3, 0.2)
    assert job.move[1].pose.position == (1.5, 0, 0), "in the unit of the place where it stands"
    other = parse_job(JOB, variables={"reach": 1200.0})
    assert other.move[3].pose.position == pytest.approx((1.2, 0, 0))
    assert other.variables["reach"] == 1200
    assert parse_job(JOB.replace('title = "$', 'title = "')).title == ""


@pytest.mark.parametrize(
    ("text", "values", "line"),
    [
        (JOB.replace('"$goal"', '"$gaol"'), {}, 15),
        (JOB, {"raech": 1.0}, 4),
        ('robot = "$arm"\n[[move]]\npause = 1', {}, 1),
    ],
)
def test_a_name_without_a_value_is_said_with_its_line(text, values, line):
    with pytest.raises(JobError) as caught:
        parse_job(text, "cell.toml", values)
    assert caught.value.key == "job.no_variable"
    assert caught.value.message("en").startswith(f"cell.toml:{line}:")
    assert caught.value.message("ar") != caught.value.message("en")


def test_a_value_of_the_wrong_kind_is_refused_where_it_stands():
    with pytest.raises(JobError) as caught:
        parse_job(JOB, "cell.toml", {"reach": "far"})
    assert "pose.far.position" in caught.value.message("en")


def test_the_command_line_sets_them(tmp_path, capsys):
    path = tmp_path / "job.toml"
    path.write_text(JOB)
    out = tmp_path / "out"
    assert main(["run", str(path), "--set", "reach=1300", "law=pd_gravity", "--out", str(out)]) == 0
    assert json.loads((out / "results.json").read_text())["variables"]["reach"] == 1300
    capsys.readouterr()
    assert main(["run", str(path), "--dry-run", "--set", "reach"]) == 2
    assert "name=value" in capsys.readouterr().err
    assert main(["run", str(path), "--dry-run", "--set", "height=1"]) == 2
    assert "reach, law, goal" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ('[lock]\na = 1.0\nb = "two"', "lock.b"),
        ('[frame.good]\n[frame.bad]\nposition = "high"', "frame.bad.position"),
        ('[configuration]\nhome = [1, "x"]', "configuration.home"),
        ("[pattern.p]\ncount = [0]\npitch = [0.1]", "pattern.p.count"),
        ("[pose.a]\nposition = [1, 2]", "pose.a.position"),
    ],
)
def test_values_of_named_things_are_refused_by_their_names(text, place):
    with pytest.raises(JobError) as caught:
        parse_job('robot = "panda"\n' + text + "\n[[move]]\npause = 1\n", "cell.toml")
    assert place in caught.value.message("en")
