"""Numerical inverse kinematics: every answer verified by forward kinematics, every refusal with its reason."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError, ModelError
from mafsil.geometry import pose
from mafsil.ik import IKStatus, solve_ik

ROBOTS = ["panda", "fr3", "iiwa7", "ur5e", "puma560", "offset_puma", "stanford_arm", "rrprrr", "scara_rrrp", "planar3r"]


def random_states(robot, count, seed):
    lower = np.where(np.isfinite(robot.limits.lower), robot.limits.lower, -np.pi)
    upper = np.where(np.isfinite(robot.limits.upper), robot.limits.upper, np.pi)
    return np.random.default_rng(seed).uniform(lower, upper, (count, robot.n))


@pytest.fixture(scope="module")
def panda():
    return mf.load("panda")


@pytest.mark.capability("07-40", "07-44", "07-2")
@pytest.mark.parametrize("name", ROBOTS)
def test_reachable_poses_are_reached_within_the_limits(name):
    robot = mf.load(name)
    T = robot.forward_kinematics(random_states(robot, 400, 1))
    answer = solve_ik(robot, T)
    assert answer.all_solved, answer.explain(int(np.flatnonzero(~answer.solved)[0]))
    reached = robot.forward_kinematics(answer.q)
    assert np.abs(reached[:, :3, 3] - T[:, :3, 3]).max() <= 1e-10
    assert np.abs(pose.error(reached, T)[:, :3]).max() <= 1e-10
    assert (answer.q >= robot.limits.lower).all()
    assert (answer.q <= robot.limits.upper).all()


def test_a_pose_does_not_depend_on_its_batch(panda):
    T = panda.forward_kinematics(random_states(panda, 60, 2))
    whole = solve_ik(panda, T)
    shaped = solve_ik(panda, T.reshape(3, 20, 4, 4))
    np.testing.assert_array_equal(shaped.q.reshape(60, 7), whole.q)
    for k in (0, 17, 59):
        alone = solve_ik(panda, T[k])
        assert alone.q.shape == (7,)
        np.testing.assert_array_equal(alone.q, whole.q[k])
    np.testing.assert_array_equal(solve_ik(panda, T).q, whole.q)
    assert not np.array_equal(solve_ik(panda, T, rng=1).q, whole.q)


def test_seed_is_where_the_search_starts(panda):
    q = random_states(panda, 50, 3)
    near = solve_ik(panda, panda.forward_kinematics(q), seed=q + 1e-3)
    # Shifted starts may lie just outside the limits; they are clipped.
    assert near.all_solved
    assert np.abs(near.q - q).max() < 0.05
    assert near.iterations.max() <= 6
    one = solve_ik(panda, panda.forward_kinematics(q), seed=np.zeros(7), restarts=0)
    assert one.attempts.max() == 1


def test_empty_batches(panda):
    answer = solve_ik(panda, np.zeros((0, 4, 4)))
    assert answer.q.shape == (0, 7)
    assert answer.all_solved


@pytest.mark.capability("07-3")
def test_out_of_reach_is_proven_and_the_nearest_pose_given(panda):
    T = np.eye(4)
    T[:3, 3] = [0.0, 5.0, 0.5]
    answer = solve_ik(panda, T)
    assert answer.status is IKStatus.OUT_OF_REACH
    assert answer.distance > answer.reach
    # The nearest configuration stretches towards the pose.
    assert answer.T_reached[1, 3] > 0.5
    assert answer.position_error == pytest.approx(np.linalg.norm(answer.T_reached[:3, 3] - T[:3, 3]))
    assert "out of reach" in answer.explain(language="en")
    assert answer.explain(language="ar")


def test_no_state_leaves_the_reach_bound():
    from mafsil.ik.problem import reach_bound

    for name in ROBOTS:
        robot = mf.load(name)
        centre, radius = reach_bound(robot.mechanism, None)
        p = robot.forward_kinematics(random_states(robot, 2000, 4))[:, :3, 3]
        assert np.linalg.norm(p - centre, axis=1).max() <= radius * (1 + 1e-12)


def test_beyond_limits_names_the_joint(panda):
    """With the elbow's range cut short the folded pose needs an elbow beyond it."""
    joints = tuple(
        replace(joint, limits=replace(joint.limits, lower=-0.5)) if joint.name == "joint4" else joint
        for joint in panda.mechanism.joints
    )
    stiff = mf.Robot(replace(panda.mechanism, joints=joints))
    T = panda.forward_kinematics(np.array([0.0, 0.3, 0.0, -2.5, 0.0, 2.0, 0.0]))
    answer = solve_ik(stiff, T, restarts=15)
    assert answer.status is IKStatus.BEYOND_LIMITS
    assert str(answer.worst_joint) in answer.explain(language="en")
    assert str(answer.worst_joint) in answer.explain(language="ar")
    assert (answer.q >= stiff.limits.lower).all()
    assert solve_ik(stiff, T, limits=False).status is IKStatus.SOLVED


def test_budget_spent_says_it_proves_nothing(panda):
    T = panda.forward_kinematics(random_states(panda, 200, 5))
    answer = solve_ik(panda, T, restarts=0)
    missed = ~answer.solved
    assert 0 < missed.sum() < 200
    k = int(np.flatnonzero(missed)[0])
    assert answer.status[k] in (IKStatus.BUDGET_SPENT, IKStatus.BEYOND_LIMITS)
    assert answer.residual[k] > 1e-10
    for language in ("en", "ar"):
        assert IKStatus.BUDGET_SPENT.sentence(
            language, attempts=1, iterations=2, position_error=0.1, rotation_error=0.2
        )


def test_bad_rows_are_marked_and_touch_no_others(panda):
    T = panda.forward_kinematics(random_states(panda, 8, 6))
    clean = solve_ik(panda, T)
    spoilt = T.copy()
    spoilt[1, 0, 3] = np.nan
    spoilt[2, :3, :3] *= 2.0
    spoilt[3, :3, :3] = np.diag([1.0, 1.0, -1.0])
    spoilt[4, 3] = [0.0, 0.0, 1.0, 1.0]
    spoilt[5] = np.inf
    answer = solve_ik(panda, spoilt)
    bad = [1, 2, 3, 4, 5]
    assert all(answer.status[k] is IKStatus.NOT_A_POSE for k in bad)
    assert np.isnan(answer.q[bad]).all()
    assert "not a pose" in answer.explain(1, language="en")
    assert answer.explain(1, language="ar")
    np.testing.assert_array_equal(np.delete(answer.q, bad, 0), np.delete(clean.q, bad, 0))


def test_printed_rotations_are_repaired(panda):
    T = np.round(panda.forward_kinematics(random_states(panda, 20, 7)), 7)
    answer = solve_ik(panda, T)
    assert answer.solved.mean() > 0.9


def test_frame_of_another_link(panda):
    q = random_states(panda, 20, 8)
    T = panda.forward_kinematics(q, frame="link5")
    answer = solve_ik(panda, T, frame="link5")
    assert answer.all_solved
    np.testing.assert_allclose(panda.forward_kinematics(answer.q, frame="link5"), T, atol=1e-9)


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda r: solve_ik(r, np.full((4, 4), np.nan)), InputError, "T_sd"),
        (lambda r: solve_ik(r, np.eye(3)), InputError, "T_sd"),
        (lambda r: solve_ik(r, np.eye(4), seed=np.zeros(6)), InputError, "seed"),
        (lambda r: solve_ik(r, np.eye(4), seed=np.full(7, np.nan)), InputError, "seed"),
        (lambda r: solve_ik(r, np.tile(np.eye(4), (2, 1, 1)), seed=np.zeros((3, 7))), InputError, "seed"),
        (lambda r: solve_ik(r, np.eye(4), tolerance=0.0), InputError, "tolerance"),
        (lambda r: solve_ik(r, np.eye(4), restarts=-1), InputError, "restarts"),
        (lambda r: solve_ik(r, np.eye(4), frame="nose"), ModelError, "nose"),
    ],
)
def test_wrong_input_is_named(panda, call, error, words):
    with pytest.raises(error, match=words):
        call(panda)


@pytest.mark.slow
def test_ten_thousand_panda_poses(panda):
    T = panda.forward_kinematics(random_states(panda, 10_000, 9))
    answer = solve_ik(panda, T)
    assert answer.all_solved
    assert answer.residual.max() <= 1e-10
