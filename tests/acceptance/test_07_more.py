"""Further worked numbers of inverse kinematics, each through the public functions."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.geometry import pose, rotation
from mafsil.ik import inverse_kinematics, twist_of_motion, twists_between
from mafsil.ik.result import IKStatus
from mafsil.ik.structure import puma_shape, strokes
from mafsil.performance import rank
from tests.acceptance.reading import cases, unread_after
from tests.acceptance.test_07_inverse_kinematics import assert_same_set, at, puma_position_arm

CASES = cases("07-more.json")


def arm_of(given):
    return mf.Robot.from_screws(given["S_omega_v"], given["M"])


@pytest.mark.capability("07-13", "07-16", "07-58")
def test_puma_with_the_offset_to_the_right():
    case = CASES["ch07-puma-offset-right"]
    given, want = case["inputs"], case["expected"]
    d, p = given["shoulder_offset"], given["p"]
    robot = puma_position_arm(given["base_height"], given["a1"], given["a2"], d)
    shape = puma_shape(robot)
    np.testing.assert_allclose(
        [shape.height, shape.offset, shape.upper_arm, shape.forearm],
        [given["base_height"], d, given["a1"], given["a2"]],
        atol=1e-12,
    )
    answer = inverse_kinematics(robot, at(p), task="position")
    assert answer.complete
    assert_same_set(answer.q, want["solutions"], case["tol"])
    for theta, rho in zip(want["solutions"], want["rho_of_solution"], strict=True):
        q = answer.nearest(theta)
        np.testing.assert_allclose((q - theta + np.pi) % (2 * np.pi) - np.pi, 0.0, atol=case["tol"])
        # rho is the reach along the heading of joint 1.
        assert p[0] * np.cos(q[0]) + p[1] * np.sin(q[0]) == pytest.approx(rho, abs=case["tol"])
        other = [q[0] + np.pi + 2 * np.arctan2(d, rho), np.pi - q[1], -q[2]]
        np.testing.assert_allclose(robot.forward_kinematics(other)[:3, 3], p, atol=1e-9)


@pytest.mark.capability("07-36")
def test_two_positive_strokes():
    case = CASES["ch07-generalized-stanford-two-positive-strokes"]
    given, want = case["inputs"], case["expected"]
    for c2, roots in zip(given["c_squared"], want["theta3_roots"], strict=True):
        found = strokes(given["r_w"], given["v3"], np.sqrt(c2))
        np.testing.assert_allclose(found, roots, atol=case["tol"])
    answer = inverse_kinematics(arm_of(given), given["X"], tolerance=1e-8)
    assert answer.complete
    assert len(answer.q) == want["n"]
    assert_same_set(answer.q, want["solutions"], case["tol"], sliding=[2])
    assert (answer.q[:, 2] >= 0.0).sum() == want["n_with_theta3_nonnegative"]


@pytest.mark.capability("07-57")
def test_wrist_centre_at_the_shoulder():
    case = CASES["ch07-wrist-centre-at-shoulder"]
    given, want = case["inputs"], case["expected"]
    robot = arm_of(given)
    answer = inverse_kinematics(robot, given["X"], tolerance=1e-8)
    assert answer.status is IKStatus.CONTINUUM
    np.testing.assert_allclose(np.abs(answer.q[:, 2]), want["theta3"], atol=1e-6)
    names = robot.joint_names
    assert rank(robot, answer.q[0]) == want["rank_J"]
    joints = {family.joint for family in answer.families if family.solution == 0}
    assert joints == {names[0], names[1]}
    assert len(joints) == want["family_dimension"]
    for first, second in given["chosen_theta1_theta2"]:
        members = [family.at(first, **{names[1]: second}) for family in answer.families if family.joint == names[0]]
        expected = [m for m in want["members"] if m[:2] == [first, second]]
        found = np.array([m for m in members if np.isfinite(m).all()])
        assert len(expected) == 2
        for one in expected:
            gap = np.abs((found - one + np.pi) % (2 * np.pi) - np.pi).max(axis=1)
            assert gap.min() < 1e-6


@pytest.mark.capability("07-54")
def test_twist_of_a_wanted_motion():
    case = CASES["ch07-twist-of-a-wanted-motion"]

    def X(t):
        R = rotation.rot_z(0.3 * t**2) @ rotation.rot_y(0.5 * np.sin(t))
        return pose.from_rotation_translation(R, [0.2 * np.cos(t), 0.3 * t, 0.1 * t**2])

    t = case["inputs"]["t"]
    V_b, V_s = twist_of_motion(X, t)
    np.testing.assert_allclose(V_b, case["expected"]["V_b"], rtol=0, atol=case["tol"])
    np.testing.assert_allclose(V_s, case["expected"]["V_s"], rtol=0, atol=case["tol"])
    times = t + np.array([-1e-4, 0.0, 1e-4])
    poses = np.stack([X(s) for s in times])
    steps = twists_between(poses, times)
    np.testing.assert_allclose(steps.mean(axis=0), V_b, atol=1e-7)
    np.testing.assert_allclose(poses[0] @ pose.exp(steps[0] * 1e-4), poses[1], atol=1e-12)


@pytest.mark.capability("07-52")
def test_fewer_than_six_joints():
    case = CASES["ch07-fewer-than-six-joints"]
    given, want = case["inputs"], case["expected"]
    one, two, three = given["L"]
    S = [[0, 0, 1, 0, 0, 0], [0, 0, 1, 0, -one, 0], [0, 0, 1, 0, -one - two, 0]]
    robot = mf.Robot.from_screws(S, at([one + two + three, 0, 0]))
    X = np.array(given["X"])
    lifted, tilted = X.copy(), X.copy()
    lifted[2, 3] = 0.1
    tilted[:3, :3] = tilted[:3, :3] @ rotation.rot_x(0.05)
    assert given["variants"] == ["as given", "z = 0.1", "X Rot(x,0.05)"]
    answers = [inverse_kinematics(robot, T, tolerance=1e-8) for T in (X, lifted, tilted)]
    assert [len(answer) for answer in answers] == want["n"]
    assert_same_set(answers[0].q, want["solutions"], case["tol"])
    for answer in answers[1:]:
        assert answer.status is IKStatus.NOT_OF_THIS_ARM
    assert "the position is off its plane" in answers[1].explain("en")
    assert "with this orientation" not in answers[1].explain("en")
    assert answers[1].details["position_error"] == pytest.approx(0.1, abs=1e-6)
    assert answers[1].details["rotation_error"] == pytest.approx(0.0, abs=1e-6)
    assert "cannot be tilted" in answers[2].explain("en")
    assert answers[2].details["rotation_error"] == pytest.approx(0.05, abs=1e-3)


def test_every_key_is_read():
    assert not unread_after({name: x for name, x in globals().items() if name != "test_every_key_is_read"}, CASES)
