"""Row J1 at the size of a pull request; more by `python -m tests.reliability.job_verdicts`."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from mafsil.job import Run, parse_job, solve
from mafsil.job.judging.causes import Cause
from mafsil.job.remark import Remark
from tests.reliability import figures, job_verdicts
from tests.reliability.recording_check import complaints

JOB = """
robot = "planar2r"
[controller]
kind = "pd_gravity"
kp = [400, 3]
kd = [60, 1]
[simulation]
step = 0.002
[[move]]
name = "out"
joints = [0.4, 0.3]
[[move]]
pick = { mass = 1.0, known = false }
[[move]]
joints = [0.0, 0.1]
"""


@pytest.mark.row("J1")
def test_no_false_word_about_random_jobs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["job_verdicts", "--jobs", "8", "--shard", "8", "--resume", str(tmp_path)])
    found = figures.run("J1", figures.arguments("", "jobs", 8, 8), job_verdicts.work)
    assert found["passed"], found
    assert found["jobs"] == 8
    assert min(int(str(found[name])) for name in ("verdict_failure", "causes", "missed")) > 0
    assert int(str(found["missed"])) < int(str(found["targets"]))


@pytest.fixture(scope="module")
def missing() -> Run:
    run = solve(parse_job(JOB), JOB, Path())
    assert isinstance(run, Run)
    assert not complaints(run)[1]
    return run


def changed(run: Run, key: str, **details: object) -> Run:
    remarks = [replace(r, details={**r.details, **details}) if r.key == key else r for r in run.remarks]
    return replace(run, remarks=tuple(remarks))


def caused(run: Run, what: str) -> Run:
    """The cause of the first miss with one word changed."""
    first = next(r for r in run.remarks if r.key == "job.not_reached_joints")
    assert isinstance(first.cause, Cause)
    lie = replace(first.cause, key="job.cause_friction")
    if what == "after":
        lie = replace(first.cause, details={**first.cause.details, "after": "77°"})
    return replace(run, remarks=tuple(replace(r, cause=lie) if r is first else r for r in run.remarks))


LIES: dict[str, Callable[[Run], Run]] = {
    "all reached": lambda run: replace(run, remarks=(*run.remarks, Remark("good", "job.all_reached", _REACHED))),
    "nothing missed": lambda run: replace(run, remarks=tuple(r for r in run.remarks if "not_reached" not in r.key)),
    "a smaller error": lambda run: changed(run, "job.not_reached_joints", error="0.6°"),
    "another size of the cause": lambda run: caused(run, "after"),
    "another cause": lambda run: caused(run, "key"),
    "a limit that was kept": lambda run: replace(run, remarks=(Remark("failure", "job.limit_crossed", _BEYOND),)),
    "a load too heavy": lambda run: replace(run, remarks=(*run.remarks, Remark("failure", "job.cannot_hold", _HEAVY))),
    "green": lambda run: replace(run, remarks=tuple(replace(r, level="good") for r in run.remarks)),
}
_REACHED = {"count": 3, "position": "1 mm", "angle": "0.1°"}
_BEYOND = {"joint": "joint1", "excess": "3°", "time": "0 ms"}
_HEAVY = {"joint": "joint1", "share": "230 %", "time": "1 s"}


@pytest.mark.parametrize("lie", LIES)
def test_a_lie_is_found(missing: Run, lie: str) -> None:
    assert complaints(LIES[lie](missing))[1], lie
