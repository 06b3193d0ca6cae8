"""Row R8 of the goal table at the size of a pull request; more by `python -m tests.reliability.lie_groups`."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.row("R8")
def test_exp_and_log_on_many_cases(tmp_path: Path):
    command = [sys.executable, "-m", "tests.reliability.lie_groups", "--cases", "200000", "--resume", str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=240, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    figures = json.loads(done.stdout.splitlines()[-1])
    assert figures["passed"]
    assert figures["cases"] == 200_000
    assert figures["exact_cases"] == 2_000
