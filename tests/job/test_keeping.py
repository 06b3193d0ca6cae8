"""Moves that keep something on the way: a tool upright, an orientation, a point on a line or in a plane."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mafsil.errors import JobError
from mafsil.job import solve
from mafsil.job.driving import arrival
from mafsil.job.driving.run import Run
from mafsil.job.judging import judge_run, summary
from mafsil.job.language.reading import parse_job
from mafsil.job.remark import Refusal
from mafsil.report.contents import page

HERE = Path()
GLASS = """
robot = "panda"
angles = "degrees"
lengths = "millimetres"
[start]
pose = { position = [450, 300, 350], rpy = [180, 0, 0] }
[frame.table]
position = [500, 0, 0]
rpy = [0, 0, 90]
[[obstacle]]
name = "wall"
box = [300, 40, 300]
position = [600, 0, 150]
[[move]]
name = "carry"
pose = { position = [450, -300, 350], rpy = [180, 0, 0] }
constraints = { upright = 5 }
[[move]]
name = "slide"
pose = { position = [450, -200, 450], rpy = [180, 0, 0] }
constraints = { orientation = true, plane = [0, 1, 0], frame = "table", tolerance = 2 }
"""


@pytest.fixture(scope="module")
def run() -> Run:
    found = solve(parse_job(GLASS), GLASS, HERE)
    assert isinstance(found, Run), found.explain("en")
    return found


@pytest.mark.capability("11-50")
def test_what_moves_keep_is_kept_by_the_driven_arm(run: Run) -> None:
    assert run
    t, tips = run.recording.t, run.tips(np.arange(len(run.recording.t)))[0]
    first, second = ((t >= run.plan.starts[k]) & (t <= run.plan.starts[k + 1]) for k in (0, 1))
    up = np.degrees(np.arccos(np.clip(-tips[first, 2, 2], -1.0, 1.0)))
    assert up.max() < 5.0
    # Along y of {s}, x of the frame: its y, the normal, is -x of {s}.
    assert np.abs(tips[second, 0, 3] - 0.45).max() < 0.002
    assert np.ptp(tips[second, 1, 3]) > 0.09
    said = run.explain("en")
    assert "as simulated, axis within" in said
    assert "point within" in said
    assert any("the limit is 5 deg" in text for _, text in page(run, summary(run), "en").details[1].pairs)


def test_what_was_not_kept_when_driven_is_said(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    worst = arrival.worst_kept(run, 0)
    assert worst is not None
    monkeypatch.setattr(arrival, "worst_kept", lambda run, leg: arrival.Measured(worst.kept, 40.0 * worst.measures))
    broken = [one for one in judge_run(run, summary(run)) if one.key == "job.constraint_violated"]
    assert broken[0].level == "failure"
    assert "violates the path constraints" in broken[0].sentence("en") != broken[0].sentence("ar")


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ("{ upright = 5 }", "{ }", "names no constraint"),
        ("{ upright = 5 }", "{ upright = 200 }", "half a turn"),
        ("{ upright = 5 }", "{ upright = 5, tolerance = 2 }", "line, plane"),
        ("plane = [0, 1, 0]", "plane = [0, 0, 0]", "no length"),
        ("{ upright = 5 }", '{ upright = 5 }\npath = "line"', "path = \"joint\""),
        ("{ upright = 5 }", '{ upright = 5 }\nplanner = "prm"', "need planner = \"rrt_connect\""),
        ("{ upright = 5 }", "{ upright = 5 }\navoid = false", "remove 'avoid'"),
        ("{ upright = 5 }", '{ upright = 5 }\nprofile = "cubic"', "time-optimal"),
        ('frame = "table"', 'frame = "tabel"', "tabel"),
    ],
)  # fmt: skip
def test_what_cannot_be_kept_is_refused_with_its_line(old: str, new: str, word: str) -> None:
    with pytest.raises(JobError, match=word) as refused:
        parse_job(GLASS.replace(old, new))
    assert refused.value.details["line"] is not None


def test_a_goal_that_does_not_keep_it_is_refused_by_how_much() -> None:
    text = GLASS.replace("[450, -300, 350], rpy = [180, 0, 0]", "[450, -300, 350], rpy = [180, 10, 0]")
    refused = solve(parse_job(text), text, HERE)
    assert isinstance(refused, Refusal)
    assert "carry" in refused.explain("en")
    assert "10 deg" in refused.explain("en")
