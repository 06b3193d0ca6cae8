"""Roadmaps: shortest ways as Dijkstra finds them, paths that never get longer, many questions, budgets."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import mafsil as mf
from mafsil import planning
from mafsil.collision import Box, Checker, Obstacle
from mafsil.errors import InputError
from mafsil.planning import roadmap_loops
from mafsil.planning.outcome import PlanningStatus

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


@pytest.mark.capability("11-43")
def test_paths_get_shorter_with_the_budget(panda):
    first = mf.plan(panda, None, START, GOAL, seed=4)
    lengths = [first.length]
    for nodes in (400, 1500, 5000):
        found = mf.plan(panda, None, START, GOAL, seed=4, planner="lazy_prm_star", max_nodes=nodes, seconds=60.0)
        assert panda.check_path(found.path)
        assert panda.free(dense(found.path)).all()
        np.testing.assert_array_equal(found.path[[0, -1]], [START, GOAL])
        lengths.append(found.length)
    assert (np.diff(lengths) <= 1e-9).all()
    assert lengths[-1] < lengths[0]
    again = mf.plan(panda, None, START, GOAL, seed=4, planner="lazy_prm_star", max_nodes=5000, seconds=60.0)
    np.testing.assert_array_equal(found.path, again.path)


@pytest.mark.capability("11-43")
def test_the_shortest_way_is_the_shortest_way(panda):
    """In a scene without obstacles for a roadmap grown at random, against scipy's Dijkstra on the same edges."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import dijkstra

    roadmap = planning.ArmRoadmap(panda, seed=2)
    roadmap.grow(300, START)
    arrays, shop = roadmap._arrays, panda.workshop()
    for goal in (5, 50, 200):
        code, way = roadmap_loops.shortest_proved(shop, arrays, 0, np.array([goal]), np.inf, 10_000)
        edges = arrays.edges[: arrays.sizes[1]]
        kept = edges[edges[:, 4] != roadmap_loops.BLOCKED]
        away = np.linalg.norm(arrays.q[kept[:, 0]] - arrays.q[kept[:, 1]], axis=1)
        graph = coo_matrix((away, (kept[:, 0], kept[:, 1])), shape=(300, 300))
        expected = dijkstra(graph, directed=False, indices=0)[goal]
        if code == 0:
            assert np.isinf(expected)
            continue
        length = np.linalg.norm(np.diff(arrays.q[way], axis=0), axis=1).sum()
        np.testing.assert_allclose(length, expected, rtol=1e-12)
        assert panda.check_path(arrays.q[way])


@pytest.mark.capability("11-43")
def test_one_roadmap_answers_many_questions(panda):
    roadmap = planning.ArmRoadmap(panda, seed=1)
    roadmap.grow(1500, START)
    assert roadmap.nodes == 1500
    rng = np.random.default_rng(0)
    ends = START + rng.uniform(-0.4, 0.4, (30, 7))
    ends = ends[panda.free(ends)][:6]
    goals = ends * [-1, 1, 1, 1, 1, 1, 1]
    answers = [
        mf.plan(roadmap, None, a, b, max_nodes=roadmap.nodes)
        for a, b in zip(ends, goals, strict=True)
        if panda.free(b)
    ]  # fmt: skip
    assert sum(map(bool, answers)) >= len(answers) - 1
    for found in answers:
        assert not found or panda.check_path(found.path)
    before = roadmap.proved
    again = mf.plan(roadmap, None, answers[0].path[0], answers[0].path[-1], max_nodes=roadmap.nodes)
    assert again
    assert again.length <= answers[0].length * (1 + 1e-9)
    assert roadmap.proved >= before
    inside = np.array([0.0, 0.9, 0.0, -1.0, 0.0, 1.9, 0.0])
    blocked = mf.plan(roadmap, None, START, inside)
    assert blocked.status is PlanningStatus.GOAL_BLOCKED


@pytest.mark.capability("11-43")
def test_several_goals_and_none_in_the_budget(panda):
    two = mf.plan(panda, None, START, [GOAL, GOAL + 0.1], planner="lazy_prm_star", max_nodes=800, seconds=30.0)
    assert two
    assert two.goal in (0, 1)
    few = mf.plan(planning.ArmRoadmap(panda), None, START, GOAL, max_nodes=2)
    assert few.status is PlanningStatus.NOT_FOUND
    same = mf.plan(planning.ArmRoadmap(panda), None, START, START)
    assert same.length == 0.0
    with pytest.raises(InputError, match="roadmap"):
        mf.plan(planning.ArmRoadmap(panda), [WALL], START, GOAL)
    with pytest.raises(InputError, match="nodes"):
        planning.ArmRoadmap(panda).grow(0, START)
    with pytest.raises(InputError, match="q"):
        planning.ArmRoadmap(panda).grow(5, START[:3])
