"""What planning of arms does with nothing, with very much, with what is no number, and with no time."""

from __future__ import annotations

import os
import signal
import threading
from time import perf_counter

import numpy as np
import pytest

import mafsil as mf
from mafsil import planning
from mafsil.collision import Box, Checker, Obstacle, TriangleMesh
from mafsil.errors import InputError
from mafsil.planning.outcome import PlanningStatus

START = np.radians([45.0, 20, 0, -110, 0, 130, 45])
GOAL = np.radians([-45.0, 20, 0, -110, 0, 130, 45])
PLANNERS = ("rrt_connect", "lazy_prm_star", "trajectory_optimisation")


@pytest.fixture(scope="module")
def parted():
    """An arm of four links in a plane that cannot go from one side to the other, and an end on each side."""
    plates = [
        Obstacle(Box((2.4, 0.02, 0.5)), (1.4, 0.0, 0.0), "before"),
        Obstacle(Box((2.4, 0.02, 0.5)), (-1.4, 0.0, 0.0), "behind"),
    ]
    home = np.eye(4)
    home[0, 3] = 2.0
    arm = mf.Robot.from_screws([[0, 0, 1, 0, -x, 0] for x in (0.0, 0.5, 1.0, 1.5)], home)
    start, goal = np.array([0.7, 0.1, 0.0, 0.0]), np.array([-0.7, 0.1, 0.0, 0.0])
    return Checker(arm, plates, radius=0.03, self_collision=False), start, goal


@pytest.fixture(scope="module")
def panda():
    return Checker("panda", radius=0.05, self_collision=False)


@pytest.mark.capability("11-40")
@pytest.mark.parametrize("planner", PLANNERS)
def test_an_empty_scene(panda, planner):
    found = mf.plan(panda, [], START, GOAL, planner=planner, max_nodes=50, seconds=20.0)
    assert found
    np.testing.assert_allclose(found.length, np.linalg.norm(GOAL - START), rtol=1e-9)
    assert np.isinf(found.clearance(5).distance).all()


@pytest.mark.capability("11-40")
def test_a_mesh_of_a_million_triangles(panda):
    side = 708
    x, y = np.meshgrid(np.linspace(0.3, 0.8, side), np.linspace(-0.5, 0.5, side), indexing="ij")
    z = 0.15 * np.exp(-(y**2) / 0.01)
    index = np.arange(side * side).reshape(side, side)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])[:1_000_000]
    assert len(faces) > 999_000
    ridge = Obstacle(TriangleMesh(np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1), faces), name="ridge")
    over = panda.with_scene([ridge])
    found = mf.plan(over, None, START, GOAL, seed=1, seconds=20.0)
    assert found, found.explain("en")
    assert over.check_path(found.path)


@pytest.mark.parametrize("planner", PLANNERS)
def test_what_is_no_number_and_ends_that_are_the_same(panda, planner):
    T = panda.robot.forward_kinematics(GOAL)
    T[0, 3] = np.nan
    with pytest.raises(InputError, match="goal"):
        mf.plan(panda, None, START, T, planner=planner)
    with pytest.raises(InputError, match="start"):
        mf.plan(panda, None, np.full(7, np.nan), GOAL, planner=planner)
    same = mf.plan(panda, None, START, START, planner=planner, seconds=1.0)
    assert same.status is PlanningStatus.FOUND
    assert same.length == 0.0
    beyond = mf.plan(panda, None, START + np.array([9.0, 0, 0, 0, 0, 0, 0]), GOAL, planner=planner)
    assert beyond.status is PlanningStatus.START_OUTSIDE
    assert "limits" in beyond.explain("en")


@pytest.mark.capability("11-40")
@pytest.mark.parametrize("planner", [*PLANNERS, "prm", "rrt_star"])
def test_time_runs_out(parted, planner):
    checker, start, goal = parted
    mf.plan(checker, None, start, goal, planner=planner, max_nodes=20, seconds=0.1)
    begun = perf_counter()
    found = mf.plan(checker, None, start, goal, planner=planner, seconds=0.3, max_nodes=10**7)
    assert perf_counter() - begun < 10.0
    assert found.status is PlanningStatus.NOT_FOUND
    assert "not proven" in found.explain("en")
    assert "are unlimited" in found.explain("en"), "such as from 3 to -3 rad past a bar at 0"


def test_the_best_so_far_when_time_runs_out(panda):
    wall = panda.with_scene([Obstacle(Box((0.5, 0.04, 0.6)), (0.6, 0.0, 0.3), "wall")])
    plain = mf.plan(wall, None, START, GOAL, seed=3)
    hurried = mf.plan(wall, None, START, GOAL, seed=3, planner="lazy_prm_star", seconds=0.2)
    assert hurried
    assert hurried.length <= plain.length * (1 + 1e-9)


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("keep", [(), planning.InPlane([0, 0, 1])])
def test_an_interruption_ends_a_search_soon(parted, keep):
    checker, start, goal = parted
    mf.plan(checker, None, start, goal, max_nodes=20, seconds=0.1, constraints=keep)
    timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
    begun = perf_counter()
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            mf.plan(checker, None, start, goal, seconds=30.0, max_nodes=10**7, constraints=keep)
        assert perf_counter() - begun < 20.0
    finally:
        timer.cancel()
        timer.join()
