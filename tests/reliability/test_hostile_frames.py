"""Row F4 at the size of a pull request; 100,000 by `python -m tests.reliability.hostile_frames`."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests.reliability import figures, hostile_frames


@pytest.mark.row("F4")
def test_hostile_frames_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["hostile_frames", "--frames", "1000", "--resume", str(tmp_path)])
    found = figures.run("F4", figures.arguments("", "frames", 1000, 1000), hostile_frames.work)
    assert found["passed"], found
    assert found["frames"] == 1000
    assert int(str(found["refused"])) > 950
    assert found["good"] == 10
