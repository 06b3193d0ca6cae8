"""Acceptance cases of part 7, inverse kinematics of open chains."""

import json
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.ik import (
    distances,
    integrate_rates,
    inverse_kinematics,
    joint_rates,
    newton_ik,
    two_axes,
    wrist_angles,
)

CASES = {
    case["id"]: case for case in json.loads(Path(__file__).with_name("07-inverse-kinematics.json").read_text("utf-8"))
}


def arm_of(case_input):
    return mf.Robot.from_screws(case_input["S_omega_v"], case_input["M"])


def pose_of(printed):
    """A printed pose, its rotation brought back to working precision."""
    T = np.array(printed, dtype=float)
    U, _, Vt = np.linalg.svd(T[:3, :3])
    T[:3, :3] = U @ Vt
    return T


def at(position):
    T = np.eye(4)
    T[:3, 3] = position
    return T


def assert_same_set(found, expected, tolerance, sliding=()):
    """Unordered sets of joint vectors, angles modulo whole turns."""
    found, expected = np.atleast_2d(found), np.atleast_2d(expected)
    assert len(found) == len(expected)
    d = found[:, None] - expected[None]
    wrapped = (d + np.pi) % (2 * np.pi) - np.pi
    d = np.where(np.isin(np.arange(d.shape[-1]), sliding), d, wrapped)
    close = np.abs(d).max(axis=-1) <= tolerance
    assert close.any(axis=0).all()
    assert close.any(axis=1).all()


@pytest.mark.capability("07-1", "07-6", "07-7", "07-8", "07-9")
@pytest.mark.parametrize("k", range(8))
def test_planar_2r(k):
    case = CASES["ch07-2R-sets"]
    given, expected = case["input"][k], case["expected"][k]
    L1, L2 = given["L"]
    S = [[0, 0, 1, 0, 0, 0], [0, 0, 1, 0, -L1, 0]]
    robot = mf.Robot.from_screws(S, at([L1 + L2, 0, 0]))
    answer = inverse_kinematics(robot, at([*given["xy"], 0.0]), task="position")
    if expected["n"] == "inf":
        assert len(answer.families) == 1
        assert answer.families[0].joint == robot.joint_names[0]
        assert abs(abs(answer.q[0, 1]) - np.pi) < 1e-7
        return
    assert len(answer.q) == expected["n"]
    assert answer.complete
    if expected["n"]:
        assert_same_set(answer.q, expected["theta"], case["tol"])
    else:
        assert "out of reach" in answer.explain("en")


def puma_position_arm(h, a1, a2, d):
    """Heading, two elevations positive upwards; the offset to the left of the heading."""
    S = [[0, 0, 1, 0, 0, 0], [0, -1, 0, h, 0, 0], [0, -1, 0, h, 0, -a1]]
    return mf.Robot.from_screws(S, at([a1 + a2, d, h]))


@pytest.mark.capability("07-12", "07-15", "07-16", "07-17", "07-18", "07-31")
@pytest.mark.parametrize("name", ["ch07-puma-pos-no-offset", "ch07-puma-pos-offset"])
def test_puma_position(name):
    case = CASES[name]
    given = case["input"]
    robot = puma_position_arm(given["base_height"], given["a1"], given["a2"], given["shoulder_offset"])
    answer = inverse_kinematics(robot, at(given["p"]), task="position")
    assert_same_set(answer.q, case["expected"]["solutions"], case["tol"])
    assert answer.complete


@pytest.mark.capability("07-25")
@pytest.mark.parametrize("k", range(3))
def test_distance_subproblem(k):
    case = CASES["ch07-subproblem-distance"]
    given = case["input"]
    w = np.array(given["omega"])
    found = distances(w / np.linalg.norm(w), given["r"], given["p"], given["c"][k]).solutions()
    expected = case["expected"]["theta"][k]
    np.testing.assert_allclose(np.sort(found), sorted(expected), atol=case["tol"])


@pytest.mark.capability("07-27")
def test_two_axes_subproblem():
    case = CASES["ch07-subproblem-two-axes"]
    given = case["input"]
    found = two_axes(given["w1"], given["w2"], given["p2"], given["p1"]).solutions(1e-9)
    assert_same_set(found, case["expected"]["theta"], case["tol"])


@pytest.mark.capability("07-21", "07-28")
def test_wrist():
    case = CASES["ch07-wrist-perp"]
    given = case["input"]
    R = pose_of(np.block([[np.array(given["R"]), np.zeros((3, 1))], [np.zeros(3), np.ones(1)]]))[:3, :3]
    found = wrist_angles(given["w4"], given["w5"], given["w6"], R).solutions(1e-9)
    assert_same_set(found, case["expected"]["theta"], case["tol"])


@pytest.mark.capability("07-13", "07-14", "07-22", "07-23", "07-30")
@pytest.mark.parametrize("name", ["ch07-generalized-puma-8", "ch07-6R-fig5.7-8"])
def test_spherical_wrist_arms(name):
    case = CASES[name]
    answer = inverse_kinematics(arm_of(case["input"]), pose_of(case["input"]["X"]), tolerance=1e-8)
    assert_same_set(answer.q, case["expected"]["solutions"], case["tol"])
    assert answer.complete
    assert answer.method == "closed form"


@pytest.mark.capability("07-36")
def test_generalized_stanford():
    case = CASES["ch07-generalized-stanford-fig5.10"]
    answer = inverse_kinematics(arm_of(case["input"]), pose_of(case["input"]["X"]), tolerance=1e-8)
    assert_same_set(answer.q, case["expected"]["solutions_all"], case["tol"], sliding=[2])
    assert (answer.q[:, 2] >= 0).sum() == case["expected"]["n_with_theta3_nonnegative"]


@pytest.mark.capability("07-32", "07-33", "07-34")
@pytest.mark.parametrize(("k", "key"), [(0, "no_offset"), (1, "with_offset")])
def test_stanford_position(k, key):
    case = CASES["ch07-stanford-pos"]
    given = case["input"][k]
    S = [[0, 0, 1, 0, 0, 0], [0, -1, 0, given["d1"], 0, 0], [0, 0, 0, 1, 0, 0]]
    robot = mf.Robot.from_screws(S, at([given["a1"], given["offset"], given["d1"]]))
    answer = inverse_kinematics(robot, at(given["p"]), task="position")
    reached = answer.q[answer.q[:, 2] >= 0]
    assert_same_set(reached, case["expected"][key], case["tol"], sliding=[2])


@pytest.mark.capability("07-40", "07-41")
def test_newton_body_and_space_coincide():
    case = CASES["ch07-newton-body-space"]
    robot = arm_of(CASES["ch07-6R-fig5.7-8"]["input"])
    X = robot.forward_kinematics(np.array(case["input"]["theta_true"]))
    records = [newton_ik(robot, X, case["input"]["theta0"], form=form) for form in ("body", "space")]
    np.testing.assert_allclose(records[0].iterates, records[1].iterates, atol=1e-12)
    for record in records:
        step = record.iterates[1] - record.iterates[0]
        np.testing.assert_allclose(step, case["expected"]["first_step"], atol=case["tol"])
        expected = case["expected"]["frobenius_residuals"]
        np.testing.assert_allclose(record.differences[: len(expected)], expected, rtol=1e-5, atol=1e-12)
        np.testing.assert_allclose(record.q, case["expected"]["theta"], atol=case["tol"])
        assert record.iterations <= case["expected"]["max_iterations_to_1e_12"]


@pytest.mark.capability("07-37", "07-40")
def test_newton_planar_2r():
    case = CASES["ch07-newton-2R"]
    robot = mf.Robot.from_screws([[0, 0, 1, 0, 0, 0], [0, 0, 1, 0, -1, 0]], at([2, 0, 0]))
    X = robot.forward_kinematics(np.deg2rad(case["input"]["target_deg"]))
    record = newton_ik(robot, X, np.deg2rad(case["input"]["theta0_deg"]))
    expected = case["expected"]["iterates_deg"]
    np.testing.assert_allclose(np.rad2deg(record.iterates[: len(expected)]), expected, atol=case["tol"])
    np.testing.assert_allclose(record.twists[0], case["expected"]["V_b_first"], atol=case["tol"])


@pytest.mark.capability("07-46", "07-47", "07-48")
def test_weighted_rates_of_a_7r_arm():
    from mafsil.geometry import pose

    case = CASES["ch07-redundant-7R"]
    given = case["input"]
    robot = arm_of(given)
    T = robot.forward_kinematics(np.array(given["theta"]))
    np.testing.assert_allclose(T, case["expected"]["T"], atol=case["tol"])
    rates = joint_rates(robot, given["theta"], given["V_b"], cost=given["Q_diag"])
    np.testing.assert_allclose(rates.qd, case["expected"]["qdot"], atol=case["tol"])
    norm = np.sqrt(rates.qd @ (np.array(given["Q_diag"]) * rates.qd))
    assert norm == pytest.approx(case["expected"]["weighted_norm"], abs=case["tol"])
    V_s = pose.adjoint(T) @ np.array(given["V_b"])
    space = joint_rates(robot, given["theta"], V_s, form="space", cost=given["Q_diag"])
    np.testing.assert_allclose(space.qd, rates.qd, atol=1e-12)
    plain = joint_rates(robot, given["theta"], given["V_b"])
    np.testing.assert_allclose(plain.qd, case["expected"]["qdot_identity"], atol=case["tol"])


@pytest.mark.capability("07-50")
def test_rate_integration_drifts_to_first_order():
    case = CASES["ch07-rate-integration"]
    S = [[0, 0, 1, 0, 0, 0], [0, 0, 1, 0, -1, 0], [0, 0, 1, 0, -2, 0]]
    robot = mf.Robot.from_screws(S, at([2.5, 0, 0]))
    start = np.array([0.3, 0.8, -0.5])
    V = np.array([0.3, -0.4])
    goal = robot.forward_kinematics(start)[:2, 3] + V
    for dt, drift in zip(case["input"]["dt"], case["expected"]["drift"], strict=True):
        path = integrate_rates(robot, start, lambda _t, _q: V, 1.0, dt, form="tip", rows=(3, 4))
        assert np.linalg.norm(robot.forward_kinematics(path[-1])[:2, 3] - goal) == pytest.approx(drift, abs=case["tol"])
    np.testing.assert_allclose(path[-1], case["expected"]["theta_end_dt_0p001"], atol=case["tol"])


@pytest.mark.capability("07-42", "07-43")
def test_almost_ideal_arm_from_closed_form_seeds():
    case = CASES["ch07-analytic-seed-refine"]
    robot = arm_of(case["input"])
    answer = inverse_kinematics(robot, robot.forward_kinematics(np.array(case["input"]["theta_true"])))
    np.testing.assert_allclose(
        robot.forward_kinematics(np.array(case["input"]["theta_true"])), case["input"]["X"], atol=1e-9
    )
    assert answer.method == "refined closed form"
    # The seeds prove nothing; elimination on the arm as it is proves that there are just these eight.
    assert answer.complete
    assert_same_set(answer.q, case["expected"]["solutions"], case["tol"])
    assert answer.residual.max() <= case["input"]["residual_tol"]


def test_every_case_has_a_test():
    tested = Path(__file__).read_text("utf-8")
    assert not [name for name in CASES if name not in tested]
