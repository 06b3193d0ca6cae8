"""Ends as they are measured: a little beyond a written limit they are planned for from the limit, and it is said."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.collision import Checker
from mafsil.model.limits import MEASURED, snap_to_bounds
from mafsil.planning.outcome import PlanningStatus
from mafsil.trajectory import MotionLimits, check, cubic, prove


@pytest.fixture(scope="module")
def checker():
    return Checker("ur5e", radius=0.04, self_collision=False)


def configuration(checker, far):
    q = np.array([0.0, -1.0, 1.0, 0.0, 0.5, 0.0])
    q[0] = checker.robot.limits.upper[0] + far
    return q


@pytest.mark.parametrize("far", [8.9e-16, 1.7e-7, 4e-6])
@pytest.mark.parametrize("swapped", [False, True])
def test_an_end_beyond_a_limit_by_rounding_is_planned_for(checker, far, swapped):
    ends = np.array([0.0, -1.0, 1.0, 0.0, 0.5, 0.0]), configuration(checker, far)
    start, goal = ends[::-1] if swapped else ends
    found = mf.plan(checker, None, start, goal)
    assert found, found.explain()
    np.testing.assert_array_equal(found.path[[0, -1]], [start, goal])
    assert "outside the limits by at most" in found.explain("en")
    assert found.explain("ar") != found.explain("en")
    inner = found.path[1:-1]
    assert ((inner >= checker.robot.limits.lower) & (inner <= checker.robot.limits.upper)).all()


def test_farther_beyond_is_refused(checker):
    start = np.array([0.0, -1.0, 1.0, 0.0, 0.5, 0.0])
    found = mf.plan(checker, None, start, configuration(checker, 2 * MEASURED))
    assert found.status is PlanningStatus.GOAL_OUTSIDE
    found = mf.plan(checker, None, configuration(checker, 2 * MEASURED), start)
    assert found.status is PlanningStatus.START_OUTSIDE


def test_the_rule_itself():
    lower, upper = np.array([-1.0, -np.inf]), np.array([1.0, 2.0])
    q = np.array([[1.0 + 0.9 * MEASURED, 0.0], [-1.0 - 2 * MEASURED, 2.0], [0.5, 2.0 + 0.5 * MEASURED]])
    np.testing.assert_array_equal(snap_to_bounds(q, lower, upper), [[1.0, 0.0], [-1.0 - 2 * MEASURED, 2.0], [0.5, 2.0]])


def test_checks_of_motions_know_the_same_tolerance():
    for far, kept in ((0.9 * MEASURED, True), (2.0 * MEASURED, False)):
        motion = cubic([0.0], [1.0 + far], 2.0)
        limits = MotionLimits.of(1, position=1.0)
        assert bool(check(motion, limits)) is kept
        assert bool(prove(motion, limits)) is kept
