"""Row R19, several arms, at the size of a pull request."""

from __future__ import annotations

import pytest

from tests.reliability import several_arms


@pytest.mark.row("R19")
@pytest.mark.capability("11-45", "11-46")
def test_several_arms_in_random_scenes():
    found = several_arms.work(1, 5)
    assert not any(value for name, value in found.items() if name.startswith("bad_"))
    assert found["together"] > 1
    assert found["in_turn"] > 1
