"""Worked numbers of the specification, part 10, about one joint, through `mafsil.one_joint`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from mafsil import one_joint

CASES = {case["id"]: case for case in json.loads(Path(__file__).with_name("10-one-joint.json").read_text())}


def agree(got, expected, tol):
    expected = np.asarray(expected, dtype=float)
    assert np.all(np.abs(np.asarray(got) - expected) <= tol * np.maximum(1.0, np.abs(expected)))


def parts(name):
    case = CASES[name]
    return case["input"], case["expected"], case["tol"]


@pytest.mark.capability("10-24", "10-26", "10-27", "10-28")
def test_pd_damping_regimes():
    given, expected, tol = parts("pd_damping_regimes")
    damping = given["b"] + given["Kd"]
    kp = one_joint.kp_for_damping_ratio(given["M"], damping, given["zeta"])
    agree(kp, expected["Kp"], tol)
    loop = one_joint.SecondOrder.of_joint(given["M"], damping, kp)
    agree(loop.natural_frequency, expected["omega_n"], tol)
    agree(np.sort(loop.roots[0].real), expected["roots_zeta_1_5"], tol)
    agree(loop.roots[1].real, expected["root_zeta_1"], tol)
    agree(loop.roots[2].real, expected["roots_zeta_0_5"]["re"], tol)
    agree(np.abs(loop.roots[2].imag), expected["roots_zeta_0_5"]["im"], tol)
    agree(100 * loop.overshoot[2], expected["overshoot_pct_zeta_0_5"], tol)
    agree(loop.peak_time[2], expected["t_peak_zeta_0_5"], tol)
    agree(loop.settling_time(), expected["settle2pct_exact"], tol)
    agree(loop.settling_by_rule, expected["settle_4tau"], tol)


@pytest.mark.capability("10-23")
def test_hurwitz():
    given, expected, _ = parts("hurwitz")
    got = [bool(one_joint.routh_hurwitz(row)) for row in given["coeffs_high_to_low"]]
    assert got == expected["stable"]


@pytest.mark.capability("10-24", "10-25", "10-27")
def test_step_response_with_initial_velocity():
    given, expected, tol = parts("step_response_initial_velocity_three_regimes")
    loop = one_joint.SecondOrder.of_joint(given["M"], given["b"] + given["Kd"], given["Kp"])
    start = given["e0"], given["e_dot0"]
    agree(loop.damping_ratio, expected["zeta"], tol)
    agree(loop.response(given["t"], *start), expected["theta_e"], tol)
    peak = loop.opposite_peak(*start)
    agree(peak, expected["largest_theta_e_opposite_side"], tol)
    agree(100 * peak / abs(given["e0"]), expected["overshoot_pct_of_abs_e0"], tol)
    agree(loop.settling_time(*start), expected["settle_2pct_of_abs_e0"], tol)


@pytest.mark.capability("10-31")
def test_rest_error_of_pd():
    given, expected, tol = parts("pd_gravity_rest_error")
    load = given["m"] * given["r"] * given["g"]
    loop = one_joint.SecondOrder.of_joint(given["M"], given["b"] + given["Kd"], given["Kp"])
    agree(loop.damping_ratio, expected["zeta"], tol)
    rest = one_joint.rest_under_gravity(given["Kp"], load, given["theta_d"])
    agree(rest.error, expected["theta_e_inf"], tol)
    agree(rest.torque, expected["torque_inf"], tol)


@pytest.mark.capability("10-32", "10-33")
def test_integral_gain_under_gravity():
    given, expected, tol = parts("pid_ki_bound_under_gravity")
    goal = np.array([np.pi / 2, 0.0, -np.pi / 2, 1.0])
    joint, load = (given["M"], given["b"] + given["Kd"], given["Kp"]), given["m"] * given["g"] * given["r"]
    agree(one_joint.ki_limit(*joint, load, goal), expected["Ki_max_local"], tol)
    agree(one_joint.ki_limit(*joint), expected["Ki_max_printed_10_14"], tol)


@pytest.mark.capability("10-36", "10-109")
def test_tracking_of_ramp_and_sine():
    given, expected, tol = parts("tracking_error_pd_pid_ramp_sine")
    tracking = one_joint.TrackingError.of(given["M"], given["b"], given["Kp"], given["Ki"], given["Kd"])
    agree(tracking.ramp(2.0), expected["ramp_error"], tol)
    phasor = tracking.sine([2.0])[:, 0]
    agree(np.abs(phasor), expected["sine_error_amplitude"], tol)
    agree(np.angle(phasor), expected["sine_error_phase_rad"], tol)


def test_rest_with_a_wrong_model():
    given, expected, tol = parts("computed_torque_wrong_mass")
    one = given["one_joint"]
    # Computed torque at rest: M_hat Kp e + m g r_hat cos(theta) = m g r cos(theta).
    left = one["m"] * one["g"] * (one["r"] - one["r_hat"])
    rest = one_joint.rest_under_gravity(one["M_hat"] * one["Kp"], left, one["theta_d"])
    agree(rest.error, expected["one_joint_rest_error"], tol)
