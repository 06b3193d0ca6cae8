"""Row R18, paths as coal sees them, at the size of a pull request."""

from __future__ import annotations

import pytest

from tests.reliability import coal_paths


@pytest.mark.row("R18")
@pytest.mark.capability("11-39", "11-40")
def test_paths_in_scenes_of_our_own_are_free_by_coal():
    found = coal_paths.examined(coal_paths.primitives()[1], coal_paths.random_problems(3, 4))
    assert not any(value for name, value in found.items() if name.startswith("bad_"))
    assert found["found"] >= 3
    assert found["timed"] >= 1
    assert found["states"] > 10_000


@pytest.mark.capability("11-39")
def test_a_path_through_something_would_be_seen():
    """The same look finds a path that was planned without the scene."""
    _, peer = coal_paths.primitives()
    problems = list(coal_paths.random_problems(5, 8))
    seen = [peer.first_contact(cell, coal_paths.dense(coal_paths.np.stack([a, b]))) >= 0 for cell, a, b in problems]
    ours = [not cell.free(coal_paths.dense(coal_paths.np.stack([a, b]))).all() for cell, a, b in problems]
    assert seen == ours
    assert any(seen)
