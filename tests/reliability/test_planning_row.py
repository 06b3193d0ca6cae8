"""Row R17, paths in random scenes, at the size of a pull request."""

from __future__ import annotations

import pytest

from tests.reliability import planning_scenes


@pytest.mark.row("R17")
@pytest.mark.capability("11-40", "11-50")
def test_paths_in_random_scenes():
    found = planning_scenes.work(7, 30)
    assert not any(value for name, value in found.items() if name.startswith("bad_"))
    assert found["found"] > 13
    assert found["ends"] > 1
