"""Goals that leave room, and groups of joints of a semantic description."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import mafsil as mf
from mafsil import planning
from mafsil.collision import Box, Checker, Obstacle, Scene
from mafsil.errors import FileError, InputError
from mafsil.planning import GoalRegion, joint_group
from mafsil.planning.outcome import PlanningStatus

URDF = """<robot name="two"><link name="base"/>
{links}
</robot>"""
ARM = """<link name="{s}1"/><link name="{s}2"/><link name="{s}_hand"/>
<joint name="{s}_a" type="revolute"><parent link="base"/><child link="{s}1"/><origin xyz="{x} 0 0"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="9" velocity="2"/></joint>
<joint name="{s}_b" type="revolute"><parent link="{s}1"/><child link="{s}2"/><origin xyz="0.5 0 0"/><axis xyz="0 0 1"/>
<limit lower="-2.5" upper="2.5" effort="9" velocity="2"/></joint>
<joint name="{s}_f" type="fixed"><parent link="{s}2"/><child link="{s}_hand"/><origin xyz="0.4 0 0"/></joint>"""
SRDF = """<robot name="two">
<group name="left"><chain base_link="base" tip_link="left_hand"/></group>
<group name="right"><joint name="right_a"/><link name="right2"/></group>
<group name="both"><group name="left"/><group name="right"/></group>
<group_state group="left" name="home"><joint name="left_a" value="0.5"/><joint name="left_b" value="-1"/></group_state>
{more}</robot>"""


def files(tmp_path, more=""):
    robot, semantics = tmp_path / "two.urdf", tmp_path / "two.srdf"
    robot.write_text(URDF.format(links=ARM.format(s="left", x=0) + ARM.format(s="right", x=1)))
    semantics.write_text(SRDF.format(more=more))
    return robot, semantics


@pytest.mark.capability("11-39")
@given(st.integers(0, 10_000), st.floats(0, 0.5), st.floats(0, np.pi))
def test_poses_of_a_region_lie_in_it(seed, side, angle):
    rng = np.random.default_rng(seed)
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = Rotation.random(rng=rng).as_matrix(), rng.normal(size=3)
    region = GoalRegion(T, box=(side, 0.0, 2 * side), angle=angle, count=20, seed=seed)
    poses = region.poses()
    assert np.array_equal(poses[0], T)
    away = (poses[:, :3, 3] - T[:3, 3]) @ T[:3, :3]
    assert (np.abs(away) <= np.array([side, 0.0, 2 * side]) + 1e-12).all()
    turned = Rotation.from_matrix(np.swapaxes(T[:3, :3], 0, 1) @ poses[:, :3, :3]).magnitude()
    assert (turned <= angle + 1e-7).all()
    assert region.contains(poses).all()
    outside = poses[0].copy()
    outside[:3, 3] += T[:3, 1] * 0.01
    assert not region.contains(outside)
    assert np.array_equal(poses, GoalRegion(T, box=(side, 0.0, 2 * side), angle=angle, count=20, seed=seed).poses())


def test_orientations_are_even():
    """Of rotations without a limit, angles are distributed as (a - sin a) / pi."""
    poses = GoalRegion(np.eye(4), angle=np.pi, count=5000).poses()
    angles = np.sort(Rotation.from_matrix(poses[1:, :3, :3]).magnitude())
    shares = (angles - np.sin(angles)) / np.pi
    assert np.abs(shares - (np.arange(len(shares)) + 0.5) / len(shares)).max() < 0.03


def test_about_one_axis_only():
    region = GoalRegion(np.eye(4), angle=1.0, axis=(0, 0, 2), count=50)
    turns = Rotation.from_matrix(region.poses()[:, :3, :3]).as_rotvec()
    assert np.abs(turns[:, :2]).max() < 1e-12
    assert 0.9 < np.abs(turns[:, 2]).max() <= 1.0
    tilted = np.eye(4)
    tilted[:3, :3] = Rotation.from_rotvec([0.1, 0, 0]).as_matrix()
    assert not region.contains(tilted)


@pytest.mark.capability("11-39")
def test_a_region_is_reached_where_its_middle_is_blocked():
    arm = mf.load("ur5e")
    q = np.array([0.3, -1.4, 1.4, -1.6, -1.5, 0.0])
    T = arm.forward_kinematics(q)
    block = Obstacle(Box((0.06, 0.06, 0.06)), T, "block")
    checker = Checker(arm, Scene([block]), radius=0.03, self_collision=False)
    start = np.array([-1.0, -1.4, 1.4, -1.6, -1.5, 0.0])
    assert mf.plan(checker, None, start, T).status is PlanningStatus.GOAL_BLOCKED
    region = GoalRegion(T, box=0.25, angle=0.5, count=40)
    found = mf.plan(checker, None, start, region)
    assert found
    assert checker.check_path(found.path)
    assert region.contains(arm.forward_kinematics(found.path[-1]))
    again = mf.plan(checker, None, start, region)
    assert np.array_equal(again.path, found.path)
    far = T.copy()
    far[:3, 3] += 5.0
    assert mf.plan(checker, None, start, GoalRegion(far, box=0.1)).status is PlanningStatus.UNREACHABLE


def test_groups_of_joints(tmp_path):
    robot, semantics = files(tmp_path)
    whole = mf.load(robot)
    left = joint_group(robot, semantics, "left", at=[0.1, 0.2, 0.3, 0.4])
    names = list(whole.joint_names)
    assert [names[k] for k in left.places] == ["left_a", "left_b"]
    assert left.robot.mechanism.tip == "left_hand"
    home = left.configuration("home")
    assert home.tolist() == [0.5, -1.0]
    q = left.whole([[0.5, -1.0], [0.6, 0.0]])
    assert q.shape == (2, 4)
    assert np.array_equal(left.of_whole(q), [[0.5, -1.0], [0.6, 0.0]])
    others = [k for k in range(4) if k not in left.places]
    assert np.array_equal(q[:, others], np.broadcast_to(np.array([0.1, 0.2, 0.3, 0.4])[others], (2, 2)))
    at_tip = whole.with_tip("left_hand").forward_kinematics(q[0])
    assert np.allclose(left.robot.forward_kinematics(home), at_tip)
    assert {names[k] for k in joint_group(robot, semantics, "right").places} == {"right_a", "right_b"}
    assert len(joint_group(robot, semantics, "both").places) == 4
    found = mf.plan(
        Checker(left.robot, radius=0.02, self_collision=False), None, [0.0, 0.0], left.configuration("home")
    )
    assert found
    assert np.array_equal(left.whole(found.path)[-1, list(left.places)], home)


@pytest.mark.parametrize(
    ("more", "group", "error", "word"),
    [
        ('<group name="ring"><group name="ring"/></group>', "ring", FileError, "itself"),
        ('<group name="g"><joint name="nobody"/></group>', "g", FileError, "nobody"),
        ('<group name="g"><link name="nowhere"/></group>', "g", FileError, "nowhere"),
        ('<group name="g"><chain base_link="base" tip_link="x"/></group>', "g", FileError, "x"),
        ('<group name="g"><group name="h"/></group>', "g", FileError, "h"),
        ('<group name="g"><link name="base"/></group>', "g", InputError, "no joint"),
        ("", "middle", InputError, "left, right, both"),
        ('<group_state group="left" name="bad"><joint name="left_a" value="nan"/><joint name="left_b" value="1"/>'
         "</group_state>", "left", FileError, "bad"),
        ('<group_state group="left" name="half"><joint name="left_a" value="1"/></group_state>',
         "left", FileError, "half"),
    ],
)  # fmt: skip
def test_bad_groups_are_named(tmp_path, more, group, error, word):
    robot, semantics = files(tmp_path, more)
    with pytest.raises(error, match=word):
        joint_group(robot, semantics, group)


def test_bad_regions_are_named(tmp_path):
    for options in (
        {"box": -1.0},
        {"box": (1.0, 2.0)},
        {"angle": 4.0},
        {"angle": np.nan},
        {"axis": (0, 0, 0)},
        {"count": 0},
    ):
        with pytest.raises(InputError, match=next(iter(options))):
            GoalRegion(np.eye(4), **options)
    with pytest.raises(InputError):
        GoalRegion(np.eye(3))
    robot, semantics = files(tmp_path)
    with pytest.raises(InputError, match="home"):
        joint_group(robot, semantics, "left").configuration("away")
    assert planning.GoalRegion is GoalRegion
