"""Paths made cheaper by gradients: never dearer, always proved, derivatives right, budgets kept."""

from __future__ import annotations

from itertools import pairwise
from time import perf_counter

import numpy as np
import pytest

import mafsil as mf
from mafsil import planning
from mafsil.collision import Box, Checker, Obstacle
from mafsil.errors import InputError
from mafsil.planning import path_optimisation
from mafsil.planning.outcome import PlanningStatus
from tests.budget import within
from tests.collision.peer import CoalChecker

START = np.radians([45.0, 20, 0, -110, 0, 130, 45])
GOAL = np.radians([-45.0, 20, 0, -110, 0, 130, 45])
WALL = Obstacle(Box((0.5, 0.04, 0.6)), (0.6, 0.0, 0.3), "wall")


@pytest.fixture(scope="module")
def panda():
    return Checker("panda", [WALL], radius=0.05, self_collision=False)


def dense(path, step=0.002):
    return np.concatenate(
        [a + np.linspace(0, 1, int(np.abs(b - a).max() / step) + 2)[:, None] * (b - a) for a, b in pairwise(path)]
    )


@pytest.mark.capability("11-50")
@pytest.mark.parametrize("seed", range(5))
def test_a_path_gets_cheaper_and_stays_free(panda, seed):
    raw = mf.plan(panda, None, START, GOAL, seed=seed, shortcut_iterations=0)
    better = raw.optimise()
    assert better.descent is not None
    assert better.descent.after.total < better.descent.before.total
    assert better.length < raw.length
    np.testing.assert_array_equal(better.path[[0, -1]], [START, GOAL])
    assert panda.check_path(better.path)
    assert panda.free(dense(better.path)).all()
    np.testing.assert_array_equal(better.path, raw.optimise().path)
    assert "cost" in better.explain("en")
    assert better.explain("en") != better.explain("ar")


@pytest.mark.capability("11-50")
def test_it_beats_shortcuts_on_the_mean(panda):
    """Same starts: lengths after a thousand shortcuts against those after a hundred and a descent; coal agrees."""
    shortcuts, descents = [], []
    for seed in range(8):
        shortcuts.append(mf.plan(panda, None, START, GOAL, seed=seed, shortcut_iterations=1000).length)
        better = mf.plan(panda, None, START, GOAL, seed=seed).optimise(enough_clearance=0.02)
        descents.append(better.length)
    assert np.mean(descents) < np.mean(shortcuts)
    peer = CoalChecker(panda)
    assert min(peer.distance(q) for q in dense(better.path, 0.02)) > 0.0


def test_derivatives_of_the_cost(panda):
    terms = path_optimisation._Terms(panda, 0.3, 0.01, np.ones(7))
    rng = np.random.default_rng(3)
    points = path_optimisation.evenly(np.stack([START, 0.5 * (START + GOAL) + 0.2 * rng.normal(size=7), GOAL]), 9)
    cost, gradient = terms.at(points, 40.0)
    for _ in range(20):
        way = np.zeros_like(points)
        way[1:-1] = rng.normal(size=(7, 7))
        h = 1e-6
        slope = (terms.at(points + h * way, 40.0)[0].total - terms.at(points - h * way, 40.0)[0].total) / (2 * h)
        np.testing.assert_allclose((gradient * way).sum(), slope, rtol=2e-4, atol=1e-4 * cost.total)


@pytest.mark.capability("11-50")
def test_straight_lines_bend_until_they_are_free(panda):
    found = mf.plan(panda, None, START, GOAL, planner="trajectory_optimisation", seed=1)
    assert found, found.explain("en")
    assert panda.free(dense(found.path)).all()
    none = mf.plan(panda, None, START, GOAL, planner="trajectory_optimisation", max_nodes=1)
    assert none.status is PlanningStatus.NOT_FOUND
    assert mf.plan(panda, None, START, START, planner="trajectory_optimisation").length == 0.0


def test_budgets_and_wrong_arguments(panda):
    raw = mf.plan(panda, None, START, GOAL, seed=1, shortcut_iterations=0)
    hurried = within(1.0, lambda: raw.optimise(seconds=0.02, iterations=100_000, points=60), clock=perf_counter)
    assert hurried.descent.after.total <= hurried.descent.before.total
    assert panda.check_path(hurried.path)
    for wrong in (
        {"enough_clearance": 0.0},
        {"smoothness": -1.0},
        {"points": 0},
        {"iterations": 0},
        {"seconds": np.nan},
    ):
        with pytest.raises(InputError, match=next(iter(wrong))):
            raw.optimise(**wrong)
    with pytest.raises(InputError, match="no path to follow"):
        mf.plan(panda, None, START, GOAL, max_nodes=1, seed=1, shortcut_iterations=0).optimise()
    kept = mf.plan(panda, None, START, GOAL, constraints=planning.Upright(3.0), seed=1)
    with pytest.raises(InputError, match="path constraints"):
        kept.optimise()


def test_smoothness_makes_corners_rounder(panda):
    raw = mf.plan(panda, None, START, GOAL, seed=2)
    smooth = raw.optimise(smoothness=0.05, iterations=400)
    assert smooth.descent.after.bending < 0.7 * smooth.descent.before.bending
    assert smooth.descent.after.total < smooth.descent.before.total
