"""Worked numbers of the specification, part 04: |got - expected| <= tol max(1, |expected|), up to the ambiguities."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from mafsil.geometry import (
    euler,
    matrix_exponential,
    membership,
    planar,
    pose,
    quaternion,
    rotation,
    screw,
    twist,
    wrench,
)
from mafsil.geometry.axis_triples import middle_zero
from mafsil.geometry.frames import CameraScene
from tests.acceptance.reading import cases, unread_after

CASES = cases("04-rigid-body-motions.json")


def agree(case, got, expected):
    expected = np.asarray(expected, dtype=float)
    assert np.shape(got) == expected.shape
    assert np.all(np.abs(np.asarray(got) - expected) <= case["tol"] * np.maximum(1.0, np.abs(expected)))


def agree_angles(case, got, expected_deg):
    difference = np.asarray(got) - np.deg2rad(np.asarray(expected_deg, dtype=float))
    assert np.all(np.abs(np.angle(np.exp(1j * difference))) <= case["tol"])


@pytest.mark.row("Q3")
@pytest.mark.capability("04-9", "04-10", "04-11", "04-12", "04-13", "04-14", "04-98")
def test_planar_pair_and_pole():
    case = CASES["ch4-01"]
    given, want = case["input"], case["expected"]
    T_sb, T_sc = (
        planar.pose(np.deg2rad(given[k]["theta_deg"]), np.array(given[k]["p"], float)) for k in ("T_sb", "T_sc")
    )
    T_bc = planar.compose(planar.inverse(T_sb), T_sc)
    agree(case, T_bc[:2, :2], want["Q_bc"])
    agree(case, T_bc[:2, 2], want["q_bc"])
    agree(case, planar.compose(T_sb, T_bc), T_sc)
    moved = planar.displacement(T_sb, T_sc)
    agree(case, moved, want["displacement_space"])
    agree(case, planar.angle(moved[:2, :2]), want["psi"])
    point, exists = planar.finite_pole(moved)
    assert exists
    agree(case, point, want["pole_space"])
    V = planar.log(moved)
    agree(case, V / V[0], want["twist_space_omega_vx_vy"])
    agree(case, planar.twist_of_pole(1.0, point), want["twist_space_omega_vx_vy"])
    body = planar.log(T_bc)
    agree(case, body / body[0], want["twist_body_omega_vx_vy"])
    S, _ = screw.chasles(planar.to_spatial_pose(moved))
    agree(case, screw.pitch(S), want["h"])


@pytest.mark.row("Q3")
@pytest.mark.capability("04-86", "04-87", "04-91")
def test_camera_scene():
    case = CASES["ch4-02"]
    given, want = {k: np.array(v, float) for k, v in case["input"].items()}, case["expected"]
    scene = CameraScene.of(given["T_ad"], given["T_db"], given["T_de"], given["T_bc"])
    agree(case, scene.T_ab.array, want["T_ab"])
    agree(case, scene.graph().pose("a", "e").array, want["T_ae"])
    agree(case, scene.graph().pose("a", "c").array, want["T_ac"])
    agree(case, scene.graph().pose("c", "a").array, want["T_ac_inv"])
    agree(case, scene.grasp_pose().array, want["T_ce"])
    agree(case, scene.graph().pose("c", "e").array, want["T_ce"])
    assert scene.grasp_pose().frames == ("c", "e")
    given["T_bc"][2, 3] = 25.0
    other = CameraScene.of(given["T_ad"], given["T_db"], given["T_de"], given["T_bc"])
    agree(case, other.graph().pose("a", "c").origin, want["with_T_bc_z_25"]["T_ac_p"])
    agree(case, other.grasp_pose().array, want["with_T_bc_z_25"]["T_ce"])


@pytest.mark.row("Q3")
@pytest.mark.capability("04-34", "04-35", "04-36", "04-46")
def test_zyx_euler_both_branches():
    case = CASES["ch4-03"]
    want = case["expected"]
    R = rotation.from_euler(np.deg2rad(case["input"]["alpha_beta_gamma_deg"]), "ZYX")
    agree(case, R, want["R"])
    plus, minus = euler.solutions(R, "ZYX").angles
    agree_angles(case, plus, want["branch_plus_deg"])
    agree_angles(case, minus, want["branch_minus_deg"])
    agree_angles(case, rotation.to_rpy(R), want["equals_fixed_XYZ_roll_pitch_yaw_deg"])
    agree(case, rotation.from_rpy(np.deg2rad(want["equals_fixed_XYZ_roll_pitch_yaw_deg"])), want["R"])


@pytest.mark.row("Q3")
@pytest.mark.capability("04-41", "04-42", "04-37")
def test_zyz_euler():
    case = CASES["ch4-05"]
    want = case["expected"]
    R = rotation.from_euler(np.deg2rad(case["input"]["alpha_beta_gamma_deg"]), "ZYZ")
    agree(case, R, want["R"])
    plus, minus = euler.solutions(R, "ZYZ").angles
    agree_angles(case, plus, want["branch_plus_deg"])
    agree_angles(case, minus, want["branch_minus_deg"])
    for singular in want["singular"]:
        locked = euler.solutions(rotation.from_euler(np.deg2rad(singular["given_deg"]), "ZYZ"), "ZYZ")
        assert locked.locked
        agree_angles(case, locked.angles[0], singular["canonical_deg"])


@pytest.mark.row("Q3")
@pytest.mark.capability("04-43")
def test_generalized_three_axis_set():
    case = CASES["ch4-06"]
    given, want = case["input"], case["expected"]
    axes = np.array([given["axis1"], given["axis2"], given["axis3"]], float)
    R = rotation.from_davenport(given["angles"], axes)
    agree(case, R, want["R"])
    agree(case, middle_zero(axes), want["lambda_"])
    agree(case, rotation.to_davenport(R, axes), want["recovered_sets"])


@pytest.mark.row("Q3")
@pytest.mark.capability("04-63")
def test_rodrigues():
    case = CASES["ch4-07"]
    axis, theta, want = np.array(case["input"]["axis"]), np.deg2rad(case["input"]["theta_deg"]), case["expected"]
    R = rotation.from_axis_angle(axis, theta)
    agree(case, R, want["R"])
    agree(case, rotation.log(R), want["r"])
    agree(case, rotation.exp(np.array(want["r"])), want["R"])
    agree(case, np.trace(R), want["trace"])


@pytest.mark.row("Q3")
@pytest.mark.capability("04-65", "04-77")
def test_log_near_the_ends():
    case = CASES["ch4-09"]
    axis = np.array(case["input"]["axis"])
    for theta in [*case["input"]["theta"], *(pi - d for d in case["input"]["pi_minus"])]:
        q = np.concatenate([[np.cos(theta / 2)], np.sin(theta / 2) * axis])
        r = rotation.log(rotation.from_quaternion(q))
        assert np.abs(r - axis * theta).max() / theta <= case["expected"]["max_relative_error"]
        assert case["expected"]["log_of_exp"] == "axis*theta"


@pytest.mark.row("Q3")
@pytest.mark.capability("04-72", "04-73", "04-74", "04-76")
def test_quaternions():
    case = CASES["ch4-10"]
    want = case["expected"]
    q, p = (
        quaternion.exp(np.array(case["input"][k]["axis"], float) * np.deg2rad(case["input"][k]["theta_deg"]))
        for k in "qp"
    )
    agree(case, q, want["q"])
    agree(case, p, want["p"])
    agree(case, quaternion.multiply(q, p), want["qp"])
    agree(case, quaternion.multiply(p, q), want["pq"])
    agree(case, rotation.from_quaternion(quaternion.multiply(q, p)), want["R_qp"])
    agree(case, rotation.from_quaternion(q) @ rotation.from_quaternion(p), want["R_qp"])
    agree(case, rotation.from_quaternion(-q), rotation.from_quaternion(q))
    half = rotation.from_axis_angle(np.array(case["input"]["q"]["axis"]), pi)
    agree(case, quaternion.to_quaternion(half), want["q_at_theta_pi"])


@pytest.mark.row("Q3")
@pytest.mark.capability("04-92", "04-93", "04-94", "04-95", "04-96")
def test_screw_to_twist_to_pose():
    case = CASES["ch4-11"]
    want = case["expected"]
    for k, given in enumerate(case["input"]["screws"]):
        S = screw.from_axis(given["axis"], given["q"], given["h"])
        agree(case, S, want["S"][k])
        agree(case, screw.pitch(S), given["h"])
        agree(case, screw.displacement(S, given["theta"]), want["T"][k])
    axis, theta = given["axis"], given["theta"]
    agree(case, screw.nearest_point(S), want["nearest_axis_point_2"])
    agree(case, screw.integral(np.array(axis), theta), want["G_2"])
    agree(case, screw.integral_inverse(np.array(axis), theta), want["Ginv_2"])


@pytest.mark.row("Q3")
@pytest.mark.capability("04-88", "04-89", "04-97")
def test_displaced_body():
    case = CASES["ch4-13"]
    T_ba, want = np.array(case["input"]["T_ba"]), case["expected"]
    agree(case, pose.act(T_ba, np.array(case["input"]["p_a"], float)), want["p_b"])
    S, theta = screw.chasles(T_ba)
    agree(case, S, want["S"])
    agree(case, theta, want["theta"])
    agree(case, screw.pitch(S), want["h"])
    agree(case, screw.nearest_point(S), want["q_nearest"])
    agree(case, pose.inverse(T_ba), want["T_ab"])


@pytest.mark.row("Q3")
@pytest.mark.capability("04-100", "04-101", "04-102", "04-104")
def test_adjoint():
    case = CASES["ch4-14"]
    T_ba, S_a, want = np.array(case["input"]["T_ba"], float), np.array(case["input"]["S_a"]), case["expected"]
    agree(case, pose.adjoint(T_ba), want["Ad"])
    S_b = twist.transform(T_ba, S_a)
    agree(case, S_b, want["S_b"])
    agree(case, pose.vee(T_ba @ pose.hat(S_a) @ pose.inverse(T_ba)), want["S_b"])
    agree(case, [screw.pitch(S_a), screw.pitch(S_b)], [want["pitch_both"]] * 2)


@pytest.mark.row("Q3")
@pytest.mark.capability("04-105")
def test_space_and_body_form_of_one_screw():
    case = CASES["ch4-15"]
    T_01, given, want = np.array(case["input"]["T_01"]), case["input"]["screw"], case["expected"]
    S = screw.from_axis(given["axis"], given["q"], given["h"])
    agree(case, S, want["S"])
    T_02 = screw.displacement(S, given["theta"]) @ T_01
    agree(case, T_02, want["T_02"])
    T_12 = pose.inverse(T_01) @ T_02
    agree(case, T_12, want["T_12"])
    S_prime = twist.transform(pose.inverse(T_01), S)
    agree(case, S_prime, want["S_prime"])
    agree(case, screw.displacement(S_prime, given["theta"]), want["T_12"])


@pytest.mark.row("Q3")
@pytest.mark.capability("04-113", "04-114", "04-115")
def test_wrench_change_of_frame_and_power():
    case = CASES["ch4-17"]
    given, want = {k: np.array(v, float) for k, v in case["input"].items()}, case["expected"]
    F_a = wrench.from_force(given["r_a"], given["f_a"])
    agree(case, F_a, want["F_a"])
    F_b = wrench.transform(given["T_ab"], F_a)
    agree(case, F_b, want["F_b"])
    V_b = twist.transform(pose.inverse(given["T_ab"]), given["V_a"])
    agree(case, V_b, want["V_b"])
    agree(case, [wrench.power(given["V_a"], F_a), wrench.power(V_b, F_b)], [want["power"]] * 2)


@pytest.mark.row("Q3")
@pytest.mark.capability("04-52", "04-53", "04-54", "04-57")
def test_matrix_exponential():
    case = CASES["ch4-18"]
    given, want = case["input"], case["expected"]
    A, t = given["A"], given["t"]
    methods = [
        matrix_exponential.exponential(A, t),
        matrix_exponential.series(A, t).value,
        matrix_exponential.by_similarity(A, t)[0],
        matrix_exponential.by_characteristic_polynomial(A, t),
    ]
    for value in methods:
        agree(case, value, want["eAt"])
    agree(case, matrix_exponential.solution(A, given["x0"], t), want["x_t"])
    agree(case, matrix_exponential.exponential(given["jordan"], t), want["e_jordan_t"])
    agree(case, matrix_exponential.by_characteristic_polynomial(given["jordan"], t), want["e_jordan_t"])
    p = matrix_exponential.characteristic_polynomial(given["charpoly_test"])
    agree(case, p, want["charpoly"])
    agree(case, matrix_exponential.polynomial_of(p, given["charpoly_test"]), np.zeros((3, 3)))


@pytest.mark.row("Q3")
@pytest.mark.capability("04-19", "04-20", "04-21", "04-22")
def test_membership():
    case = CASES["ch4-19"]
    matrices, want = np.array(case["input"]["matrices"], float), case["expected"]
    residuals = rotation.residuals(matrices)
    agree(case, residuals[:, 6] + 1, want["det"])
    assert list(np.abs(residuals[:, :6]).max(-1) < 1e-9) == want["orthogonal"]
    assert list(rotation.is_rotation(matrices)) == want["in_SO3"]
    assert np.isinf(membership.measure("rotation", matrices[0]))


def test_every_key_of_every_case_is_read(request):
    del request  # an argument, so that the guard does not call itself
    assert unread_after(globals(), CASES) == []
