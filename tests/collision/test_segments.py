"""Motions proved free: nothing thin is stepped over, dense sampling finds nothing, all kinds of joints are bounded."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil as mf
from mafsil import collision
from mafsil.collision import Box, Checker, Obstacle, Sphere
from mafsil.collision.checker import PathStatus
from tests.collision.arms import arm, scene, urdf


def audit(checker: Checker, a, b, step: float) -> bool:
    """Whether any of densely sampled states collides."""
    count = max(2, int(np.abs(b - a).max() / step))
    return bool(checker.in_collision(a + np.linspace(0.0, 1.0, count)[:, None] * (b - a)).any())


@pytest.mark.capability("11-39")
@pytest.mark.parametrize("thickness", [1e-2, 1e-4, 1e-6])
def test_no_step_jumps_over_a_thin_wall(tmp_path, thickness):
    """The arm swings through a foil that no sampling would find: a quarter turn to each side, the wall between."""
    robot = arm(tmp_path)
    reach = robot.forward_kinematics(np.array([0.0, 1.2, 0.4, 0.0, 0.0, 0.0]))[:3, 3]
    wall = Obstacle(Box((0.3, thickness, 0.3)), reach, "foil")
    checker = Checker(robot, [wall], self_collision=False)
    a, b = (np.array([x, 1.2, 0.4, 0.0, 0.0, 0.0]) for x in (-0.9, 1.03))
    assert checker.free(a)
    assert checker.free(b)
    assert not checker.free_segment(a, b)
    answer = checker.check_path(a, b)
    assert not answer
    assert answer.status in (PathStatus.COLLIDING, PathStatus.TOUCHING)
    assert answer.contacts[0].second == "foil"
    assert answer.contacts[0].distance < 2e-6
    assert checker.with_scene(()).free_segment(a, b)


@pytest.mark.capability("11-39")
@pytest.mark.parametrize("seed", [11, 12, 13])
def test_what_is_proved_free_is_free_and_what_collides_does(tmp_path, seed):
    checker = Checker(arm(tmp_path), scene(seed, 12), clearance=0.004)
    q = checker.random_configurations(4000)
    q = q[checker.free(q)][:120]
    rng = np.random.default_rng(seed)
    a, b = q[:-1], q[:-1] + (q[1:] - q[:-1]) * rng.uniform(0.02, 0.8, (len(q) - 1, 1))
    free = checker.free_segment(a, b)
    assert 0.1 < free.mean() < 0.98
    for k in range(len(a)):
        if free[k]:
            assert not audit(checker, a[k], b[k], 2e-3)
        else:
            answer = checker.check_path(a[k], b[k])
            assert checker.distance(answer.q).distance <= 0.004 + 2e-6
            on_line = a[k] + answer.at * (b[k] - a[k])
            np.testing.assert_allclose(answer.q, on_line, atol=1e-12)


_SLIDING = """<robot name="gantry">
<link name="base"><collision><origin xyz="0 0 -0.5"/><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
<link name="x"/><link name="y"><collision><geometry><box size="0.1 0.1 0.3"/></geometry></collision></link>
<link name="turn">
<collision><origin xyz="0.3 0 0"/><geometry><capsule radius="0.04" length="0.3"/></geometry></collision></link>
<link name="out"><collision><origin xyz="0.1 0 0"/><geometry><sphere radius="0.05"/></geometry></collision></link>
<link name="follow"><collision><origin xyz="0.05 0 0"/><geometry><sphere radius="0.03"/></geometry></collision></link>
<joint name="a" type="prismatic"><parent link="base"/><child link="x"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
<joint name="b" type="prismatic"><parent link="x"/><child link="y"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
<joint name="c" type="revolute"><parent link="y"/><child link="turn"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
<joint name="d" type="prismatic"><parent link="turn"/><child link="out"/><origin xyz="0.5 0 0"/><axis xyz="1 0 0"/>
<limit lower="0" upper="0.5" velocity="1" effort="1"/></joint>
<joint name="e" type="revolute"><parent link="out"/><child link="follow"/><origin xyz="0.2 0 0"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" velocity="1" effort="1"/><mimic joint="c" multiplier="-1.5" offset="0.2"/></joint>
</robot>"""


@pytest.mark.capability("11-39")
def test_sliding_and_coupled_joints_are_bounded(tmp_path):
    """A gantry among thin rods and plates: whatever is proved free stays free under dense sampling."""
    path = tmp_path / "gantry.urdf"
    path.write_text(_SLIDING)
    rng = np.random.default_rng(3)
    rods = [Obstacle(Box((2e-3, 2e-3, 0.5)), p) for p in rng.uniform([-1.5, -1.5, -0.1], [1.5, 1.5, 0.1], (60, 3))]
    checker = Checker(str(path), rods)
    q = checker.random_configurations(3000)
    q = q[checker.free(q)][:200]
    a, b = q[:-1], q[:-1] + (q[1:] - q[:-1]) * rng.uniform(0.02, 0.5, (len(q) - 1, 1))
    free = checker.free_segment(a, b)
    assert 0.1 < free.mean() < 0.9
    assert not any(audit(checker, x, y, 5e-4) for x, y in zip(a[free], b[free], strict=True))


seeds = st.integers(0, 10**6)


@pytest.fixture(scope="module")
def checker(tmp_path_factory):
    return Checker(arm(tmp_path_factory.mktemp("arm")), scene(21, 12))


@settings(max_examples=60, deadline=None)
@given(seeds)
def test_a_motion_is_free_both_ways_and_so_are_its_parts(checker, seed):
    rng = np.random.default_rng(seed)
    a = rng.uniform(-2.8, 2.8, 6)
    b = a + rng.uniform(-0.6, 0.6, 6)
    whole = checker.free_segment(a, b)
    cut = np.sort(rng.uniform(0.0, 1.0, 2))[:, None]
    p, q = a + cut * (b - a)
    if whole:
        assert checker.free(np.stack([a, b, p, q])).all()
        assert checker.free_segment(b, a)
        assert checker.free_segment(p, q)
        assert checker.check_path([a, p, q, b])
    assert checker.free_segment(a, a) == bool(checker.free(a))


def test_batches_and_single_motions_agree(checker):
    q = checker.random_configurations(40)
    a, b = q[:20].reshape(4, 5, 6), (q[:20] + 0.2).reshape(4, 5, 6)
    many = checker.free_segment(a, b)
    assert many.shape == (4, 5)
    one_by_one = [[checker.free_segment(x, y) for x, y in zip(*rows, strict=True)] for rows in zip(a, b, strict=True)]
    assert many.tolist() == one_by_one
    assert isinstance(one_by_one[0][0], bool)


def test_an_arm_alone_and_a_floor_it_stands_on(tmp_path):
    """Without anything to meet every motion is free; what touches from the start is not, but for what never moves."""
    path = tmp_path / "arm.urdf"
    path.write_text(urdf())
    alone = Checker(str(path), self_collision=False)
    assert alone.free_segment(np.full(6, -2.0), np.full(6, 2.0))
    low, high = Obstacle(Sphere(0.1), (0.1, 0.0, 0.0), "low"), Obstacle(Sphere(0.1), (0.1, 0.1, 0.4), "high")
    q, there = np.zeros(6), np.full(6, 0.1)
    touching = Checker(str(path), [high], self_collision=False)
    assert not touching.free_segment(q, there)
    assert touching.in_collision(q)
    assert touching.check(q).contacts[0].first == "link2"
    standing = Checker(str(path), [low], self_collision=False)
    assert standing.free_segment(q, there), "the base stands in the ball, which no motion changes"
    assert standing.free(q)
    assert standing.check(q).contacts[0].first != "link0"


def test_answers_of_paths_say_where_and_by_what(checker):
    q = checker.random_configurations(2000)
    hit, free = q[checker.in_collision(q)][0], q[checker.free(q)][0]
    answer = checker.check_path([free, free, hit])
    assert not answer
    assert 1.0 < answer.at <= 2.0
    assert "hits" in answer.explain("en")
    assert answer.explain("ar")
    assert "continuously verified" in checker.check_path(free, free).explain("en")
    with pytest.raises(mf.InputError, match="path"):
        checker.check_path(free)
    with pytest.raises(mf.InputError, match="q_b"):
        checker.check_path(free, np.full(6, np.nan))
    with pytest.raises(mf.InputError, match="a"):
        checker.free_segment(np.zeros(5), np.zeros(6))
    assert isinstance(checker.scene, collision.Scene)
