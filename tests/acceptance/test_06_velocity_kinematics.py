"""Worked examples of velocity kinematics, statics, singularities and manipulability of the reference arms."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from mafsil.geometry import pose, screw, wrench
from mafsil.geometry.points import common_normal
from mafsil.model.library import textbook
from mafsil.model.mounting import change_frames
from mafsil.performance import (
    determinant_factors,
    joint_torque,
    planar_ellipse,
    rank,
    self_motion,
    singularity,
    task_jacobian,
    tip_wrench,
    velocity_ellipsoid,
)
from mafsil.performance.dexterity import ellipsoid_of
from mafsil.performance.statics import pinned_arm
from mafsil.robot import Robot
from tests.acceptance.reading import cases, unread_after

CASES = cases("06-velocity-kinematics.json")
DEFINED = json.loads(Path(__file__).with_name("05-definitions.json").read_text("utf-8"))["c5-08"]
ROBOTS = {
    "c5-07-6R-elbow-fig5.7": Robot(textbook.elbow6r(0.5, 0.4)),
    "c5-08-6R-fig5.9": Robot.from_screws(DEFINED["S"], DEFINED["M"]),
    "c5-09-RRPRRR-fig5.10": Robot(textbook.rrprrr(0.5, 0.3)),
    "c6-02-Js-RRPRRR-fig6.3": Robot(textbook.rrprrr_upright(0.5, 0.3)),
}


def close(case):
    return {"atol": case["tol"], "rtol": 0}


@pytest.mark.capability("05-38")
def test_the_arm_of_figure_5_9_is_the_one_defined():
    drawn = Robot(textbook.arm6r(DEFINED["L"]))
    q = np.random.default_rng(0).uniform(-2, 2, (5, 6))
    defined = ROBOTS["c5-08-6R-fig5.9"]
    np.testing.assert_allclose(drawn.forward_kinematics(q), defined.forward_kinematics(q), atol=1e-14)
    assert set(DEFINED) == {"L", "M", "S"}


@pytest.mark.capability("05-49", "05-53", "05-70")
def test_space_jacobian_of_the_rrrp():
    case = CASES["c6-01-Js-RRRP-fig6.2"]
    arm = Robot.from_screws(case["input"]["S"], np.eye(4))
    drawn = Robot(textbook.scara_rrrp(0.2, case["input"]["L2"], case["input"]["L3"]))
    np.testing.assert_allclose(
        drawn.jacobian_space(case["input"]["theta"]), arm.jacobian_space(case["input"]["theta"]), **close(case)
    )
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
    drawn = Robot(textbook.rrprrr_upright(case["input"]["L1"], case["input"]["L2"]))
    np.testing.assert_allclose(drawn.jacobian_space(case["input"]["theta"]), J, **close(case))
    meeting = common_normal(screw.nearest_point(J[:, 3]), J[:3, 3], screw.nearest_point(J[:, 4]), J[:3, 4])
    np.testing.assert_allclose(meeting.first, case["expected"]["q_w"], **close(case))
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
    r_b = pose.act(pose.inverse(T_sb), case["input"]["r_s"])
    np.testing.assert_allclose(r_b, case["expected"]["r_b"], **close(case))
    f_b = T_sb[:3, :3].T @ case["input"]["f_s"]
    np.testing.assert_allclose(wrench.from_force(r_b, f_b), case["expected"]["F_b"], **close(case))


@pytest.mark.capability("05-65", "05-66")
def test_statics_of_both_arms():
    arm_59 = ROBOTS["c5-08-6R-fig5.9"]
    case = CASES["c6-05-statics"]
    flat = Robot(textbook.planar2r(case["input"]["planar2R"]["L"]))
    q, f = case["input"]["planar2R"]["theta"], case["input"]["planar2R"]["f"]
    J = task_jacobian(flat, q, "planar_position")
    np.testing.assert_allclose(J.T @ f, case["expected"]["planar2R_tau"], **close(case))
    assert ROBOTS[case["input"]["sixR"]["same_robot_as"]] is arm_59
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
    arm, q = Robot(textbook.planar3r(case["input"]["L"])), case["input"]["theta"]
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


CASE_OF = {"I": "collinear_same", "II": "parallel_coplanar", "III": "concurrent"}
"""Names of the numbered cases that the sentences of the file mention."""
WORDS = {
    "elbow straight": {"one_line"},
    "elbow+wrist": {"collinear_same"},
    "axes 4,6 collinear": {"collinear"},
    "five axes through one point": {"concurrent"},
}


def reasons(sentence):
    """Names of cases, or beginnings of them, that a sentence of the file asks for."""
    numbered = {CASE_OF[number] for number in re.findall(r"\bcase (I{1,3})\b", sentence)}
    return numbered or WORDS.get(sentence, set())


@pytest.mark.capability("05-70", "05-72", "05-74", "05-75", "05-76", "05-78", "05-79")
def test_singular_configurations_and_their_reasons():
    case = CASES["c6-08-robot-singularities"]
    expected = case["expected"]
    for config, want, reason in zip(case["input"]["configs"], expected["rank"], expected["reason"], strict=True):
        arm = ROBOTS[config["robot"]]
        found = singularity(arm, config["theta"])
        assert found.rank == want, reason
        for J in (arm.jacobian_body(config["theta"]), arm.jacobian_space(config["theta"])):
            assert np.linalg.matrix_rank(J, tol=1e-6) == want, reason
        seen = {cause.case for cause in found.causes}
        for name in reasons(reason):
            assert any(case_name.startswith(name) for case_name in seen), reason
        assert found.singular == bool(found.causes) == (reason not in ("generic", "regular"))
        for joints in re.findall(r"axes ([\d,]+)|I \((\d,\d)\)|II \((\d,\d,\d)\)", reason):
            wanted = {int(k) - 1 for k in "".join(joints).split(",")}
            assert any(wanted <= set(cause.joints) for cause in found.causes), reason


@pytest.mark.capability("05-73", "05-94")
def test_base_and_tool_leave_the_singular_set_alone():
    case = CASES["c6-09-frame-invariance"]
    arm = ROBOTS[case["input"]["same_robot_as"]]
    q, P, Q = case["input"]["theta"], pose.project(case["input"]["P"]), pose.project(case["input"]["Q"])
    J_s, J_b = arm.jacobian_space(q), arm.jacobian_body(q)
    moved, held = Robot(change_frames(arm, base=P)), Robot(change_frames(arm, tool=Q))
    named = {
        "Ad_P Js": pose.adjoint(P) @ J_s,
        "Jb": J_b,
        "Js": J_s,
        "Ad_{Q^-1} Jb": pose.adjoint(pose.inverse(Q)) @ J_b,
    }
    expected = case["expected"]
    np.testing.assert_allclose(moved.forward_kinematics(q), P @ arm.forward_kinematics(q), **close(case))
    np.testing.assert_allclose(held.forward_kinematics(q), arm.forward_kinematics(q) @ Q, **close(case))
    np.testing.assert_allclose(moved.jacobian_space(q), named[expected["Js_PT_equals"]], **close(case))
    np.testing.assert_allclose(moved.jacobian_body(q), named[expected["Jb_PT_equals"]], **close(case))
    np.testing.assert_allclose(held.jacobian_space(q), named[expected["Js_TQ_equals"]], **close(case))
    np.testing.assert_allclose(held.jacobian_body(q), named[expected["Jb_TQ_equals"]], **close(case))
    np.testing.assert_allclose(held.jacobian_body(q)[:, 0], expected["Jb_TQ_col1"], **close(case))
    np.testing.assert_allclose(moved.jacobian_space(q)[:, 5], expected["Js_PT_col6"], **close(case))
    singular = [q[0], np.pi / 2, *q[2:]]
    assert rank(arm, singular) == rank(moved, singular) == rank(held, singular) == 5


@pytest.mark.capability("05-81", "05-82", "05-83", "05-84", "05-85", "05-86")
def test_ellipses_and_ellipsoids():
    arm_59 = ROBOTS["c5-08-6R-fig5.9"]
    case = CASES["c6-10-manipulability"]
    for name in ("golden", "other", "isotropic"):
        given, expected = case["input"][name], case["expected"][name]
        arm = Robot(textbook.planar2r(given["L"]))
        found = velocity_ellipsoid(arm, given["theta"], "planar")
        np.testing.assert_allclose(found.lengths, expected["semi_axes"], **close(case))
        np.testing.assert_allclose(found.ratio, expected["ratio"], **close(case))
        if "J" in expected:
            J = task_jacobian(arm, given["theta"], "planar_position")
            np.testing.assert_allclose(J, expected["J"], **close(case))
        if "coeffs" in expected:
            ellipse = planar_ellipse(task_jacobian(arm, given["theta"], "planar_position"))
            np.testing.assert_allclose([ellipse.alpha, ellipse.beta, ellipse.gamma], expected["coeffs"], **close(case))
            assert ellipse.discriminant < 0
            np.testing.assert_allclose(found.lengths.prod(), expected["w"], **close(case))
        if "major_dir_up_to_sign" in expected:
            np.testing.assert_allclose(abs(found.axes[:, 0] @ expected["major_dir_up_to_sign"]), 1, **close(case))
            vector = found.joint_vectors[:, 0] @ expected["joint_vel_major_up_to_sign"]
            np.testing.assert_allclose(abs(vector), 1, **close(case))
    given, expected = case["input"]["collapsed"], case["expected"]["collapsed"]
    flat = velocity_ellipsoid(Robot(textbook.planar2r(given["L"])), given["theta"], "planar")
    np.testing.assert_allclose(flat.lengths, expected["semi_axes"], **close(case))
    np.testing.assert_allclose(abs(flat.axes[:, 0] @ expected["line_dir_up_to_sign"]), 1, **close(case))
    assert ROBOTS[case["input"]["sixR"]["same_robot_as"]] is arm_59
    q, expected = case["input"]["sixR"]["theta"], case["expected"]["sixR"]
    angular, linear = (velocity_ellipsoid(arm_59, q, part) for part in ("angular", "linear"))
    np.testing.assert_allclose(angular.lengths, expected["semi_axes_omega"], **close(case))
    np.testing.assert_allclose(linear.lengths, expected["semi_axes_v_tip"], **close(case))
    wrong = ellipsoid_of(arm_59.jacobian_space(q)[3:]).lengths
    np.testing.assert_allclose(wrong, expected["semi_axes_v_from_Js_WRONG_for_tip"], **close(case))


def test_every_key_of_every_case_is_read(request):
    del request  # an argument, so that the guard does not call itself
    assert unread_after(globals(), CASES) == []
