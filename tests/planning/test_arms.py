"""Arms among obstacles: paths that coal finds free too, ends that cannot be, goals as poses, problems of others."""

from __future__ import annotations

import json
import lzma
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.collision import Box, Checker, Cylinder, Obstacle, Scene, Sphere
from mafsil.errors import InputError
from mafsil.geometry.rotation import from_quaternion
from mafsil.planning.outcome import PlanningStatus
from mafsil.trajectory import JointPath, MotionLimits, time_optimal
from tests.collision.arms import arm, scene
from tests.collision.peer import CoalChecker

PROBLEMS = Path(__file__).parents[3] / "shared" / "data" / "planning"
WALL = Scene([Obstacle(Box((0.7, 0.1, 1.2)), (0.65, 0.0, 0.6), "wall")])
GRAZING = ("table_pick", 72)
LEFT, RIGHT = np.array([1.1, 0.9, 0.3, 0.0, 0.2, 0.0]), np.array([-1.1, 0.9, 0.3, 0.0, 0.2, 0.0])


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return arm(tmp_path_factory.mktemp("arm"))


def dense(path, step):
    """Configurations along a path, no coordinate more than a step apart."""
    parts = [a + np.linspace(0, 1, int(np.abs(b - a).max() / step) + 2)[:, None] * (b - a) for a, b in pairwise(path)]
    return np.concatenate(parts)


@pytest.mark.capability("11-40", "11-50")
def test_an_arm_goes_round_a_wall_and_coal_agrees(robot):
    checker = Checker(robot, WALL)
    assert not checker.free_segment(LEFT, RIGHT)
    found = mf.plan(checker, None, LEFT, RIGHT, seed=3)
    assert found
    np.testing.assert_array_equal(found.path[[0, -1]], [LEFT, RIGHT])
    assert checker.check_path(found.path)
    peer = CoalChecker(checker)
    assert min(peer.distance(q) for q in dense(found.path, 0.01)) > 0.0
    limits = robot.limits
    assert ((found.path >= limits.lower) & (found.path <= limits.upper)).all()
    raw = mf.plan(checker, None, LEFT, RIGHT, seed=3, shortcut_iterations=0)
    assert found.length <= raw.length
    assert found.clearance(50)
    assert found.proofs > 0
    assert found.explain("en") != found.explain("ar")


@pytest.mark.capability("11-40")
@pytest.mark.parametrize("seed", range(6))
def test_paths_in_random_scenes_are_free_by_dense_checks(robot, seed):
    checker = Checker(robot, scene(seed))
    rng = np.random.default_rng(seed)
    ends = rng.uniform(-2.5, 2.5, (400, 6))
    ends = ends[checker.free(ends)][:2]
    found = mf.plan(checker, None, *ends, seed=seed, seconds=30.0)
    assert found, found.explain("en")
    assert checker.free(dense(found.path, 0.002)).all()
    again = mf.plan(checker, None, *ends, seed=seed, seconds=30.0)
    np.testing.assert_array_equal(found.path, again.path)


@pytest.mark.capability("11-40")
@pytest.mark.parametrize("planner", ["prm", "rrt_star"])
def test_other_planners_prove_too(robot, planner):
    checker = Checker(robot, WALL)
    found = mf.plan(
        checker, None, LEFT, RIGHT, planner=planner, max_nodes=600, seconds=30.0, seed=1, shortcut_iterations=20
    )
    assert found, found.explain("en")
    assert checker.check_path(found.path)


@pytest.mark.capability("11-40")
def test_ends_that_cannot_be_are_named(robot):
    checker = Checker(robot, WALL)
    inside = np.array([0.0, 1.2, 0.4, 0.0, 0.2, 0.0])
    blocked = mf.plan(checker, None, inside, RIGHT)
    assert blocked.status is PlanningStatus.START_BLOCKED
    assert "wall" in blocked.explain("en")
    assert not blocked
    ends = mf.plan(checker, None, LEFT, [inside, inside + 0.01])
    assert ends.status is PlanningStatus.GOAL_BLOCKED
    assert "goal 1" in ends.explain("en")
    several = mf.plan(checker, None, LEFT, [inside, RIGHT], seed=3)
    assert several
    assert several.goal == 1
    beyond = mf.plan(checker, None, LEFT + np.array([5.0, 0, 0, 0, 0, 0]), RIGHT)
    assert beyond.status is PlanningStatus.START_OUTSIDE
    assert "joint1" in beyond.explain("en")
    assert mf.plan(checker, None, LEFT, RIGHT + 9.0).status is PlanningStatus.GOAL_OUTSIDE
    same = mf.plan(checker, None, LEFT, LEFT)
    assert same
    assert same.length == 0.0


@pytest.mark.capability("11-40")
def test_a_search_says_only_that_it_found_nothing(robot):
    found = mf.plan(robot, WALL, LEFT, RIGHT, max_nodes=1)
    assert found.status is PlanningStatus.NOT_FOUND
    assert "not proven" in found.explain("en")
    assert found.length == np.inf


@pytest.mark.capability("11-40", "11-50")
def test_goals_as_poses(robot):
    checker = Checker(robot, WALL)
    T = robot.forward_kinematics(RIGHT)
    for goal in (T, mf.Pose.of(T[:3, :3], T[:3, 3]), np.stack([T, T])):
        found = mf.plan(checker, None, LEFT, goal, seed=1)
        assert found
        np.testing.assert_allclose(robot.forward_kinematics(found.path[-1]), T, atol=1e-7)
    far = T.copy()
    far[:3, 3] = [5.0, 0.0, 0.0]
    assert mf.plan(checker, None, LEFT, far).status is PlanningStatus.UNREACHABLE


def test_without_obstacles_the_path_is_straight(robot):
    found = mf.plan(robot, [], LEFT, RIGHT)
    assert found
    assert len(found.path) == 2
    wide = mf.plan(robot, WALL, LEFT, RIGHT, clearance=0.02, seed=2)
    assert wide
    assert (wide.clearance().distance > 0.02).all()


@pytest.mark.capability("11-40", "11-50")
@pytest.mark.parametrize("jerk", [np.inf, 50.0])
def test_the_timed_motion_is_free_and_does_not_stop(robot, jerk):
    checker = Checker(robot, WALL)
    found = mf.plan(checker, None, LEFT, RIGHT, seed=3)
    path = found.joint_path()
    assert len(path.corners()) == 0
    assert len(path.stops()) == 0
    limits = MotionLimits.of(6, velocity=2.0, acceleration=5.0, jerk=jerk)
    timed = found.time_optimal(limits)
    assert timed
    q = timed.trajectory.at(np.linspace(0.0, timed.duration, 20_000)).u
    assert checker.free(q).all()
    np.testing.assert_allclose(q[[0, -1]], [LEFT, RIGHT], atol=1e-9)
    winding = mf.plan(checker, None, LEFT, RIGHT, seed=3, shortcut_iterations=0)
    stopping = time_optimal(JointPath.through(winding.path, "lines"), limits)
    assert winding.time_optimal(limits).duration < 0.8 * stopping.duration
    sharp = found.joint_path(share=0.0)
    assert len(sharp.corners()) == len(found.path) - 2
    with pytest.raises(InputError, match="share"):
        found.joint_path(share=0.7)
    with pytest.raises(InputError, match="no path"):
        mf.plan(robot, WALL, LEFT, RIGHT, max_nodes=1).time_optimal(limits)


def test_the_largest_way_bounds_every_point(robot):
    checker = Checker(robot, WALL)
    rng = np.random.default_rng(0)
    for _ in range(50):
        q, dq = rng.uniform(-2, 2, 6), rng.uniform(-0.2, 0.2, 6)
        poses = [robot.link_poses(x) for x in (q, q + dq)]
        moved = max(
            np.linalg.norm((b[body.link] @ T)[:3, 3] - (a[body.link] @ T)[:3, 3])
            for body in checker.bodies
            for _, T in body.shapes
            for a, b in [poses]
        )
        assert moved <= checker.largest_way(np.abs(dq), np.abs(q)) + 1e-12


def test_wrong_arguments_are_named(robot):
    for start, goal, match in (
        ([np.nan] * 6, RIGHT, "start"), (LEFT[:5], RIGHT, "start"), (LEFT, RIGHT[:5], "goal"),
        (LEFT, np.full((2, 6), np.inf), "goal"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=match):
            mf.plan(robot, [], start, goal)
    for wrong, match in (({"planner": "magic"}, "rrt_connect"), ({"seconds": 0}, "seconds"), ({"nodes": 0}, "nodes")):
        with pytest.raises(InputError, match=match):
            mf.plan(robot, [], LEFT, RIGHT, **wrong)


def problem_obstacle(row):
    T = np.eye(4)
    quaternion = np.array(row["quaternion_wxyz"])
    T[:3, :3], T[:3, 3] = from_quaternion(quaternion / np.linalg.norm(quaternion)), row["position"]
    made = {
        "box": lambda: Box(tuple(row["size"])),
        "cylinder": lambda: Cylinder(row["radius"], row["length"]),
        "sphere": lambda: Sphere(row["radius"]),
    }
    return Obstacle(made[row["kind"]](), T, row["name"])


@pytest.mark.skipif(not PROBLEMS.exists(), reason="the problems of others are not here")
@pytest.mark.parametrize("name", ["panda", "ur5"])
@pytest.mark.filterwarnings("ignore")
def test_problems_of_others_are_solved(name):
    with lzma.open(PROBLEMS / f"{name}.json.xz") as file:
        data = json.load(file)
    checker = Checker(str(PROBLEMS / f"{name}_spherized.urdf"), srdf=PROBLEMS / f"{name}.srdf")
    names = [each.name for each in checker.robot.mechanism.coordinates]
    for found in data["sets"].values():
        for problem in found["problems"][:3]:
            ends = []
            for key in ("start", "goal"):
                values = dict(zip(found["joints"], problem[key], strict=True)) | (data["other_joints"] or {})
                ends.append(np.array([values[each] for each in names]))
            there = checker.with_scene(Scene(map(problem_obstacle, problem["obstacles"])))
            path = mf.plan(there, None, *ends)
            if path.status in (PlanningStatus.START_BLOCKED, PlanningStatus.GOAL_BLOCKED):
                assert not there.free(np.stack(ends)).all()
                continue
            assert path, path.explain("en")
            assert there.free(dense(path.path, 0.005)).all()


@pytest.mark.capability("11-50")
@pytest.mark.skipif(not PROBLEMS.exists(), reason="the problems of others are not here")
@pytest.mark.filterwarnings("ignore")
def test_what_shortcuts_leave_of_other_motions_stands_a_proof_of_its_own():
    """On this problem a shortcut left a part of a motion that passes within a micrometre of an obstacle."""
    with lzma.open(PROBLEMS / "panda.json.xz") as file:
        data = json.load(file)
    checker = Checker(str(PROBLEMS / "panda_spherized.urdf"), srdf=PROBLEMS / "panda.srdf")
    names = [each.name for each in checker.robot.mechanism.coordinates]
    found = data["sets"][GRAZING[0]]
    problem = found["problems"][GRAZING[1]]
    ends = []
    for key in ("start", "goal"):
        values = dict(zip(found["joints"], problem[key], strict=True)) | (data["other_joints"] or {})
        ends.append(np.array([values[each] for each in names]))
    there = checker.with_scene(Scene(map(problem_obstacle, problem["obstacles"])))
    path = mf.plan(there, None, *ends)
    assert path
    assert there.check_path(path.path)
