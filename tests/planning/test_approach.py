"""Gross and fine motion: the last part is a straight line of the tip, and all of it is free."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.collision import Box, Checker, Obstacle, Scene
from mafsil.errors import InputError
from mafsil.planning import plan_approach
from mafsil.planning.outcome import PlanningStatus

START = np.array([-1.0, -1.4, 1.4, -1.6, -1.5, 0.0])
GOAL = np.array([0.6, -1.3, 1.7, -1.9, -1.5, 0.0])


def cell(*extra, radius=0.03):
    arm = mf.load("ur5e")
    T = arm.forward_kinematics(GOAL)
    box = Obstacle(Box((0.3, 0.05, 0.4)), np.array([0.3, -0.1, 0.9]), "wall")
    return Checker(arm, Scene([box, *extra]), radius=radius, self_collision=False), T


@pytest.mark.capability("11-40")
def test_the_tip_comes_in_on_a_line_and_nothing_is_met():
    checker, T = cell()
    found = plan_approach(checker, START, T, away=(0.0, 0.0, -0.12), seed=2)
    assert found, found.explain()
    assert checker.check_path(found.path)
    tips = checker.robot.forward_kinematics(found.fine)
    assert np.allclose(tips[-1], T, atol=1e-6)
    assert np.allclose(tips[0][:3, 3], T[:3, 3] - 0.12 * T[:3, 2], atol=1e-6)
    along = (tips[:, :3, 3] - tips[0][:3, 3]) @ T[:3, 2]
    assert (np.diff(along) > 0).all()
    off = tips[:, :3, 3] - tips[0][:3, 3] - along[:, None] * T[:3, 2]
    assert np.abs(off).max() < 1e-5
    assert np.allclose(tips[:, :3, :3], T[:3, :3], atol=1e-5)
    assert found.deviation < 1e-4
    assert np.array_equal(found.path[0], START)
    again = plan_approach(checker, START, T, away=(0.0, 0.0, -0.12), seed=2)
    assert np.array_equal(again.path, found.path)


@pytest.mark.capability("11-40")
def test_why_there_is_no_fine_motion():
    checker, T = cell()
    lid = T.copy()
    lid[:3, 3] -= 0.08 * T[:3, 2]
    cover = Obstacle(Box((0.2, 0.2, 0.002)), lid, "lid")
    covered, _ = cell(cover, radius=0.001)
    found = plan_approach(covered, START, T)
    assert found.status is PlanningStatus.FINE_BLOCKED
    assert not found
    assert "lid" in found.explain("en")
    assert all(branch.reason for branch in found.branches)
    far = T.copy()
    far[0, 3] += 5
    assert plan_approach(checker, START, far).status is PlanningStatus.UNREACHABLE
    for options in ({"away": (0, 0, 0)}, {"away": (np.nan, 0, 0)}, {"seconds": 0.0}, {"planner": "none"}):
        with pytest.raises(InputError):
            plan_approach(checker, START, T, **options)
    with pytest.raises(InputError):
        plan_approach(checker, START, np.stack([T, T]))
