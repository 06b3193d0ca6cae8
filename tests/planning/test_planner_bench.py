"""Planners side by side, and searches watched edge by edge."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

import mafsil as mf
from mafsil import figures, planning
from mafsil.collision import Box, Checker, Obstacle, Scene
from mafsil.errors import InputError
from mafsil.planning import PLANNERS, Problem, Query, bench_planners, log_search
from mafsil.planning.outcome import PlanningStatus


def disc(q):
    return np.linalg.norm(q, axis=1) > 0.4


def point(goal=(0.8, 0.0), free=disc):
    return Query("point", Problem([-1, -1], [1, 1], free), np.array([-0.8, 0.0]), np.array(goal))


def arm():
    wall = Obstacle(Box((0.5, 0.04, 0.6)), (0.6, 0.0, 0.3), "wall")
    checker = Checker("panda", Scene([wall]), radius=0.05, self_collision=False)
    ends = np.radians([[45, 20, 0, -110, 0, 130, 45], [-45, 20, 0, -110, 0, 130, 45]])
    return Query("arm", checker, *ends)


@pytest.mark.capability("11-50")
def test_all_planners_answer_the_same_question():
    found = bench_planners([point()], seeds=(0, 1), seconds=0.5, max_nodes=1500)
    assert {each.planner for each in found} == set(PLANNERS)
    assert found
    shortest = 2 * np.sqrt(0.8**2 - 0.4**2) + 0.4 * (np.pi - 2 * np.arccos(0.5))
    for each in found:
        assert each.solved == 2
        assert (each.length >= shortest - 1e-9).all()
        assert (each.configurations > 0).all()
    star = next(each for each in found if each.planner == "rrt_star")
    assert star.median_length < 1.1 * shortest
    again = bench_planners([point()], ["rrt_connect"], seeds=(0, 1), seconds=5.0)
    first = next(each for each in found if each.planner == "rrt_connect")
    assert np.array_equal(next(iter(again)).length, first.length)
    assert "rrt_connect" in repr(found)
    assert "2" in found.explain("ar")


@pytest.mark.capability("11-50")
def test_ctrl_c_keeps_the_planners_that_have_answered(monkeypatch):
    def stopped(problem, start, goals, budget):
        raise KeyboardInterrupt

    monkeypatch.setitem(PLANNERS, "stopped", stopped)
    found = bench_planners([point()], ["rrt_connect", "stopped", "prm"], seeds=(0,), seconds=5.0)
    assert found.interrupted
    assert not found
    assert [each.planner for each in found] == ["rrt_connect"]
    assert "interrupted" in found.explain("en")
    with pytest.raises(KeyboardInterrupt):
        bench_planners([point()], ["stopped"], seeds=(0,))


@pytest.mark.capability("11-50")
def test_what_is_not_solved_is_said_with_its_reason():
    walled = point(free=lambda q: np.abs(q[:, 0]) > 0.1)
    blocked = point(goal=(0.0, 0.0))
    found = bench_planners([point(), walled, blocked], ["rrt_connect", "prm"], seeds=(0,), seconds=1.0, max_nodes=200)
    assert not found
    for each in found:
        assert each.solved == 1
        assert [row[0] for row in each.status] == [
            PlanningStatus.FOUND, PlanningStatus.NOT_FOUND, PlanningStatus.GOAL_BLOCKED]  # fmt: skip
    assert "not proven" in found.explain("en")
    assert "goal" in found.explain("en")


@pytest.mark.capability("11-50")
def test_planners_of_arms_and_ones_own():
    def straight_or_corner(problem, start, goals, budget):
        """A path of two segments over random corners."""
        for made in range(1, budget.nodes):
            if not budget.left(made):
                break
            corner = problem.sample(budget.rng, 1)[0]
            path = np.stack([start, corner, goals[0]])
            if problem.is_free_path(path):
                return path, made
        return None, budget.nodes

    PLANNERS["corner"] = straight_or_corner
    try:
        query = arm()
        found = bench_planners([query], ["rrt_connect", "corner"], seeds=(0,), seconds=5.0)
        assert found
        for each in found:
            assert each.clearance[0, 0] > 0.0
        log = log_search(query, "corner", max_nodes=5000)
        assert log.plan
        assert np.allclose(log.edges[-1, 1], query.goal)
    finally:
        del PLANNERS["corner"]


@pytest.mark.capability("11-50")
def test_a_watched_search_is_the_search(tmp_path):
    query = point()
    log = log_search(query, "rrt_connect", seed=4)
    plain = planning.find_path(query.space, query.start, query.goal, seed=4, shortcut_iterations=False)
    assert np.array_equal(log.plan.path, plain.path)
    assert len(log) == plain.segments
    for (a, b), free in zip(log.edges, log.free, strict=True):
        steps = a + np.linspace(0, 1, 400)[:, None] * (b - a)
        if not free:
            assert np.linalg.norm(steps, axis=1).min() <= 0.4 + 0.02
        else:
            assert np.linalg.norm(steps, axis=1).min() > 0.4 - 0.02
    file = tmp_path / "search.svg"
    figures.plot_search(log, file, seconds=3.0, language="ar")
    root = ET.parse(file).getroot()
    lines = [each for each in root if each.tag.endswith("polyline")]
    assert len(lines) == len(log) + 1
    begins = [float(line[0].get("begin")[:-1]) for line in lines]
    assert begins == sorted(begins)
    assert begins[-1] == 3.0
    assert any(each.get("fill") == "#ccc" for each in root)


def test_pictures_of_arms_and_refusals(tmp_path):
    log = log_search(arm(), "rrt_connect", max_nodes=300)
    figures.plot_search(log, tmp_path / "arm.svg")
    assert (tmp_path / "arm.svg").stat().st_size > 2000
    with pytest.raises(InputError, match="show"):
        figures.plot_search(log, tmp_path / "bad.svg", show=lambda q: q)
    with pytest.raises(InputError, match="png"):
        figures.plot_search(log, tmp_path / "bad.png")
    with pytest.raises(InputError, match="planner"):
        log_search(point(), "trajectory_optimisation")
    with pytest.raises(InputError, match="planners"):
        bench_planners([point()], ["lazy_prm_star"])
    with pytest.raises(InputError, match="query"):
        bench_planners([])
    with pytest.raises(InputError, match="seconds"):
        bench_planners([point()], seconds=0.0)


def test_the_command(tmp_path, capsys):
    from mafsil.cli.main import main

    job = "examples/jobs/around_a_wall_panda.toml"
    code = main(["compare", "planners", job, "--planners", "rrt_connect", "prm", "--seeds", "1", "--seconds", "2",
                 "--replay", str(tmp_path), "--lang", "en"])  # fmt: skip
    said = capsys.readouterr().out
    assert code == 0
    assert re.search(r"solved\s+\d/\d\s+\d/\d", said)
    assert {each.name for each in tmp_path.glob("*.svg")} == {"rrt_connect.svg", "prm.svg"}
    assert main(["compare", "planners", job, "--laws", "pid"]) != 0
    assert main(["compare", "planners", "examples/jobs/palletiser.toml", "--seeds", "1"]) != 0
    assert mf.planning.PLANNERS
