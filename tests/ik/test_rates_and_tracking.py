"""Newton's method, joint rates and paths: laws that hold for every arm."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.ik import bounded_rates, integrate_rates, joint_rates, newton_ik, prioritised_rates, track, twist_jacobian
from mafsil.model import Mechanism


@pytest.fixture(scope="module")
def iiwa():
    return mf.load("iiwa7")


Q = np.array([0.1, 0.5, 0.2, -1.2, 0.3, 0.8, 0.4])


@pytest.mark.capability("07-48", "07-45")
def test_weighted_rates_are_the_cheapest(iiwa):
    rng = np.random.default_rng(1)
    cost = np.array([7.0, 6, 5, 4, 3, 2, 1])
    V = rng.normal(size=6)
    rates = joint_rates(iiwa, Q, V, cost=cost)
    J = iiwa.jacobian_body(Q)
    np.testing.assert_allclose(J @ rates.qd, V, atol=1e-12)
    # Optimal exactly if Q qd has no part along the self-motion (KKT).
    assert np.abs(rates.null_space.T @ (cost * rates.qd)).max() < 1e-12
    assert rates.redundancy == 1
    for _ in range(5):
        other = rates.qd + rates.null_space @ rng.normal(size=7)
        np.testing.assert_allclose(J @ other, V, atol=1e-12)
        assert other @ (cost * other) >= rates.qd @ (cost * rates.qd) - 1e-12


def test_goals_move_only_the_self_motion(iiwa):
    V = np.array([0.0, 0.1, 0.0, 0.05, 0.0, 0.02])
    rates = joint_rates(iiwa, np.stack([Q, -Q]), V, qd_preferred=np.ones(7))
    assert rates.qd.shape == (2, 7)
    assert rates.residual.max() < 1e-12
    assert np.abs(rates.qd - joint_rates(iiwa, np.stack([Q, -Q]), V).qd).max() > 1e-3


@pytest.mark.capability("07-49")
def test_singular_postures_are_reported():
    robot = mf.load("elbow6r")
    rates = joint_rates(robot, np.zeros(6), [0, 0, 0, 1.0, 0, 0])
    assert rates.rank < 6
    assert rates.residual + np.abs(rates.qd).max() > 0.1


@pytest.mark.capability("07-46", "07-51")
def test_forms_of_the_twist_agree(iiwa):
    T = iiwa.forward_kinematics(Q)
    V_b = np.array([0.1, -0.2, 0.05, 0.03, 0.04, -0.02])
    body = joint_rates(iiwa, Q, V_b).qd
    R = T[:3, :3]
    tip = np.concatenate([R @ V_b[:3], R @ V_b[3:]])
    np.testing.assert_allclose(joint_rates(iiwa, Q, tip, form="tip").qd, body, atol=1e-12)
    np.testing.assert_allclose(joint_rates(iiwa, Q, pose.adjoint(T) @ V_b, form="space").qd, body, atol=1e-12)
    with pytest.raises(InputError):
        twist_jacobian(iiwa, Q, "world")


def test_priorities_are_strict(iiwa):
    J = iiwa.jacobian_body(Q)
    first, second = np.array([0.1, 0.0, 0.2]), np.array([1.0, -2.0, 0.5, 0.3, 0.2, 0.1, 0.4])
    qd = prioritised_rates(iiwa, Q, [(J[3:], first), (np.eye(7), second)])
    np.testing.assert_allclose(J[3:] @ qd, first, atol=1e-12)
    assert np.linalg.norm(qd - second) < np.linalg.norm(np.linalg.pinv(J[3:]) @ first - second)


WRONG = {
    "robot": (lambda r, q, T: joint_rates(7, q, np.ones(6)), "robot"),
    "rows": (lambda r, q, T: joint_rates(r, q, np.ones(1), rows=[6]), "rows"),
    "no rows": (lambda r, q, T: bounded_rates(r, q, np.ones(0), rows=[]), "rows"),
    "rows twice": (lambda r, q, T: joint_rates(r, q, np.ones(2), rows=[1, 1]), "rows"),
    "cost of words": (lambda r, q, T: joint_rates(r, q, np.ones(6), cost="heavy"), "cost"),
    "cost askew": (lambda r, q, T: joint_rates(r, q, np.ones(6), cost=np.triu(np.ones((7, 7)))), "transpose"),
    "batches": (lambda r, q, T: joint_rates(r, np.stack([q] * 3), np.ones((2, 6))), "batch"),
    "preferred rates": (
        lambda r, q, T: joint_rates(r, np.stack([q] * 3), np.ones(6), qd_preferred=np.ones((2, 7))),
        "batch",
    ),
    "tasks": (lambda r, q, T: prioritised_rates(r, q, None), "tasks"),
    "no pair": (lambda r, q, T: prioritised_rates(r, q, [(np.eye(7),)]), "tasks"),
    "no Jacobian": (lambda r, q, T: prioritised_rates(r, q, [(np.eye(6), np.ones(6))]), "tasks"),
    "twist": (lambda r, q, T: integrate_rates(r, q, None, 1.0, 0.1), "twist"),
    "steps": (lambda r, q, T: integrate_rates(r, q, lambda t, x: np.ones(6), 1e300, 1e-300), "duration"),
    "newton's robot": (lambda r, q, T: newton_ik(7, T, q), "robot"),
    "newton's batch": (lambda r, q, T: newton_ik(r, np.stack([T, T]), q), "T_sd"),
    "newton's initial guess": (lambda r, q, T: newton_ik(r, T, np.stack([q, q])), "q0"),
    "newton's steps": (lambda r, q, T: newton_ik(r, T, q, max_steps=-1), "max_steps"),
    "newton's tolerance": (lambda r, q, T: newton_ik(r, T, q, rotation_tolerance=0.0), "rotation_tolerance"),
    "newton's damping": (lambda r, q, T: newton_ik(r, T, q, damping=-1.0), "damping"),
    "track's robot": (lambda r, q, T: track(7, T[None], q), "robot"),
    "one pose": (lambda r, q, T: track(r, T, q), "T_path"),
    "no number": (lambda r, q, T: track(r, np.stack([T, T * np.nan]), q), "T_path"),
    "no pose": (lambda r, q, T: track(r, np.stack([T, T * [2, 2, 2, 1]]), q), r"T_path\[1\]"),
    "starts": (lambda r, q, T: track(r, T[None], np.stack([q, q])), "q0"),
}


@pytest.mark.parametrize("call", WRONG)
def test_wrong_input_is_refused_by_name(iiwa, call):
    function, words = WRONG[call]
    with pytest.raises(InputError, match=words):
        function(iiwa, Q, iiwa.forward_kinematics(Q))


def test_costs_must_be_positive(iiwa):
    with pytest.raises(InputError, match="positive definite"):
        joint_rates(iiwa, Q, np.zeros(6), cost=[1, 1, 1, 1, 1, 1, -1])
    with pytest.raises(InputError, match="positive"):
        integrate_rates(iiwa, Q, lambda _t, _q: np.zeros(6), 1.0, -0.1)


@pytest.mark.capability("07-39", "07-40", "07-41", "07-38")
def test_newton_converges_quadratically_and_damped():
    robot = mf.load("ur5e")
    q = np.array([0.3, -1.1, 1.4, -0.7, 0.9, 0.2])
    T = robot.forward_kinematics(q)
    record = newton_ik(robot, T, q + 0.1)
    assert record.converged
    np.testing.assert_allclose(record.q, q, atol=1e-9)
    late = record.differences[record.differences > 1e-7]
    assert late[-1] < 20 * late[-2] ** 2
    assert newton_ik(robot, T, q + 0.1, damping=1e-3, form="space").converged
    assert not newton_ik(robot, T, q + 0.1, max_steps=1).converged
    with pytest.raises(InputError):
        newton_ik(robot, T, q, form="world")


@pytest.mark.capability("07-50", "07-51")
def test_paths_keep_their_branch(iiwa):
    T = np.repeat(iiwa.forward_kinematics(Q)[None], 40, axis=0)
    T[:, 1, 3] += np.linspace(0, 0.1, 40)
    done = track(iiwa, T, Q)
    assert done.continuous
    assert done.residual.max() < 1e-9
    assert np.abs(np.diff(done.q, axis=0)).max() < 0.1


def test_arms_of_few_joints_follow_what_lies_between_as_well_as_they_can():
    robot = mf.load("planar2r")
    start = np.array([0.3, 0.6])
    ends = robot.forward_kinematics(np.stack([start, [1.5, -0.6]]))
    done = track(robot, ends, start)
    assert done.continuous
    np.testing.assert_allclose(done.q[-1], [1.5, -0.6], atol=1e-8)
    whole = mf.load("puma560").mechanism
    joints = [joint for joint in whole.joints if joint.name != "joint6"]
    links = [link for link in whole.links if link.name in {end for j in joints for end in (j.parent, j.child)}]
    five = mf.Robot(Mechanism.assemble("puma5", links, joints))
    way = np.linspace([0.2, 0.3, -1.0, 0.5, 0.6], [0.9, -0.3, -0.6, -0.2, 1.0], 9)
    done = track(five, five.forward_kinematics(way), way[0])
    assert done.continuous
    np.testing.assert_allclose(done.q, way, atol=1e-7)


def test_paths_that_leave_the_reach_end_there_with_a_reason(iiwa):
    T = np.repeat(iiwa.forward_kinematics(Q)[None], 12, axis=0)
    T[4:7, 0, 3] += 5.0
    done = track(iiwa, T, Q)
    assert (done.reached, done.continuous) == (4, False)
    assert 3.0 < done.stopped_at < 4.0
    assert np.isnan(done.q[4:]).all()
    for language in ("en", "ar"):
        assert done.refusal.explain(language).split("\n")[0] in done.explain(language)
    assert track(iiwa, T[4:], Q).reached == 0
    assert track(iiwa, np.empty((0, 4, 4)), Q).reached == 0


@pytest.mark.capability("07-50")
def test_a_turn_about_the_elbow_goes_through_the_stretched_arm():
    robot = mf.load("planar2r")
    ends = robot.forward_kinematics(np.array([[0.3, 0.6], [0.3, -0.6]]))
    done = track(robot, ends, [0.3, 0.6])
    assert done.continuous
    np.testing.assert_allclose(done.q[-1], [0.3, -0.6], atol=1e-8)


def test_limits_end_a_branch_and_name_the_joint_and_the_time():
    robot = mf.load("puma560")
    q = np.array([0.2, 0.3, -1.0, 0.5, 0.6, 0.3])
    turned = np.repeat(q[None], 80, axis=0)
    turned[:, 0] += np.linspace(0.0, 4.0, 80)
    times = np.linspace(10.0, 14.0, 80)
    done = track(robot, robot.forward_kinematics(turned), q, times=times)
    (switch,) = done.switches
    assert (switch.reason, switch.joint) == ("limit", "joint1")
    assert switch.time == pytest.approx(10.0 + robot.limits.upper[0] - 0.2, abs=2e-3)
    assert not done.continuous
    assert ((done.q >= robot.limits.lower) & (done.q <= robot.limits.upper)).all()
    before, after = switch.branches
    assert (before.shoulder, after.shoulder) == ("right", "left")
    for language in ("en", "ar"):
        assert "joint1" in done.explain(language)
        assert before.label(language) in done.explain(language)
        assert after.label(language) in done.explain(language)


def test_near_singularities_are_named_with_the_lost_twist():
    robot = mf.load("puma560")
    way = np.repeat(np.array([[0.2, 0.3, -1.0, 0.5, 0.0, 0.3]]), 61, axis=0)
    way[:, 4] = np.linspace(-0.6, 0.6, 61)
    done = track(robot, robot.forward_kinematics(way), way[0])
    assert done.continuous
    (singularity,) = done.near_singularities
    assert singularity.index == 30
    J = robot.jacobian_body(done.q[30])
    # A lost twist is normal to all columns, in the product that scales lengths by the reach.
    scale = np.repeat([1.0, 1.0 / 0.8641], 3)
    assert np.linalg.svd(scale[:, None] * J, compute_uv=False)[-1] < 1e-6
    for language in ("en", "ar"):
        assert singularity.explain(language)


def test_closed_paths_report_their_drift(iiwa):
    a = np.linspace(0, 2 * np.pi, 40)
    T = np.repeat(iiwa.forward_kinematics(Q)[None], 40, axis=0)
    T[:, 0, 3] += 0.1 * (np.cos(a) - 1)
    T[:, 1, 3] += 0.1 * np.sin(a)
    done = track(iiwa, T, Q)
    q = Q.copy()
    for X in T:
        for _ in range(5):
            q = q + np.linalg.pinv(iiwa.jacobian_body(q)) @ pose.error(iiwa.forward_kinematics(q), X)
    assert done.closed
    np.testing.assert_allclose(done.drift, q - Q, atol=2e-2)
    for language in ("en", "ar"):
        assert f"{np.abs(done.drift).max():.3g}" in done.explain(language)
    with pytest.raises(InputError, match="times"):
        track(iiwa, T, Q, times=np.zeros(40))
    with pytest.raises(InputError, match="times"):
        track(iiwa, T, Q, times=np.arange(3.0))


@pytest.mark.capability("07-49")
@pytest.mark.row("R7")
def test_planted_singularities_have_bounded_rates_and_the_right_rank():
    robot = mf.load("iiwa7")
    rng = np.random.default_rng(3)
    q = rng.uniform(robot.limits.lower, robot.limits.upper, (1500, 7))
    q[:, 5] = 0.0  # axes 5 and 7 fall together: still rank 6 by the elbow's freedom
    q[500:, 3] = 0.0  # the arm is stretched
    q[1000:, 1] = 0.0
    V = rng.normal(size=(1500, 6))
    rates = bounded_rates(robot, q, V, limits=np.full(7, 2.0))
    assert np.isfinite(rates.qd).all()
    assert np.abs(rates.qd).max() <= 2.0 + 1e-12
    J = robot.jacobian_body(q)
    np.testing.assert_array_equal(rates.rank, np.linalg.matrix_rank(J, tol=1e-8))
    assert set(rates.rank[1000:]) <= {3, 4, 5}
    for k in (600, 1200):
        assert np.abs(rates.lost(k).T @ J[k]).max() < 1e-8
        assert rates.lost(k).shape == (6, 6 - rates.rank[k])


def test_bounded_rates_are_exact_where_the_arm_is_regular(iiwa):
    V = np.array([0.1, -0.2, 0.05, 0.03, 0.04, -0.02])
    rates = bounded_rates(iiwa, Q, V, region=1e-4)
    np.testing.assert_allclose(rates.qd, joint_rates(iiwa, Q, V).qd, atol=1e-12)
    assert rates.residual < 1e-12
    assert (rates.scale, rates.damped, rates.rank) == (1.0, 0, 6)
    slow = bounded_rates(iiwa, Q, V, region=1e-4, limits=np.full(7, 1e-3))
    np.testing.assert_allclose(slow.qd, slow.scale * rates.qd)
    assert np.abs(slow.qd).max() == pytest.approx(1e-3)
    for wrong in ({"region": 0.0}, {"damping": -1.0}, {"limits": np.zeros(7)}):
        with pytest.raises(InputError):
            bounded_rates(iiwa, Q, V, **wrong)
