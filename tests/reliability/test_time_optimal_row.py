"""Row R11, paths, at the size of a pull request; more by `python -m tests.reliability.time_optimal_paths`."""

from __future__ import annotations

import pytest

import mafsil as mf
from mafsil.robot import Robot
from tests.reliability import time_optimal_paths


@pytest.mark.row("R11")
def test_limits_hold_on_random_paths() -> None:
    found = time_optimal_paths.work(0, 20)
    assert found["paths"] == 20
    assert found["with_efforts"] >= 1
    assert not {name: value for name, value in found.items() if name.startswith("bad_") and value}


def test_a_broken_limit_is_found() -> None:
    robots: list[Robot] = [mf.load("panda")]
    _, path, limits, _ = time_optimal_paths.question(0, 1, robots)
    tight = mf.trajectory.MotionLimits.of(
        7, velocity=tuple(0.999 * limits.velocity), acceleration=tuple(limits.acceleration)
    )
    loose = mf.trajectory.time_optimal(path, limits, intervals=100)
    broken = mf.trajectory.timing.TimeOptimal(loose.status, path, tight, loose.timing)
    slow = mf.trajectory.MotionLimits.of(
        7, velocity=tuple(limits.velocity), acceleration=tuple(0.999 * limits.acceleration)
    )
    hard = mf.trajectory.timing.TimeOptimal(loose.status, path, slow, loose.timing)
    assert any(time_optimal_paths.judged(answer, path, None)["bad_excess"] for answer in (broken, hard))
