"""Worked numbers of part 08 (parallel robots): platforms on legs, through the public face."""

import numpy as np
import pytest

from mafsil.geometry import quaternion, rotation
from mafsil.parallel import StewartPlatform
from tests.acceptance.reading import cases, unread_after

CASES = cases("08-closed-chains.json", "08-more.json")
OWN = {
    name: CASES[name]
    for name in (
        "ch08-05-stewart-ik-jacobian-statics",
        "ch08-06-stewart-home-and-singular",
        "ch08-07-stewart-fk-all-modes-semiregular",
        "ch08-104-stewart-dietmaier-count",
        "ch08-105-stewart-general-18-real",
        "ch08-107-six-axis-sensor-two-frames",
    )
}
"""Cases of which the tests here read every key."""


def near(got, expected, tolerance=2e-8):
    assert np.shape(got) == np.shape(expected)
    assert np.asarray(got, float) == pytest.approx(np.asarray(expected, float), abs=tolerance)


def stewart():
    return StewartPlatform.on_circles(
        2.0, 1.0, np.radians([-15, 15, 105, 135, 225, 255]), np.radians([-45, 45, 75, 165, 195, 285])
    )


def pose_of(case):
    T = np.eye(4)
    T[:3, :3] = rotation.rot_z(np.radians(10)) @ rotation.rot_y(np.radians(-5)) @ rotation.rot_x(np.radians(8))
    near(T[:3, :3], case["R"], 1e-9)
    T[:3, 3] = case["p"]
    return T


@pytest.mark.capability("08-7", "08-25", "08-26", "08-36", "08-37", "08-38", "08-39")
def test_stewart_platform():
    case = CASES["ch08-05-stewart-ik-jacobian-statics"]
    robot, T = stewart(), pose_of(case)
    G = robot.jacobian(T)
    near(robot.lengths(T), case["s"], 1e-9)
    near(G, case["Jinv_s"], 1e-9)
    near(np.linalg.det(G), case["det_Jinv"], 1e-8)
    near(robot.leg_rates(T, case["twist_s"]), case["sdot"], 1e-9)
    near(robot.wrench(T, case["tau"]), case["wrench_s"], 1e-8)
    near(robot.leg_forces(T, case["wrench_s"]), case["tau"])
    assert case["payload"] == "100 N down at platform origin"
    weight = np.concatenate([np.cross(case["p"], [0, 0, -100]), [0, 0, -100]])
    near(robot.leg_forces(T, -weight), case["leg_forces_holding"])
    begin = case["fk_newton_start"]
    assert begin["R"] == "I"
    guess = np.eye(4)
    guess[:3, 3] = begin["p"]
    found = robot.forward_near(robot.lengths(T), guess)
    assert found
    assert found.steps <= case["fk_newton_max_iter"]
    near(found.T, T, case["fk_newton_tol"])


@pytest.mark.capability("08-10")
def test_six_axis_sensor():
    case = CASES["ch08-107-six-axis-sensor-two-frames"]
    robot, T = stewart(), pose_of(CASES["ch08-05-stewart-ik-jacobian-statics"])
    expected = case["expected"]
    near(robot.external_wrench(T, case["tau"]), expected["F_ext_s"], case["tol"])
    near(robot.external_wrench(T, case["tau"], "body"), expected["F_ext_b"], case["tol"])
    near(robot.wrench_noise(T), expected["sigma_b"], case["tol"])
    near(np.linalg.svd(robot.jacobian(T), compute_uv=False), expected["singular_values_of_Jinv"], case["tol"])


@pytest.mark.capability("08-53")
def test_stewart_home_and_singular_poses():
    case, robot = CASES["ch08-06-stewart-home-and-singular"], stewart()
    T = np.eye(4)
    T[2, 3] = 1.5
    near(robot.lengths(T), [case["s_home"]] * 6, 1e-9)
    for row in case["det"]:
        turned = T.copy()
        turned[:3, :3] = rotation.rot_z(np.radians(row["psi_deg"]))
        G = robot.jacobian(turned)
        near(np.linalg.det(G), row["det"], 1e-8)
        assert np.linalg.matrix_rank(G, 1e-9) == row["rank"]
    special = case["architecture_singular"]
    assert special["b"] == "0.5*a_i (similar, unrotated hexagons)"
    similar = StewartPlatform(robot.base, 0.5 * robot.base)
    assert np.linalg.matrix_rank(similar.jacobian(T), 1e-9) == special["rank_at_home"]
    tilted = pose_of(CASES["ch08-05-stewart-ik-jacobian-statics"])
    assert np.linalg.matrix_rank(similar.jacobian(tilted), 1e-9) == special["rank_at_case05_pose"]


@pytest.mark.capability("08-27", "08-35")
def test_all_modes_of_a_semiregular_platform():
    case = CASES["ch08-07-stewart-fk-all-modes-semiregular"]
    found = stewart().forward_kinematics(stewart().lengths(pose_of(CASES["ch08-05-stewart-ik-jacobian-statics"])))
    assert found.count == case["n_real"]
    assert found.finite == case["n_finite_nonsingular"] == found.expected
    above = np.array(sorted(T[:3, 3].tolist() for T in found if T[2, 3] > 0))
    near(above, sorted(case["p_with_positive_z"]), 1e-9)
    below = np.array(sorted((T[:3, 3] * [1, 1, -1]).tolist() for T in found if T[2, 3] < 0))
    near(above, below, 1e-9)


@pytest.mark.capability("08-27")
def test_all_forty_modes_are_real():
    case = CASES["ch08-104-stewart-dietmaier-count"]
    robot, expected = StewartPlatform(case["a"], case["b"]), case["expected"]
    found = robot.forward_kinematics(case["s"])
    assert (found.count, found.finite) == (expected["n_real"], expected["n_complex"])
    near(robot.lengths(found.T), np.tile(case["s"], (40, 1)), 1e-9)
    misread = robot.forward_kinematics(np.sqrt(case["s"]))
    assert misread.count == expected["n_real_if_the_numbers_are_misread_as_squares"]


@pytest.mark.capability("08-27")
def test_all_modes_of_a_general_platform():
    case = CASES["ch08-105-stewart-general-18-real"]
    robot, expected, made = StewartPlatform(case["a"], case["b"]), case["expected"], case["generating_pose"]
    q = np.array(made["quat_wxyz_unnormalised"])
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = quaternion.from_quaternion(q / np.linalg.norm(q)), made["p"]
    near(robot.lengths(T), case["s"], 1e-9)
    found = robot.forward_kinematics(case["s"])
    assert (found.count, found.finite) == (expected["n_real"], expected["n_complex_nonsingular"])
    listed = np.array(expected["solutions_p_quat"])
    order = np.argsort(found.T[:, 0, 3])
    near(found.T[order, :3, 3], listed[:, :3], case["tol"])
    q = quaternion.to_quaternion(found.T[order, :3, :3])
    near(np.abs((q * listed[:, 3:]).sum(axis=1)), np.ones(18), case["tol"])


def test_every_key_is_read():
    others = {name: item for name, item in globals().items() if name != "test_every_key_is_read"}
    assert unread_after(others, OWN) == []
