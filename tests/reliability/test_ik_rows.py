"""Rows R5, R6 and R7 at the size of a pull request; the modules they call go on to any size."""

from __future__ import annotations

import pytest

from tests.reliability import ik_complete, ik_numerical, ik_unreachable
from tests.reliability.ik_arms import ARMS, arm


@pytest.mark.row("R5")
@pytest.mark.parametrize("name", ["panda", "ur5e", "puma560", "kinova", "baxter"])
def test_reachable_poses_are_reached_one_by_one(name: str) -> None:
    found = ik_numerical.shard(name, 400, seed=5)
    if not found["poses"]:
        pytest.skip("example-robot-data is not installed")
    assert not any(value for key, value in found.items() if key.startswith("bad_pose") or key.startswith("bad_limit"))
    assert found["missed"] == 0


def test_there_are_ten_arms_and_more() -> None:
    assert len(ARMS) >= 16
    assert sum((robot := arm(name)) is not None and robot.n >= 7 for name in ("panda", "fr3", "iiwa7")) == 3


@pytest.mark.row("R6")
@pytest.mark.parametrize("name", ["puma", "generalised_puma", "ur", "elbow6r", "ur5e"])
def test_planted_postures_are_found(name: str) -> None:
    found = ik_complete.work([name], seed=1, cases=400)
    assert found["cases"] >= 300
    assert not {key: value for key, value in found.items() if key.startswith("bad_") and value}


@pytest.mark.row("R7")
def test_what_cannot_be_reached_is_said_so() -> None:
    found = ik_unreachable.work(seed=3, cases=2000)
    assert found["cases"] >= 1900
    assert found["rank_4"] > 0
    assert not {key: value for key, value in found.items() if key.startswith("bad_") and value}
