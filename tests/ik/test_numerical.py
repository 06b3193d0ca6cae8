"""Numerical inverse kinematics: every answer verified by forward kinematics, every refusal with its reason."""

from __future__ import annotations

import copy
import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError, ModelError
from mafsil.geometry import pose
from mafsil.ik import solve_ik
from mafsil.ik.numerical.fast_search import search_of
from mafsil.ik.numerical.full_search import exact_starts
from mafsil.ik.result import FIELDS, IKStatus

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
    assert not np.array_equal(solve_ik(panda, T, seed=1).q, whole.q)


def test_seed_is_where_the_search_starts(panda):
    q = random_states(panda, 50, 3)
    near = solve_ik(panda, panda.forward_kinematics(q), q0=q + 1e-3)
    # Shifted starts may lie just outside the limits; they are clipped.
    assert near.all_solved
    assert np.abs(near.q - q).max() < 0.05
    assert near.iterations.max() <= 6
    one = solve_ik(panda, panda.forward_kinematics(q), q0=np.zeros(7), restarts=0)
    assert one.attempts.max() == 1


def test_an_array_given_as_seed_is_the_initial_guess_with_a_warning(panda):
    q = random_states(panda, 1, 3)[0]
    T = panda.forward_kinematics(q)
    with pytest.warns(DeprecationWarning, match="q0"):
        old = solve_ik(panda, T, seed=q + 1e-3)
    np.testing.assert_array_equal(old.q, solve_ik(panda, T, q + 1e-3).q)
    with pytest.raises(InputError, match="seed"):
        solve_ik(panda, T, q, seed=q)


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
    from mafsil.ik.result import reach_bound

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
        assert IKStatus.BUDGET_SPENT.sentence(language)
        assert answer.explain(k, language=language)


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
        (lambda r: solve_ik(r, np.eye(4), q0=np.zeros(6)), InputError, "q0"),
        (lambda r: solve_ik(r, np.eye(4), q0=np.full(7, np.nan)), InputError, "q0"),
        (lambda r: solve_ik(r, np.tile(np.eye(4), (2, 1, 1)), q0=np.zeros((3, 7))), InputError, "q0"),
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


@pytest.mark.capability("07-3")
@pytest.mark.parametrize("shape", [(), (1,), (3,)])
def test_the_closed_form_is_asked_before_a_no(shape):
    """A pose of a Puma that 256 attempts miss: its closed form lists the very configuration."""
    robot = mf.load("puma560")
    q = np.array([2.72748198, -0.77931343, -3.87972646, 0.03649796, -0.58530039, 1.21012158])
    T = np.broadcast_to(robot.forward_kinematics(q), (*shape, 4, 4))
    answer = solve_ik(robot, T)
    assert answer.all_solved
    assert (answer.q >= robot.limits.lower).all()
    assert (answer.q <= robot.limits.upper).all()
    reached = robot.forward_kinematics(answer.q)
    assert np.abs(pose.error(reached, T)).max() <= 1e-10
    assert (answer.attempts > 256).all()
    near = solve_ik(robot, T, np.broadcast_to(q + 0.3, (*shape, 6)), limits=False)
    assert near.all_solved
    # Who allows a few attempts only asks for the solution near the own start, or for none.
    assert not solve_ik(robot, T, np.zeros((*shape, 6)), restarts=2).all_solved


@pytest.mark.parametrize("name", ["puma560", "ur5e", "stanford_arm"])
def test_exact_starts_are_solutions_within_the_limits_nearest_first(name):
    robot = mf.load(name)
    T = robot.forward_kinematics(random_states(robot, 200, 8))
    near = random_states(robot, 200, 9)
    plan = search_of(robot, None, True, 0, "pose", (0.0, 0.0, 1.0), None, 1e-10, None).plan
    q = exact_starts(plan.problem, plan.task, T.reshape(-1, 16), near)
    assert q is not None
    some = np.isfinite(q).all(axis=2)
    assert some[:, 0].all()
    far = np.where(some, np.abs(q - near[:, None]).max(axis=2), np.inf)
    np.testing.assert_array_less(-1e-12, np.diff(np.nan_to_num(far, posinf=1e9), axis=1))
    reached = robot.forward_kinematics(q[some])
    assert np.abs(pose.error(reached, T[np.nonzero(some)[0]])).max() <= 1e-4
    assert ((q[some] >= robot.limits.lower - 1e-4) & (q[some] <= robot.limits.upper + 1e-4)).all()


def test_arms_without_a_closed_form_have_no_exact_starts():
    for name, task in (("panda", "pose"), ("puma560", "position"), ("rrprrr", "axis")):
        plan = search_of(mf.load(name), None, True, 0, task, (0.0, 0.0, 1.0), None, 1e-10, None).plan
        assert exact_starts(plan.problem, plan.task, np.eye(4).reshape(1, 16), np.zeros((1, 7))) is None


def test_an_answer_finds_its_fields_when_they_are_asked_for_and_keeps_them(panda):
    T = panda.forward_kinematics(random_states(panda, 1, 12)[0])
    answer, batch = solve_ik(panda, T), solve_ik(panda, T[None])
    assert answer.nearest is answer.nearest
    for name in FIELDS:
        np.testing.assert_array_equal(
            getattr(answer, name),
            np.asarray(getattr(batch, name)).reshape(np.shape(getattr(answer, name))),
            err_msg=name,
        )
    with pytest.raises(AttributeError):
        answer.nearest = np.zeros(7)
    with pytest.raises(AttributeError, match="nonsense"):
        _ = answer.nonsense
    again = pickle.loads(pickle.dumps(answer))
    np.testing.assert_array_equal(again.q, answer.q)
    assert again.status is IKStatus.SOLVED
    assert copy.copy(batch)[0].explain() == answer.explain()
    assert not hasattr(answer, "__dict__")


def test_repeated_calls_see_changed_settings(panda):
    """A call is recognised by all that it was given, not by some of it."""
    T = panda.forward_kinematics(random_states(panda, 1, 13)[0])
    first = solve_ik(panda, T)
    assert solve_ik(panda, T, seed=5).attempts >= 1
    np.testing.assert_array_equal(solve_ik(panda, T).q, first.q)
    assert solve_ik(panda, T, task="position").q.shape == (7,)
    np.testing.assert_array_equal(solve_ik(panda, T, limits=True, axis=[0, 0, 1]).q, first.q)
    np.testing.assert_array_equal(solve_ik("panda", T.tolist()).q, first.q)
    for wrong in ({"tolerance": -1.0}, {"tolerance": True}, {"seed": True}, {"restarts": -1}, {"task": "nothing"}):
        with pytest.raises(InputError):
            solve_ik(panda, T, **wrong)
    start = np.full(7, np.nan)
    with pytest.raises(InputError, match="q0"):
        solve_ik(panda, T, start)


def test_threads_share_a_search(panda):
    q = random_states(panda, 200, 14)
    T = panda.forward_kinematics(q)
    alone = [solve_ik(panda, each).q for each in T]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda each: solve_ik(panda, each).q, T))
    np.testing.assert_array_equal(alone, together)
