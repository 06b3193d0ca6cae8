"""Worked numbers of part 08 (parallel robots): platforms on legs, through the public face."""

import numpy as np
import pytest

from mafsil.geometry import rotation
from mafsil.parallel import StewartPlatform
from tests.acceptance.reading import cases

CASES = cases("08-closed-chains.json", "08-more.json")


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
    found = robot.forward(robot.lengths(T), guess)
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
