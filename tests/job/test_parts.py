"""Parts by name: mass, centre of mass and inertia."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import JobError
from mafsil.job import Run, parse_job, solve

HEAD = """
robot = "puma560"
[simulation]
friction = false
[start]
joints = [0.3, -0.5, 0.4, 0.1, 0.6, 0.2]
[part.gear]
mass = 1.2
size = [0.1, 0.06, 0.04]
offset = [0, 0, 0.05]
com = [0.02, -0.01, 0.005]
inertia = [0.004, 0.005, 0.006, 0.0005, -0.0002, 0.0001]
"""
MOVES = """
[[move]]
pick = "gear"
[[move]]
joints = [-0.3, -0.3, 0.1, 0.4, 0.2, -0.5]
[[move]]
place = true
"""


def solved(text: str) -> Run:
    found = solve(parse_job(text), text, Path())
    assert isinstance(found, Run)
    return found


def test_a_part_by_name_moves_as_a_body_of_its_inertia():
    run = solved(HEAD + MOVES)
    assert run
    xx, yy, zz, xy, xz, yz = 0.004, 0.005, 0.006, 0.0005, -0.0002, 0.0001
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    loaded = mf.load("puma560").with_payload(1.2, com=(0.02, -0.01, 0.055), inertia=inertia)
    carried = next(each for each in run.driven if each.carried is not None)
    assert carried.carried is not None
    assert carried.carried.name == "gear"
    q, qd, qdd = np.random.default_rng(0).normal(size=(3, 20, 6))
    ours = carried.scenario.true_plant.robot.inverse_dynamics(q, qd, qdd)
    np.testing.assert_allclose(ours, loaded.inverse_dynamics(q, qd, qdd), atol=1e-12)


def test_millimetres_are_metres():
    text = HEAD.replace("robot =", 'lengths = "millimetres"\nrobot =').replace("[0.1, 0.06, 0.04]", "[100, 60, 40]")
    text = text.replace("[0, 0, 0.05]", "[0, 0, 50]").replace("[0.02, -0.01, 0.005]", "[20, -10, 5]")
    own, other = (parse_job(each + MOVES).move[0].pick for each in (HEAD, text))
    assert own is not None
    assert other is not None
    np.testing.assert_allclose([*own.size, *own.offset, *own.com], [*other.size, *other.offset, *other.com])
    assert own.inertia == other.inertia


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ('pick = "gear"', 'pick = "wheel"', r"\[part\] wheel; known: gear"),
        ("0.004, 0.005, 0.006", "0.004, 0.005, 0.016", "triangle"),
        ("0.004, 0.005, 0.006", "-0.004, 0.005, 0.006", "<text>:12: no body"),
        (", -0.0002, 0.0001]", "]", "inertia"),
        ("mass = 1.2", "mass = 1.2\nweight = 3", "weight"),
    ],
)
def test_what_is_wrong_with_a_part_is_said(before, after, said):
    with pytest.raises(JobError, match=said):
        parse_job((HEAD + MOVES).replace(before, after))
