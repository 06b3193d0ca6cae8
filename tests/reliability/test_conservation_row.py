"""Row R10 of the goal table at the size of a pull request; more by `python -m tests.reliability.conservation`."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from mafsil.robot import load
from mafsil.simulation import forward_dynamics_trajectory
from tests.reliability import conservation, figures

FALL = np.array([0.2, -0.4, 0.6, 0.3, -0.5, 0.1])


@pytest.mark.row("R10")
def test_free_motion_of_random_trees(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    command = ["conservation", "--cases", "2", "--shard", "2", "--resume", str(tmp_path)]
    monkeypatch.setattr(sys, "argv", command)
    monkeypatch.setattr(conservation, "DURATION", 4.0)
    found = figures.run("R10", figures.arguments("", "cases", 2, 2), conservation.work)
    assert found["passed"], found
    assert found["trees"] == 2
    assert found["orders"] >= 8
    assert json.loads((tmp_path / "R10.json").read_text()) == found


def test_a_wrong_energy_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(conservation, "TOLERANCE", 1e-4)
    assert conservation.judged(0, 20.0)["bad_energy"]


@pytest.mark.row("R10")
@pytest.mark.capability("09-7", "09-66")
def test_energy_of_a_falling_arm_by_the_error_estimate() -> None:
    """A shorter run of `tests.reliability.falling_arm`: 100 s there."""
    moved = forward_dynamics_trajectory(load("puma560"), FALL, duration=10.0, friction=False, tolerance=1e-13)
    assert moved.energy_drift < 1e-11


@pytest.mark.row("R10")
@pytest.mark.capability("09-66")
def test_energy_of_the_variational_integrator_does_not_drift() -> None:
    moved = forward_dynamics_trajectory(
        load("puma560"), FALL, duration=20.0, friction=False, method="variational", step=2e-3
    )
    error = moved.energy - moved.energy[0]
    early, late = np.abs(error[: len(error) // 4]).max(), np.abs(error[-len(error) // 4 :]).max()
    assert late < 1.5 * early
    trend = np.polyfit(moved.t, error, 1)[0] * moved.duration
    assert abs(trend) < 0.3 * np.abs(error).max()
