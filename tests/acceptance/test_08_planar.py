"""Worked numbers of part 08 (parallel robots): planar platforms, through the public face."""

import numpy as np
import pytest

from mafsil.parallel import PlanarThreeRPR, SingularKind
from tests.acceptance.reading import unread_after
from tests.acceptance.test_08_closed_chains import CASES, near

OWN = {
    name: CASES[name]
    for name in (
        "ch08-02-3rpr",
        "ch08-03-3rpr-six-assembly-modes",
        "ch08-101-3rpr-mode-at-phi-180",
        "ch08-103-3rpr-actuator-singularity",
    )
}
"""Cases of which the tests here read every key."""

DEGREES = np.array([1, 1, 180 / np.pi])


@pytest.mark.capability("08-13", "08-20", "08-21", "08-22", "08-40")
def test_three_rpr():
    case = CASES["ch08-02-3rpr"]
    robot, pose = PlanarThreeRPR(case["a"], case["b"]), case["pose"]
    x = [pose["px"], pose["py"], np.radians(pose["phi_deg"])]
    near(robot.lengths(x), case["s"], 1e-9)
    near(robot.jacobian(x), case["G"], 1e-8)
    near(np.linalg.det(robot.jacobian(x)), case["det_G"], 1e-8)
    near(robot.leg_rates(x, case["twist"]), case["sdot"], 1e-8)
    near(robot.wrench(x, case["leg_forces"]), case["wrench_mz_fx_fy"], 1e-8)
    near(robot.leg_forces(x, case["wrench_mz_fx_fy"]), case["leg_forces"], 1e-7)
    found = robot.forward_kinematics(robot.lengths(x))
    assert found.count == case["n_real_fk"]
    near(found.x * DEGREES, case["fk_solutions_px_py_phideg"], 1e-7)


@pytest.mark.capability("08-22", "08-23", "08-24")
def test_six_modes_are_real():
    case = CASES["ch08-03-3rpr-six-assembly-modes"]
    robot = PlanarThreeRPR(case["a"], case["b"])
    sides = case["platform_sides"]
    for name, i, j in (("b1b2", 0, 1), ("b2b3", 1, 2), ("b1b3", 0, 2)):
        near(np.linalg.norm(robot.platform[i] - robot.platform[j]), sides[name], 1e-8)
    sextic = robot.sextic(case["s"])
    near(sextic / sextic[-1], case["monic_sextic_ascending"], 1e-8)
    found = robot.forward_kinematics(case["s"])
    near(np.tan(found.x[:, 2] / 2), case["t_roots"], 1e-8)
    near(found.x * DEGREES, case["solutions_px_py_phideg"], 2e-6)
    mirrored = PlanarThreeRPR(case["a"], robot.platform * [1, -1]).forward_kinematics(case["s"])
    assert mirrored.count == case["mirror_platform_b3_y_negative_n_real"]


@pytest.mark.capability("08-22")
def test_a_mode_at_half_a_turn():
    case = CASES["ch08-101-3rpr-mode-at-phi-180"]
    robot, expected = PlanarThreeRPR(case["a"], case["b"]), case["expected"]
    sextic = robot.sextic(case["s"])
    near(sextic * np.sign(sextic[0]), expected["sextic_ascending_max_abs_1"], case["tol"])
    found = robot.forward_kinematics(case["s"])
    assert found.count == expected["n_real"]
    near(found.x * DEGREES, expected["solutions_px_py_phideg"], case["tol"])


@pytest.mark.capability("08-53", "08-54", "08-60")
def test_three_rpr_where_the_legs_meet():
    case = CASES["ch08-103-3rpr-actuator-singularity"]
    robot, expected = PlanarThreeRPR(case["a"], case["b"]), case["expected"]
    assert expected["cls"] == "actuator, nondegenerate"
    for root in expected["roots"]:
        x = np.array([*case["p"], np.radians(root["phi_deg"])])
        near(robot.lengths(x), root["s"], 1e-9)
        found = robot.singularity(x)
        assert found.of_A < 1e-9
        assert found.status is SingularKind.SECOND
        assert np.linalg.matrix_rank(robot.jacobian(x), 1e-8) == expected["rank_G"]
        motion = found.free_motion / found.free_motion[0]
        near(motion, root["null_twist_wz_vx_vy"], case["tol"])
        near([-motion[2], motion[1]], root["concurrence_point"], case["tol"])
        w = found.internal_forces / found.internal_forces[2]
        near(w, root["w_last_1"], case["tol"])
        near(robot.second_order(x, motion, w), root["w_dot_d2s"], case["tol"])


def test_every_key_is_read():
    others = {name: item for name, item in globals().items() if name != "test_every_key_is_read"}
    assert unread_after(others, OWN) == []
