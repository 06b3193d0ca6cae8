"""Where a path of the tip cannot be followed: out of reach, too fast, on another branch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil import Robot
from mafsil.errors import InputError
from mafsil.ik import track
from mafsil.ik.tracking import TrackStatus
from mafsil.model import Limits
from mafsil.model.library.textbook import planar2r
from mafsil.trajectory import diagnose_path, joined_path, line_path, reachability
from mafsil.trajectory.difficulties import BranchChange, FastStretch, UnreachableStretch
from mafsil.trajectory.difficulties.diagnosis import PathStatus
from mafsil.trajectory.difficulties.ladder import PathReachStatus
from tests.sizes import size

UR5E_START = np.array([0.3, -1.2, 1.2, 0.4, 1.0, 0.2])


def line(a, b):
    T_0, T_1 = np.eye(4), np.eye(4)
    T_0[:2, 3], T_1[:2, 3] = a, b
    return line_path(T_0, T_1)


def moved_line(robot, q, way):
    T = robot.forward_kinematics(q)
    goal = T.copy()
    goal[:3, 3] += way
    return line_path(T, goal)


def narrow(limit):
    """A planar 2R arm whose first joint is limited on both sides; rates to 2 rad/s."""
    arm = planar2r()
    bounds = iter([Limits(-limit, limit, velocity=2.0), Limits(-np.pi, np.pi, velocity=2.0)])
    joints = [replace(joint, limits=next(bounds)) if joint.moves else joint for joint in arm.joints]
    return Robot(replace(arm, joints=tuple(joints)))


@pytest.mark.capability("11-10")
def test_the_middle_of_a_line_is_out_of_reach():
    robot, path = Robot(planar2r((1.0, 0.5))), line((1, 0.3), (-1, 0.3))
    answer = reachability(robot, path, task="position")
    assert not answer
    assert answer.status is PathReachStatus.UNREACHABLE
    np.testing.assert_allclose(answer.unreachable, [(0.3, 0.7)], atol=1e-9)
    assert "0.3" in answer.explain("en")
    assert "0.7" in answer.explain("ar")
    (difficulty,) = diagnose_path(robot, path, task="position")
    assert isinstance(difficulty, UnreachableStretch)
    np.testing.assert_allclose([difficulty.where.begin, difficulty.where.end], [0.3, 0.7], atol=1e-9)
    assert "200 mm" in difficulty.explain("en")


@pytest.mark.capability("11-10")
def test_a_line_within_reach():
    answer = reachability(Robot(planar2r()), line((1, -1.2), (1, 1.2)), task="position")
    assert answer
    assert answer.unreachable == ()
    assert answer.beyond_limits == ()


@pytest.mark.capability("11-10")
def test_places_beyond_the_limits_are_named_with_the_joint():
    """The first joint would have to turn by 90 degrees and more on the left of the base."""
    answer = diagnose_path(narrow(0.5), line((1.9, 0.0), (0.5, 1.5)), task="position")
    beyond = [each for each in answer if isinstance(each, UnreachableStretch)]
    assert [each.kind for each in beyond] == ["beyond_limits"]
    assert beyond[0].joint == "joint1"
    assert answer.reach.status is PathReachStatus.BEYOND_LIMITS


@pytest.mark.capability("11-12")
def test_the_elbow_has_to_flip_between_the_limits():
    answer = diagnose_path(narrow(np.radians(70)), line((1, -1.2), (1, 1.2)), task="position")
    (change,) = answer
    assert isinstance(change, BranchChange)
    assert (change.part, change.end, change.end_joint) == ("elbow", "limit", "joint1")
    np.testing.assert_allclose(change.limit, np.radians(70))
    y = np.array([-0.1866570916, 0.1866570916])
    np.testing.assert_allclose([change.where.begin, change.where.end], (y + 1.2) / 2.4, atol=1e-9)
    assert "the elbow flips" in answer.explain("en")
    assert answer.to_dict()["difficulties"][0]["kind"] == "BranchChange"


@pytest.mark.capability("11-11")
def test_rates_near_a_singularity():
    """Past the base at 1 cm: the first joint turns by nearly half a turn within a few centimetres."""
    robot, path = narrow(np.inf), line((1.0, 0.01), (-1.0, 0.01))
    answer = diagnose_path(robot, path, task="position", duration=10.0)
    (fast,) = answer
    assert isinstance(fast, FastStretch)
    assert fast.joint == "joint1"
    # In the middle the tip turns about the base: joint 1 turns with it, d(angle)/ds = 2 / 0.01.
    np.testing.assert_allclose([fast.at, fast.rate], [0.5, 20.0], rtol=1e-4)
    # The angle atan2(y, x) has the rate 0.02 / (x^2 + y^2) / 10 s, and joint 2 adds to it less than 1e-3.
    x = np.sqrt(0.02 / 20.0 - 0.01**2)
    np.testing.assert_allclose([fast.where.begin, fast.where.end], [0.5 - x / 2, 0.5 + x / 2], atol=2e-3)
    assert 1e-3 < fast.distance < 0.3
    assert fast.causes
    assert diagnose_path(robot, path, task="position", duration=200.0)


@pytest.mark.capability("11-11")
def test_a_tip_that_keeps_to_the_path_when_rates_suffice():
    robot = narrow(np.inf)
    path = line((1.0, 0.01), (-1.0, 0.01))
    distances = [
        [
            each.distance
            for each in diagnose_path(robot, path, task="position", duration=T)
            if isinstance(each, FastStretch)
        ]
        for T in (5.0, 20.0, 80.0)
    ]
    (a,), (b,), (c,) = distances
    assert a > b > c > 0.0


@pytest.mark.capability("11-11", "11-12")
def test_the_wrist_flips_where_tracking_loses_the_branch():
    robot = mf.load("ur5e")
    path = moved_line(robot, UR5E_START, [-0.8, 0.2, 0.1])
    answer = diagnose_path(robot, path, q_start=UR5E_START)
    change = next(each for each in answer if isinstance(each, BranchChange))
    assert (change.part, change.end) == ("wrist", "singular")
    s = np.linspace(0.0, 1.0, 201)
    tracked = track(robot, path.poses(s), UR5E_START, times=s)
    np.testing.assert_allclose(change.ends_at, tracked.switches[0].time, atol=1e-4)
    assert any("lie in one plane" in cause.sentence("en") for cause in change.causes)


@pytest.mark.capability("11-12")
def test_verdicts_agree_with_tracking_on_random_lines():
    """A peer: small steps of Newton's method, with no list of solutions."""
    robot, rng = mf.load("ur5e"), np.random.default_rng(3)
    s, verdicts = np.linspace(0.0, 1.0, 101), []
    for _ in range(size(5, 8)):
        q = rng.uniform(-2.0, 2.0, 6)
        path = moved_line(robot, q, rng.uniform(-0.4, 0.4, 3))
        answer = diagnose_path(robot, path, q_start=q)
        tracked = track(robot, path.poses(s), q)
        lasting = tracked.status is TrackStatus.FOLLOWED
        assert any(not isinstance(each, FastStretch) for each in answer) == (not lasting)
        verdicts.append(lasting)
        if answer:
            np.testing.assert_allclose(answer.q[0], q, atol=1e-9)
            np.testing.assert_allclose(answer.q[-1], tracked.q[-1], atol=1e-6)
    assert {True, False} == set(verdicts)


def test_chains_are_on_the_path_and_legs_are_named():
    robot = mf.load("ur5e")
    first = moved_line(robot, UR5E_START, [0.1, 0.0, -0.1])
    last = line_path(first.poses(1.0), first.poses(1.0) + np.eye(4, k=3) * -1.2)
    path = joined_path([first, last])
    answer = diagnose_path(robot, path, q_start=UR5E_START)
    inside = np.isfinite(answer.q).all(axis=1)
    np.testing.assert_allclose(robot.forward_kinematics(answer.q[inside]), path.poses(answer.s[inside]), atol=1e-8)
    assert answer.status is PathStatus.HAS_DIFFICULTIES
    assert "leg 2 of 2" in answer.explain("en")


def test_refused_requests():
    robot, path = Robot(planar2r()), line((1, -1.2), (1, 1.2))
    with pytest.raises(InputError, match="q_start"):
        diagnose_path(robot, path, task="position", q_start=[0.0, 0.0])
    with pytest.raises(InputError, match="duration"):
        diagnose_path(robot, path, task="position", duration=-1.0)
    with pytest.raises(InputError, match="samples"):
        diagnose_path(robot, path, task="position", samples=1)
    with pytest.raises(InputError, match="task"):
        diagnose_path(robot, path, task="speed")


@pytest.mark.capability("11-12")
def test_a_redundant_arm_is_led_along():
    robot = mf.load("panda")
    q = np.array([0.3, 0.4, 0.2, -1.6, 0.1, 1.8, 0.3])
    path = moved_line(robot, q, [0.05, 0.05, -0.05])
    answer = diagnose_path(robot, path, q_start=q)
    assert answer
    assert answer.status is PathStatus.FOLLOWABLE
    np.testing.assert_allclose(answer.q[0], q)
    np.testing.assert_allclose(robot.forward_kinematics(answer.q), path.poses(answer.s), atol=1e-6)
    far = diagnose_path(robot, moved_line(robot, q, [1.0, 0.0, 0.0]), q_start=q)
    assert not far
    assert "reach" in far.explain("en")
