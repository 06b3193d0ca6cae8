"""The rows K1, K2, K3, C1 and D1 of the goal table at the size of a pull request; larger sizes by command."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SIZES = [
    pytest.param("kill_cache", "kills", 100, marks=pytest.mark.row("K1"), id="K1"),
    pytest.param("corrupt_cache", "cases", 250, marks=pytest.mark.row("K2"), id="K2"),
    pytest.param("stampede", "rounds", 2, marks=pytest.mark.row("K3"), id="K3"),
    pytest.param("concurrency", "calls", 16_000, marks=pytest.mark.row("C1"), id="C1"),
    pytest.param("determinism", "scenarios", 12, marks=pytest.mark.row("D1"), id="D1"),
]


@pytest.mark.skipif(sys.platform != "linux", reason="the harness forks and kills")
@pytest.mark.parametrize(("module", "unit", "size"), SIZES)
def test_row(module: str, unit: str, size: int, tmp_path: Path):
    command = [sys.executable, "-m", f"tests.reliability.{module}", f"--{unit}", str(size), "--resume", str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=240, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    figures = json.loads(done.stdout.splitlines()[-1])
    assert figures["passed"]
    assert figures[unit] == size


def test_finished_shards_are_not_run_again(tmp_path: Path):
    (tmp_path / "K2-000000.json").write_text(json.dumps({"row": "K2", "seed": 0, "cases": 2000, "bad_kept": 0}))
    command = [sys.executable, "-m", "tests.reliability.corrupt_cache", "--cases", "2010", "--resume", str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=True)
    assert json.loads(done.stdout.splitlines()[-1])["cases"] == 2010


def test_a_bad_figure_fails_the_row(tmp_path: Path):
    (tmp_path / "K2-000000.json").write_text(json.dumps({"row": "K2", "seed": 0, "cases": 10, "bad_kept": 1}))
    command = [sys.executable, "-m", "tests.reliability.corrupt_cache", "--cases", "10", "--resume", str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 1
    assert not json.loads((tmp_path / "K2.json").read_text())["passed"]
