"""Row R9b at the size of a pull request; any size by `python -m tests.reliability.platforms`."""

from __future__ import annotations

import pytest

from tests.reliability import platforms


@pytest.mark.row("R9b")
@pytest.mark.capability("08-27", "08-35")
def test_planted_poses_of_random_platforms_are_among_the_forty() -> None:
    count = platforms.work(3, 50)
    assert count["platforms"] == count["all_forty"] == 50
    assert count["asked_for_proof"] == 1
    assert not [name for name, value in count.items() if name.startswith("bad_") and value], count
