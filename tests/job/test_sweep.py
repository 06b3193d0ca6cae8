"""A job for many values of its variables."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from mafsil.cli.main import main
from mafsil.errors import InputError, JobError
from mafsil.job import Run, parse_job, solve
from mafsil.job.judging.judgement import summary
from mafsil.job.sweep import sweep

JOB = """
robot = "planar2r"
[variables]
reach = 1.5
law = "pid"
[controller]
kind = "$law"
[[move]]
joints = [0.3, 0.2]
[[move]]
pose = { position = ["$reach", 0, 0], task = "position" }
"""


def test_each_case_is_the_job_with_its_values():
    grid = {"reach": [1.2, 1.6, 3.0], "law": ["pid", "computed_torque"]}
    seen = []
    found = sweep(JOB, grid, Path(), simulate=True, progress=seen.append)
    assert [tuple(case.values.values()) for case in found] == [(r, k) for r in grid["reach"] for k in grid["law"]]
    assert seen[-1] == 1.0
    assert not found
    for case in found:
        alone = solve(parse_job(JOB, variables=case.values), JOB, Path())
        if case.values["reach"] == 3.0:
            assert case.refusal is not None
            assert np.isnan(case.cycle)
            assert case.refusal.explain("en") == alone.explain("en")
        else:
            assert isinstance(alone, Run)
            assert case.cycle == summary(alone).cycle
            assert case.numbers[0] == summary(alone).tip_error
            assert case.numbers[1] == summary(alone).energy
            limits = alone.robot.limits.effort
            assert case.numbers[2] == np.max(summary(alone).peak_effort / limits)
    best = found.quickest
    assert best is not None
    assert best.cycle == min(case.cycle for case in found if case.refusal is None)
    text = found.explain("en")
    assert "4 of 6" in text
    assert "reach = 3" in text
    assert "4" in found.explain("ar")


def test_bad_grids_are_named():
    for grid in ({}, {"reach": []}, {"reach": list(range(40)), "law": ["pid"] * 40}):
        with pytest.raises(InputError, match="grid"):
            sweep(JOB, grid, Path())
    with pytest.raises(JobError, match="raech"):
        sweep(JOB, {"raech": [1.0]}, Path())


def test_the_commands(tmp_path, capsys):
    file = tmp_path / "job.toml"
    file.write_text(JOB)
    assert main(["sweep", str(file), "reach=1.2,1.4", "law=pid", "--json"]) == 0
    cases = json.loads(capsys.readouterr().out)["cases"]
    assert [case["values"]["reach"] for case in cases] == [1.2, 1.4]
    assert all(case["cycle"] > 0 and case["tip_error"] is None for case in cases)
    assert main(["sweep", str(file), "reach"]) != 0
    assert not (tmp_path / "mafsil-results").exists()
