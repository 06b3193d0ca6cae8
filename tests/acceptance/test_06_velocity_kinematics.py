"""Worked examples of velocity kinematics, statics, singularities and manipulability of the reference arms."""

import json
from pathlib import Path

import numpy as np
import pytest

from mafsil.geometry import pose, wrench
from mafsil.model.library import planar, textbook
from mafsil.performance import (
    determinant_factors,
    joint_torque,
    pinned_arm,
    planar_ellipse,
    rank,
    self_motion,
    singularity,
    task_jacobian,
    tip_wrench,
    velocity_ellipsoid,
)
from mafsil.robot import Robot

CASES = {
    case["id"]: case for case in json.loads((Path(__file__).parent / "06-velocity-kinematics.json").read_text("utf-8"))
}
ROBOTS = {
    "c5-07-6R-elbow-fig5.7": Robot(textbook.elbow6r(0.5, 0.4)),
    "c5-08-6R-fig5.9": Robot(textbook.arm6r(0.6)),
    "c5-09-RRPRRR-fig5.10": Robot(textbook.rrprrr(0.5, 0.3)),
    "c6-02-Js-RRPRRR-fig6.3": Robot(textbook.rrprrr_upright(0.5, 0.3)),
}


def close(case):
    return {"atol": case["tol"], "rtol": 0}


@pytest.fixture
def arm_59():
    """The 6R arm of fig. 5.9 in the size that the case's numbers belong to."""
    return Robot(textbook.arm6r(0.6))


@pytest.mark.capability("05-49", "05-53", "05-70")
def test_space_jacobian_of_the_rrrp():
    case = CASES["c6-01-Js-RRRP-fig6.2"]
    arm = Robot.from_screws(case["input"]["S"], np.eye(4))
    q, expected = case["input"]["theta"], case["expected"]
    J = arm.jacobian_space(q)
    np.testing.assert_allclose(J, expected["Js"], **close(case))
    assert rank(arm, q) == expected["rank"]
    assert rank(arm, [0.3, 0.0, -0.2, 0.1]) == rank(arm, [0.3, np.pi, -0.2, 0.1]) == expected["rank_theta2_0"]
    np.testing.assert_allclose(np.linalg.det(J[2:]), expected["minor_rows3to6"], **close(case))


@pytest.mark.capability("05-49", "05-54")
def test_space_jacobian_of_the_rrprrr():
    case = CASES["c6-02-Js-RRPRRR-fig6.3"]
    arm = Robot.from_screws(case["input"]["S"], case["input"]["M"])
    J = arm.jacobian_space(case["input"]["theta"])
    np.testing.assert_allclose(J, case["expected"]["Js"], **close(case))
    np.testing.assert_allclose(np.linalg.det(J), case["expected"]["det"], **close(case))
    np.testing.assert_allclose(
        determinant_factors(arm).evaluate(case["input"]["theta"]), case["expected"]["det"], **close(case)
    )


@pytest.mark.capability("05-61", "05-62")
def test_wrench_in_two_frames():
    case = CASES["c6-04-wrench-frames"]
    F_s = wrench.from_force(case["input"]["r_s"], case["input"]["f_s"])
    np.testing.assert_allclose(F_s, case["expected"]["F_s"], **close(case))
    T_sb = pose.project(case["input"]["T_sb"])
    np.testing.assert_allclose(wrench.transform(T_sb, F_s), case["expected"]["F_b"], **close(case))


@pytest.mark.capability("05-65", "05-66")
def test_statics_of_both_arms(arm_59):
    case = CASES["c6-05-statics"]
    flat = Robot(planar.planar2r(case["input"]["planar2R"]["L"]))
    q, f = case["input"]["planar2R"]["theta"], case["input"]["planar2R"]["f"]
    J = task_jacobian(flat, q, "planar_position")
    np.testing.assert_allclose(J.T @ f, case["expected"]["planar2R_tau"], **close(case))
    q, F_s = case["input"]["sixR"]["theta"], case["input"]["sixR"]["F_s"]
    tau = joint_torque(arm_59, q, F_s, given_in="space")
    np.testing.assert_allclose(tau, case["expected"]["sixR_tau"], **close(case))
    F_b = wrench.transform(arm_59.forward_kinematics(q), F_s)
    np.testing.assert_allclose(F_b, case["expected"]["sixR_Fb"], **close(case))
    np.testing.assert_allclose(joint_torque(arm_59, q, F_b), tau, **close(case))
    back = tip_wrench(arm_59, q, tau)
    p = arm_59.forward_kinematics(q)[:3, 3]
    np.testing.assert_allclose(back.F[:3] + np.cross(p, back.F[3:]), F_s[:3], **close(case))
    np.testing.assert_allclose(back.F[3:], F_s[3:], **close(case))


@pytest.mark.capability("05-67", "05-68")
def test_pinned_planar_3r():
    case = CASES["c6-06-redundant-pinned-3R"]
    arm, q = Robot(planar.planar3r(case["input"]["L"])), case["input"]["theta"]
    expected = case["expected"]
    np.testing.assert_allclose(task_jacobian(arm, q, "planar_position"), expected["J"], **close(case))
    motion = self_motion(arm, q, task="planar_position")[0]
    np.testing.assert_allclose(motion / motion[0], expected["self_motion_scaled"], **close(case))
    answer = tip_wrench(arm, q, case["input"]["tau"], task="planar_position")
    np.testing.assert_allclose(answer.F, expected["F_least_squares"], **close(case))
    np.testing.assert_allclose(answer.unbalanced, expected["tau_unbalanced"], **close(case))
    linkage = pinned_arm(arm, q)
    assert linkage.freedoms == 1
    assert linkage.drift < 1e-12


REASONS = [
    (),
    ("one_line",),
    ("collinear_same",),
    ("concurrent",),
    ("collinear_same",),
    ("collinear_same", "parallel_coplanar"),
    ("collinear_same",),
    ("parallel_coplanar",),
    ("concurrent",),
    ("collinear_same",),
    ("concurrent",),
    (),
    ("collinear_opposite",),
    ("concurrent",),
]


@pytest.mark.capability("05-70", "05-72", "05-74", "05-75", "05-76", "05-78", "05-79")
@pytest.mark.parametrize("k", range(14))
def test_singular_configurations_and_their_reasons(k):
    case = CASES["c6-08-robot-singularities"]
    config = case["input"]["configs"][k]
    arm = ROBOTS[config["robot"]]
    found = singularity(arm, config["theta"])
    assert found.rank == case["expected"]["rank"][k]
    assert np.linalg.matrix_rank(arm.jacobian_body(config["theta"]), tol=1e-6) == found.rank
    assert set(REASONS[k]) <= {cause.case for cause in found.causes}
    assert found.singular == bool(found.causes)


@pytest.mark.capability("05-73")
def test_base_and_tool_leave_the_singular_set_alone(arm_59):
    case = CASES["c6-09-frame-invariance"]
    q, P, Q = case["input"]["theta"], pose.project(case["input"]["P"]), pose.project(case["input"]["Q"])
    J_s, J_b = arm_59.jacobian_space(q), arm_59.jacobian_body(q)
    J_PT, J_TQ = pose.adjoint(P) @ J_s, pose.adjoint(pose.inverse(Q)) @ J_b
    np.testing.assert_allclose(J_TQ[:, 0], case["expected"]["Jb_TQ_col1"], **close(case))
    np.testing.assert_allclose(J_PT[:, 5], case["expected"]["Js_PT_col6"], **close(case))


@pytest.mark.capability("05-81", "05-82", "05-83", "05-84", "05-85", "05-86")
def test_ellipses_and_ellipsoids(arm_59):
    case = CASES["c6-10-manipulability"]
    for name in ("golden", "other", "isotropic"):
        given, expected = case["input"][name], case["expected"][name]
        arm = Robot(planar.planar2r(given["L"]))
        found = velocity_ellipsoid(arm, given["theta"], "planar")
        np.testing.assert_allclose(found.lengths, expected["semi_axes"], **close(case))
        np.testing.assert_allclose(found.ratio, expected["ratio"], **close(case))
        if "coeffs" in expected:
            ellipse = planar_ellipse(task_jacobian(arm, given["theta"], "planar_position"))
            np.testing.assert_allclose([ellipse.alpha, ellipse.beta, ellipse.gamma], expected["coeffs"], **close(case))
            assert ellipse.discriminant < 0
            np.testing.assert_allclose(found.lengths.prod(), expected["w"], **close(case))
        if "major_dir_up_to_sign" in expected:
            np.testing.assert_allclose(abs(found.axes[:, 0] @ expected["major_dir_up_to_sign"]), 1, **close(case))
            vector = found.joint_vectors[:, 0] @ expected["joint_vel_major_up_to_sign"]
            np.testing.assert_allclose(abs(vector), 1, **close(case))
    flat = velocity_ellipsoid(Robot(planar.planar2r((1, 1))), [0, 0], "planar")
    np.testing.assert_allclose(flat.lengths, case["expected"]["collapsed"]["semi_axes"], **close(case))
    np.testing.assert_allclose(np.abs(flat.axes[:, 0]), [0, 1], **close(case))
    q, expected = case["input"]["sixR"]["theta"], case["expected"]["sixR"]
    angular, linear = (velocity_ellipsoid(arm_59, q, part) for part in ("angular", "linear"))
    np.testing.assert_allclose(angular.lengths, expected["semi_axes_omega"], **close(case))
    np.testing.assert_allclose(linear.lengths, expected["semi_axes_v_tip"], **close(case))
