"""Ways out of where tools are: they go back without turning, searches begin with them, and need few nodes for it."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.collision import ArmMount, Box, Checker, MultiArmCell, Obstacle
from mafsil.kernels.loops.loop import compiled
from mafsil.model import DHRow
from mafsil.planning import arm_search, retreat_loops
from mafsil.planning.arm_search import limbs_of
from mafsil.planning.outcome import PlanningStatus

SMALL = 1e-5
HOME = np.radians([0.0, -20, 0, -130, 0, 110, 45])
REACHING = np.radians([40.0, 30, 0, -90, 0, 120, 45])


@compiled
def retreats(limbs, q, bounds, out):
    return retreat_loops.retreats(limbs, q, bounds, out)


def rates_of(checker, q, bounds=None):
    """(3, n) rates of the coordinates for one reach back, inward and up, and whether there are any."""
    limits, limbs, n = checker.robot.limits, limbs_of(checker), checker.robot.n
    box = np.array([np.maximum(limits.lower, -9.0), np.minimum(limits.upper, 9.0)]) if bounds is None else bounds
    out = np.empty((8, n))
    some = retreats(limbs, q, box, out)
    expected = np.clip(q + retreat_loops.SUMS @ limbs.rates, *box)
    assert np.isfinite(out).all()
    if len(limbs.parts) == 1 and some:
        np.testing.assert_allclose(out, expected, atol=1e-12)
    return limbs, out, some


@pytest.mark.capability("11-40")
@pytest.mark.parametrize("name", ["panda", "ur5e", "iiwa7"])
def test_tools_go_back_without_turning(name):
    """Small steps against the robot's own kinematics: along the tool, towards the base's axis, and up."""
    checker = Checker(name, radius=0.05, self_collision=False)
    robot, rng = checker.robot, np.random.default_rng(0)
    seen = 0
    for _ in range(40):
        q = rng.uniform(np.maximum(robot.limits.lower, -3.0), np.minimum(robot.limits.upper, 3.0))
        if np.linalg.svd(robot.jacobian_body(q), compute_uv=False)[-1] < 0.1:
            continue  # Near a singularity a part of the way is left out.
        limbs, _, some = rates_of(checker, q)
        assert some
        T = robot.forward_kinematics(q)
        moved = robot.forward_kinematics(q + SMALL * limbs.rates)
        way = (moved[:, :3, 3] - T[:3, 3]) / (SMALL * limbs.reach[0])
        turned = np.linalg.norm(moved[:, :3, :3] - T[:3, :3], axis=(1, 2)) / SMALL
        back, inward, up = limbs.directions
        np.testing.assert_allclose(way, limbs.directions, atol=0.15)
        assert turned.max() < 0.3
        assert abs(abs(T[:3, 2] @ back) - 1.0) < 1e-9, "these tools roll about where they point"
        assert back @ T[:3, 2] < 0.0
        np.testing.assert_array_equal(up, [0.0, 0.0, 1.0])
        assert abs(inward[2]) < 1e-12
        assert inward[:2] @ T[:2, 3] < 0.0
        seen += 1
    assert seen > 10


@pytest.mark.capability("11-40")
def test_the_size_of_a_robot_does_not_matter():
    angles = []
    for scale in (1e-3, 1.0, 1e3):
        rows = [DHRow(a=0.0, alpha=np.pi / 2, d=scale), DHRow(a=scale), DHRow(a=scale)]
        checker = Checker(mf.Robot.from_dh(rows, "classic"), radius=0.02 * scale, self_collision=False)
        limbs, _, _ = rates_of(checker, np.array([0.3, 0.7, -1.1]))
        angles.append(limbs.rates.copy())
    np.testing.assert_allclose(angles[0], angles[1], atol=1e-9)
    np.testing.assert_allclose(angles[2], angles[1], atol=1e-9)


@pytest.mark.capability("11-40", "11-46")
def test_held_joints_stay_and_arms_of_one_table_go_back_together():
    mounted = [
        ArmMount("left", "ur5e", (0.0, 0.0, 0.0), radius=0.05),
        ArmMount("right", "panda", (1.5, 0.0, 0.0), radius=0.05),
    ]
    both = MultiArmCell(mounted)
    assert len(limbs_of(both).parts) == 2
    q = np.concatenate([np.radians([10.0, -60, 80, -40, -90, 0]), REACHING])
    limits = both.robot.limits
    bounds = np.array([np.maximum(limits.lower, -9.0), np.minimum(limits.upper, 9.0)])
    _, out, some = rates_of(both, q, bounds)
    assert some
    assert (np.abs(out[0] - q)[[1, 2, 7, 9]] > 1e-3).all()
    bounds[:, 6:] = q[6:]
    _, out, some = rates_of(both, q, bounds)
    assert some
    np.testing.assert_array_equal(out[:, 6:], np.tile(q[6:], (8, 1)))
    bounds[:] = q
    assert not rates_of(both, q, bounds)[2]


def pocket(T, size=0.2, wall=0.02, depth=0.16):
    """Four walls around a tool, open where it came from."""
    boxes = []
    for axis, sign in ((0, 1), (0, -1), (1, 1), (1, -1)):
        at, sides = np.eye(4), [size, size, depth]
        at[2, 3] = 0.03
        at[axis, 3], sides[axis] = sign * size / 2, wall
        boxes.append(Obstacle(Box(tuple(sides)), T @ at, f"wall{axis}{sign}"))
    return boxes


@pytest.mark.capability("11-40")
def test_searches_leave_a_pocket_the_way_the_tool_came_in():
    """Few nodes, and the same ones whatever the seed: no sample is drawn."""
    free = Checker("panda", radius=0.04, self_collision=False)
    T = free.robot.forward_kinematics(REACHING)
    arm = free.with_scene(pocket(T))
    assert arm.free(REACHING)
    assert not arm.free_segment(HOME, REACHING)
    for start, goal in ((HOME, REACHING), (REACHING, HOME)):
        plans = [mf.plan(arm, None, start, goal, shortcut_iterations=0, seed=seed) for seed in range(4)]
        assert plans[0], plans[0].explain("en")
        assert plans[0].nodes < 12
        assert arm.check_path(plans[0].path)
        for other in plans[1:]:
            np.testing.assert_array_equal(other.path, plans[0].path)
        short = mf.plan(arm, None, start, goal)
        assert short.length < plans[0].length
        assert arm.check_path(short.path)
    assert mf.plan(arm, None, HOME, REACHING, max_nodes=1).status is PlanningStatus.NOT_FOUND


@pytest.mark.capability("11-40")
def test_a_detour_is_measured_against_another_way(monkeypatch):
    """Shortcuts stay on their side of a wall; of two sides the shorter is the answer."""
    wall = Obstacle(Box((0.5, 0.04, 0.6)), (0.6, 0.0, 0.3), "wall")
    arm = Checker("panda", [wall], radius=0.05, self_collision=False)
    a, b = (np.radians([s * 45.0, 20, 0, -110, 0, 130, s * 45]) for s in (1.0, -1.0))
    raw = mf.plan(arm, None, a, b, shortcut_iterations=0)
    short = [mf.plan(arm, None, a, b, seed=seed) for seed in range(12)]
    assert all(arm.check_path(each.path) for each in short)
    assert min(each.nodes for each in short) > raw.nodes, "both searches count"
    monkeypatch.setattr(arm_search, "DETOUR", np.inf)
    alone = [mf.plan(arm, None, a, b, seed=seed) for seed in range(12)]
    assert {each.nodes for each in alone} == {raw.nodes}
    assert np.mean([each.length for each in short]) < np.mean([each.length for each in alone]) < raw.length


def chain(path, joints):
    """A description of a chain of bars: a kind and an axis for each joint."""
    words = ['<robot name="r"><link name="l0"/>']
    for k, (kind, axis) in enumerate(joints):
        words.append(
            f'<link name="l{k + 1}"><collision><origin xyz="0.2 0 0"/><geometry><box size="0.3 0.04 0.04"/></geometry>'
            f'</collision></link><joint name="j{k}" type="{kind}"><parent link="l{k}"/><child link="l{k + 1}"/>'
            f'<origin xyz="0.4 0 0"/><axis xyz="{axis}"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>'
        )
    path.write_text("".join([*words, "</robot>"]))
    return path


@pytest.mark.capability("11-40")
@pytest.mark.parametrize(
    "joints",
    [
        [("prismatic", "1 0 0"), ("prismatic", "0 1 0"), ("prismatic", "0 0 1")],
        [("revolute", "0 0 1"), ("revolute", "0 0 1"), ("prismatic", "0 0 1"), ("revolute", "0 0 1")],
        [("continuous", "0 0 1")] * 3,
        [("revolute", "0 0 1"), ("revolute", "0 1 0")] * 5,
    ],
)
def test_whatever_the_joints_ends_of_retreats_are_configurations(tmp_path, joints):
    """Of a gantry the reach was zero, and paths led over what is no number."""
    free = Checker(str(chain(tmp_path / "r.urdf", joints)))
    rates_of(free, np.full(free.robot.n, 0.3))
    rng, some = np.random.default_rng(1), 0
    for _ in range(30):
        a, b = rng.uniform(-1.5, 1.5, (2, free.robot.n))
        T = np.eye(4)
        T[:3, 3] = free.robot.forward_kinematics(0.5 * (a + b))[:3, 3]
        arm = free.with_scene([Obstacle(Box((0.1, 0.1, 0.3)), T)])
        if not arm.free(np.stack([a, b])).all():
            continue
        plan = mf.plan(arm, None, a, b, seconds=0.3, max_nodes=3000)
        some += plan.nodes > 2
        assert not plan or arm.check_path(plan.path)
    assert some
