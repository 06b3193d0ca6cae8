"""Paths that keep something: measured again by hand, bounds that no state exceeds, ends that do not keep it, loops."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil as mf
from mafsil import planning
from mafsil.collision import Box, Checker, Obstacle
from mafsil.errors import InputError, ModelError
from mafsil.planning import kept_loops, path_constraints
from mafsil.planning.kept_planning import Kept
from mafsil.planning.outcome import PlanningStatus
from mafsil.trajectory import MotionLimits

START = np.radians([45.0, 20, 0, -110, 0, 130, 45])
GOAL = np.radians([-45.0, 20, 0, -110, 0, 130, 45])
CHECKERS = {}
WALL = Obstacle(Box((0.5, 0.04, 0.5)), (0.6, 0.0, 0.25), "wall")


@pytest.fixture(scope="module")
def panda():
    return Checker("panda", [WALL], radius=0.05, self_collision=False)


def dense(path, step=0.001):
    return np.concatenate(
        [a + np.linspace(0, 1, int(np.abs(b - a).max() / step) + 2)[:, None] * (b - a) for a, b in pairwise(path)]
    )


def tilt(T, direction):
    return np.arccos(np.clip(T[..., :3, 2] @ direction, -1.0, 1.0))


@pytest.mark.capability("11-4", "11-50")
@pytest.mark.parametrize("angle", [0.01, 0.15])
def test_a_tool_stays_upright_around_a_wall(panda, angle):
    assert not panda.free_segment(START, GOAL)
    found = mf.plan(panda, None, START, GOAL, constraints=planning.Upright(angle), seed=1)
    assert found, found.explain("en")
    direction = panda.robot.forward_kinematics(START)[:3, 2]
    q = dense(found.path)
    off = tilt(panda.robot.forward_kinematics(q), direction).max()
    assert off <= found.kept_bounds()[0] <= angle
    assert panda.free(q).all()
    assert "deg" in found.explain("en")
    assert found.explain("en") != found.explain("ar")
    unconstrained = mf.plan(panda, None, START, GOAL, planner="prm", seed=1)
    assert tilt(panda.robot.forward_kinematics(dense(unconstrained.path)), direction).max() > angle
    again = mf.plan(panda, None, START, GOAL, constraints=[planning.Upright(angle)], seed=1)
    np.testing.assert_array_equal(found.path, again.path)


@pytest.mark.capability("11-4", "11-7")
@pytest.mark.parametrize(
    ("keep", "shift"),
    [
        (planning.OnLine([0, 1, 0], tolerance=5e-4), (0.0, -0.5, 0.0)),
        (planning.InPlane([1, 0, 0]), (0.0, -0.4, 0.2)),
        ([planning.OnLine([0, 1, 0]), planning.FixedOrientation(tolerance=0.005)], (0.0, -0.5, 0.0)),
    ],
)
def test_goals_as_poses_on_lines_and_in_planes(keep, shift):
    checker = Checker("panda", radius=0.05, self_collision=False)
    T = checker.robot.forward_kinematics(START)
    goal = T.copy()
    goal[:3, 3] += shift
    found = mf.plan(checker, None, START, goal, constraints=keep, seed=1)
    assert found, found.explain("en")
    poses = checker.robot.forward_kinematics(dense(found.path))
    moved = poses[:, :3, 3] - T[:3, 3]
    first = keep[0] if isinstance(keep, list) else keep
    across = np.abs(moved[:, 0]) if isinstance(first, planning.InPlane) else np.linalg.norm(moved[:, [0, 2]], axis=1)
    assert across.max() <= found.kept_bounds()[0] <= first.tolerance
    if isinstance(keep, list):
        cosine = (np.einsum("kij,ij->k", poses[:, :3, :3], T[:3, :3]) - 1.0) / 2.0
        assert np.arccos(np.clip(cosine, -1, 1)).max() <= found.kept_bounds()[1] + 1e-7
    timed = found.time_optimal(MotionLimits.of(7, velocity=2.0, acceleration=5.0))
    q = timed.trajectory.at(np.linspace(0.0, timed.duration, 4000)).u
    assert found.kept is not None
    assert found.kept.holds(checker, q).all()
    assert len(found.joint_path().corners()) == 0


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from(["stanford_arm", "panda", "ur5"]))
def test_bounds_are_above_every_state_of_a_motion(seed, name):
    checker = CHECKERS.setdefault(name, Checker(name, radius=0.05, self_collision=False))
    rng, n = np.random.default_rng(seed), checker.robot.n
    q = rng.uniform(-1.0, 1.0, n)
    a, b = q + rng.uniform(-0.5, 0.5, (2, n))
    keep = (
        planning.Upright(3.0), planning.FixedOrientation(tolerance=3.0),
        planning.OnLine(rng.normal(size=3), tolerance=9.0),
        planning.InPlane(rng.normal(size=3), tolerance=9.0, at=rng.normal(size=3)),
        planning.LoopClosed(checker.robot.mechanism.link_names[3], checker.robot.mechanism.tip, tolerance=9.0),
    )  # fmt: skip
    bounds = np.full(n, -9.0), np.full(n, 9.0)
    kept = Kept(*path_constraints.kept_of(checker, keep, q, bounds))
    worst = kept.along(checker, a[None], b[None])
    assert worst is not None
    measures = kept.measures(checker, dense(np.stack([a, b]), 0.005)).max(axis=0)
    assert (measures <= worst + 1e-12).all()
    assert (worst <= measures + 0.021 * kept.arrays.limit).all()
    T0, T = (checker.robot.forward_kinematics(x) for x in (q, a))
    cosine = (np.trace(T0[:3, :3].T @ T[:3, :3]) - 1) / 2
    one = kept.measures(checker, a[None])[0]
    np.testing.assert_allclose(keep[1].amount(one[1]), np.arccos(np.clip(cosine, -1, 1)), atol=1e-7)
    np.testing.assert_allclose(keep[0].amount(one[0]), tilt(T, T0[:3, 2]), atol=1e-7)


@pytest.mark.parametrize("name", ["stanford_arm", "panda", "ur5"])
def test_projections_keep_it_and_most_are_near(name):
    """Those that begin where the constraints hardly change with q may end far away, or nowhere."""
    checker = CHECKERS.setdefault(name, Checker(name, radius=0.05, self_collision=False))
    found: list[bool] = []
    near: list[float] = []
    for seed in range(40):
        rng, n = np.random.default_rng(seed), checker.robot.n
        q = rng.uniform(-1.0, 1.0, n)
        keep = (planning.InPlane(rng.normal(size=3)), planning.Upright(0.05))
        kept = Kept(*path_constraints.kept_of(checker, keep, q, (np.full(n, -9.0), np.full(n, 9.0))))
        rows, done = q + rng.uniform(-0.02, 0.02, (5, n)), np.zeros(5, bool)
        given_rows = rows.copy()
        kept_loops.project_to_constraints(kept.arrays, checker.world().kinematics, rows, done)
        assert kept.holds(checker, rows)[done].all()
        found += done.tolist()
        near += np.linalg.norm(rows - given_rows, axis=1)[done].tolist()
    assert np.mean(found) > 0.9
    assert np.quantile(near, 0.9) < 0.5


@pytest.mark.capability("11-4")
def test_ends_that_do_not_keep_it_are_named(panda):
    off = mf.plan(panda, None, START, GOAL, constraints=planning.FixedOrientation())
    assert off.status is PlanningStatus.GOAL_OFF
    assert "90 deg" in off.explain("en")
    wrong = mf.plan(panda, None, START, GOAL, constraints=planning.Upright(0.1, direction=[0, 0, 1]))
    assert wrong.status is PlanningStatus.START_OFF
    assert not wrong
    never = mf.plan(panda, None, START, GOAL, constraints=planning.Upright(0.01), max_nodes=1)
    assert never.status is PlanningStatus.NOT_FOUND
    assert "not proven" in never.explain("en")
    same = mf.plan(panda, None, START, START, constraints=planning.Upright(0.1))
    assert same
    assert same.length == 0.0


def test_wrong_constraints_are_named(panda):
    for make, match in (
        (lambda: planning.Upright(0.0), "angle"), (lambda: planning.OnLine([1, np.nan, 0]), "direction"),
        (lambda: planning.InPlane([0, 0, 1], tolerance=-1.0), "tolerance"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=match):
            make()
    for keep, match in (
        (planning.Upright(4.0), "angle"), (planning.Upright(0.1, axis=[0, 0, 0]), "axis"),
        (planning.OnLine([0, 0, 0]), "direction"),
        (planning.FixedOrientation(np.ones((3, 3))), "rotation"),
        ("upright", "constraints"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=match):
            mf.plan(panda, None, START, GOAL, constraints=keep)
    with pytest.raises(ModelError, match="elbow"):
        mf.plan(panda, None, START, GOAL, constraints=planning.Upright(0.1, frame="elbow"))
    with pytest.raises(InputError, match="rrt_connect"):
        mf.plan(panda, None, START, GOAL, constraints=planning.Upright(0.1), planner="prm")


def four_bar():
    """Two arms on one base whose ends are to stay together: a crank, a coupler, and a rocker."""
    names = ("base", "crank", "coupler", "rocker")
    geometry = '<collision><origin xyz="0.1 0 0"/><geometry><sphere radius="0.02"/></geometry></collision>'
    links = "".join(f'<link name="{name}">{geometry if name != "base" else ""}</link>' for name in names)
    joints = "".join(
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{place}"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="2" effort="50"/></joint>'
        for name, parent, child, place in (
            ("a", "base", "crank", "0 0 0"), ("b", "crank", "coupler", "0.2 0 0"), ("c", "base", "rocker", "0.5 0 0"),
        )
    )  # fmt: skip
    return f'<robot name="four_bar">{links}{joints}</robot>'


def closed(angle):
    """(3,) coordinates of the four-bar with its loop closed, for an angle of the crank: two circles meet."""
    elbow, pivot, l2, l3 = 0.2 * np.array([np.cos(angle), np.sin(angle)]), np.array([0.5, 0.0]), 0.5, 0.4
    way = pivot - elbow
    d = np.linalg.norm(way)
    along = (d**2 + l2**2 - l3**2) / (2 * d)
    side = np.sqrt(l2**2 - along**2)
    pin = elbow + along * way / d + side * np.array([-way[1], way[0]]) / d
    b, c = pin - elbow, pin - pivot
    return np.array([angle, np.arctan2(b[1], b[0]) - angle, np.arctan2(c[1], c[0])])


@pytest.mark.capability("11-4")
def test_a_closed_loop_stays_closed(tmp_path):
    path = tmp_path / "four_bar.urdf"
    path.write_text(four_bar())
    checker = Checker(mf.load(str(path), tip="coupler"), self_collision=False)
    loop = planning.LoopClosed("coupler", "rocker", at=(0.5, 0, 0), other_at=(0.4, 0, 0), tolerance=5e-4)
    start, goal = closed(0.4), closed(1.6)
    found = mf.plan(checker, None, start, goal, constraints=loop)
    assert found, found.explain("en")
    assert found.kept_bounds()[0] <= 5e-4
    for q in dense(found.path, 0.01):
        pin = 0.2 * np.array([np.cos(q[0]), np.sin(q[0])]) + 0.5 * np.array([np.cos(q[0] + q[1]), np.sin(q[0] + q[1])])
        other = np.array([0.5 + 0.4 * np.cos(q[2]), 0.4 * np.sin(q[2])])
        assert np.linalg.norm(pin - other) <= found.kept_bounds()[0] + 1e-12
    broken = mf.plan(checker, None, start, goal + np.array([0, 0, 0.1]), constraints=loop)
    assert broken.status is PlanningStatus.GOAL_OFF
