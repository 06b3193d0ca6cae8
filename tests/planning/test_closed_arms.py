"""Paths of mechanisms with loops: closed at every point, within what was proved between, round obstacles; refusals."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil import planning
from mafsil.collision import Arms, Checker, Mounted, Obstacle, Sphere
from mafsil.errors import InputError, ModelWarning
from mafsil.model import Joint, JointKind
from mafsil.parallel import ClosedChain
from mafsil.planning import PlanningStatus
from mafsil.trajectory import MotionLimits

ROBOTS = Path(__file__).resolve().parents[2] / "examples" / "robots"


@pytest.fixture(scope="module")
def palletiser():
    with pytest.warns(ModelWarning):
        return mf.load(ROBOTS / "palletiser.xml")


@pytest.fixture(scope="module")
def ends(palletiser):
    chain = ClosedChain(palletiser)
    held = ["shoulder", "lever"]
    return chain.closed([0, 0, 0, 0], hold=held).q, chain.closed([1.0, -0.1, 0.7, -0.3], hold=held).q


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
    other = chain.closed([0.0, 0.0, np.pi - 0.05, np.pi - 0.05], hold=["shoulder", "elbow"])
    assert other
    assert abs(other.q[2]) > 1.0
    wide = replace(
        palletiser.mechanism,
        joints=tuple(replace(j, limits=mf.model.Limits()) for j in palletiser.mechanism.joints),
    )
    found = mf.plan(Checker(wide, self_collision=False), None, ends[0], other.q, seconds=0.3, nodes=3000)
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


def test_planners_that_would_leave_loops_open_refuse_them(palletiser, ends):
    with pytest.raises(InputError, match="palletiser has loops"):
        planning.ArmRoadmap(Checker(palletiser))
    cell = Arms([Mounted("one", palletiser), Mounted("two", palletiser, [3.0, 0, 0])])
    for call in (
        planning.plan_together,
        lambda *a: planning.plan_in_turn(*a, MotionLimits.of(8, velocity=1.0, acceleration=1.0)),
    ):
        with pytest.raises(InputError, match="palletiser has loops"):
            call(cell, {"one": ends[0], "two": ends[0]}, {"one": ends[1]})


def test_hinges_and_fixed_joints_are_kept_by_points(palletiser):
    loop = palletiser.mechanism.loops[0]
    for kind, count in ((JointKind.SPHERICAL, 1), (JointKind.REVOLUTE, 2), (JointKind.FIXED, 3)):
        closing = Joint("end", kind, loop.parent, loop.child, loop.T_pj, axis=np.array([0, 1.0, 0]))
        assert len(planning.loops_kept(replace(palletiser.mechanism, loops=(closing,)))) == count
    assert planning.loops_kept(mf.load("ur5e").mechanism) == ()
