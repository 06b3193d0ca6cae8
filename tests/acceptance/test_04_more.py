"""Further worked numbers of rigid-body motions, each through the public functions."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.geometry import euler, length_units, planar, pose, relative_motion, rotation, screw, twist, wrench
from mafsil.geometry.logarithms import screws
from mafsil.geometry.screw import helix
from mafsil.geometry.wrist import Wrist
from tests.acceptance.reading import cases, unread_after

CASES = cases("04-more.json")


def near(case, got, expected):
    expected = np.asarray(expected, dtype=float)
    assert np.shape(got) == expected.shape
    np.testing.assert_allclose(got, expected, rtol=0, atol=case["tol"])


@pytest.mark.capability("04-40")
def test_zero_of_the_middle_wrist_joint():
    case = CASES["M4-01"]
    angles, want = case["inputs"]["joint_angles"], case["expected"]
    for sign, key, zyz in (
        (1, "R_03_zero_moved_plus_90", "ZYZ_angles_of_R_plus_times_Ry_minus_90"),
        (-1, "R_03_zero_moved_minus_90", "ZYZ_angles_of_R_minus_times_Ry_plus_90"),
    ):
        R = Wrist.of_sequence("ZYX").with_middle_zero(sign * np.pi / 2).rotation(angles)
        near(case, R, want[key])
        near(case, rotation.to_euler(R @ rotation.rot_y(-sign * np.pi / 2), "ZYZ"), want[zyz])


@pytest.mark.capability("04-117")
def test_both_screws_of_a_half_turn():
    case = CASES["M4-03"]
    want = case["expected"]
    first, second = screws(pose.project(case["inputs"]["T"]), 0.0, np.pi, tolerance=1e-6)
    if first.screw[0] < 0:
        first, second = second, first
    near(case, [first.amount, second.amount], [want["theta"]] * 2)
    near(case, first.screw, want["S_first"])
    near(case, second.screw, want["S_second"])
    near(case, first.pitch, want["pitch_first"])
    near(case, second.pitch, want["pitch_second"])


@pytest.mark.capability("04-118")
def test_relative_and_inverse_motion():
    case = CASES["M4-05"]
    given, want = case["inputs"], case["expected"]
    T_ab, T_bc = pose.project(given["T_ab"]), pose.project(given["T_bc"])
    V_ac = relative_motion.space(given["V_ab_space"], T_ab, given["V_bc_space"])
    near(case, V_ac, want["V_ac_space"])
    in_b = twist.transform(pose.inverse(T_ab), given["V_ab_space"])
    in_c = twist.transform(pose.inverse(T_bc), given["V_bc_space"])
    body = relative_motion.body(in_b, T_bc, in_c)
    near(case, body, want["V_ac_body"])
    space_ca, body_ca = relative_motion.exchange_bodies(V_ac, body)
    near(case, space_ca, want["V_ca_space"])
    near(case, body_ca, want["V_ca_body"])


@pytest.mark.capability("04-97", "04-98")
def test_planar_logarithm():
    case = CASES["M4-07"]
    for T, want in zip(case["inputs"]["T"], case["expected"]["logs"], strict=True):
        V = planar.log(T)
        near(case, V, want["exponential_coordinates"])
        omega, theta, v = planar.screw(T)
        near(case, omega, want["omega3"])
        near(case, theta, want["theta"])
        near(case, v, want["v"])
        place, exists = planar.finite_pole(T)
        assert bool(exists) == (want["pole"] is not None)
        if exists:
            near(case, place, want["pole"])
        near(case, planar.exp(np.array([omega, *v]) * theta), T)


@pytest.mark.capability("04-120")
def test_change_of_the_length_unit():
    case = CASES["M4-09"]
    given, want, k = case["inputs"], case["expected"], case["inputs"]["factor"]
    assert k == length_units.factor("m", "mm")
    T = pose.project(given["T_m"])
    near(case, length_units.pose(T, k), want["T_mm"])
    V, F = length_units.twist(given["V_m"], k), length_units.wrench(given["F_m"], k)
    near(case, V, want["V_mm"])
    near(case, F, want["F_mm"])
    near(case, [screw.pitch(given["V_m"]), screw.pitch(V)], [want["pitch_m"], want["pitch_mm"]])
    near(case, length_units.adjoint(pose.adjoint(T), k) @ V, want["Ad_T_V_mm"])
    near(case, twist.transform(length_units.pose(T, k), V), want["Ad_T_V_mm"])
    near(case, wrench.power(given["V_m"], given["F_m"]), want["power_N_m_s"])
    near(case, wrench.power(V, F), want["power_N_mm_s"])


@pytest.mark.capability("04-88", "04-123")
def test_the_frame_that_names_a_displacement():
    case = CASES["M4-11"]
    given, want = case["inputs"], case["expected"]
    X_ai, X_af = (mf.Pose(pose.project(given[key])) for key in ("X_ai", "X_af"))
    T_ba = X_ai.displacement_to(X_af)
    near(case, T_ba.array, want["T_ba"])
    near(case, T_ba.inverse().array, want["T_ab"])
    near(case, (X_ai @ X_af.inverse()).array, want["T_ab"])
    before = X_ai.displace(given["body_point"])
    near(case, before, want["p_before"])
    near(case, T_ba.displace(before), want["p_after"])


@pytest.mark.capability("04-34", "04-50")
def test_second_branch_of_a_negative_middle_angle():
    case = CASES["M4-13"]
    angles, want = np.radians(case["inputs"]["alpha_beta_gamma_deg"]), case["expected"]
    R = rotation.from_euler(angles, "ZYX")
    near(case, R, want["R"])
    plus, minus = np.degrees(euler.solutions(R, "ZYX").positive())
    near(case, plus, np.mod(want["branch_plus_deg"], 360.0))
    near(case, minus, want["branch_minus_deg"])
    near(case, np.degrees(euler.solutions(R, "ZYX").angles[0]), want["branch_plus_deg"])


@pytest.mark.capability("04-127")
def test_helix_of_a_body_point():
    case = CASES["M4-15"]
    given, want = case["inputs"], case["expected"]
    path = helix(screw.from_axis(given["axis"], given["q"], given["h"]), given["x"])
    near(case, path.at(given["theta"]), want["positions"])
    near(case, [path.radius, path.speed], [want["radius"], want["speed"]])
    near(case, path.length(2.0), want["path_length_to_2"])
    assert path.lead == pytest.approx(2 * np.pi * given["h"])


def test_every_key_of_every_case_is_read(request):
    del request  # an argument, so that the guard does not call itself
    assert unread_after(globals(), CASES) == []
