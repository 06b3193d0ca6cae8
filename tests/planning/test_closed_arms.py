"""Paths of mechanisms with loops: closed at every point, within what was proved between, round obstacles; refusals."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil import planning
from mafsil.collision import ArmMount, Checker, MultiArmCell, Obstacle, Sphere
from mafsil.errors import InputError
from mafsil.model import Joint, JointKind
from mafsil.parallel import ClosedChain
from mafsil.planning.outcome import PlanningStatus
from mafsil.trajectory import MotionLimits

ROBOTS = Path(__file__).resolve().parents[2] / "examples" / "robots"


@pytest.fixture(scope="module")
def palletiser():
    return mf.load(ROBOTS / "palletiser.xml")


@pytest.fixture(scope="module")
def ends(palletiser):
    chain = ClosedChain(palletiser)
    held = ["shoulder", "lever"]
    return chain.close_loops([0, 0, 0, 0], hold=held).q, chain.close_loops([1.0, -0.1, 0.7, -0.3], hold=held).q


BALL = Obstacle(Sphere(0.06), (0.52, 0.0, 0.53), "ball")


@pytest.mark.parametrize("seed", range(3))
def test_round_a_ball_with_closed_loops(palletiser, ends, seed):
    checker, chain = Checker(palletiser, [BALL]), ClosedChain(palletiser)
    assert not checker.check_path(np.stack([*ends]))
    found = mf.plan(checker, None, *ends, seed=seed)
    assert found, found.explain("en")
    assert chain.error(found.path).max() < 1e-9
    assert found.kept_bounds().max() <= 1e-3
    q = found.at(np.linspace(0, 1, 2000))
    assert checker.free(q).all()
    assert chain.error(q).max() <= found.kept_bounds().max() * 2
    assert (
        chain.error(found.joint_path().curve.at(np.linspace(0, found.joint_path().curve.duration, 500)).u).max() < 2e-3
    )


def test_poses_are_goals(palletiser, ends):
    T = palletiser.forward_kinematics(ends[1])
    found = mf.plan(palletiser, [BALL], ends[0], mf.Pose(T), seed=1)
    assert found
    np.testing.assert_allclose(palletiser.forward_kinematics(found.path[-1]), T, atol=1e-8)
    T[0, 3] += 3.0
    assert mf.plan(palletiser, [BALL], ends[0], mf.Pose(T)).status is PlanningStatus.UNREACHABLE


def test_ends_that_gape_are_refused_with_the_gap(palletiser, ends):
    open_ = ends[1] + np.array([0, 0.1, 0, 0])
    start = mf.plan(palletiser, None, open_, ends[0])
    assert start.status is PlanningStatus.START_OFF
    assert "loop closed within" in start.explain("en")
    assert mf.plan(palletiser, None, ends[0], open_).status is PlanningStatus.GOAL_OFF


def test_the_other_way_to_close_is_not_reached(palletiser, ends):
    chain = ClosedChain(palletiser)
    other = chain.close_loops([0.0, 0.0, np.pi - 0.05, np.pi - 0.05], hold=["shoulder", "elbow"])
    assert other
    assert abs(other.q[2]) > 1.0
    wide = replace(
        palletiser.mechanism,
        joints=tuple(replace(j, limits=mf.model.Limits()) for j in palletiser.mechanism.joints),
    )
    found = mf.plan(Checker(wide, self_collision=False), None, ends[0], other.q, seconds=0.3, max_nodes=3000)
    assert found.status in (PlanningStatus.NOT_FOUND, PlanningStatus.FOUND)
    if found:
        assert ClosedChain(wide).error(found.path).max() < 1e-9


def test_a_platform_on_six_legs_passes_below_a_ball():
    robot = mf.load(ROBOTS / "stewart.xml", tip="platform")
    chain = ClosedChain(robot)
    T = robot.forward_kinematics(np.zeros(robot.n))
    from mafsil.parallel import closed_inverse_kinematics

    poses = []
    for x in (-0.12, 0.12):
        poses.append(T.copy())
        poses[-1][:3, 3] += [x, 0, 0.02]
    start, goal = (closed_inverse_kinematics(chain, pose).q[0] for pose in poses)
    checker = Checker(robot, [Obstacle(Sphere(0.06), (0.0, 0.0, 0.699), "ball")], self_collision=False)
    assert checker.free(np.stack([start, goal])).all()
    found = mf.plan(checker, None, start, goal, seed=2)
    assert found, found.explain("en")
    assert chain.error(found.path).max() < 1e-9
    assert checker.free(found.at(np.linspace(0, 1, 500))).all()


def test_what_is_not_planned_is_said(palletiser, ends):
    with pytest.raises(InputError, match="rrt_connect"):
        mf.plan(palletiser, None, *ends, planner="trajectory_optimisation")
    loop = palletiser.mechanism.loops[0]
    slot = replace(
        palletiser.mechanism,
        loops=(Joint("slot", JointKind.PRISMATIC, loop.parent, loop.child, loop.T_pj, axis=np.array([1.0, 0, 0])),),
    )
    with pytest.raises(InputError, match=r"slot.*prismatic"):
        mf.plan(slot, None, *ends)


def test_a_roadmap_of_straight_motions_refuses_loops(palletiser):
    with pytest.raises(InputError, match="palletiser has closed loops"):
        planning.ArmRoadmap(Checker(palletiser))


@pytest.fixture(scope="module")
def two(palletiser):
    """Two arms face to face whose loops are no parallelograms: straight motions open them."""
    shift = np.zeros((4, 4))
    shift[0, 3] = 0.03
    joints = [replace(j, T_pj=j.T_pj + shift * (j.name == "lever")) for j in palletiser.mechanism.joints]
    arm = mf.Robot(replace(palletiser.mechanism, joints=tuple(joints)))
    T = np.diag([-1.0, -1.0, 1.0, 1.0])
    T[0, 3] = 0.9
    return ClosedChain(arm), MultiArmCell([ArmMount("one", arm), ArmMount("two", arm, T)])


def _swapped(two):
    closed = [two[0].close_loops([s, 0, v, 0], hold=["shoulder", "lever"]).q for s, v in ((0.0, 0.0), (1.0, 0.7))]
    return {"one": closed[0], "two": closed[1]}, {"one": closed[1], "two": closed[0]}


SLOW = MotionLimits.of(8, velocity=1.0, acceleration=2.0)


@pytest.mark.parametrize(
    "planned",
    [planning.plan_coupled, lambda cell, *ends: planning.plan_prioritized(cell, *ends, SLOW)],
    ids=["together", "in turn"],
)
def test_two_arms_with_loops_pass_each_other(two, planned):
    chain, cell = two
    found = planned(cell, *_swapped(two))
    assert found, found.explain("en")
    q = found.at(np.linspace(0, getattr(found, "duration", 1.0), 400))
    assert cell.free(q).all()
    assert max(chain.error(part).max() for part in cell.split(q).values()) < planning.kept_planning.TOLERANCE
    start, goal = _swapped(two)
    np.testing.assert_allclose(q[[0, -1]], [cell.join(start), cell.join(goal)], atol=1e-9)


def test_an_arm_with_loops_steps_aside_with_its_loops_closed(two):
    chain, cell = two
    q = np.random.default_rng(1).uniform(-1.0, 1.0, (30, 4))
    near = planning.kept_planning.closed_near(chain.robot, q)
    assert len(near) > 10
    assert chain.error(near).max() < 1e-9
    start = _swapped(two)[0]
    settled = planning.plan_around_moving(cell, "one", start, start["one"], SLOW, {})
    assert settled, settled.explain("en")


def test_gaping_ends_of_several_arms_are_named_with_the_gap(two):
    _, cell = two
    start, goal = _swapped(two)
    bent = start | {"one": start["one"] + [0, 0.05, 0, 0]}
    for refused, status in (
        (planning.plan_prioritized(cell, bent, goal, SLOW), PlanningStatus.START_OFF),
        (planning.plan_prioritized(cell, start, goal | {"two": bent["one"]}, SLOW), PlanningStatus.GOAL_OFF),
        (planning.plan_coupled(cell, bent, goal), PlanningStatus.START_OFF),
        (planning.plan_around_moving(cell, "one", bent, goal["one"], SLOW, {}), PlanningStatus.START_OFF),
        (planning.plan_around_moving(cell, "one", start, bent["one"], SLOW, {}), PlanningStatus.GOAL_OFF),
    ):
        assert refused.status is status
        assert "the limit is 1 mm" in refused.explain("en")


def test_hinges_and_fixed_joints_are_kept_by_points(palletiser):
    loop = palletiser.mechanism.loops[0]
    for kind, count in ((JointKind.SPHERICAL, 1), (JointKind.REVOLUTE, 2), (JointKind.FIXED, 3)):
        closing = Joint("end", kind, loop.parent, loop.child, loop.T_pj, axis=np.array([0, 1.0, 0]))
        assert len(planning.loop_constraints(replace(palletiser.mechanism, loops=(closing,)))) == count
    assert planning.loop_constraints(mf.load("ur5e").mechanism) == ()
