"""One small run, solved once for all tests of the report."""

from pathlib import Path

import pytest

from mafsil.job import Run, parse_job, solve

TEXT = """
title = "Tests \u202e <script>alert(1)</script> & 'quotes'"
robot = "panda"
angles = "degrees"
[tool]
offset = { position = [0.0, 0.0, 0.2] }
mass = 0.5
[start]
joints = [0, -35, 0, -135, 0, 100, 45]
[simulation]
step = 0.004
[[move]]
name = "down </script><img src=x onerror=alert(2)>"
pose = { position = [0.45, -0.1, 0.3], rpy = [180, 0, 0] }
[[move]]
pick = { mass = 0.5 }
[[move]]
joints = [0, -35, 0, -135, 0, 100, 45]
[[move]]
place = true
"""


@pytest.fixture(scope="session")
def small_run() -> Run:
    run = solve(parse_job(TEXT), TEXT, Path())
    assert isinstance(run, Run)
    return run
