"""The replay shows what the tip touches where it is: also holes, and what is hollow so that the arm shows through."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mafsil.job import Run, parse, solve
from mafsil.report.touched import standing

JOB = """
robot = "planar2r"
[start]
joints = [0.3, 0.9]
[[surface]]
point = [0, 0, 0]
sphere = 3
hollow = true
stiffness = 1e4
[[surface]]
point = [0, 3, 0]
cylinder = 0.2
axis = [0, 0, 1]
stiffness = 1e4
[[hole]]
name = "bore"
mouth = [0.5, -1.5, 0]
axis = [0, 1, 0]
clearance = 0.001
chamfer = 0.002
depth = 0.3
[[move]]
pause = 0.05
"""


@pytest.mark.capability("10-70")
def test_holes_and_hollow_surfaces_are_drawn():
    run = solve(parse(JOB), JOB, Path())
    assert isinstance(run, Run)
    (ball, _), (bar, _), (bore, place) = standing(run, 2.0)
    assert ball.solids[0].kind == "sphere"
    assert ball.solids[0].size == (3.0,)
    assert ball.solids[0].colour[3] < 0.5
    assert bar.solids[0].colour[3] == 1.0
    face, shaft = bore.solids
    assert face.colour[3] < 0.5
    radius, depth = shaft.size
    assert depth == 0.3
    assert radius >= 0.003
    # From the mouth down its axis to the bottom.
    ends = [place @ [0, 0, shaft.pose[2] + side * depth / 2.0, 1.0] for side in (1, -1)]
    np.testing.assert_allclose(ends, [[0.5, -1.5, 0, 1], [0.5, -1.8, 0, 1]], atol=1e-12)
