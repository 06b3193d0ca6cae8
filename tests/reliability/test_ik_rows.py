"""Row R5 at the size of a pull request; `tests.reliability.ik_numerical` goes on to any size."""

from __future__ import annotations

import pytest

from tests.reliability import ik_numerical
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
