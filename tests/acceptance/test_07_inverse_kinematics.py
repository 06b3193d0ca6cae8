"""Acceptance cases of part 7, inverse kinematics of open chains."""

import numpy as np
import pytest

import mafsil as mf
from mafsil.geometry import pose
from mafsil.ik import (
    arm_structure,
    continued_branches,
    find_root,
    integrate_rates,
    inverse_kinematics,
    joint_rates,
    newton_ik,
    planar_reach,
)
from mafsil.ik.newton import RootStatus
from mafsil.ik.structure import PlaceClass, distances, strokes, two_axes, wrist_angles
from tests.acceptance.reading import cases

CASES = cases("07-inverse-kinematics.json")


def arm_of(case_input):
    return mf.Robot.from_screws(case_input["S_omega_v"], case_input["M"])


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
    place = at([*given["xy"], 0.0])
    answer = inverse_kinematics(robot, place, task="position")
    assert planar_reach(robot).classify(place[:3, 3]) is CLASSES[k]
    if expected["n"] == "inf":
        assert expected["theta"] == "theta2=pi, theta1 free"
        assert len(answer.families) == 1
        assert answer.families[0].joint == robot.joint_names[0]
        assert abs(abs(answer.q[0, 1]) - np.pi) < 1e-7
        return
    assert len(answer.q) == expected["n"]
    assert answer.complete
    if expected["n"]:
        assert_same_set(answer.q, expected["theta"], case["tol"])
    else:
        assert expected["theta"] == []
        assert "out of reach" in answer.explain("en")


CLASSES = (
    *[PlaceClass.INTERIOR] * 3,
    PlaceClass.OUTER_BOUNDARY,
    PlaceClass.INNER_BOUNDARY,
    PlaceClass.OUTSIDE,
    PlaceClass.HOLE,
    PlaceClass.INNER_BOUNDARY,
)
"""Of the places of the planar arm."""


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
    if "book_zero_theta1" in case["expected"]:
        # It is a quarter turn from joint 1 of the mirrored arm: the printed arctangents have exchanged arguments.
        mirrored = puma_position_arm(given["base_height"], given["a1"], given["a2"], -given["shoulder_offset"])
        first = inverse_kinematics(mirrored, at(given["p"]), task="position").q[:, 0] - np.pi / 2
        for value in case["expected"]["book_zero_theta1"]:
            assert np.abs((first - value + np.pi) % (2 * np.pi) - np.pi).min() < case["tol"]


@pytest.mark.capability("07-25")
@pytest.mark.parametrize("k", range(3))
def test_distance_subproblem(k):
    case = CASES["ch07-subproblem-distance"]
    given = case["input"]
    w = np.array(given["omega"])
    found = distances(w / np.linalg.norm(w), given["r"], given["p"], given["c"][k]).solutions()
    expected = case["expected"]["theta"][k]
    np.testing.assert_allclose(np.sort(found), sorted(expected), rtol=0, atol=case["tol"])


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
    found = wrist_angles(given["w4"], given["w5"], given["w6"], given["R"]).solutions(1e-9)
    assert_same_set(found, case["expected"]["theta"], case["tol"])


@pytest.mark.capability("07-13", "07-14", "07-22", "07-23", "07-30")
@pytest.mark.parametrize("name", ["ch07-generalized-puma-8", "ch07-6R-fig5.7-8"])
def test_spherical_wrist_arms(name):
    case = CASES[name]
    robot, X = arm_of(case["input"]), np.array(case["input"]["X"])
    answer = inverse_kinematics(robot, X)
    assert_same_set(answer.q, case["expected"]["solutions"], case["tol"])
    assert answer.complete
    assert answer.method == "closed form"
    if "p1_norm" in case["expected"]:
        moved = X @ pose.inverse(case["input"]["M"])
        centre = pose.act(moved, arm_structure(robot).wrist_centre)
        assert np.linalg.norm(centre) == pytest.approx(case["expected"]["p1_norm"], abs=case["tol"])
        thirds = np.unique(np.round(answer.q[:, 2], 6))
        np.testing.assert_allclose(thirds, sorted(case["expected"]["theta3"]), rtol=0, atol=1e-6)


@pytest.mark.capability("07-36")
def test_generalized_stanford():
    case = CASES["ch07-generalized-stanford-fig5.10"]
    robot, X = arm_of(case["input"]), np.array(case["input"]["X"])
    answer = inverse_kinematics(robot, X)
    centre = arm_structure(robot).wrist_centre
    reached = np.linalg.norm(pose.act(X @ pose.inverse(case["input"]["M"]), centre))
    found = strokes(centre, case["input"]["S_omega_v"][2][3:], reached)
    np.testing.assert_allclose(found, sorted(case["expected"]["theta3_roots"]), rtol=0, atol=case["tol"])
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
    assert case["input"]["robot"].endswith("ch07-6R-fig5.7-8")
    assert case["input"]["X"] == "FK(theta_true)"
    robot = arm_of(CASES["ch07-6R-fig5.7-8"]["input"])
    X = robot.forward_kinematics(np.array(case["input"]["theta_true"]))
    printed = find_root(
        lambda q: pose.error(robot.forward_kinematics(q), X), case["input"]["theta0"], robot.jacobian_body
    )
    assert (printed.status is RootStatus.DIVERGED) == case["expected"]["printed_sign_diverges"]
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
    np.testing.assert_allclose(np.rad2deg(record.iterates[: len(expected)]), expected, rtol=0, atol=case["tol"])
    np.testing.assert_allclose(record.twists[0], case["expected"]["V_b_first"], atol=case["tol"])


@pytest.mark.capability("07-46", "07-47", "07-48")
def test_weighted_rates_of_a_7r_arm():
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
    ideal = continued_branches(robot, case["input"]["X"]).ideal
    assert np.isfinite(ideal).all()
    for seed in ideal:
        record = newton_ik(robot, case["input"]["X"], seed, rotation_tolerance=1e-9, position_tolerance=1e-9)
        assert record.converged
        assert record.iterations <= case["expected"]["max_iterations"]


def test_every_key_of_every_case_is_read():
    for name, function in globals().items():
        if not name.startswith("test_") or name == "test_every_key_of_every_case_is_read":
            continue
        marks = [mark for mark in function.pytestmark if mark.name == "parametrize"]
        values = [value if isinstance(value, tuple) else (value,) for value in marks[0].args[1]] if marks else [()]
        for value in values:
            function(*value)
    assert not [place for case in CASES.values() for place in case.unread()]
