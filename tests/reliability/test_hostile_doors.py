"""F5 at a small size, and that the row finds what it is there to find."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.reliability import hostile_doors
from tests.sizes import size


@pytest.mark.row("F5")
@pytest.mark.timeout(600)
def test_no_door_lets_in_what_is_foreign_slow_or_unsound():
    counts = hostile_doors.work(10_001, size(400, 5000))
    assert counts["files"] == size(400, 5000)
    assert counts["accepted"] > 20
    assert counts["refused"] > 100
    assert counts["special"] > 3
    assert {name: value for name, value in counts.items() if name.startswith("bad_") and value} == {}


def test_a_door_that_lets_nonsense_in_is_found_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def foreign(path: Path) -> object:
        raise KeyError(path.name)

    monkeypatch.setitem(hostile_doors.DOORS, "cloud.xyz", (foreign, hostile_doors.anything))
    monkeypatch.setitem(hostile_doors.DOORS, "part.obj", (lambda path: [float("nan")], hostile_doors.finite))
    (tmp_path / "x").write_text("")
    counts = dict.fromkeys(hostile_doors.COUNTS, 0)
    said = [*hostile_doors.judge("cloud.xyz", tmp_path / "x", counts)]
    said += hostile_doors.judge("part.obj", tmp_path / "x", counts)
    assert len(said) == 2
    assert counts["bad_exception"] == counts["bad_content"] == 1
