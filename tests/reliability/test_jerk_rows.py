"""Row R11, jerk-limited motions, at the size of a pull request; any size by the modules that are called here."""

from __future__ import annotations

import pytest

from tests.reliability import jerk_limited, jerk_via_points


@pytest.mark.row("R11")
def test_states_to_states():
    pytest.importorskip("ruckig")
    found = jerk_limited.work(0, 2000)
    assert not any(value for name, value in found.items() if name.startswith("bad_"))
    assert found["compared"] == 2000


@pytest.mark.row("R11")
def test_via_points():
    found = jerk_via_points.work(0, 75)
    assert not any(value for name, value in found.items() if name.startswith("bad_"))
    assert found["shorter_than_stops"] > 62
