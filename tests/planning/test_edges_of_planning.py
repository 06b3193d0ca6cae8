"""Empty and huge scenes, NaN, equal ends, limits, time-outs and Ctrl-C: a clear answer each, the best so far kept."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.cli.main import main
from mafsil.collision import Box, Checker, Obstacle, Sphere, TriangleMesh
from mafsil.job import parse_job, solve
from mafsil.job.judging.judgement import summary
from mafsil.job.solve import prepare
from mafsil.planning import Problem, arm_planners, find_path, roadmap_loops, search
from mafsil.planning.outcome import PlanningStatus, is_interruption
from mafsil.planning.problem import length_of
from mafsil.report.results import as_data

A = np.array([0.8, -0.3, 0.0, -2.2, 0.0, 1.9, 0.8])
B = np.array([-0.8, -0.3, 0.0, -2.2, 0.0, 1.9, 0.8])
WALL = Obstacle(Box((0.5, 0.04, 0.7)), (0.6, 0.0, 0.35), "wall")


@pytest.fixture(scope="module")
def arm():
    return Checker("panda", radius=0.05)


def far_balls(count):
    """Balls beyond the reach of the arm, all around it."""
    rng = np.random.default_rng(1)
    rows = rng.normal(size=(count, 3))
    rows *= rng.uniform(1.6, 2.5, (count, 1)) / np.linalg.norm(rows, axis=1, keepdims=True)
    return rows


@pytest.mark.capability("11-39", "11-40")
def test_empty_scenes_and_arms_without_shapes(arm):
    for scene in (None, [], mf.Scene()):
        assert len(mf.plan(arm, scene, A, B).path) == 2
    assert mf.plan("panda", None, A, B, radius=0.05)
    assert mf.plan("panda", None, A, B)
    bare = mf.Robot.from_dh([[0.4, 0.0, 0.1, 0.0], [0.3, 0.0, 0.0, 0.0]], "modified")
    with pytest.raises(mf.InputError, match="radius="):
        mf.plan(bare, None, [0.0, 0.0], [1.0, 0.0])


@pytest.mark.capability("11-39", "11-40")
def test_ten_thousand_obstacles_and_a_mesh_of_a_million_triangles(arm):
    near = mf.Scene([WALL, *(Obstacle(Sphere(0.03), p, f"ball {k}") for k, p in enumerate(far_balls(10_000)))])
    plan = mf.plan(arm, near, A, B)
    assert plan
    assert plan.checker.free_segment(plan.path[:-1], plan.path[1:]).all()
    n = 708
    x, y = np.meshgrid(*[np.linspace(-2, 2, n)] * 2)
    i = np.arange(n * n).reshape(n, n)
    lower, upper = [i[:-1, :-1], i[1:, :-1], i[:-1, 1:]], [i[1:, 1:], i[:-1, 1:], i[1:, :-1]]
    faces = np.concatenate([np.stack(each, -1).reshape(-1, 3) for each in (lower, upper)])
    hills = np.stack([x, y, -0.5 + 0.05 * np.sin(5 * x) * np.cos(5 * y)], -1).reshape(-1, 3)
    assert len(faces) > 999_000
    ground = arm.with_scene(mf.Scene([WALL, Obstacle(TriangleMesh(hills, faces), (0, 0, 0.4), "ground")]))
    plan = mf.plan(ground, None, A, B)
    assert plan
    low = np.array([1.5, 1.7, 0.0, -0.5, 0.0, 2.0, 0.0])
    stopped = mf.plan(ground, None, A, low)
    assert stopped.status is PlanningStatus.GOAL_BLOCKED
    assert "ground" in stopped.explain("en")


@pytest.mark.capability("11-40")
def test_numbers_that_are_none_and_ends_that_cannot_be_are_named(arm):
    T = np.eye(4)
    for start, goal in (
        (np.nan * A, B),
        (A, np.nan * B),
        (A, [np.inf, *B[1:]]),
        (A, T * np.nan),
        (A, np.zeros((0, 7))),
    ):
        with pytest.raises(mf.InputError):
            mf.plan(arm, None, start, goal)
    same = mf.plan(arm, None, A, A)
    assert same
    assert same.length == 0.0
    outside = A.copy()
    outside[3] = 0.5
    assert mf.plan(arm, None, outside, B).status is PlanningStatus.START_OUTSIDE
    found = mf.plan(arm, None, B, outside)
    assert found.status is PlanningStatus.GOAL_OUTSIDE
    assert "joint4" in found.explain("en")
    T[0, 3] = 5.0
    far = mf.plan(arm, None, A, T)
    assert far.status is PlanningStatus.UNREACHABLE
    assert "out of reach" in far.explain("en")
    assert "inf" not in far.explain("en").split("\n")[-1]
    assert far.explain("ar") != far.explain("en")
    for wrong, words in (
        ({"goal": "home"}, "goal: expected real numbers"),
        ({"goal": 2.0 * np.eye(4)}, "goal: not a pose"),
        ({"planner": ["prm"]}, "rrt_connect"),
        ({"radius": 0.1}, "a Checker has its capsules already"),
        ({"clearance": -1.0}, "clearance"),
        ({"scene": Box((1, 1, 1))}, "list of obstacles"),
    ):
        with pytest.raises(mf.MafsilError, match=words):
            mf.plan(arm, wrong.pop("scene", None), A, wrong.pop("goal", B), **wrong)
    with pytest.raises(mf.InputError, match="finite"):
        same.at(np.nan)
    lower = arm.robot.limits.lower
    barely = mf.plan(arm, None, np.where(np.arange(7) == 3, np.nextafter(lower, -9.0), A), B)
    assert barely, "an end that rounding leaves beyond a limit is on it"
    assert "by at most 4.4e-16" in barely.explain("en")


@pytest.mark.capability("11-39")
def test_the_margin_of_a_question_counts_for_a_checker_too(arm):
    """It was ignored without a word."""
    ball = arm.with_scene([Obstacle(Sphere(0.05), (0.3, 0.3, 0.8), "ball")])
    found = ball.distance(A)
    assert found.second == "ball"
    near = float(found.distance)
    assert mf.plan(ball, None, A, A, clearance=0.9 * near)
    kept = mf.plan(ball, None, A, A, clearance=1.1 * near)
    assert kept.status is PlanningStatus.START_BLOCKED


@pytest.mark.capability("11-40")
def test_a_time_out_says_so_and_planners_that_improve_give_their_best(arm):
    cell = [Obstacle(Box((0.1, 0.1, 0.1)), (0.0, 0.0, 5.0))]
    stuck = Problem(-np.ones(2), np.ones(2), lambda q: np.abs(q[:, 0]) > 0.1, resolution=0.01)
    cut = find_path(stuck, [-0.5, 0.0], [0.5, 0.0], seconds=0.05)
    assert cut.status is PlanningStatus.NOT_FOUND
    assert cut.seconds < 2.0
    assert mf.plan(arm, [*cell, WALL], A, B, max_nodes=1).status is PlanningStatus.NOT_FOUND
    for planner in ("lazy_prm_star", "rrt_star"):
        mf.plan(
            arm, [WALL], A, B, planner=planner, seconds=60.0, max_nodes=60
        )  # A first call ever waits for the compiler.
        plan = mf.plan(arm, [WALL], A, B, planner=planner, seconds=0.2)
        assert plan
        assert not plan.interrupted
        assert plan.seconds < 2.0


def test_ctrl_c_in_searches_from_other_seeds_ends_with_the_best_of_them(arm, monkeypatch):
    real, made = arm_planners.rrt_connect, []

    def stopped(asked):
        if len(made) == 4:
            raise KeyboardInterrupt
        made.append(real(asked))
        return made[-1]

    monkeypatch.setattr(arm_planners, "rrt_connect", stopped)
    plan = mf.plan(arm, [WALL], A, B, planner="lazy_prm_star", seconds=60.0)
    assert plan.interrupted
    assert plan.seconds < 60.0
    assert plan.length == min(length_of(path) for path, _, _ in made)


def test_ctrl_c_keeps_the_best_so_far(arm, monkeypatch):
    """Also where it comes while a compiled loop gives its result, which Python calls a SystemError."""
    looks = iter(range(100))
    real = roadmap_loops.shortest_proved

    def stopped(*args):
        if next(looks) == 2:
            try:
                raise KeyboardInterrupt
            except KeyboardInterrupt as cause:
                raise SystemError("returned a result with an exception set") from cause
        return real(*args)

    monkeypatch.setattr(roadmap_loops, "shortest_proved", stopped)
    plan = mf.plan(arm, [WALL], A, B, planner="lazy_prm_star", seconds=60.0)
    assert plan
    assert plan.interrupted
    assert plan.seconds < 60.0
    assert plan.checker.free_segment(plan.path[:-1], plan.path[1:]).all()
    assert "interrupted" in plan.explain("en")
    assert plan.to_dict()["interrupted"] is True
    assert not mf.plan(arm, [WALL], A, B).interrupted
    text = f'robot = "panda"\n[collision]\nplanner = "lazy_prm_star"\navoid = true\n[start]\njoints = {A.tolist()}\n'
    text += f"[[obstacle]]\nbox = [0.5, 0.04, 0.7]\nposition = [0.6, 0, 0.35]\n[[move]]\njoints = {B.tolist()}\n"
    looks = iter(range(100))
    with pytest.raises(KeyboardInterrupt):
        prepare(parse_job(text), text, Path())


def test_ctrl_c_without_a_path_goes_on(arm, monkeypatch):
    def stopped(*args, **kwargs):
        raise KeyboardInterrupt

    monkeypatch.setattr(search, "_grown", stopped)
    problem = Problem([-1, -1], [1, 1], lambda q: np.abs(q[:, 0]) > 0.1, resolution=0.01)
    with pytest.raises(KeyboardInterrupt):
        find_path(problem, [-0.5, 0.0], [0.5, 0.0])
    assert not is_interruption(SystemError("of another kind"))
    assert not is_interruption(ValueError())


@pytest.mark.capability("11-40")
def test_the_same_by_command(tmp_path, capsys):
    rows = far_balls(2_000)
    scene = tmp_path / "many.toml"
    scene.write_text("".join(f"[[obstacle]]\nsphere = 0.03\nposition = {p.round(4).tolist()}\n" for p in rows))
    a, b = ([f"{x}" for x in q] for q in (A, B))
    assert main(["plan", "panda", "--start", *a, "--goal", *b, "--scene", str(scene)]) == 0
    capsys.readouterr()
    for words, said in (
        (["--start", "nan", *a[1:], "--goal", *b], "nan"),
        (["--start", *a[:3], "0.5", *a[4:], "--goal", *b], "joint4"),
        (["--start", *a, "--pose", "5", "0", "0", "0", "0", "0"], "out of reach"),
        (["--start", *a, "--goal", *b, "--planner", "teleport"], "rrt_connect"),
        (["--start", *a, "--goal", *b, "--seconds", "0"], "seconds"),
    ):
        assert main(["plan", "panda", *words]) != 0
        assert said in capsys.readouterr().err
    assert main(["plan", "panda", "--start", *a, "--goal", *a, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["length"] == 0.0


def test_a_job_with_nothing_to_meet_has_results():
    text = 'robot = "panda"\n[collision]\navoid = true\nself_collision = false\n'
    text += f"[start]\njoints = {A.tolist()}\n[[move]]\njoints = {A.tolist()}\n"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        run = solve(parse_job(text), text, Path())
    data = as_data(run, summary(run))
    assert data["clearance"] is None
    json.dumps(data, allow_nan=False)
